//! What casting costs in work rather than in time.

use std::iter::Sum;
use std::ops::{Add, AddAssign};

/// Work counted while casting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Rays cast: pixels, times the rays of each.
    pub rays: u64,
    /// Points along rays at which the terrain was looked up. Casters that walk from cell to cell
    /// have none.
    pub samples: u64,
    /// Cells of which the corners were read: walked through, or interpolated in.
    pub cells: u64,
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            samples: self.samples + other.samples,
            cells: self.cells + other.cells,
        }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for Work {
    fn sum<I: Iterator<Item = Self>>(works: I) -> Self {
        works.fold(Self::default(), Add::add)
    }
}

/// What hot loops tell their work to: [`Work`] counts, [`Uncounted`] compiles to nothing.
pub(crate) trait Tally {
    /// Whether it counts anything.
    const COUNTS: bool = true;

    /// A ray begins.
    fn ray(&mut self);
    /// So many rays begin side by side: those of a caster's step, from a lane on.
    #[inline(always)]
    fn rays(&mut self, step: u32, lane: i32, count: i32) {
        let _ = (step, lane);
        for _ in 0..count {
            self.ray();
        }
    }
    /// The terrain is looked up at a point of it.
    fn sample(&mut self);
    /// A cell's corners are read.
    fn cell(&mut self);
    /// As many cells' corners, or blocks' bounds, as there are numbers of rays, for each ray one.
    #[inline(always)]
    fn cells(&mut self, rays: &[i32]) {
        for _ in rays {
            self.cell();
        }
    }
    /// As `cells`, for those of sixteen rays, numbered from `first` on, of which the bits are set.
    #[inline(always)]
    fn cells_of(&mut self, first: i32, rays: u16) {
        for ray in (0..16).filter(|ray| rays >> ray & 1 != 0) {
            self.cells(&[first + ray]);
        }
    }
}

impl Tally for Work {
    fn ray(&mut self) {
        self.rays += 1;
    }

    fn sample(&mut self) {
        self.samples += 1;
    }

    fn cell(&mut self) {
        self.cells += 1;
    }
}

/// Counts nothing, at no cost.
pub(crate) struct Uncounted;

impl Tally for Uncounted {
    const COUNTS: bool = false;

    #[inline(always)]
    fn ray(&mut self) {}

    #[inline(always)]
    fn sample(&mut self) {}

    #[inline(always)]
    fn cell(&mut self) {}

    // A compiler does not see that the default does nothing here.
    #[inline(always)]
    fn cells_of(&mut self, _: i32, _: u16) {}
}
