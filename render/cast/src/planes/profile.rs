//! Profiles of the ground along vertical planes: its heights and colours where planes cross lines of
//! posts, and how they go on from there to the next line.

mod axis;
mod bend;
mod border;
mod crossing;
mod halves;
mod outlook;
mod station;
#[cfg(test)]
mod tests;
mod window;

pub(super) use bend::{Bend, BentColours};
pub(super) use border::Border;
pub(super) use crossing::Texels;
pub(super) use halves::{
    FINE, between, coarse_halves, either, fine_halves, halves, parts, twice, upper_bytes,
};
pub(super) use outlook::{Outlook, passed};
pub(super) use station::{Mark, Station, Stretch, parts as parts_between};

use self::window::ROWS_AHEAD;
use crate::lanes::{LANES, Lanes};

/// Sixteen neighbouring vertical planes through the eye.
#[derive(Clone, Copy)]
pub(super) struct PlaneGroup<L: Lanes> {
    /// Cells along the minor axis for each one along the major axis.
    pub(super) advance: L::F,
    /// Lines along the major axis for each cell along the minor one.
    per_advance: L::F,
    /// Of the first and the last plane.
    pub(super) outer: [f32; 2],
    /// How many cells aside they go until the line for whose memory they ask.
    drift: i32,
}

impl<L: Lanes> PlaneGroup<L> {
    #[inline(always)]
    pub(super) fn new(l: L, advance: &[f32; LANES]) -> Self {
        let outer = [advance[0], advance[LANES - 1]];
        let advance = l.load(advance);
        Self {
            advance,
            per_advance: l.div(l.splat(1.0), l.max(advance, l.splat(f32::MIN_POSITIVE))),
            outer,
            drift: (0.5 * (outer[0] + outer[1]) * ROWS_AHEAD as f32) as i32,
        }
    }
}
