//! What a terrain slice shows at a place: the nearest post, or the surface between four.

use crate::tally::Tally;
use sandtable_terrain::{Ground, Rgb};

/// How slices read the ground.
pub(crate) trait SlicePosts<'a> {
    /// What height and colour depend on.
    type Place: Copy + PartialEq;

    fn new(ground: &'a Ground) -> Self;

    /// The place at `(x, y)` in posts from the south-west one; the nearest on the terrain.
    fn place(&self, x: f64, y: f64) -> Self::Place;

    /// The height there in metres.
    fn height<T: Tally>(&self, place: Self::Place, tally: &mut T) -> f64;

    /// The ground's colour there.
    fn colour(&self, place: Self::Place) -> Rgb;
}

/// Flat-topped columns, each of one post's height and colour, as in the papers.
pub(crate) struct Nearest<'a> {
    ground: &'a Ground,
    last: [u32; 2],
}

impl<'a> SlicePosts<'a> for Nearest<'a> {
    type Place = [u32; 2];

    fn new(ground: &'a Ground) -> Self {
        let grid = ground.grid();
        Self {
            ground,
            last: [grid.cols - 1, grid.rows - 1],
        }
    }

    #[inline]
    fn place(&self, x: f64, y: f64) -> [u32; 2] {
        // A negative number saturates at post 0.
        [
            ((x + 0.5) as u32).min(self.last[0]),
            ((y + 0.5) as u32).min(self.last[1]),
        ]
    }

    #[inline]
    fn height<T: Tally>(&self, [col, row]: [u32; 2], _: &mut T) -> f64 {
        f64::from(self.ground.heights().post(col, row))
    }

    #[inline]
    fn colour(&self, [col, row]: [u32; 2]) -> Rgb {
        let spacing = self.ground.grid().spacing;
        self.ground
            .colour_at(f64::from(col) * spacing.x, f64::from(row) * spacing.y)
    }
}

/// The ground's own bilinear surface and colour.
pub(crate) struct Bilinear<'a> {
    ground: &'a Ground,
}

impl<'a> SlicePosts<'a> for Bilinear<'a> {
    type Place = [f64; 2];

    fn new(ground: &'a Ground) -> Self {
        Self { ground }
    }

    #[inline]
    fn place(&self, x: f64, y: f64) -> [f64; 2] {
        [x, y]
    }

    #[inline]
    fn height<T: Tally>(&self, [x, y]: [f64; 2], tally: &mut T) -> f64 {
        tally.cell();
        let heights = self.ground.heights();
        let ([col, row], [u, v]) = heights.locate(x, y);
        let [sw, se, nw, ne] = heights.cell(col, row).map(f64::from);
        let (south, north) = (sw + (se - sw) * u, nw + (ne - nw) * u);
        south + (north - south) * v
    }

    #[inline]
    fn colour(&self, [x, y]: [f64; 2]) -> Rgb {
        let spacing = self.ground.grid().spacing;
        self.ground.colour_at(x * spacing.x, y * spacing.y)
    }
}
