//! The reference, which every processor runs: what all those of an architecture have, by `wide`, and plain
//! Rust where that is nothing.

use super::{LANES, Lanes, Texels};
use bytemuck::cast;
use sandtable_terrain::SlabView;
use wide::{f32x4, i16x8, i32x4, u16x8};

/// Sixteen lanes of what all processors have.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

type F = [f32; LANES];
type I = [i32; LANES];
/// All ones or all zeros a lane.
type M = [u32; LANES];

/// Lanes of one register.
const QUAD: usize = 4;
const QUADS: usize = LANES / QUAD;

/// Lanes by registers: compilers seldom find out by themselves that lanes can go side by side.
#[inline(always)]
fn floats(lanes: F) -> [f32x4; QUADS] {
    cast(lanes)
}

/// As [`floats`].
#[inline(always)]
fn ints(lanes: I) -> [i32x4; QUADS] {
    cast(lanes)
}

/// As [`floats`], of masks.
#[inline(always)]
fn masks(lanes: M) -> [i32x4; QUADS] {
    cast(lanes)
}

/// What `f` makes of each of a group's registers.
#[inline(always)]
fn map<A, R>(f: impl Fn(A) -> R, a: [A; QUADS]) -> [R; QUADS] {
    let [a0, a1, a2, a3] = a;
    [f(a0), f(a1), f(a2), f(a3)]
}

/// As [`map`], of two.
#[inline(always)]
fn zip<A, B, R>(f: impl Fn(A, B) -> R, a: [A; QUADS], b: [B; QUADS]) -> [R; QUADS] {
    let ([a0, a1, a2, a3], [b0, b1, b2, b3]) = (a, b);
    [f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3)]
}

#[inline(always)]
fn each<R>(lane: impl FnMut(usize) -> R) -> [R; LANES] {
    std::array::from_fn(lane)
}

/// By how much all lanes are shifted, where that is known to be the same: there are instructions only for that.
#[inline(always)]
fn same_count(by: I) -> Option<u32> {
    let [a, b, c, d] = ints(by);
    let first = i32x4::splat(by[0]);
    let same = a.simd_eq(first) & b.simd_eq(first) & c.simd_eq(first) & d.simd_eq(first);
    same.all().then_some(by[0] as u32)
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

    /// The `count` items from a place on, where its slot has so many.
    #[inline(always)]
    fn items_at(&mut self, place: i32, count: usize) -> Option<&'a [T]> {
        let place = place as u32;
        let within = |begin: u32| {
            let at = place.wrapping_sub(begin) as usize;
            at..at.wrapping_add(count)
        };
        if let Some(items) = self.slot.get(within(self.begin)) {
            return Some(items);
        }
        (self.begin, self.slot) = self.items.slot_at(place);
        self.slot.get(within(self.begin))
    }

    /// The item at a place; zeros where there is none.
    #[inline(always)]
    fn item(&mut self, place: i32) -> T {
        self.items_at(place, 1)
            .map(|items| items[0])
            .unwrap_or_default()
    }

    /// The first item of each row of the cell at a place and the one behind it; zeros where there is
    /// no such cell.
    #[inline(always)]
    fn cell(&mut self, place: i32, stride: u32) -> [T; 4] {
        let stride = stride as usize;
        self.items_at(place, stride + 2)
            .map(|posts| [posts[0], posts[1], posts[stride], posts[stride + 1]])
            .unwrap_or_default()
    }
}

/// The lesser, and `b` where one is NaN.
#[inline(always)]
fn least(a: f32x4, b: f32x4) -> f32x4 {
    if cfg!(target_feature = "sse2") {
        a.fast_min(b)
    } else {
        a.simd_lt(b).bitselect(a, b)
    }
}

/// The greater, and `b` where one is NaN.
#[inline(always)]
fn greatest(a: f32x4, b: f32x4) -> f32x4 {
    if cfg!(target_feature = "sse2") {
        a.fast_max(b)
    } else {
        b.simd_lt(a).bitselect(a, b)
    }
}

impl Lanes for Portable {
    type F = F;
    type I = I;
    type M = M;

    const HOLDS_LITTLE: bool = true;

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
        cast(zip(|a, b| a + b, floats(a), floats(b)))
    }
    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        cast(zip(|a, b| a - b, floats(a), floats(b)))
    }
    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        cast(zip(|a, b| a * b, floats(a), floats(b)))
    }
    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        cast(zip(|a, b| a / b, floats(a), floats(b)))
    }
    #[inline(always)]
    fn sqrt(self, a: F) -> F {
        cast(map(f32x4::sqrt, floats(a)))
    }
    #[inline(always)]
    fn abs(self, a: F) -> F {
        cast(map(f32x4::abs, floats(a)))
    }
    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        cast(zip(least, floats(a), floats(b)))
    }
    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        cast(zip(greatest, floats(a), floats(b)))
    }

    #[inline(always)]
    fn lt(self, a: F, b: F) -> M {
        cast(zip(f32x4::simd_lt, floats(a), floats(b)))
    }
    #[inline(always)]
    fn le(self, a: F, b: F) -> M {
        cast(zip(f32x4::simd_le, floats(a), floats(b)))
    }
    #[inline(always)]
    fn select(self, mask: M, yes: F, no: F) -> F {
        cast(self.select_i(mask, cast(yes), cast(no)))
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        let bits = i32x4::splat(i32::from(bits));
        let own = ints(each(|k| 1 << k));
        cast(map(|own| (bits & own).simd_eq(own), own))
    }
    #[inline(always)]
    fn bits(self, mask: M) -> u16 {
        let [a, b, c, d] = map(i32x4::to_bitmask, masks(mask));
        (a | b << 4 | c << 8 | d << 12) as u16
    }
    #[inline(always)]
    fn and(self, a: M, b: M) -> M {
        cast(zip(|a, b| a & b, masks(a), masks(b)))
    }
    #[inline(always)]
    fn or(self, a: M, b: M) -> M {
        cast(zip(|a, b| a | b, masks(a), masks(b)))
    }
    #[inline(always)]
    fn and_not(self, a: M, b: M) -> M {
        cast(zip(|a, b| a & !b, masks(a), masks(b)))
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
        cast(zip(|a, b| a + b, ints(a), ints(b)))
    }
    #[inline(always)]
    fn sub_i(self, a: I, b: I) -> I {
        cast(zip(|a, b| a - b, ints(a), ints(b)))
    }
    #[inline(always)]
    fn mul_i(self, a: I, b: I) -> I {
        cast(zip(|a, b| a * b, ints(a), ints(b)))
    }
    #[inline(always)]
    fn mul_small(self, a: I, b: I) -> I {
        let product = |a: i32x4, b: i32x4| cast::<_, i16x8>(a).dot(cast(b));
        cast(zip(product, ints(a), ints(b)))
    }
    #[inline(always)]
    fn min_halves(self, a: I, b: I) -> I {
        let least = |a: u16x8, b: u16x8| a - a.saturating_sub(b);
        cast(zip(least, cast(a), cast(b)))
    }
    #[inline(always)]
    fn mul_halves(self, a: I, b: I) -> I {
        cast(zip(|a: i16x8, b: i16x8| a * b, cast(a), cast(b)))
    }
    #[inline(always)]
    fn lerp_halves(self, a: I, b: I, share: I) -> I {
        let (a, share): ([i16x8; QUADS], [i16x8; QUADS]) = (cast(a), cast(share));
        let way = zip(|a: i16x8, b: i16x8| b - a, a, cast(b));
        cast(zip(
            |a, part| a + part,
            a,
            zip(i16x8::mul_scale_round, way, share),
        ))
    }
    #[inline(always)]
    fn and_i(self, a: I, b: I) -> I {
        cast(zip(|a, b| a & b, ints(a), ints(b)))
    }
    #[inline(always)]
    fn min_i(self, a: I, b: I) -> I {
        self.select_i(self.gt_i(b, a), a, b)
    }
    #[inline(always)]
    fn max_i(self, a: I, b: I) -> I {
        self.select_i(self.gt_i(a, b), a, b)
    }
    #[inline(always)]
    fn shl_i(self, a: I, by: I) -> I {
        if let Some(by) = same_count(by) {
            return cast(map(|a| a << by, ints(a)));
        }
        each(|k| a[k].wrapping_shl(by[k] as u32))
    }
    #[inline(always)]
    fn shr_i(self, a: I, by: I) -> I {
        if let Some(by) = same_count(by) {
            return cast(map(|a| a >> by, ints(a)));
        }
        each(|k| a[k].wrapping_shr(by[k] as u32))
    }
    #[inline(always)]
    fn gt_i(self, a: I, b: I) -> M {
        cast(zip(i32x4::simd_gt, ints(a), ints(b)))
    }
    #[inline(always)]
    fn eq_i(self, a: I, b: I) -> M {
        cast(zip(i32x4::simd_eq, ints(a), ints(b)))
    }
    #[inline(always)]
    fn select_i(self, mask: M, yes: I, no: I) -> I {
        let yes = zip(|mask, yes| mask & yes, masks(mask), ints(yes));
        let no = zip(|mask: i32x4, no| !mask & no, masks(mask), ints(no));
        cast(zip(|yes, no| yes | no, yes, no))
    }
    #[inline(always)]
    fn add_i_where(self, mask: M, a: I, b: I) -> I {
        self.add_i(a, cast(zip(|b, mask| b & mask, ints(b), masks(mask))))
    }
    #[inline(always)]
    fn bits_of_float(self, number: F) -> I {
        cast(number)
    }
    #[inline(always)]
    fn float_of_bits(self, bits: I) -> F {
        cast(bits)
    }
    #[inline(always)]
    fn to_float(self, a: I) -> F {
        cast(map(i32x4::round_float, ints(a)))
    }
    #[inline(always)]
    fn to_int(self, a: F) -> I {
        cast(map(f32x4::fast_trunc_int, floats(a)))
    }

    #[inline(always)]
    fn exponent(self, a: F) -> I {
        self.sub_i(self.shr_i(cast(a), self.splat_i(23)), self.splat_i(127))
    }

    #[inline(always)]
    fn compress_i(self, mask: M, value: I, to: &mut I) {
        self.compress_all(mask, [value], [to]);
    }

    #[inline(always)]
    fn compress_all<const N: usize>(self, mask: M, values: [I; N], mut to: [&mut [i32; LANES]; N]) {
        // Each lane is looked for once for all columns, and one end is not foreseen instead of many.
        let mut bits = self.bits(mask);
        if bits == u16::MAX {
            // Register by register.
            for (to, value) in to.iter_mut().zip(&values) {
                **to = *value;
            }
            return;
        }
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
    fn transpose(self, rows: [I; LANES]) -> [I; LANES] {
        // As registers until the end: lanes may lie where no register may.
        let mut columns = [[f32x4::splat(0.0); QUADS]; LANES];
        for from in 0..QUADS {
            for to in 0..QUADS {
                let quad = |k: usize| floats(cast(rows[QUAD * from + k]))[to];
                let turned = f32x4::transpose([quad(0), quad(1), quad(2), quad(3)]);
                for k in 0..QUAD {
                    columns[QUAD * to + k][from] = turned[k];
                }
            }
        }
        columns.map(cast)
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
        let mut corners = [[f32x4::splat(0.0); QUADS]; 4];
        let mut cursor = Cursor::new(posts);
        for quad in 0..QUADS {
            let mut cell = |k: usize| f32x4::new(cursor.cell(at[QUAD * quad + k], stride));
            let cells = [cell(0), cell(1), cell(2), cell(3)];
            for (to, corner) in corners.iter_mut().zip(f32x4::transpose(cells)) {
                to[quad] = corner;
            }
        }
        cast(corners)
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
        let mut numbers = [[i32x4::splat(0); QUADS]; 2];
        let mut cursor = Cursor::new(pairs);
        for quad in 0..QUADS {
            let mut pair = |k: usize| cursor.item(at[QUAD * quad + k]).map(|number| number as i32);
            let pairs = [pair(0), pair(1), pair(2), pair(3)];
            for (number, to) in numbers.iter_mut().enumerate() {
                to[quad] = i32x4::new(pairs.map(|pair| pair[number]));
            }
        }
        cast(numbers)
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
