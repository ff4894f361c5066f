//! AVX2: eight lanes a register, two registers a group.

mod pairs;
mod texels;

use self::pairs::{apart, bounded, pairs, rows};
use self::texels::{along, blend, blend_by_six_bits};
use super::alone::place_alone;
use super::{LANES, Lanes, Texels};
use sandtable_terrain::SlabView;
use std::arch::x86_64::*;

/// The proof that the processor has AVX2, and the instructions on bits that came with it or before.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(());

impl Avx2 {
    /// The proof, where there is one.
    pub(crate) fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("popcnt"))
        .then_some(Self(()))
    }
}

/// Lanes 0 to 7, and 8 to 15.
type F = [__m256; 2];
type I = [__m256i; 2];
/// All ones or all zeros a lane.
type M = [__m256i; 2];

/// Intrinsics on values.
macro_rules! on_values {
    ($intrinsics:expr) => {
        // SAFETY: whoever holds an `Avx2` has seen that the processor has the instructions.
        unsafe { $intrinsics }
    };
}

/// An intrinsic on both halves of groups.
macro_rules! on_halves {
    ($intrinsic:expr, $($group:ident),+) => {
        on_values!([$intrinsic($($group[0]),+), $intrinsic($($group[1]),+)])
    };
}

#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline(never)]
fn run<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// For each mask of eight lanes, the numbers of its lanes, a byte each, closed up.
static CLOSED_UP: [u64; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut end) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask] |= lane << (8 * end);
                end += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// Which lanes of a mask's halves are set.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
fn bits_of(mask: M) -> [usize; 2] {
    let [low, high] = mask;
    [
        _mm256_movemask_ps(_mm256_castsi256_ps(low)) as u8 as usize,
        _mm256_movemask_ps(_mm256_castsi256_ps(high)) as u8 as usize,
    ]
}

/// Writes the lanes of `mask`, closed up, to the front of `to`.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
fn close_up(mask: M, value: I, to: &mut [i32; LANES]) {
    let [low, high] = bits_of(mask);
    let [from_low, from_high] = [&raw const CLOSED_UP[low], &raw const CLOSED_UP[high]];
    // SAFETY: a table's entry has eight bytes.
    let lanes = unsafe {
        [
            _mm256_cvtepu8_epi32(_mm_loadl_epi64(from_low.cast())),
            _mm256_cvtepu8_epi32(_mm_loadl_epi64(from_high.cast())),
        ]
    };
    let to = to.as_mut_ptr();
    // SAFETY: a half takes eight of the sixteen places, and no more than eight are before it.
    unsafe {
        _mm256_storeu_si256(to.cast(), _mm256_permutevar8x32_epi32(value[0], lanes[0]));
        _mm256_storeu_si256(
            to.add(low.count_ones() as usize).cast(),
            _mm256_permutevar8x32_epi32(value[1], lanes[1]),
        );
    }
}

/// The same, of which a compiler knows no more where it comes from: of what is selected of memory it
/// would make masked stores, which take AMD's processors a dozen cycles each.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
fn opaque(mut half: __m256) -> __m256 {
    // SAFETY: there are no instructions.
    unsafe {
        std::arch::asm!(
            "/* {0} */",
            inout(ymm_reg) half,
            options(pure, nomem, nostack, preserves_flags)
        );
    }
    half
}

/// Writes two pairs to two places.
///
/// # Safety
/// There is room for a pair at each.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
unsafe fn write_two(to: *mut [i32; 2], places: i64, pairs: __m128i) {
    let (even, odd) = (places as u32 as usize, (places as u64 >> 32) as usize);
    // SAFETY: the caller's promise.
    unsafe {
        _mm_storel_epi64(to.add(even).cast(), pairs);
        _mm_storeh_pd(to.add(odd).cast(), _mm_castsi128_pd(pairs));
    }
}

/// No lane beyond `last`, as unsigned numbers.
#[inline(always)]
fn limited(at: I, last: usize) -> I {
    let last = i32::try_from(last).unwrap_or(i32::MAX);
    let last = on_values!([_mm256_set1_epi32(last); 2]);
    on_halves!(_mm256_min_epu32, at, last)
}

/// Columns for rows, of a square of eight: within halves of registers first, then whole halves.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
fn transposed(rows: [__m256i; 8]) -> [__m256i; 8] {
    let mut pairs = rows;
    for k in (0..8).step_by(2) {
        pairs[k] = _mm256_unpacklo_epi32(rows[k], rows[k + 1]);
        pairs[k + 1] = _mm256_unpackhi_epi32(rows[k], rows[k + 1]);
    }
    // Row 4 b + c now: in half h, the rows 4 b to 4 b + 3 of column 4 h + c.
    let mut fours = pairs;
    for b in [0, 4] {
        fours[b] = _mm256_unpacklo_epi64(pairs[b], pairs[b + 2]);
        fours[b + 1] = _mm256_unpackhi_epi64(pairs[b], pairs[b + 2]);
        fours[b + 2] = _mm256_unpacklo_epi64(pairs[b + 1], pairs[b + 3]);
        fours[b + 3] = _mm256_unpackhi_epi64(pairs[b + 1], pairs[b + 3]);
    }
    let mut columns = rows;
    for c in 0..4 {
        columns[c] = _mm256_permute2x128_si256::<0x20>(fours[c], fours[4 + c]);
        columns[4 + c] = _mm256_permute2x128_si256::<0x31>(fours[c], fours[4 + c]);
    }
    columns
}

/// The lanes of a group that the last four bits of eight lanes name.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
fn picked([low, high]: I, at: __m256i) -> __m256i {
    let low = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(low, at));
    let high = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(high, at));
    // The fourth bit, where a sign is, tells the halves apart.
    let which = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(at));
    _mm256_castps_si256(_mm256_blendv_ps(low, high, which))
}

impl Lanes for Avx2 {
    type F = F;
    type I = I;
    type M = M;

    #[inline(always)]
    fn vectorize<R>(self, work: impl FnOnce() -> R) -> R {
        on_values!(run(work))
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F {
        on_values!([_mm256_set1_ps(value); 2])
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> F {
        let from = from.as_ptr();
        // SAFETY: there are sixteen lanes.
        unsafe { [_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(8))] }
    }
    #[inline(always)]
    fn store(self, value: F, to: &mut [f32; LANES]) {
        let to = to.as_mut_ptr();
        // SAFETY: there is room for sixteen lanes.
        unsafe {
            _mm256_storeu_ps(to, value[0]);
            _mm256_storeu_ps(to.add(8), value[1]);
        }
    }
    #[inline(always)]
    fn store_where(self, mask: M, value: F, to: &mut [f32; LANES]) {
        let all = self.select(mask, value, self.load(to));
        self.store(on_halves!(opaque, all), to);
    }
    #[inline(always)]
    fn add(self, a: F, b: F) -> F {
        on_halves!(_mm256_add_ps, a, b)
    }
    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        on_halves!(_mm256_sub_ps, a, b)
    }
    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        on_halves!(_mm256_mul_ps, a, b)
    }
    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        on_halves!(_mm256_div_ps, a, b)
    }
    #[inline(always)]
    fn sqrt(self, a: F) -> F {
        on_halves!(_mm256_sqrt_ps, a)
    }
    #[inline(always)]
    fn abs(self, a: F) -> F {
        let sign = on_values!([_mm256_set1_ps(-0.0); 2]);
        on_halves!(_mm256_andnot_ps, sign, a)
    }
    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        on_halves!(_mm256_min_ps, a, b)
    }
    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        on_halves!(_mm256_max_ps, a, b)
    }

    #[inline(always)]
    fn lt(self, a: F, b: F) -> M {
        let less = on_halves!(_mm256_cmp_ps::<_CMP_LT_OQ>, a, b);
        on_halves!(_mm256_castps_si256, less)
    }
    #[inline(always)]
    fn le(self, a: F, b: F) -> M {
        let no_more = on_halves!(_mm256_cmp_ps::<_CMP_LE_OQ>, a, b);
        on_halves!(_mm256_castps_si256, no_more)
    }
    #[inline(always)]
    fn select(self, mask: M, yes: F, no: F) -> F {
        let mask = on_halves!(_mm256_castsi256_ps, mask);
        on_halves!(_mm256_blendv_ps, no, yes, mask)
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        on_values!({
            let bits = _mm256_set1_epi32(i32::from(bits));
            let low = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let high = _mm256_slli_epi32::<8>(low);
            [
                _mm256_cmpeq_epi32(_mm256_and_si256(bits, low), low),
                _mm256_cmpeq_epi32(_mm256_and_si256(bits, high), high),
            ]
        })
    }
    #[inline(always)]
    fn bits(self, mask: M) -> u16 {
        let [low, high] = on_values!(bits_of(mask));
        (low | high << 8) as u16
    }
    #[inline(always)]
    fn and(self, a: M, b: M) -> M {
        on_halves!(_mm256_and_si256, a, b)
    }
    #[inline(always)]
    fn or(self, a: M, b: M) -> M {
        on_halves!(_mm256_or_si256, a, b)
    }
    #[inline(always)]
    fn and_not(self, a: M, b: M) -> M {
        on_halves!(_mm256_andnot_si256, b, a)
    }

    #[inline(always)]
    fn splat_i(self, value: i32) -> I {
        on_values!([_mm256_set1_epi32(value); 2])
    }
    #[inline(always)]
    fn load_i(self, from: &[i32; LANES]) -> I {
        let from = from.as_ptr();
        // SAFETY: there are sixteen lanes.
        unsafe {
            [
                _mm256_loadu_si256(from.cast()),
                _mm256_loadu_si256(from.add(8).cast()),
            ]
        }
    }
    #[inline(always)]
    fn store_i(self, value: I, to: &mut [i32; LANES]) {
        let to = to.as_mut_ptr();
        // SAFETY: there is room for sixteen lanes.
        unsafe {
            _mm256_storeu_si256(to.cast(), value[0]);
            _mm256_storeu_si256(to.add(8).cast(), value[1]);
        }
    }
    #[inline(always)]
    fn ends(self, value: I) -> [i32; 2] {
        on_values!([
            _mm256_cvtsi256_si32(value[0]),
            _mm256_extract_epi32::<7>(value[1]),
        ])
    }
    #[inline(always)]
    fn add_i(self, a: I, b: I) -> I {
        on_halves!(_mm256_add_epi32, a, b)
    }
    #[inline(always)]
    fn sub_i(self, a: I, b: I) -> I {
        on_halves!(_mm256_sub_epi32, a, b)
    }
    #[inline(always)]
    fn mul_i(self, a: I, b: I) -> I {
        on_halves!(_mm256_mullo_epi32, a, b)
    }
    #[inline(always)]
    fn mul_small(self, a: I, b: I) -> I {
        on_halves!(_mm256_madd_epi16, a, b)
    }
    #[inline(always)]
    fn min_halves(self, a: I, b: I) -> I {
        on_halves!(_mm256_min_epu16, a, b)
    }
    #[inline(always)]
    fn mul_halves(self, a: I, b: I) -> I {
        on_halves!(_mm256_mullo_epi16, a, b)
    }
    #[inline(always)]
    fn lerp_halves(self, a: I, b: I, share: I) -> I {
        on_halves!(along, a, b, share)
    }
    #[inline(always)]
    fn and_i(self, a: I, b: I) -> I {
        on_halves!(_mm256_and_si256, a, b)
    }
    #[inline(always)]
    fn min_i(self, a: I, b: I) -> I {
        on_halves!(_mm256_min_epi32, a, b)
    }
    #[inline(always)]
    fn max_i(self, a: I, b: I) -> I {
        on_halves!(_mm256_max_epi32, a, b)
    }
    #[inline(always)]
    fn shl_i(self, a: I, by: I) -> I {
        on_halves!(_mm256_sllv_epi32, a, by)
    }
    #[inline(always)]
    fn shr_i(self, a: I, by: I) -> I {
        on_halves!(_mm256_srav_epi32, a, by)
    }
    #[inline(always)]
    fn gt_i(self, a: I, b: I) -> M {
        on_halves!(_mm256_cmpgt_epi32, a, b)
    }
    #[inline(always)]
    fn eq_i(self, a: I, b: I) -> M {
        on_halves!(_mm256_cmpeq_epi32, a, b)
    }
    #[inline(always)]
    fn select_i(self, mask: M, yes: I, no: I) -> I {
        on_halves!(_mm256_blendv_epi8, no, yes, mask)
    }
    #[inline(always)]
    fn add_i_where(self, mask: M, a: I, b: I) -> I {
        self.add_i(a, self.and_i(b, mask))
    }
    #[inline(always)]
    fn bits_of_float(self, number: F) -> I {
        on_halves!(_mm256_castps_si256, number)
    }
    #[inline(always)]
    fn float_of_bits(self, bits: I) -> F {
        on_halves!(_mm256_castsi256_ps, bits)
    }

    #[inline(always)]
    fn to_float(self, a: I) -> F {
        on_halves!(_mm256_cvtepi32_ps, a)
    }
    #[inline(always)]
    fn to_int(self, a: F) -> I {
        on_halves!(_mm256_cvttps_epi32, a)
    }

    #[inline(always)]
    fn exponent(self, a: F) -> I {
        let bits = on_halves!(_mm256_castps_si256, a);
        let biased = on_halves!(_mm256_srli_epi32::<23>, bits);
        self.sub_i(biased, self.splat_i(127))
    }

    #[inline(always)]
    fn compress_i(self, mask: M, value: I, to: &mut [i32; LANES]) {
        on_values!(close_up(mask, value, to));
    }

    #[inline(always)]
    fn transpose(self, rows: [I; LANES]) -> [I; LANES] {
        let mut columns = rows;
        for from in 0..2 {
            for to in 0..2 {
                let square = std::array::from_fn(
                    #[inline(always)]
                    |k| rows[8 * from + k][to],
                );
                let square = on_values!(transposed(square));
                for k in 0..8 {
                    columns[8 * to + k][from] = square[k];
                }
            }
        }
        columns
    }

    #[inline(always)]
    fn scatter(self, mask: M, at: I, value: F, to: &mut [f32]) {
        assert!(!to.is_empty());
        let last = to.len() - 1;
        let (mut places, mut values) = ([0; LANES], [0.0; LANES]);
        // All sixteen: how many lanes there are is not foreseen, and to find that out takes longer.
        self.store_i(self.select_i(mask, at, self.splat_i(-1)), &mut places);
        self.store(value, &mut values);
        for k in 0..LANES {
            to[(places[k] as u32 as usize).min(last)] = values[k];
        }
    }

    #[inline(always)]
    fn scatter_pairs(self, mask: M, at: I, [first, second]: [I; 2], to: &mut [[i32; 2]]) {
        assert!(!to.is_empty());
        let last = to.len() - 1;
        let at = limited(self.select_i(mask, at, self.splat_i(-1)), last);
        let to = to.as_mut_ptr();
        for half in 0..2 {
            let (at, first, second) = (at[half], first[half], second[half]);
            let (low, high) = on_values!((
                _mm256_unpacklo_epi32(first, second),
                _mm256_unpackhi_epi32(first, second),
            ));
            macro_rules! write_quarter {
                ($quarter:literal) => {
                    // SAFETY: no place is beyond the last pair, nor before the first.
                    unsafe {
                        let at = _mm256_extracti128_si256::<$quarter>(at);
                        write_two(
                            to,
                            _mm_cvtsi128_si64(at),
                            _mm256_extracti128_si256::<$quarter>(low),
                        );
                        write_two(
                            to,
                            _mm_extract_epi64::<1>(at),
                            _mm256_extracti128_si256::<$quarter>(high),
                        );
                    }
                };
            }
            write_quarter!(0);
            write_quarter!(1);
        }
    }

    #[inline(always)]
    fn cells(self, posts: &SlabView<'_, f32>, at: &[i32; LANES], stride: u32) -> [F; 4] {
        let [low, high] = rows(posts, at, stride);
        on_values!({
            let ([sw, se], [nw, ne]) = (apart(low[0]), apart(low[1]));
            let ([high_sw, high_se], [high_nw, high_ne]) = (apart(high[0]), apart(high[1]));
            [[sw, high_sw], [se, high_se], [nw, high_nw], [ne, high_ne]]
        })
    }

    #[inline(always)]
    fn byte_cells(self, bytes: &SlabView<'_, u8>, at: I, stride: u32) -> [F; 4] {
        assert!(bytes.len() >= stride as usize + 4, "a tile has a cell");
        // Four bytes are read where two are asked for, so the last places are read from before.
        let from = limited(at, bytes.len() - (stride as usize + 4));
        let south = bytes.as_ptr();
        let north = south.wrapping_add(stride as usize);
        // SAFETY: from each place on there is a row and four bytes.
        let (south, north) = unsafe {
            (
                [
                    _mm256_i32gather_epi32::<1>(south.cast(), from[0]),
                    _mm256_i32gather_epi32::<1>(south.cast(), from[1]),
                ],
                [
                    _mm256_i32gather_epi32::<1>(north.cast(), from[0]),
                    _mm256_i32gather_epi32::<1>(north.cast(), from[1]),
                ],
            )
        };
        let skipped = self.shl_i(self.sub_i(at, from), self.splat_i(3));
        let (byte, eight) = (self.splat_i(0xff), self.splat_i(8));
        // The upper bytes that come down are those of what was read, or copies of a sign.
        let (south, north) = (self.shr_i(south, skipped), self.shr_i(north, skipped));
        let (south_east, north_east) = (self.shr_i(south, eight), self.shr_i(north, eight));
        [
            self.to_float(self.and_i(south, byte)),
            self.to_float(self.and_i(south_east, byte)),
            self.to_float(self.and_i(north, byte)),
            self.to_float(self.and_i(north_east, byte)),
        ]
    }

    #[inline(always)]
    fn pairs(self, items: &SlabView<'_, [u32; 2]>, at: &[i32; LANES]) -> [I; 2] {
        assert!(!items.is_empty());
        let last = items.len() - 1;
        let from = items.as_ptr();
        let mut moved = [0; LANES];
        let at = on_values!(bounded(at, last, &mut moved));
        let address = |k| [from.wrapping_add(place_alone(at, k)).cast()];
        // SAFETY: no place is behind the last pair.
        unsafe {
            let ([low], [high]) = (pairs(0, address), pairs(8, address));
            let [first_low, second_low] = apart(low);
            let [first_high, second_high] = apart(high);
            [
                [
                    _mm256_castps_si256(first_low),
                    _mm256_castps_si256(first_high),
                ],
                [
                    _mm256_castps_si256(second_low),
                    _mm256_castps_si256(second_high),
                ],
            ]
        }
    }

    #[inline(always)]
    fn pick(self, table: I, at: I) -> I {
        on_values!([picked(table, at[0]), picked(table, at[1])])
    }

    #[inline(always)]
    fn among(self, table: [I; 2], at: I) -> I {
        let (low, high) = (self.pick(table[0], at), self.pick(table[1], at));
        let which = self.gt_i(self.and_i(at, self.splat_i(16)), self.splat_i(0));
        self.select_i(which, high, low)
    }

    #[inline(always)]
    fn look_up(self, table: &[u32], at: I) -> I {
        assert!(!table.is_empty());
        let at = limited(at, table.len() - 1);
        let table = table.as_ptr().cast();
        // SAFETY: no place is behind the last entry.
        unsafe {
            [
                _mm256_i32gather_epi32::<4>(table, at[0]),
                _mm256_i32gather_epi32::<4>(table, at[1]),
            ]
        }
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
        let [low, high] = rows(texels, at, stride);
        on_values!([
            blend(low, east[0], north[0]),
            blend(high, east[1], north[1])
        ])
    }

    #[inline(always)]
    fn mean_texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        stride: u32,
        places: [Texels<'_, Self>; 2],
    ) -> I {
        let [first, second] = places;
        let first_rows = rows(texels, first.at, stride);
        let second_rows = rows(texels, second.at, stride);
        on_values!({
            let first = [
                blend_by_six_bits(first_rows[0], first.east[0], first.north[0]),
                blend_by_six_bits(first_rows[1], first.east[1], first.north[1]),
            ];
            let second = [
                blend_by_six_bits(second_rows[0], second.east[0], second.north[0]),
                blend_by_six_bits(second_rows[1], second.east[1], second.north[1]),
            ];
            let half = _mm256_set1_epi16(64);
            let mean = |k: usize, n: usize| {
                let both = _mm256_add_epi16(first[k][n], second[k][n]);
                _mm256_srli_epi16::<7>(_mm256_add_epi16(both, half))
            };
            [
                _mm256_packus_epi16(mean(0, 0), mean(0, 1)),
                _mm256_packus_epi16(mean(1, 0), mean(1, 1)),
            ]
        })
    }
}
