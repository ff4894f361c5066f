//! How high the ground rises where planes may pass it.

use crate::planes::field::{Axis, Field};
use crate::planes::roofs::LEVEL_BEGIN;

/// Levels of blocks that planes may pass at once, as [`roofs`](crate::planes::roofs) has them: the larger
/// first.
pub(in crate::planes) const PASSED: [usize; 3] = [6, 5, 4];

/// The smallest of them.
const LEAST_PASSED: usize = PASSED[PASSED.len() - 1];

impl Axis {
    /// Whether at a mirrored line blocks begin that planes may pass.
    pub(in crate::planes) fn is_block(&self, line: i32) -> bool {
        self.post(line) & ((1 << LEAST_PASSED) - 1) == 0
    }
}

/// From which to which mirrored cell of the minor axis planes reach, of which the outermost advance by
/// `outer`, up to where they come in `to` cells from where they are in `from` cells.
#[inline(always)]
fn cells_of(field: &Field<'_>, [first, last]: [f32; 2], [from, to]: [f32; 2]) -> [i32; 2] {
    [
        field.minor.cell_alone(first.min(last) * from),
        field.minor.cell_alone(first.max(last) * to),
    ]
}

/// How high over the eye, in metres, the ground rises at most that two neighbouring groups of planes, of
/// which the outermost advance by `outer`, pass between the mirrored line `line` and the one that lies
/// 2 ^ `level` cells further; `None` where blocks do not begin at that line, or the ground ends before.
#[inline(always)]
pub(in crate::planes) fn ceiling(
    field: &Field<'_>,
    outer: [[f32; 2]; 2],
    line: i32,
    level: usize,
) -> Option<f32> {
    let (major, minor) = (&field.major, &field.minor);
    let size = 1 << level;
    let post = major.post(line);
    if post & (size - 1) != 0 || line < major.cells[0] || line + size > major.cells[1] + 1 {
        return None;
    }
    let from = line as f32 - major.fraction;
    let [one, other] = outer.map(|outer| cells_of(field, outer, [from, from + size as f32]));
    let cells = [one[0].min(other[0]), one[1].max(other[1])];
    let cells = cells.map(|cell| minor.ground_alone(cell) >> level);
    let along = major.ground_alone(line);
    let half = size as f32 * 0.5;
    let mut most = f32::MIN;
    for block in cells[0].min(cells[1])..=cells[0].max(cells[1]) {
        let aside = block << level;
        let (x, y) = if field.major_axis == 0 {
            (along, aside)
        } else {
            (aside, along)
        };
        let within = (((y & 255) >> level) << (8 - level)) + ((x & 255) >> level);
        let place = field.roofs.tile(x >> 8, y >> 8) + (LEVEL_BEGIN[level] + within) as u32;
        let [height, rise] = *field.roofs.items.from_place(place).first()?;
        let [east, north] = [rise << 16, rise & 0xffff_0000].map(|rise| f32::from_bits(rise).abs());
        most = most.max(f32::from_bits(height) + half * (east + north));
    }
    Some(most - field.eye_height + field.rounding)
}
