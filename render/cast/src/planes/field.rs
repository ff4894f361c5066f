//! The ground as one sector's rays meet it: mirrored and turned, so that all of them run the same
//! way.

use super::roofs::Roof;
use crate::lanes::Lanes;
use sandtable_terrain::SlabView;

/// Cells along a tile's side, as a shift.
const TILE_SHIFT: i32 = 8;
const TILE_LAST: i32 = (1 << TILE_SHIFT) - 1;

/// A raster's memory, and where its tiles lie in it.
pub(super) struct Tiles<'a, T> {
    pub(super) items: SlabView<'a, T>,
    /// Tiles from west to east, and items from row to row in a tile.
    across: i32,
    pub(super) stride: u32,
    /// Whether tile n begins at n times a tile's length; else where tiles begin is looked up.
    in_order: bool,
}

impl<'a, T> Tiles<'a, T> {
    pub(super) fn new(items: SlabView<'a, T>, across: u32, stride: usize) -> Self {
        Self {
            across: across as i32,
            stride: stride as u32,
            in_order: items.is_in_order(),
            items,
        }
    }

    /// Where the tiles begin in which (x, y) lie.
    #[inline(always)]
    pub(super) fn base<L: Lanes>(&self, l: L, x: L::I, y: L::I) -> L::I {
        let shift = l.splat_i(TILE_SHIFT);
        let number = l.add_i(
            l.mul_small(l.shr_i(y, shift), l.splat_i(self.across)),
            l.shr_i(x, shift),
        );
        self.begin(l, number)
    }

    /// The number of the tile that is the `x`-th from the west and the `y`-th from the south.
    #[inline(always)]
    pub(super) fn number(&self, x: i32, y: i32) -> usize {
        (y * self.across + x) as usize
    }

    /// The number of the tile to the north of one.
    #[inline(always)]
    pub(super) fn above(&self, number: usize) -> usize {
        number + self.across as usize
    }

    /// Where the tile begins that has a number along x and along y.
    pub(super) fn tile(&self, x: i32, y: i32) -> u32 {
        self.items.bases()[(y * self.across + x) as usize]
    }

    /// Where tiles begin.
    #[inline(always)]
    fn begin<L: Lanes>(&self, l: L, number: L::I) -> L::I {
        if self.in_order {
            l.mul_i(number, l.splat_i(self.items.slot_len() as i32))
        } else {
            l.look_up(self.items.bases(), number)
        }
    }

    /// `place` in the lanes of `mask`, and a place of the first tile in the others: those may come
    /// from anywhere, and what is not of these tiles may be changing.
    #[inline(always)]
    pub(super) fn only<L: Lanes>(&self, l: L, mask: L::M, place: L::I) -> L::I {
        l.select_i(mask, place, l.splat_i(self.items.bases()[0] as i32))
    }

    /// The place of (x, y).
    #[inline(always)]
    pub(super) fn place<L: Lanes>(&self, l: L, x: L::I, y: L::I) -> L::I {
        l.add_i(self.base(l, x, y), self.within(l, x, y))
    }

    /// The place of (x, y) of a raster of its own: one that begins with tile `first` and has
    /// `across` tiles from west to east.
    #[inline(always)]
    pub(super) fn place_in<L: Lanes>(
        &self,
        l: L,
        first: L::I,
        across: L::I,
        x: L::I,
        y: L::I,
    ) -> L::I {
        let shift = l.splat_i(TILE_SHIFT);
        let row = l.mul_small(l.shr_i(y, shift), across);
        let number = l.add_i(first, l.add_i(row, l.shr_i(x, shift)));
        l.add_i(self.begin(l, number), self.within(l, x, y))
    }

    /// The place of (x, y) in its tile.
    #[inline(always)]
    fn within<L: Lanes>(&self, l: L, x: L::I, y: L::I) -> L::I {
        let within = l.splat_i(TILE_LAST);
        let row = l.mul_small(l.and_i(y, within), l.splat_i(self.stride as i32));
        l.add_i(row, l.and_i(x, within))
    }
}

/// One axis of the ground as a sector's rays run along it.
///
/// Grid lines are numbered from the eye's cell on, in the direction in which rays run: line n lies
/// `n − fraction` cells from the eye, and mirrored cell n between lines n and n + 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) sign: i32,
    /// The ground's cell that is mirrored cell 0.
    pub(super) base: i32,
    /// Where the eye lies in its cell, in [0, 1), along the rays' direction.
    pub(super) fraction: f32,
    /// The first and the last mirrored cell of the ground.
    pub(super) cells: [i32; 2],
    /// How far from the eye the ground begins: 0 or less where it does so behind it. Not what is left of 1 behind
    /// `fraction`: right before a wall, all that is seen of it hangs on this distance.
    pub(super) begin: f32,
}

impl Axis {
    /// An axis with `cells` cells along which the eye lies at `eye` cells.
    pub(super) fn new(eye: f64, cells: i32, sign: i32) -> Self {
        let base = if sign > 0 {
            eye.floor()
        } else {
            eye.ceil() - 1.0
        };
        let fraction = if sign > 0 {
            eye - base
        } else {
            base + 1.0 - eye
        };
        let begin = if sign > 0 {
            -eye
        } else {
            eye - f64::from(cells)
        };
        let base = base as i32;
        let ends = if sign > 0 {
            [-base, cells - 1 - base]
        } else {
            [base - cells + 1, base]
        };
        Self {
            sign,
            base,
            fraction: fraction as f32,
            cells: ends,
            begin: begin as f32,
        }
    }

    /// The mirrored cell at a distance from the eye, of those that there are.
    #[inline(always)]
    pub(super) fn cell<L: Lanes>(&self, l: L, along: L::F) -> L::I {
        let cell = l.to_int(l.add(along, l.splat(self.fraction)));
        let cell = l.min_i(cell, l.splat_i(self.cells[1]));
        // Rays do not run backwards: only those from off the ground can round to before it.
        l.max_i(cell, l.splat_i(self.cells[0]))
    }

    /// How far into mirrored cell `cell` lies what is `along` from the eye: in the ground's own
    /// direction, from 0 to 1.
    #[inline(always)]
    pub(super) fn inside<L: Lanes>(&self, l: L, along: L::F, cell: L::I) -> L::F {
        let inside = l.sub(l.add(along, l.splat(self.fraction)), l.to_float(cell));
        let inside = l.max(l.min(inside, l.splat(1.0)), l.splat(0.0));
        if self.sign > 0 {
            inside
        } else {
            l.sub(l.splat(1.0), inside)
        }
    }

    /// The ground's cell that is a mirrored one.
    #[inline(always)]
    fn ground<L: Lanes>(&self, l: L, cell: L::I) -> L::I {
        let base = l.splat_i(self.base);
        if self.sign > 0 {
            l.add_i(base, cell)
        } else {
            l.sub_i(base, cell)
        }
    }

    /// The distance of a mirrored grid line from the eye, in cells.
    pub(super) fn line(&self, line: i32) -> f32 {
        // To the last bit what the kernels find for the line behind a cell.
        (line - 1) as f32 + (1.0 - self.fraction)
    }
}

/// The ground, at one of its resolutions, as the rays of one sector meet it. Cells, and the rays'
/// parameter, are those of that resolution.
pub(super) struct Field<'a> {
    pub(super) heights: &'a Tiles<'a, f32>,
    pub(super) roofs: &'a Tiles<'a, Roof>,
    /// A colour a post, where detail is chosen.
    pub(super) colours: Option<&'a Tiles<'a, [u8; 4]>>,
    /// The axis along which rays advance by 1 cell for each 1 of their parameter, and the other.
    pub(super) major: Axis,
    pub(super) minor: Axis,
    /// Which of the ground's axes the major one is.
    pub(super) major_axis: usize,
    /// The eye's height in metres, and what rounding has left of it.
    pub(super) eye_height: f32,
    pub(super) eye_rest: f32,
    /// Above all ground, by more than heights are rounded by.
    pub(super) highest: f32,
    pub(super) rounding: f32,
    /// Cells of the ground along a side of a cell.
    pub(super) scale: f32,
    /// How fast the ground is taken to rise towards rays: metres for each 1 of t.
    pub(super) ground_rise: f32,
    /// Where the ground ends, in cells from the eye along major and minor axis.
    pub(super) ends: [f32; 2],
    /// Where the ground is too large for a core's own caches: how far behind a cell's place its
    /// corner lies that rays reach last, for which they ask before they read the cell.
    pub(super) ahead: Option<i32>,
}

impl<'a> Field<'a> {
    /// A resolution's ground for an eye at height 0 that sees no end of it: for tests.
    #[cfg(test)]
    pub(super) fn of_level(
        level: &'a super::frame::Level<'a>,
        [major, minor]: [Axis; 2],
        major_axis: usize,
    ) -> Self {
        Self {
            heights: &level.heights,
            roofs: &level.roofs,
            colours: level.colours.as_ref(),
            major,
            minor,
            major_axis,
            eye_height: 0.0,
            eye_rest: 0.0,
            highest: 1e4,
            rounding: 0.0,
            scale: 1.0,
            ground_rise: 0.5,
            ends: [1e4; 2],
            ahead: None,
        }
    }

    /// How fast rays and ground come together, about: metres for each 1 of t.
    #[inline(always)]
    pub(super) fn closing_rate<L: Lanes>(&self, l: L, slope: L::F) -> L::F {
        l.add(
            l.max(l.sub(l.splat(0.0), slope), l.splat(0.0)),
            l.splat(self.ground_rise),
        )
    }

    /// Whether the eye is above all ground.
    #[inline(always)]
    pub(super) fn is_above(&self) -> bool {
        self.eye_height > self.highest
    }

    /// Where the ground ends under rays.
    #[inline(always)]
    pub(super) fn end<L: Lanes>(&self, l: L, inverse: L::F) -> L::F {
        let [major_end, minor_end] = self.ends;
        l.min(l.splat(major_end), l.mul(l.splat(minor_end), inverse))
    }

    /// Where rays have left all ground.
    #[inline(always)]
    pub(super) fn leave<L: Lanes>(&self, l: L, inverse: L::F, slope: L::F) -> L::F {
        let leave = self.end(l, inverse);
        let rises = l.lt(l.splat(0.0), slope);
        let top = l.splat(self.highest - self.eye_height);
        l.select(rises, l.min(leave, l.div(top, slope)), leave)
    }

    /// The axes x and y.
    #[inline(always)]
    pub(super) fn x_y(&self) -> [&Axis; 2] {
        if self.major_axis == 0 {
            [&self.major, &self.minor]
        } else {
            [&self.minor, &self.major]
        }
    }

    /// The mirrored cell in which rays are at t.
    #[inline(always)]
    pub(super) fn cell_at<L: Lanes>(&self, l: L, t: L::F, advance: L::F) -> [L::I; 2] {
        [self.major.cell(l, t), self.minor.cell(l, l.mul(t, advance))]
    }

    /// As `cell_at`, for rays that stand on a line of the one or the other axis, where they cross it: the
    /// cell behind it.
    #[inline(always)]
    pub(super) fn cell_behind<L: Lanes>(
        &self,
        l: L,
        t: L::F,
        advance: L::F,
        [crosses_major, crosses_minor]: [L::M; 2],
    ) -> [L::I; 2] {
        // Half a cell further on, where it does not matter how the line was rounded.
        let further =
            |crosses: L::M, along: L::F| l.select(crosses, l.add(along, l.splat(0.5)), along);
        [
            self.major.cell(l, further(crosses_major, t)),
            self.minor
                .cell(l, further(crosses_minor, l.mul(t, advance))),
        ]
    }

    /// The ground's columns and rows of mirrored cells (major, minor).
    #[inline(always)]
    pub(super) fn cells<L: Lanes>(&self, l: L, major: L::I, minor: L::I) -> [L::I; 2] {
        let (major, minor) = (self.major.ground(l, major), self.minor.ground(l, minor));
        if self.major_axis == 0 {
            [major, minor]
        } else {
            [minor, major]
        }
    }

    /// The place of mirrored cells (major, minor) among the heights.
    #[inline(always)]
    pub(super) fn place<L: Lanes>(&self, l: L, [major, minor]: [L::I; 2]) -> L::I {
        let [x, y] = self.cells(l, major, minor);
        self.heights.place(l, x, y)
    }
}
