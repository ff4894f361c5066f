//! Colours as sixteen lanes have them: two of a colour's bytes in the halves of a lane.

use crate::lanes::Lanes;

/// How many times as large colours of bent profiles are, so that little is lost between them.
pub(in crate::planes) const FINE: i32 = 64;

/// One or the other colours in halves.
#[inline(always)]
pub(in crate::planes) fn either<L: Lanes>(
    l: L,
    mask: L::M,
    yes: [L::I; 2],
    no: [L::I; 2],
) -> [L::I; 2] {
    [
        l.select_i(mask, yes[0], no[0]),
        l.select_i(mask, yes[1], no[1]),
    ]
}

/// Colours in halves, [`FINE`] times as large.
#[inline(always)]
pub(in crate::planes) fn fine_halves<L: Lanes>(l: L, colours: L::I) -> [L::I; 2] {
    let [red_blue, green_alpha] = halves(l, colours);
    let shift = l.splat_i(FINE.trailing_zeros() as i32);
    [l.shl_i(red_blue, shift), l.shl_i(green_alpha, shift)]
}

/// The other way, rounded.
#[inline(always)]
pub(in crate::planes) fn coarse_halves<L: Lanes>(
    l: L,
    [red_blue, green_alpha]: [L::I; 2],
) -> [L::I; 2] {
    let shift = l.splat_i(FINE.trailing_zeros() as i32);
    let half = twice(l, l.splat_i(FINE / 2));
    let mask = l.splat_i(0x00ff_00ff);
    [
        l.and_i(l.shr_i(l.add_i(red_blue, half), shift), mask),
        l.and_i(l.shr_i(l.add_i(green_alpha, half), shift), mask),
    ]
}

/// Colours in halves so much of the way from one to another.
#[inline(always)]
pub(in crate::planes) fn between<L: Lanes>(
    l: L,
    from: [L::I; 2],
    to: [L::I; 2],
    share: L::I,
) -> [L::I; 2] {
    [
        l.lerp_halves(from[0], to[0], share),
        l.lerp_halves(from[1], to[1], share),
    ]
}

/// The bytes 0 and 2 of each lane, and 1 and 3, in 16 bits each.
#[inline(always)]
pub(in crate::planes) fn halves<L: Lanes>(l: L, colours: L::I) -> [L::I; 2] {
    let mask = l.splat_i(0x00ff_00ff);
    [
        l.and_i(colours, mask),
        l.and_i(l.shr_i(colours, l.splat_i(8)), mask),
    ]
}

/// A number below 2¹⁶ in both halves of each lane.
#[inline(always)]
pub(in crate::planes) fn twice<L: Lanes>(l: L, number: L::I) -> L::I {
    l.add_i(number, l.shl_i(number, l.splat_i(16)))
}

/// A share of 1 in both halves of each lane, as [`Lanes::lerp_halves`] takes it; one below 0 or above
/// 1 is taken for that.
#[inline(always)]
pub(in crate::planes) fn parts<L: Lanes>(l: L, share: L::F) -> L::I {
    let share = l.max(l.min(share, l.splat(1.0)), l.splat(0.0));
    twice(l, l.to_int(l.mul(share, l.splat(32767.0))))
}

/// Numbers in halves, divided by 256 and rounded.
#[inline(always)]
pub(in crate::planes) fn upper_bytes<L: Lanes>(l: L, numbers: L::I) -> L::I {
    let rounded = l.add_i(numbers, l.splat_i(0x0080_0080));
    l.and_i(l.shr_i(rounded, l.splat_i(8)), l.splat_i(0x00ff_00ff))
}
