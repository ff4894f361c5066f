//! AVX-512: sixteen lanes a register.

use super::alone::place_alone;
use super::{LANES, Lanes, Texels};
use sandtable_terrain::SlabView;
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// The proof that the processor has AVX-512 F, BW, DQ and VL, and the instructions on bits that
/// came before them.
#[derive(Clone, Copy)]
pub(crate) struct Avx512 {
    /// Whether its own instructions that read lanes' pairs take less time than a read for each lane.
    gathers: bool,
}

impl Avx512 {
    /// The proof, where there is one.
    pub(crate) fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("popcnt"))
        .then_some(Self {
            // So it is on Intel's processors that have half floats: casts take 1 to 5 % less time.
            // On AMD's a read for each lane takes two thirds of the time.
            gathers: is_x86_feature_detected!("avx512fp16"),
        })
    }

    /// Whether to gather pairs of which the last place is `last`: to the processor's instruction
    /// places have a sign.
    #[inline(always)]
    fn gathers_up_to(self, last: usize) -> bool {
        self.gathers && last <= i32::MAX as usize
    }

    /// The same, reading lanes' pairs the other way.
    #[cfg(test)]
    pub(crate) fn reading_otherwise(self) -> Self {
        Self {
            gathers: !self.gathers,
        }
    }
}

/// An intrinsic on values.
macro_rules! on_values {
    ($intrinsic:expr) => {
        // SAFETY: whoever holds an `Avx512` has seen that the processor has the instruction.
        unsafe { $intrinsic }
    };
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline(never)]
fn run<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// Two neighbouring items of four bytes each, of eight lanes.
///
/// Lanes 0, 1, 4, 5, 8, 9, 12 and 13 come together, and the others: then what works within quarters
/// of registers gives sixteen lanes in order.
type Pairs = __m512i;

/// The pairs at the `N` addresses of each of sixteen lanes. They are read together, so that what
/// tells a lane's addresses is read once.
///
/// # Safety
/// Eight bytes can be read at each.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
unsafe fn pairs<const N: usize>(address: impl Fn(usize) -> [*const u8; N]) -> [[Pairs; 2]; N] {
    let quarter = |k: usize| {
        let (first, second) = (address(k), address(k + 1));
        std::array::from_fn::<_, N, _>(|n| {
            // SAFETY: the caller's promise.
            unsafe {
                let low = _mm_loadl_epi64(first[n].cast());
                let both = _mm_loadh_pd(_mm_castsi128_pd(low), second[n].cast());
                _mm_castpd_si128(both)
            }
        })
    };
    let half = |k: usize| {
        let [a, b, c, d] = [quarter(k), quarter(k + 4), quarter(k + 8), quarter(k + 12)];
        std::array::from_fn::<_, N, _>(|n| {
            let low = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(a[n]), b[n]);
            let high = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(c[n]), d[n]);
            _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)
        })
    };
    let (low, high) = (half(0), half(2));
    std::array::from_fn(|n| [low[n], high[n]])
}

/// The first items of pairs, and the second ones.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
fn apart([a, b]: [Pairs; 2]) -> [__m512; 2] {
    let (a, b) = (_mm512_castsi512_ps(a), _mm512_castsi512_ps(b));
    [
        _mm512_shuffle_ps::<0b10_00_10_00>(a, b),
        _mm512_shuffle_ps::<0b11_01_11_01>(a, b),
    ]
}

/// `at`, where no place in it is behind `last`, as is usual; else a copy in `elsewhere`, with those that
/// are moved to it. One comparison for all lanes takes less time than one each.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
fn bounded<'a>(
    at: &'a [i32; LANES],
    last: usize,
    elsewhere: &'a mut MaybeUninit<[i32; LANES]>,
) -> &'a [i32; LANES] {
    let bound = u32::try_from(last).unwrap_or(u32::MAX);
    // SAFETY: a reference can be read.
    let places = unsafe { _mm512_loadu_si512(at.as_ptr().cast()) };
    if _mm512_cmpgt_epu32_mask(places, _mm512_set1_epi32(bound as i32)) == 0 {
        return at;
    }
    elsewhere.write(moved(at, bound))
}

/// Places, of which those behind `last` are moved to it.
#[cold]
#[inline(never)]
fn moved(at: &[i32; LANES], last: u32) -> [i32; LANES] {
    at.map(|place| (place as u32).min(last) as i32)
}

/// As `pairs`, at places in rows of items of `SIZE` bytes each, by the processor's own instruction.
///
/// # Safety
/// Eight bytes can be read at each place of each row, and no place is above `i32::MAX`.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
unsafe fn gathered<const SIZE: i32, const N: usize>(
    at: &[i32; LANES],
    rows: [*const u8; N],
) -> [[Pairs; 2]; N] {
    // SAFETY: a reference can be read.
    let places = unsafe { _mm512_loadu_si512(at.as_ptr().cast()) };
    let order = _mm512_setr_epi32(0, 1, 4, 5, 8, 9, 12, 13, 2, 3, 6, 7, 10, 11, 14, 15);
    let places = _mm512_permutexvar_epi32(order, places);
    let low = _mm512_castsi512_si256(places);
    let high = _mm512_extracti64x4_epi64::<1>(places);
    // SAFETY: the caller's promise.
    std::array::from_fn(|n| unsafe {
        [
            _mm512_i32gather_epi64::<SIZE>(low, rows[n].cast()),
            _mm512_i32gather_epi64::<SIZE>(high, rows[n].cast()),
        ]
    })
}

/// The pairs at lanes' places, and those a row further. Places behind the last cell are moved to
/// it.
#[inline(always)]
fn rows<T>(l: Avx512, items: &SlabView<'_, T>, at: &[i32; LANES], stride: u32) -> [[Pairs; 2]; 2] {
    const { assert!(size_of::<T>() == 4) };
    assert!(items.len() >= stride as usize + 2, "a tile has a cell");
    let last = items.len() - (stride as usize + 2);
    let south = items.as_ptr();
    let north = south.wrapping_add(stride as usize);
    let mut elsewhere = MaybeUninit::uninit();
    let at = on_values!(bounded(at, last, &mut elsewhere));
    // SAFETY: from each place on there is a row and two items.
    unsafe {
        if l.gathers_up_to(last) {
            return gathered::<4, _>(at, [south.cast(), north.cast()]);
        }
        pairs(|k| {
            let place = place_alone(at, k);
            [
                south.wrapping_add(place).cast(),
                north.wrapping_add(place).cast(),
            ]
        })
    }
}

/// Blends sixteen lanes' four texels: a southern and a northern row of neighbours.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
fn blend([south, north_row]: [[Pairs; 2]; 2], east: __m512, north: __m512) -> __m512i {
    let scale = _mm512_set1_ps(32767.0);
    let east = _mm512_cvttps_epi32(_mm512_mul_ps(east, scale));
    let north = _mm512_cvttps_epi32(_mm512_mul_ps(north, scale));
    // Eight lanes' western and eastern texels, 16 bits a channel, six of them a fraction.
    let west_of = _mm512_broadcast_i32x4(_mm_setr_epi8(
        0, -1, 1, -1, 2, -1, 3, -1, 8, -1, 9, -1, 10, -1, 11, -1,
    ));
    let east_of = _mm512_broadcast_i32x4(_mm_setr_epi8(
        4, -1, 5, -1, 6, -1, 7, -1, 12, -1, 13, -1, 14, -1, 15, -1,
    ));
    let along = |from, to, share| {
        _mm512_add_epi16(from, _mm512_mulhrs_epi16(_mm512_sub_epi16(to, from), share))
    };
    let row = |pairs, share| {
        let west = _mm512_slli_epi16::<6>(_mm512_shuffle_epi8(pairs, west_of));
        let east = _mm512_slli_epi16::<6>(_mm512_shuffle_epi8(pairs, east_of));
        along(west, east, share)
    };
    let eight = |k: usize| {
        let first = 2 * k as i64;
        let east = spread(east, first);
        let [south, north_row] = [row(south[k], east), row(north_row[k], east)];
        let blended = along(south, north_row, spread(north, first));
        _mm512_srli_epi16::<6>(_mm512_add_epi16(blended, _mm512_set1_epi16(32)))
    };
    _mm512_packus_epi16(eight(0), eight(1))
}

/// Of each quarter's four weights the two from `first` on, in the order of `Pairs`, on each of their four channels.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
fn spread(weights: __m512i, first: i64) -> __m512i {
    let of = |lane: i64| 0x0100_0100_0100_0100 + 0x0404_0404_0404_0404 * (first + lane);
    let quarter = _mm_set_epi64x(of(1), of(0));
    _mm512_shuffle_epi8(weights, _mm512_broadcast_i32x4(quarter))
}

/// Blends sixteen lanes' four texels: 16 bits a channel, six of them a fraction, in the order of
/// `Pairs`.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
fn blend_by_six_bits(
    [south, north_row]: [[Pairs; 2]; 2],
    east: __m512i,
    north: __m512i,
) -> [__m512i; 2] {
    // The western texel's weight and, over it, the eastern one's.
    let share = _mm512_srli_epi32::<9>(_mm512_add_epi32(east, _mm512_set1_epi32(256)));
    let weights = _mm512_sub_epi32(_mm512_slli_epi32::<8>(share), share);
    let weights = _mm512_add_epi32(weights, _mm512_set1_epi32(64));
    let side_by_side = _mm512_broadcast_i32x4(_mm_setr_epi8(
        0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15,
    ));
    let row =
        |pairs, weights| _mm512_maddubs_epi16(_mm512_shuffle_epi8(pairs, side_by_side), weights);
    let eight = |k: usize| {
        let weights = spread(weights, 2 * k as i64);
        let [south, north_row] = [row(south[k], weights), row(north_row[k], weights)];
        let rise = _mm512_sub_epi16(north_row, south);
        let north = spread(north, 2 * k as i64);
        _mm512_add_epi16(south, _mm512_mulhrs_epi16(rise, north))
    };
    [eight(0), eight(1)]
}

/// Columns for rows: within quarters of registers first, then whole quarters.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,bmi1,bmi2,popcnt")]
#[inline]
fn transposed(rows: [__m512i; LANES]) -> [__m512i; LANES] {
    let mut pairs = rows;
    for k in (0..LANES).step_by(2) {
        pairs[k] = _mm512_unpacklo_epi32(rows[k], rows[k + 1]);
        pairs[k + 1] = _mm512_unpackhi_epi32(rows[k], rows[k + 1]);
    }
    // Row 4 b + c now: in quarter q, the rows 4 b to 4 b + 3 of column 4 q + c.
    let mut fours = pairs;
    for b in (0..LANES).step_by(4) {
        fours[b] = _mm512_unpacklo_epi64(pairs[b], pairs[b + 2]);
        fours[b + 1] = _mm512_unpackhi_epi64(pairs[b], pairs[b + 2]);
        fours[b + 2] = _mm512_unpacklo_epi64(pairs[b + 1], pairs[b + 3]);
        fours[b + 3] = _mm512_unpackhi_epi64(pairs[b + 1], pairs[b + 3]);
    }
    let mut columns = rows;
    for c in 0..4 {
        let low = _mm512_shuffle_i32x4::<0b10_00_10_00>(fours[c], fours[4 + c]);
        let low_odd = _mm512_shuffle_i32x4::<0b11_01_11_01>(fours[c], fours[4 + c]);
        let high = _mm512_shuffle_i32x4::<0b10_00_10_00>(fours[8 + c], fours[12 + c]);
        let high_odd = _mm512_shuffle_i32x4::<0b11_01_11_01>(fours[8 + c], fours[12 + c]);
        columns[c] = _mm512_shuffle_i32x4::<0b10_00_10_00>(low, high);
        columns[4 + c] = _mm512_shuffle_i32x4::<0b10_00_10_00>(low_odd, high_odd);
        columns[8 + c] = _mm512_shuffle_i32x4::<0b11_01_11_01>(low, high);
        columns[12 + c] = _mm512_shuffle_i32x4::<0b11_01_11_01>(low_odd, high_odd);
    }
    columns
}

impl Lanes for Avx512 {
    type F = __m512;
    type I = __m512i;
    type M = __mmask16;

    #[inline(always)]
    fn vectorize<R>(self, work: impl FnOnce() -> R) -> R {
        on_values!(run(work))
    }

    #[inline(always)]
    fn splat(self, value: f32) -> __m512 {
        on_values!(_mm512_set1_ps(value))
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> __m512 {
        on_values!(_mm512_loadu_ps(from.as_ptr()))
    }
    #[inline(always)]
    fn store(self, value: __m512, to: &mut [f32; LANES]) {
        on_values!(_mm512_storeu_ps(to.as_mut_ptr(), value));
    }
    #[inline(always)]
    fn add(self, a: __m512, b: __m512) -> __m512 {
        on_values!(_mm512_add_ps(a, b))
    }
    #[inline(always)]
    fn sub(self, a: __m512, b: __m512) -> __m512 {
        on_values!(_mm512_sub_ps(a, b))
    }
    #[inline(always)]
    fn mul(self, a: __m512, b: __m512) -> __m512 {
        on_values!(_mm512_mul_ps(a, b))
    }
    #[inline(always)]
    fn div(self, a: __m512, b: __m512) -> __m512 {
        on_values!(_mm512_div_ps(a, b))
    }
    #[inline(always)]
    fn sqrt(self, a: __m512) -> __m512 {
        on_values!(_mm512_sqrt_ps(a))
    }
    #[inline(always)]
    fn abs(self, a: __m512) -> __m512 {
        on_values!(_mm512_abs_ps(a))
    }
    #[inline(always)]
    fn min(self, a: __m512, b: __m512) -> __m512 {
        on_values!(_mm512_min_ps(a, b))
    }
    #[inline(always)]
    fn max(self, a: __m512, b: __m512) -> __m512 {
        on_values!(_mm512_max_ps(a, b))
    }

    #[inline(always)]
    fn lt(self, a: __m512, b: __m512) -> __mmask16 {
        on_values!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b))
    }
    #[inline(always)]
    fn le(self, a: __m512, b: __m512) -> __mmask16 {
        on_values!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b))
    }
    #[inline(always)]
    fn are_shares(self, a: __m512, b: __m512) -> __mmask16 {
        // Of numbers below 0 the first bit is set, of 1 it is not.
        on_values!({
            let most = _mm512_max_epu32(_mm512_castps_si512(a), _mm512_castps_si512(b));
            _mm512_cmple_epu32_mask(most, _mm512_set1_epi32(0x3f80_0000))
        })
    }
    #[inline(always)]
    fn select(self, mask: __mmask16, yes: __m512, no: __m512) -> __m512 {
        on_values!(_mm512_mask_mov_ps(no, mask, yes))
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> __mmask16 {
        bits
    }
    #[inline(always)]
    fn bits(self, mask: __mmask16) -> u16 {
        mask
    }
    #[inline(always)]
    fn and(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a & b
    }
    #[inline(always)]
    fn or(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a | b
    }
    #[inline(always)]
    fn and_not(self, a: __mmask16, b: __mmask16) -> __mmask16 {
        a & !b
    }

    #[inline(always)]
    fn splat_i(self, value: i32) -> __m512i {
        on_values!(_mm512_set1_epi32(value))
    }
    #[inline(always)]
    fn load_i(self, from: &[i32; LANES]) -> __m512i {
        on_values!(_mm512_loadu_si512(from.as_ptr().cast()))
    }
    #[inline(always)]
    fn store_i(self, value: __m512i, to: &mut [i32; LANES]) {
        on_values!(_mm512_storeu_si512(to.as_mut_ptr().cast(), value));
    }
    #[inline(always)]
    unsafe fn store_those(self, mask: u16, value: __m512i, to: *mut i32) {
        // SAFETY: lanes that are not of `mask` are not written, and by the caller's promise the others can be.
        unsafe { _mm512_mask_storeu_epi32(to, mask, value) }
    }
    #[inline(always)]
    fn ends(self, value: __m512i) -> [i32; 2] {
        on_values!({
            let last = _mm512_extracti32x4_epi32::<3>(value);
            [_mm512_cvtsi512_si32(value), _mm_extract_epi32::<3>(last)]
        })
    }

    #[inline(always)]
    fn add_i(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_add_epi32(a, b))
    }
    #[inline(always)]
    fn sub_i(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_sub_epi32(a, b))
    }
    #[inline(always)]
    fn mul_i(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_mullo_epi32(a, b))
    }
    #[inline(always)]
    fn mul_small(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_madd_epi16(a, b))
    }
    #[inline(always)]
    fn min_halves(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_min_epu16(a, b))
    }
    #[inline(always)]
    fn mul_halves(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_mullo_epi16(a, b))
    }
    #[inline(always)]
    fn lerp_halves(self, a: __m512i, b: __m512i, share: __m512i) -> __m512i {
        on_values!({
            let way = _mm512_sub_epi16(b, a);
            _mm512_add_epi16(a, _mm512_mulhrs_epi16(way, share))
        })
    }
    #[inline(always)]
    fn and_i(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_and_si512(a, b))
    }
    #[inline(always)]
    fn min_i(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_min_epi32(a, b))
    }
    #[inline(always)]
    fn max_i(self, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_max_epi32(a, b))
    }
    #[inline(always)]
    fn shl_i(self, a: __m512i, by: __m512i) -> __m512i {
        on_values!(_mm512_sllv_epi32(a, by))
    }
    #[inline(always)]
    fn shr_i(self, a: __m512i, by: __m512i) -> __m512i {
        on_values!(_mm512_srav_epi32(a, by))
    }
    #[inline(always)]
    fn gt_i(self, a: __m512i, b: __m512i) -> __mmask16 {
        on_values!(_mm512_cmpgt_epi32_mask(a, b))
    }
    #[inline(always)]
    fn eq_i(self, a: __m512i, b: __m512i) -> __mmask16 {
        on_values!(_mm512_cmpeq_epi32_mask(a, b))
    }
    #[inline(always)]
    fn select_i(self, mask: __mmask16, yes: __m512i, no: __m512i) -> __m512i {
        on_values!(_mm512_mask_mov_epi32(no, mask, yes))
    }
    #[inline(always)]
    fn add_i_where(self, mask: __mmask16, a: __m512i, b: __m512i) -> __m512i {
        on_values!(_mm512_mask_add_epi32(a, mask, a, b))
    }
    #[inline(always)]
    fn bits_of_float(self, number: __m512) -> __m512i {
        on_values!(_mm512_castps_si512(number))
    }
    #[inline(always)]
    fn float_of_bits(self, bits: __m512i) -> __m512 {
        on_values!(_mm512_castsi512_ps(bits))
    }
    #[inline(always)]
    fn to_float(self, a: __m512i) -> __m512 {
        on_values!(_mm512_cvtepi32_ps(a))
    }
    #[inline(always)]
    fn to_int(self, a: __m512) -> __m512i {
        on_values!(_mm512_cvttps_epi32(a))
    }

    #[inline(always)]
    fn exponent(self, a: __m512) -> __m512i {
        on_values!(_mm512_sub_epi32(
            _mm512_srli_epi32::<23>(_mm512_castps_si512(a)),
            _mm512_set1_epi32(127)
        ))
    }

    #[inline(always)]
    fn compress_i(self, mask: __mmask16, value: __m512i, to: &mut [i32; LANES]) {
        // Not the instruction that compresses to memory, which some processors run slowly. And lanes' numbers, once for
        // all columns of a mask, which follow them: Zen 5 needs four times as long to close up a register as to move
        // its lanes to where numbers say.
        on_values!({
            let numbers = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let order = _mm512_maskz_compress_epi32(mask, numbers);
            let closed = _mm512_permutexvar_epi32(order, value);
            _mm512_storeu_si512(to.as_mut_ptr().cast(), closed);
        });
    }

    #[inline(always)]
    fn transpose(self, rows: [__m512i; LANES]) -> [__m512i; LANES] {
        on_values!(transposed(rows))
    }

    #[inline(always)]
    fn scatter(self, mask: __mmask16, at: __m512i, value: __m512, to: &mut [f32]) {
        assert!(!to.is_empty());
        let last = i32::try_from(to.len() - 1).unwrap_or(i32::MAX);
        // SAFETY: no place is beyond the last item, nor before the first.
        unsafe {
            let at = _mm512_min_epu32(at, _mm512_set1_epi32(last));
            _mm512_mask_i32scatter_ps::<4>(to.as_mut_ptr().cast(), mask, at, value);
        }
    }

    #[inline(always)]
    fn scatter_pairs(self, mask: __mmask16, at: __m512i, pairs: [__m512i; 2], to: &mut [[i32; 2]]) {
        // The processor's own scattering takes twice as long as writing pairs one by one.
        assert!(!to.is_empty());
        let last = i32::try_from(to.len() - 1).unwrap_or(i32::MAX);
        let (at, [low, high]) = on_values!({
            let last = _mm512_set1_epi32(last);
            let at = _mm512_min_epu32(_mm512_mask_mov_epi32(last, mask, at), last);
            let low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
            let high =
                _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
            let in_turn = [
                _mm512_permutex2var_epi32(pairs[0], low, pairs[1]),
                _mm512_permutex2var_epi32(pairs[0], high, pairs[1]),
            ];
            (at, in_turn)
        });
        let to = to.as_mut_ptr();
        macro_rules! write {
            ($places:expr, $pairs:expr) => {
                // SAFETY: no place is beyond the last pair, nor before the first.
                unsafe {
                    let (places, pairs) = ($places, $pairs);
                    let (even, odd) = (places as u32 as usize, (places as u64 >> 32) as usize);
                    _mm_storel_epi64(to.add(even).cast(), pairs);
                    _mm_storeh_pd(to.add(odd).cast(), _mm_castsi128_pd(pairs));
                }
            };
        }
        macro_rules! write_quarter {
            ($number:literal, $half:ident, $first:literal, $second:literal) => {
                let places = on_values!(_mm512_extracti32x4_epi32::<$number>(at));
                write!(
                    _mm_cvtsi128_si64(places),
                    _mm512_extracti32x4_epi32::<$first>($half)
                );
                write!(
                    _mm_extract_epi64::<1>(places),
                    _mm512_extracti32x4_epi32::<$second>($half)
                );
            };
        }
        write_quarter!(0, low, 0, 1);
        write_quarter!(1, low, 2, 3);
        write_quarter!(2, high, 0, 1);
        write_quarter!(3, high, 2, 3);
    }

    #[inline(always)]
    fn cells(self, posts: &SlabView<'_, f32>, at: &[i32; LANES], stride: u32) -> [__m512; 4] {
        let [south, north] = rows(self, posts, at, stride);
        let ([sw, se], [nw, ne]) = on_values!((apart(south), apart(north)));
        [sw, se, nw, ne]
    }

    #[inline(always)]
    fn byte_cells(self, bytes: &SlabView<'_, u8>, at: __m512i, stride: u32) -> [__m512; 4] {
        assert!(bytes.len() >= stride as usize + 4, "a tile has a cell");
        // Four bytes are read where two are asked for, so the last places are read from before.
        let last = bytes.len() - (stride as usize + 4);
        let last = i32::try_from(last).unwrap_or(i32::MAX);
        // SAFETY: from each place on there is a row and four bytes.
        unsafe {
            let from = _mm512_min_epu32(at, _mm512_set1_epi32(last));
            let skipped = _mm512_slli_epi32::<3>(_mm512_sub_epi32(at, from));
            let mask = _mm512_set1_epi32(0xff);
            let south = _mm512_i32gather_epi32::<1>(from, bytes.as_ptr().cast());
            let north = bytes.as_ptr().wrapping_add(stride as usize);
            let north = _mm512_i32gather_epi32::<1>(from, north.cast());
            let west = _mm512_srlv_epi32(south, skipped);
            let north_west = _mm512_srlv_epi32(north, skipped);
            let (east, north_east) = (
                _mm512_srli_epi32::<8>(west),
                _mm512_srli_epi32::<8>(north_west),
            );
            [
                _mm512_cvtepi32_ps(_mm512_and_si512(west, mask)),
                _mm512_cvtepi32_ps(_mm512_and_si512(east, mask)),
                _mm512_cvtepi32_ps(_mm512_and_si512(north_west, mask)),
                _mm512_cvtepi32_ps(_mm512_and_si512(north_east, mask)),
            ]
        }
    }

    #[inline(always)]
    fn pairs(self, items: &SlabView<'_, [u32; 2]>, at: &[i32; LANES]) -> [__m512i; 2] {
        assert!(!items.is_empty());
        let last = items.len() - 1;
        let from = items.as_ptr();
        let mut elsewhere = MaybeUninit::uninit();
        let at = on_values!(bounded(at, last, &mut elsewhere));
        // SAFETY: no place is behind the last pair.
        unsafe {
            let [both] = if self.gathers_up_to(last) {
                gathered::<8, _>(at, [from.cast()])
            } else {
                pairs(|k| [from.wrapping_add(place_alone(at, k)).cast()])
            };
            apart(both).map(|items| _mm512_castps_si512(items))
        }
    }

    #[inline(always)]
    fn pick(self, table: __m512i, at: __m512i) -> __m512i {
        on_values!(_mm512_permutexvar_epi32(at, table))
    }

    #[inline(always)]
    fn among(self, [low, high]: [__m512i; 2], at: __m512i) -> __m512i {
        on_values!(_mm512_permutex2var_epi32(low, at, high))
    }

    #[inline(always)]
    fn look_up(self, table: &[u32], at: __m512i) -> __m512i {
        assert!(!table.is_empty());
        let last = i32::try_from(table.len() - 1).unwrap_or(i32::MAX);
        // SAFETY: no place is behind the last entry.
        unsafe {
            let at = _mm512_min_epu32(at, _mm512_set1_epi32(last));
            _mm512_i32gather_epi32::<4>(at, table.as_ptr().cast())
        }
    }

    #[inline(always)]
    fn texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        at: &[i32; LANES],
        stride: u32,
        east: __m512,
        north: __m512,
    ) -> __m512i {
        let rows = rows(self, texels, at, stride);
        on_values!(blend(rows, east, north))
    }

    #[inline(always)]
    fn mean_texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        stride: u32,
        places: [Texels<'_, Self>; 2],
    ) -> __m512i {
        let blended = |of: Texels<'_, Self>| {
            let rows = rows(self, texels, of.at, stride);
            on_values!(blend_by_six_bits(rows, of.east, of.north))
        };
        let (first, second) = (blended(places[0]), blended(places[1]));
        on_values!({
            let half = _mm512_set1_epi16(64);
            let mean = |k: usize| {
                let both = _mm512_add_epi16(first[k], second[k]);
                _mm512_srli_epi16::<7>(_mm512_add_epi16(both, half))
            };
            _mm512_packus_epi16(mean(0), mean(1))
        })
    }
}
