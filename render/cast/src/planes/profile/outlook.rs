//! Ground that planes may pass, as all of it is hidden.

use super::PlaneGroup;
use crate::lanes::Lanes;
use crate::planes::field::{Axis, Field};
use crate::planes::roofs::{LEVEL_BEGIN, numbers};

/// Levels of blocks that planes may pass at once, as [`roofs`](crate::planes::roofs) has them: the larger
/// first.
const PASSED: [usize; 4] = [6, 5, 4, 3];

/// The smallest of them.
const LEAST_PASSED: usize = PASSED[PASSED.len() - 1];

/// How many cells aside of a block planes may be taken to be that run through it.
const BESIDE: f32 = 1.0 / 16.0;

impl Axis {
    /// Whether at a mirrored line blocks begin that planes may pass.
    pub(in crate::planes) fn is_block(&self, line: i32) -> bool {
        self.begins_block(line, LEAST_PASSED)
    }

    fn begins_block(&self, line: i32, level: usize) -> bool {
        self.post(line) & ((1 << level) - 1) == 0
    }

    /// The mirrored line half-way through the ground's cells from `cell` on, of which there are `size`.
    fn middle(&self, cell: i32, size: f32) -> f32 {
        if self.sign > 0 {
            (cell - self.base) as f32 + 0.5 * size
        } else {
            (self.base + 1 - cell) as f32 - 0.5 * size
        }
    }
}

/// What sixteen planes may still see.
pub(in crate::planes) struct Outlook<L: Lanes> {
    /// Cells along the minor axis for each one along the major axis; of the first and the last plane.
    pub(super) advance: L::F,
    pub(super) outer: [f32; 2],
    /// Which planes go on, and the slope from the eye up to which ground is hidden from them.
    pub(super) live: L::M,
    pub(super) horizon: L::F,
}

impl<L: Lanes> Outlook<L> {
    /// What planes may see over a horizon.
    pub(in crate::planes) fn new(planes: &PlaneGroup<L>, live: L::M, horizon: L::F) -> Self {
        Self {
            advance: planes.advance,
            outer: planes.outer,
            live,
            horizon,
        }
    }

    /// Whether all planes' ground is hidden between the mirrored line `line` and the one 2 ^ `level` cells
    /// further: both are on the ground, and blocks lie between them. A plane's ground is hidden where the
    /// roofs of the blocks that it runs through lie below its horizon at both lines.
    #[inline(always)]
    fn is_hidden(&self, l: L, field: &Field<'_>, line: i32, level: usize) -> bool {
        let (major, minor) = (&field.major, &field.minor);
        let size = (1 << level) as f32;
        let from = line as f32 - major.fraction;
        let to = from + size;
        let places = [
            affine(l, self.advance, from, minor.fraction),
            affine(l, self.advance, to, minor.fraction),
        ];
        let horizons = [
            l.mul(self.horizon, l.splat(from * field.scale)),
            l.mul(self.horizon, l.splat(to * field.scale)),
        ];
        let [least, most] = [
            self.outer[0].min(self.outer[1]) * from,
            self.outer[0].max(self.outer[1]) * to,
        ];
        let blocks =
            [least, most].map(|along| minor.ground_alone(minor.cell_alone(along)) >> level);
        let along = major.ground_alone(line);
        for block in blocks[0].min(blocks[1])..=blocks[0].max(blocks[1]) {
            let aside = block << level;
            let (x, y) = if field.major_axis == 0 {
                (along, aside)
            } else {
                (aside, along)
            };
            let within = (((y & 255) >> level) << (8 - level)) + ((x & 255) >> level);
            let at = field.roofs.tile(x >> 8, y >> 8) + (LEVEL_BEGIN[level] + within) as u32;
            let Some(&roof) = field.roofs.items.from_place(at).first() else {
                return false;
            };
            let [height, east, north] = numbers(roof);
            let (onwards, sideways) = if field.major_axis == 0 {
                (east, north)
            } else {
                (north, east)
            };
            let onwards = onwards * major.sign as f32 * 0.5 * size;
            let sideways = sideways * minor.sign as f32;
            let height = height - field.eye_height + field.rounding + BESIDE * sideways.abs();
            let middle = minor.middle(aside, size);
            let aside = l.splat(middle);
            let roofs = [
                affine(l, l.sub(places[0], aside), sideways, height - onwards),
                affine(l, l.sub(places[1], aside), sideways, height + onwards),
            ];
            let is_hidden = l.and(l.lt(roofs[0], horizons[0]), l.lt(roofs[1], horizons[1]));
            let reach = 0.5 * size + BESIDE;
            let runs_through = l.and(
                l.lt(l.splat(middle - reach), places[1]),
                l.lt(places[0], l.splat(middle + reach)),
            );
            if l.bits(l.and_not(l.and(self.live, runs_through), is_hidden)) != 0 {
                return false;
            }
        }
        true
    }
}

/// `number` times `factor`, and `more`.
#[inline(always)]
fn affine<L: Lanes>(l: L, number: L::F, factor: f32, more: f32) -> L::F {
    l.add(l.mul(number, l.splat(factor)), l.splat(more))
}

/// Behind which line planes are that pass, at the mirrored line `line`, the largest blocks that end before
/// t comes to `limit` and whose ground is hidden from all of them.
#[inline(always)]
pub(in crate::planes) fn passed<L: Lanes>(
    l: L,
    field: &Field<'_>,
    [left, right]: [Outlook<L>; 2],
    line: i32,
    limit: f32,
) -> Option<i32> {
    let major = &field.major;
    for level in PASSED {
        let behind = line + (1 << level);
        let end = (behind as f32 - major.fraction) * field.scale;
        let is_there = major.cells[0] <= line && behind <= major.cells[1] + 1;
        if is_there
            && end <= limit
            && major.begins_block(line, level)
            && left.is_hidden(l, field, line, level)
            && right.is_hidden(l, field, line, level)
        {
            return Some(behind);
        }
    }
    None
}
