//! The reference: plain Rust, which every processor runs.

use super::{LANES, Lanes};
use sandtable_terrain::SlabView;

/// Sixteen lanes without any instruction set; compilers make of it what the processor has.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

type F = [f32; LANES];
type I = [i32; LANES];
/// All ones or all zeros a lane, so that a choice is two bitwise operations.
type M = [u32; LANES];

#[inline(always)]
fn each<R>(lane: impl FnMut(usize) -> R) -> [R; LANES] {
    std::array::from_fn(lane)
}

#[inline(always)]
fn map<T: Copy, R>(f: impl Fn(T, T) -> R, a: [T; LANES], b: [T; LANES]) -> [R; LANES] {
    std::array::from_fn(|k| f(a[k], b[k]))
}

#[inline(always)]
fn truth(condition: bool) -> u32 {
    u32::from(condition).wrapping_neg()
}

/// The first item of each row of a cell and the one behind it; zeros where there is no such cell.
#[inline(always)]
fn cell<T: Copy + Default>(items: &SlabView<'_, T>, at: i32, stride: u32) -> [T; 4] {
    let tile = items.from_place(at as u32);
    let next = stride as usize;
    match (tile.get(..2), tile.get(next..next + 2)) {
        (Some(south), Some(north)) => [south[0], south[1], north[0], north[1]],
        _ => [T::default(); 4],
    }
}

impl Lanes for Portable {
    type F = F;
    type I = I;
    type M = M;

    #[inline(always)]
    fn vectorize<R>(self, work: impl FnOnce() -> R) -> R {
        work()
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F {
        [value; LANES]
    }
    #[inline(always)]
    fn load(self, from: &F) -> F {
        *from
    }
    #[inline(always)]
    fn store(self, value: F, to: &mut F) {
        *to = value;
    }
    #[inline(always)]
    fn add(self, a: F, b: F) -> F {
        map(|a, b| a + b, a, b)
    }
    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        map(|a, b| a - b, a, b)
    }
    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        map(|a, b| a * b, a, b)
    }
    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        map(|a, b| a / b, a, b)
    }
    #[inline(always)]
    fn sqrt(self, a: F) -> F {
        a.map(f32::sqrt)
    }
    #[inline(always)]
    fn abs(self, a: F) -> F {
        a.map(f32::abs)
    }
    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        map(|a, b| if a < b { a } else { b }, a, b)
    }
    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        map(|a, b| if a > b { a } else { b }, a, b)
    }

    #[inline(always)]
    fn lt(self, a: F, b: F) -> M {
        map(|a, b| truth(a < b), a, b)
    }
    #[inline(always)]
    fn le(self, a: F, b: F) -> M {
        map(|a, b| truth(a <= b), a, b)
    }
    #[inline(always)]
    fn select(self, mask: M, yes: F, no: F) -> F {
        each(|k| f32::from_bits((yes[k].to_bits() & mask[k]) | (no[k].to_bits() & !mask[k])))
    }
    #[inline(always)]
    fn add_where(self, mask: M, a: F, b: F) -> F {
        self.select(mask, self.add(a, b), a)
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        each(|k| truth(bits >> k & 1 == 1))
    }
    #[inline(always)]
    fn bits(self, mask: M) -> u16 {
        mask.iter()
            .enumerate()
            .fold(0, |bits, (k, &lane)| bits | ((lane & 1) << k)) as u16
    }
    #[inline(always)]
    fn and(self, a: M, b: M) -> M {
        map(|a, b| a & b, a, b)
    }
    #[inline(always)]
    fn or(self, a: M, b: M) -> M {
        map(|a, b| a | b, a, b)
    }
    #[inline(always)]
    fn and_not(self, a: M, b: M) -> M {
        map(|a, b| a & !b, a, b)
    }

    #[inline(always)]
    fn splat_i(self, value: i32) -> I {
        [value; LANES]
    }
    #[inline(always)]
    fn load_i(self, from: &I) -> I {
        *from
    }
    #[inline(always)]
    fn store_i(self, value: I, to: &mut I) {
        *to = value;
    }
    #[inline(always)]
    fn add_i(self, a: I, b: I) -> I {
        map(i32::wrapping_add, a, b)
    }
    #[inline(always)]
    fn sub_i(self, a: I, b: I) -> I {
        map(i32::wrapping_sub, a, b)
    }
    #[inline(always)]
    fn mul_i(self, a: I, b: I) -> I {
        map(i32::wrapping_mul, a, b)
    }
    #[inline(always)]
    fn and_i(self, a: I, b: I) -> I {
        map(|a, b| a & b, a, b)
    }
    #[inline(always)]
    fn min_i(self, a: I, b: I) -> I {
        map(i32::min, a, b)
    }
    #[inline(always)]
    fn max_i(self, a: I, b: I) -> I {
        map(i32::max, a, b)
    }
    #[inline(always)]
    fn shl_i(self, a: I, by: I) -> I {
        map(|a, by| a.wrapping_shl(by as u32), a, by)
    }
    #[inline(always)]
    fn shr_i(self, a: I, by: I) -> I {
        map(|a, by| a.wrapping_shr(by as u32), a, by)
    }
    #[inline(always)]
    fn gt_i(self, a: I, b: I) -> M {
        map(|a, b| truth(a > b), a, b)
    }
    #[inline(always)]
    fn eq_i(self, a: I, b: I) -> M {
        map(|a, b| truth(a == b), a, b)
    }
    #[inline(always)]
    fn select_i(self, mask: M, yes: I, no: I) -> I {
        each(|k| (yes[k] & mask[k] as i32) | (no[k] & !mask[k] as i32))
    }
    #[inline(always)]
    fn add_i_where(self, mask: M, a: I, b: I) -> I {
        each(|k| a[k].wrapping_add(b[k] & mask[k] as i32))
    }
    #[inline(always)]
    fn first_i(self, value: I, mask: M) -> i32 {
        value[self.bits(mask).trailing_zeros() as usize % LANES]
    }
    #[inline(always)]
    fn float_of_bits(self, bits: I) -> F {
        bits.map(|bits| f32::from_bits(bits as u32))
    }
    #[inline(always)]
    fn to_float(self, a: I) -> F {
        a.map(|a| a as f32)
    }
    #[inline(always)]
    fn to_int(self, a: F) -> I {
        a.map(|a| a as i32)
    }

    #[inline(always)]
    fn exponent(self, a: F) -> I {
        a.map(|a| (a.to_bits() >> 23) as i32 - 127)
    }

    #[inline(always)]
    fn compress(self, mask: M, value: F, to: &mut F) {
        let mut end = 0;
        for k in 0..LANES {
            to[end] = value[k];
            end += (mask[k] & 1) as usize;
        }
    }
    #[inline(always)]
    fn compress_i(self, mask: M, value: I, to: &mut I) {
        let mut end = 0;
        for k in 0..LANES {
            to[end] = value[k];
            end += (mask[k] & 1) as usize;
        }
    }

    #[inline(always)]
    fn prefetch_write<T>(self, _: &[T], _: usize) {}

    #[inline(always)]
    fn prefetch<T>(self, _: &SlabView<'_, T>, _: I) {}

    #[inline(always)]
    fn transpose(self, rows: [I; LANES]) -> [I; LANES] {
        each(|col| each(|row| rows[row][col]))
    }

    #[inline(always)]
    fn scatter(self, mask: M, at: I, value: F, to: &mut [f32]) {
        let last = to.len() - 1;
        for k in 0..LANES {
            if mask[k] != 0 {
                to[(at[k] as u32 as usize).min(last)] = value[k];
            }
        }
    }

    #[inline(always)]
    fn cells(self, posts: &SlabView<'_, f32>, at: I, stride: u32) -> [F; 4] {
        let mut lanes = [[0.0; LANES]; 4];
        for k in 0..LANES {
            let cell = cell(posts, at[k], stride);
            for (lanes, post) in lanes.iter_mut().zip(cell) {
                lanes[k] = post;
            }
        }
        lanes
    }
    #[inline(always)]
    fn byte_cells(self, bytes: &SlabView<'_, u8>, at: I, stride: u32) -> [F; 4] {
        let mut lanes = [[0.0; LANES]; 4];
        for k in 0..LANES {
            let cell = cell(bytes, at[k], stride);
            for (lanes, byte) in lanes.iter_mut().zip(cell) {
                lanes[k] = f32::from(byte);
            }
        }
        lanes
    }
    #[inline(always)]
    fn halves(self, numbers: &SlabView<'_, u16>, at: I) -> I {
        each(|k| {
            let found = numbers.from_place(at[k] as u32).first();
            i32::from(found.copied().unwrap_or(0))
        })
    }
    #[inline(always)]
    fn look_up(self, table: &[u32], at: I) -> I {
        let last = table.len() - 1;
        each(|k| table[(at[k] as u32 as usize).min(last)] as i32)
    }
    #[inline(always)]
    fn texels(self, texels: &SlabView<'_, [u8; 4]>, at: I, stride: u32, east: F, north: F) -> I {
        each(|k| {
            let [sw, se, nw, ne] = cell(texels, at[k], stride);
            let (east, north) = (weight(east[k]), weight(north[k]));
            i32::from_ne_bytes(std::array::from_fn(|channel| {
                let texel = |texel: [u8; 4]| i16::from(texel[channel]) << 6;
                let along =
                    |from: i16, to: i16, share: i16| from + rounded_product(to - from, share);
                let south = along(texel(sw), texel(se), east);
                let row = along(texel(nw), texel(ne), east);
                ((along(south, row, north) + 32) >> 6) as u8
            }))
        })
    }
}

/// A weight in [0, 1] in 15-bit fixed point, rounded towards zero.
#[inline(always)]
fn weight(share: f32) -> i16 {
    (share * 32767.0) as i32 as i16
}

/// a·b in 15-bit fixed point, rounded to nearest (the processors' `pmulhrsw`).
#[inline(always)]
fn rounded_product(a: i16, b: i16) -> i16 {
    ((i32::from(a) * i32::from(b) + (1 << 14)) >> 15) as i16
}
