//! Neighbouring items at lanes' places, read together.

use crate::lanes::LANES;
use crate::lanes::alone::place_alone;
use sandtable_terrain::SlabView;
use std::arch::x86_64::*;

/// Two neighbouring items of four bytes each, for eight lanes: for lanes 0, 1, 4, 5 and 2, 3, 6, 7,
/// so that what takes from both registers by quarters gives lanes in order.
pub(super) type Pairs = [__m256i; 2];

/// The pairs at eight addresses, those of lane `first` on.
///
/// # Safety
/// Eight bytes can be read at each.
#[target_feature(enable = "avx2,popcnt")]
#[inline]
pub(super) unsafe fn pairs(first: usize, address: impl Fn(usize) -> *const u8) -> Pairs {
    macro_rules! two {
        ($k:expr) => {{
            // SAFETY: the caller's promise.
            unsafe {
                let low = _mm_loadl_epi64(address(first + $k).cast());
                let both = _mm_loadh_pd(_mm_castsi128_pd(low), address(first + $k + 1).cast());
                _mm_castpd_si128(both)
            }
        }};
    }
    [
        _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two!(0)), two!(4)),
        _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two!(2)), two!(6)),
    ]
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
    let southern = |k| south.wrapping_add(place_alone(at, k).min(last)).cast();
    let northern = |k| north.wrapping_add(place_alone(at, k).min(last)).cast();
    // SAFETY: from each place on there is a row and two items.
    unsafe {
        [
            [pairs(0, southern), pairs(0, northern)],
            [pairs(8, southern), pairs(8, northern)],
        ]
    }
}

/// The western and the eastern items of pairs.
#[target_feature(enable = "avx2,popcnt")]
#[inline]
pub(super) fn apart([a, b]: Pairs) -> [__m256; 2] {
    let (a, b) = (_mm256_castsi256_ps(a), _mm256_castsi256_ps(b));
    [
        _mm256_shuffle_ps::<0b10_00_10_00>(a, b),
        _mm256_shuffle_ps::<0b11_01_11_01>(a, b),
    ]
}
