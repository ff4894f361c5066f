//! Four neighbouring texels blended.

use super::pairs::Pairs;
use std::arch::x86_64::*;

/// From `from` to `to` by a share in 15-bit fixed point.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
pub(super) fn along(from: __m256i, to: __m256i, share: __m256i) -> __m256i {
    _mm256_add_epi16(from, _mm256_mulhrs_epi16(_mm256_sub_epi16(to, from), share))
}

/// Blends eight lanes' four texels: a southern and a northern row of neighbours.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
pub(super) fn blend([south, north_row]: [Pairs; 2], east: __m256, north: __m256) -> __m256i {
    let scale = _mm256_set1_ps(32767.0);
    let east = _mm256_cvttps_epi32(_mm256_mul_ps(east, scale));
    let north = _mm256_cvttps_epi32(_mm256_mul_ps(north, scale));
    // In each half of a register: two lanes' western and eastern texels, 16 bits a channel, six of
    // them a fraction; and weights of the lanes of either register of pairs, for each channel.
    let west_of = _mm256_broadcastsi128_si256(_mm_setr_epi8(
        0, -1, 1, -1, 2, -1, 3, -1, 8, -1, 9, -1, 10, -1, 11, -1,
    ));
    let east_of = _mm256_broadcastsi128_si256(_mm_setr_epi8(
        4, -1, 5, -1, 6, -1, 7, -1, 12, -1, 13, -1, 14, -1, 15, -1,
    ));
    let spread = spread();
    macro_rules! row {
        ($pairs:expr, $share:expr) => {
            along(
                _mm256_slli_epi16::<6>(_mm256_shuffle_epi8($pairs, west_of)),
                _mm256_slli_epi16::<6>(_mm256_shuffle_epi8($pairs, east_of)),
                $share,
            )
        };
    }
    macro_rules! four {
        ($k:expr) => {{
            let east = _mm256_shuffle_epi8(east, spread[$k]);
            let north = _mm256_shuffle_epi8(north, spread[$k]);
            let blended = along(row!(south[$k], east), row!(north_row[$k], east), north);
            _mm256_srli_epi16::<6>(_mm256_add_epi16(blended, _mm256_set1_epi16(32)))
        }};
    }
    _mm256_packus_epi16(four!(0), four!(1))
}

/// Blends eight lanes' four texels: 16 bits a channel, six of them a fraction, in the order of
/// `Pairs`.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
pub(super) fn blend_by_six_bits(
    [south, north_row]: [Pairs; 2],
    east: __m256i,
    north: __m256i,
) -> [__m256i; 2] {
    // The western texel's weight and, over it, the eastern one's.
    let share = _mm256_srli_epi32::<9>(_mm256_add_epi32(east, _mm256_set1_epi32(256)));
    let weights = _mm256_sub_epi32(_mm256_slli_epi32::<8>(share), share);
    let weights = _mm256_add_epi32(weights, _mm256_set1_epi32(64));
    let side_by_side = _mm256_broadcastsi128_si256(_mm_setr_epi8(
        0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15,
    ));
    let spread = spread();
    macro_rules! row {
        ($pairs:expr, $weights:expr) => {
            _mm256_maddubs_epi16(_mm256_shuffle_epi8($pairs, side_by_side), $weights)
        };
    }
    macro_rules! four {
        ($k:expr) => {{
            let weights = _mm256_shuffle_epi8(weights, spread[$k]);
            let [south, north_row] = [row!(south[$k], weights), row!(north_row[$k], weights)];
            let rise = _mm256_sub_epi16(north_row, south);
            let north = _mm256_shuffle_epi8(north, spread[$k]);
            _mm256_add_epi16(south, _mm256_mulhrs_epi16(rise, north))
        }};
    }
    [four!(0), four!(1)]
}

/// Where weights of the lanes of either register of pairs go: to each of their channels.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
fn spread() -> [__m256i; 2] {
    [
        _mm256_broadcastsi128_si256(_mm_setr_epi8(
            0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5,
        )),
        _mm256_broadcastsi128_si256(_mm_setr_epi8(
            8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13,
        )),
    ]
}
