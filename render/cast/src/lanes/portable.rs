//! The reference: plain Rust, which every processor runs.

use super::{LANES, Lanes, Texels};
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

/// Reads places one after another, most of which lie in the slot of the one before.
struct Cursor<'a, T> {
    items: &'a SlabView<'a, T>,
    begin: u32,
    slot: &'a [T],
}

impl<'a, T: Copy + Default> Cursor<'a, T> {
    #[inline(always)]
    fn new(items: &'a SlabView<'a, T>) -> Self {
        Self {
            items,
            begin: 0,
            slot: &[],
        }
    }

    /// Goes to a place's slot; gives where in it the place is.
    #[inline(always)]
    fn seek(&mut self, place: i32) -> usize {
        let place = place as u32;
        if place.wrapping_sub(self.begin) as usize >= self.slot.len() {
            (self.begin, self.slot) = self.items.slot_at(place);
        }
        place.wrapping_sub(self.begin) as usize
    }

    /// The item at a place; zeros where there is none.
    #[inline(always)]
    fn item(&mut self, place: i32) -> T {
        let at = self.seek(place);
        self.slot.get(at).copied().unwrap_or_default()
    }

    /// The first item of each row of the cell at a place and the one behind it; zeros where there is
    /// no such cell.
    #[inline(always)]
    fn cell(&mut self, place: i32, stride: u32) -> [T; 4] {
        let south = self.seek(place);
        let north = south + stride as usize;
        let row = |from: usize| self.slot.get(from..from + 2);
        match (row(south), row(north)) {
            (Some(south), Some(north)) => [south[0], south[1], north[0], north[1]],
            _ => [T::default(); 4],
        }
    }
}

impl Lanes for Portable {
    type F = F;
    type I = I;
    type M = M;

    const IN_ONE_LOOP: bool = true;

    #[inline(always)]
    fn vectorize<R>(self, work: impl FnOnce() -> R) -> R {
        run(work)
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
        // A loop, as closures of `each` are sometimes called for each lane.
        let mut chosen = no;
        for k in 0..LANES {
            let bits = (yes[k].to_bits() & mask[k]) | (no[k].to_bits() & !mask[k]);
            chosen[k] = f32::from_bits(bits);
        }
        chosen
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        each(|k| truth(u32::from(bits) & (1 << k) != 0))
    }
    #[inline(always)]
    fn bits(self, mask: M) -> u16 {
        mask.iter()
            .enumerate()
            .fold(0, |bits, (k, &lane)| bits | (lane & (1 << k))) as u16
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
    fn ends(self, value: I) -> [i32; 2] {
        [value[0], value[LANES - 1]]
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
    fn mul_small(self, a: I, b: I) -> I {
        // Compilers have an instruction for products that they know to fit.
        map(|a, b| (a & 0x7fff) * (b & 0x7fff), a, b)
    }
    #[inline(always)]
    fn min_halves(self, a: I, b: I) -> I {
        let least = |a: i32, b: i32| {
            let low = (a & 0xffff).min(b & 0xffff);
            let high = (a as u32 >> 16).min(b as u32 >> 16);
            low | (high << 16) as i32
        };
        map(least, a, b)
    }
    #[inline(always)]
    fn mul_halves(self, a: I, b: I) -> I {
        let product = |a: i32, b: i32| {
            let low = (a & 0xffff).wrapping_mul(b & 0xffff) & 0xffff;
            low | (a >> 16).wrapping_mul(b >> 16) << 16
        };
        map(product, a, b)
    }
    #[inline(always)]
    fn lerp_halves(self, a: I, b: I, share: I) -> I {
        let half = |a: i32, b: i32, share: i32, shift: i32| {
            let [a, b, share] = [a, b, share].map(|x| (x >> shift) as i16);
            let part = (i32::from(b.wrapping_sub(a)) * i32::from(share) + (1 << 14)) >> 15;
            i32::from(a.wrapping_add(part as i16) as u16) << shift
        };
        std::array::from_fn(|k| half(a[k], b[k], share[k], 0) | half(a[k], b[k], share[k], 16))
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
        let mut chosen = no;
        for k in 0..LANES {
            chosen[k] = (yes[k] & mask[k] as i32) | (no[k] & !mask[k] as i32);
        }
        chosen
    }
    #[inline(always)]
    fn add_i_where(self, mask: M, a: I, b: I) -> I {
        each(|k| a[k].wrapping_add(b[k] & mask[k] as i32))
    }
    #[inline(always)]
    fn bits_of_float(self, number: F) -> I {
        each(|k| number[k].to_bits() as i32)
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
        // `as` would give zero for NaN, and so be slow.
        let fits = self.min(a, self.splat(2_147_483_520.0));
        let fits = self.max(fits, self.splat(-2_147_483_648.0));
        #[allow(
            unsafe_code,
            reason = "one instruction for several lanes, where `as` has many for one"
        )]
        fits.map(
            // SAFETY: it fits: the minimum of NaN and a number is the number.
            |lane| unsafe { lane.to_int_unchecked() },
        )
    }

    #[inline(always)]
    fn exponent(self, a: F) -> I {
        a.map(|a| (a.to_bits() >> 23) as i32 - 127)
    }

    #[inline(always)]
    fn compress_i(self, mask: M, value: I, to: &mut I) {
        self.compress_all(mask, [value], [to]);
    }

    #[inline(always)]
    fn compress_all<const N: usize>(self, mask: M, values: [I; N], mut to: [&mut [i32; LANES]; N]) {
        // Each lane is looked for once for all columns, and one end is not foreseen instead of many.
        let mut bits = self.bits(mask);
        for lane in 0..LANES {
            if bits == 0 {
                break;
            }
            let from = bits.trailing_zeros() as usize % LANES;
            for (to, value) in to.iter_mut().zip(&values) {
                to[lane] = value[from];
            }
            bits &= bits - 1;
        }
    }

    #[inline(always)]
    fn prefetch_read<T>(self, _: &[T], _: usize) {}

    #[inline(always)]
    fn prefetch_write<T>(self, _: &[T], _: usize) {}

    #[inline(always)]
    fn prefetch<T, const EVERY: usize>(self, _: &SlabView<'_, T>, _: &[i32; LANES], _: i32) {}

    #[inline(always)]
    fn transpose(self, rows: [I; LANES]) -> [I; LANES] {
        each(|col| each(|row| rows[row][col]))
    }

    #[inline(always)]
    fn scatter(self, mask: M, at: I, value: F, to: &mut [f32]) {
        let last = to.len() - 1;
        let mut bits = self.bits(mask);
        while bits != 0 {
            let k = bits.trailing_zeros() as usize % LANES;
            to[(at[k] as u32 as usize).min(last)] = value[k];
            bits &= bits - 1;
        }
    }

    #[inline(always)]
    fn cells(self, posts: &SlabView<'_, f32>, at: &[i32; LANES], stride: u32) -> [F; 4] {
        let mut lanes = [[0.0; LANES]; 4];
        let mut cursor = Cursor::new(posts);
        for k in 0..LANES {
            for (lanes, post) in lanes.iter_mut().zip(cursor.cell(at[k], stride)) {
                lanes[k] = post;
            }
        }
        lanes
    }
    #[inline(always)]
    fn byte_cells(self, bytes: &SlabView<'_, u8>, at: I, stride: u32) -> [F; 4] {
        let mut lanes = [[0.0; LANES]; 4];
        let mut cursor = Cursor::new(bytes);
        for k in 0..LANES {
            for (lanes, byte) in lanes.iter_mut().zip(cursor.cell(at[k], stride)) {
                lanes[k] = f32::from(byte);
            }
        }
        lanes
    }
    #[inline(always)]
    fn pairs(self, pairs: &SlabView<'_, [u32; 2]>, at: &[i32; LANES]) -> [I; 2] {
        let mut lanes = [[0; LANES]; 2];
        let mut cursor = Cursor::new(pairs);
        for k in 0..LANES {
            let [first, second] = cursor.item(at[k]);
            [lanes[0][k], lanes[1][k]] = [first as i32, second as i32];
        }
        lanes
    }
    #[inline(always)]
    fn pick(self, table: I, at: I) -> I {
        each(|k| table[at[k] as usize % LANES])
    }
    #[inline(always)]
    fn among(self, table: [I; 2], at: I) -> I {
        each(|k| table[at[k] as usize / LANES % 2][at[k] as usize % LANES])
    }
    #[inline(always)]
    fn look_up(self, table: &[u32], at: I) -> I {
        let last = table.len() - 1;
        each(|k| table[(at[k] as u32 as usize).min(last)] as i32)
    }
    #[inline(always)]
    fn texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        at: &[i32; LANES],
        stride: u32,
        east: F,
        north: F,
    ) -> I {
        let mut corners = [[0; 4 * LANES]; 4];
        // Weights in 15-bit fixed point, rounded towards zero.
        let [east, north] =
            [east, north].map(|share| self.to_int(self.mul(share, self.splat(32767.0))));
        let (mut easts, mut norths) = ([0; 4 * LANES], [0; 4 * LANES]);
        let mut cursor = Cursor::new(texels);
        for k in 0..LANES {
            let channels = 4 * k..4 * k + 4;
            for (to, texel) in corners.iter_mut().zip(cursor.cell(at[k], stride)) {
                to[channels.clone()].copy_from_slice(&texel);
            }
            easts[channels.clone()].fill(east[k] as i16);
            norths[channels].fill(north[k] as i16);
        }
        bytemuck::cast(blend(&corners, &easts, &norths))
    }

    #[inline(always)]
    fn mean_texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        stride: u32,
        places: [Texels<'_, Self>; 2],
    ) -> I {
        let blended = |of: Texels<'_, Self>| {
            let mut corners = [[0; 4 * LANES]; 4];
            let (mut easts, mut norths) = ([0; 4 * LANES], [0; 4 * LANES]);
            let mut cursor = Cursor::new(texels);
            for k in 0..LANES {
                let channels = 4 * k..4 * k + 4;
                for (to, texel) in corners.iter_mut().zip(cursor.cell(of.at[k], stride)) {
                    to[channels.clone()].copy_from_slice(&texel);
                }
                easts[channels.clone()].fill((of.east[k].wrapping_add(256) >> 9) as i16);
                norths[channels].fill(of.north[k] as i16);
            }
            blend_by_six_bits(&corners, &easts, &norths)
        };
        let (first, second) = (blended(places[0]), blended(places[1]));
        let mut mean = [0; 4 * LANES];
        for k in 0..4 * LANES {
            mean[k] = (first[k].wrapping_add(second[k]).wrapping_add(64) >> 7) as u8;
        }
        bytemuck::cast(mean)
    }
}

/// Blends the channels of sixteen lanes' four texels, by eastern weights in 6-bit and northern ones
/// in 15-bit fixed point: with six bits of a fraction. Out of line as [`blend`] is.
#[inline(never)]
fn blend_by_six_bits(
    [sw, se, nw, ne]: &[[u8; 4 * LANES]; 4],
    easts: &[i16; 4 * LANES],
    norths: &[i16; 4 * LANES],
) -> [i16; 4 * LANES] {
    let mut blended = [0; 4 * LANES];
    for (k, blended) in blended.iter_mut().enumerate() {
        let row = |west: u8, east: u8| {
            let (west, east) = (i16::from(west), i16::from(east));
            (west << 6).wrapping_add((east - west).wrapping_mul(easts[k]))
        };
        *blended = along(row(sw[k], se[k]), row(nw[k], ne[k]), norths[k]);
    }
    blended
}

/// Blends the channels of sixteen lanes' four texels by their weights.
///
/// Out of line, as only there are compilers sure to see that channels are blended side by side.
#[inline(never)]
fn blend(
    [sw, se, nw, ne]: &[[u8; 4 * LANES]; 4],
    easts: &[i16; 4 * LANES],
    norths: &[i16; 4 * LANES],
) -> [u8; 4 * LANES] {
    let mut blended = [0; 4 * LANES];
    for (k, blended) in blended.iter_mut().enumerate() {
        // Six bits of a fraction.
        let [sw, se, nw, ne] = [sw[k], se[k], nw[k], ne[k]].map(|corner| i16::from(corner) << 6);
        let south = along(sw, se, easts[k]);
        let north = along(nw, ne, easts[k]);
        *blended = (along(south, north, norths[k]).wrapping_add(32) >> 6) as u8;
    }
    blended
}

/// From `from` to `to` by a share in 15-bit fixed point. Numbers of lanes that are no cells may
/// overflow.
#[inline(always)]
fn along(from: i16, to: i16, share: i16) -> i16 {
    from.wrapping_add(rounded_product(to.wrapping_sub(from), share))
}

/// a·b in 15-bit fixed point, rounded to nearest (the processors' `pmulhrsw`), where |a| is below 2¹⁴.
#[inline(always)]
fn rounded_product(a: i16, b: i16) -> i16 {
    // (a·b + 2¹⁴) / 2¹⁵ in sixteen bits: what is above them of 2a·b, and the bit that rounds it.
    let twice = a.wrapping_add(a);
    let whole = ((i32::from(twice) * i32::from(b)) >> 16) as i16;
    let low = a.wrapping_mul(b) as u16;
    whole.wrapping_add((low >> 14 & 1) as i16)
}

/// Where all kernels are one function, the compiler loses the overview of it.
#[inline(never)]
fn run<R>(work: impl FnOnce() -> R) -> R {
    work()
}
