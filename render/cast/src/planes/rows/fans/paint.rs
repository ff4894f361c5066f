//! The light of pieces of the ground.

use super::rays::PARTS;
use crate::lanes::Lanes;
use crate::planes::profile::{FINE, between, parts, twice, upper_bytes};

/// The colours at a piece's ends, and how it rises.
pub(super) struct Paint<L: Lanes> {
    pub(super) ends: [[L::I; 2]; 2],
    /// Of bent profiles, whose colours are [`FINE`] times as large: the middle of the parabola's polygon.
    pub(super) control: [L::I; 2],
    /// One over how much the slope grows.
    pub(super) per_rise: L::F,
    /// How much of the way from end to end has been seen.
    pub(super) done: L::F,
}

impl<L: Lanes> Paint<L> {
    /// So many parts of the light of a piece; it lies half of `twice_share` of the way along it. Of bent profiles
    /// it is rounded, so that many small parts may make a little more than the whole.
    #[inline(always)]
    pub(super) fn light<const BENT: bool>(
        &self,
        l: L,
        twice_share: L::F,
        number: L::I,
    ) -> [L::I; 2] {
        let [begin, end] = self.ends;
        if BENT {
            let share = parts(l, l.mul(twice_share, l.splat(0.5)));
            let one = between(l, begin, self.control, share);
            let other = between(l, self.control, end, share);
            let there = between(l, one, other, share);
            // Of 2 ^ 15, of which there is one less.
            let most = l.splat_i(i32::from(i16::MAX));
            let number = twice(l, l.min_i(l.shl_i(number, l.splat_i(7)), most));
            return between(l, [l.splat_i(0); 2], there, number);
        }
        let share = l.to_int(l.mul(l.min(twice_share, l.splat(2.0)), l.splat(64.0)));
        let of_end = l.shr_i(l.mul_halves(number, share), l.splat_i(7));
        let of_begin = twice(l, l.sub_i(number, of_end));
        let of_end = twice(l, of_end);
        [
            l.add_i(
                l.mul_halves(begin[0], of_begin),
                l.mul_halves(end[0], of_end),
            ),
            l.add_i(
                l.mul_halves(begin[1], of_begin),
                l.mul_halves(end[1], of_end),
            ),
        ]
    }
}

/// Sums of light of straight profiles, of which a whole pixel's is its colour [`PARTS`] times, from those of bent
/// ones of so many parts, of which it is that [`FINE`] times.
#[inline(always)]
pub(super) fn straight<L: Lanes>(
    l: L,
    [red_blue, green_alpha]: [L::I; 2],
    number: L::I,
) -> [L::I; 2] {
    const { assert!(PARTS == 4.0 * FINE as f32) };
    // No more than white, whatever was rounded.
    let white = l.shr_i(l.sub_i(l.shl_i(number, l.splat_i(8)), number), l.splat_i(2));
    let white = twice(l, white);
    let shift = l.splat_i(2);
    [
        l.shl_i(l.min_halves(red_blue, white), shift),
        l.shl_i(l.min_halves(green_alpha, white), shift),
    ]
}

/// Colours from sums of light in halves.
#[inline(always)]
pub(super) fn packed<L: Lanes>(l: L, [red_blue, green_alpha]: [L::I; 2]) -> L::I {
    let green_alpha = l.add_i(green_alpha, l.splat_i(0x0080_0080));
    let green_alpha = l.and_i(green_alpha, l.splat_i(0xff00_ff00_u32 as i32));
    l.add_i(upper_bytes(l, red_blue), green_alpha)
}
