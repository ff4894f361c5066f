//! Where lanes read from: one tile for all of them, or each from its own.

use super::LANES;

/// The tiles that the lanes of a group read.
pub(crate) enum Sources<'a, T> {
    /// All lanes lie in one tile: the usual case, and the faster one.
    One(&'a [T]),
    /// Each lane has its own.
    Each([&'a [T]; LANES]),
}

impl<'a, T> Sources<'a, T> {
    /// The tile of a lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> &'a [T] {
        match self {
            Self::One(tile) => tile,
            Self::Each(tiles) => tiles[lane],
        }
    }
}
