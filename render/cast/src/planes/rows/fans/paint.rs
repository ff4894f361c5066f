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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, Portable};

    /// A white pixel is white, in however many pieces its light is added up; and so is what is seen of it so far.
    #[test]
    fn many_small_parts_are_white_at_most() {
        let l = Portable;
        let white = [l.splat_i(0x00ff_00ff * FINE); 2];
        let paint = Paint::<Portable> {
            ends: [white; 2],
            control: white,
            per_rise: l.splat(1.0),
            done: l.splat(0.0),
        };
        for at_once in [1, 2, 4, 8, 64, 256] {
            let mut light = [l.splat_i(0); 2];
            for number in (at_once..=PARTS as i32).step_by(at_once as usize) {
                let more = paint.light::<true>(l, l.splat(1.0), l.splat_i(at_once));
                light = [l.add_i(light[0], more[0]), l.add_i(light[1], more[1])];
                let [seen, _] = straight(l, light, l.splat_i(number));
                let seen = (seen[0] & 0xffff) as f32 / number as f32;
                assert!((252.0..=255.0).contains(&seen), "{seen} in {number} parts");
            }
            let whole = packed(l, straight(l, light, l.splat_i(PARTS as i32)));
            assert_eq!(whole, [-1; LANES], "{at_once} parts at once");
        }
    }
}
