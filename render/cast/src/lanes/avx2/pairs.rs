//! Neighbouring items at lanes' places, read together.

use crate::lanes::LANES;
use crate::lanes::alone::place_alone;
use sandtable_terrain::SlabView;
use std::arch::x86_64::*;

/// Two neighbouring items of four bytes each, for eight lanes: for lanes 0, 1, 4, 5 and 2, 3, 6, 7,
/// so that what takes from both registers by quarters gives lanes in order.
pub(super) type Pairs = [__m256i; 2];

/// The pairs at the `N` addresses of each of eight lanes, those of lane `first` on. They are read
/// together, so that what tells a lane's addresses is read once.
///
/// # Safety
/// Eight bytes can be read at each.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
pub(super) unsafe fn pairs<const N: usize>(
    first: usize,
    address: impl Fn(usize) -> [*const u8; N],
) -> [Pairs; N] {
    macro_rules! two {
        ($k:expr) => {{
            let (this, next) = (address(first + $k), address(first + $k + 1));
            let mut both = [_mm_setzero_si128(); N];
            for n in 0..N {
                // SAFETY: the caller's promise.
                unsafe {
                    let low = _mm_loadl_epi64(this[n].cast());
                    let pair = _mm_loadh_pd(_mm_castsi128_pd(low), next[n].cast());
                    both[n] = _mm_castpd_si128(pair);
                }
            }
            both
        }};
    }
    let quarters = [two!(0), two!(2), two!(4), two!(6)];
    let mut pairs = [[_mm256_setzero_si256(); 2]; N];
    for n in 0..N {
        for k in 0..2 {
            let low = _mm256_castsi128_si256(quarters[k][n]);
            pairs[n][k] = _mm256_inserti128_si256::<1>(low, quarters[k + 2][n]);
        }
    }
    pairs
}

/// `at`, where no place in it is behind `last`, as is usual; else a copy in `moved`, with those that
/// are moved to it. One comparison for all lanes takes less time than one each.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
pub(super) fn bounded<'a>(
    at: &'a [i32; LANES],
    last: usize,
    moved: &'a mut [i32; LANES],
) -> &'a [i32; LANES] {
    let bound = u32::try_from(last).unwrap_or(u32::MAX);
    // SAFETY: a reference can be read.
    let [low, high] = unsafe {
        let from = at.as_ptr();
        [
            _mm256_loadu_si256(from.cast()),
            _mm256_loadu_si256(from.add(8).cast()),
        ]
    };
    let most = _mm256_set1_epi32(bound as i32);
    let farthest = _mm256_max_epu32(low, high);
    let within = _mm256_cmpeq_epi32(_mm256_max_epu32(farthest, most), most);
    if _mm256_movemask_epi8(within) == -1 {
        return at;
    }
    for (moved, &place) in moved.iter_mut().zip(at) {
        *moved = (place as u32).min(bound) as i32;
    }
    moved
}

/// The pairs at lanes' places, and those a row further, for lanes 0 to 7 and 8 to 15. Places behind
/// the last cell are moved to it.
#[inline(always)]
pub(super) fn rows<T>(items: &SlabView<'_, T>, at: &[i32; LANES], stride: u32) -> [[Pairs; 2]; 2] {
    const { assert!(size_of::<T>() == 4) };
    assert!(items.len() >= stride as usize + 2, "a tile has a cell");
    let last = items.len() - (stride as usize + 2);
    let south = items.as_ptr();
    let north = south.wrapping_add(stride as usize);
    let mut moved = [0; LANES];
    // SAFETY: whoever calls this holds an `Avx2`; from each place on there is a row and two items.
    unsafe {
        let at = bounded(at, last, &mut moved);
        let address = |k| {
            let place = place_alone(at, k);
            [
                south.wrapping_add(place).cast(),
                north.wrapping_add(place).cast(),
            ]
        };
        [pairs(0, address), pairs(8, address)]
    }
}

/// The western and the eastern items of pairs.
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
#[inline]
pub(super) fn apart([a, b]: Pairs) -> [__m256; 2] {
    let (a, b) = (_mm256_castsi256_ps(a), _mm256_castsi256_ps(b));
    [
        _mm256_shuffle_ps::<0b10_00_10_00>(a, b),
        _mm256_shuffle_ps::<0b11_01_11_01>(a, b),
    ]
}
