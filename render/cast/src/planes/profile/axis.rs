//! Mirrored lines and cells of an axis, one at a time.

use crate::planes::field::Axis;

impl Axis {
    /// The post on a mirrored line.
    pub(super) fn post(&self, line: i32) -> i32 {
        if self.sign > 0 {
            self.base + line
        } else {
            self.base + 1 - line
        }
    }

    /// The number of the ground's last post.
    pub(super) fn last_post(&self) -> i32 {
        self.cells[1] - self.cells[0] + 1
    }

    /// The ground's cell that is a mirrored one.
    pub(in crate::planes) fn ground_alone(&self, cell: i32) -> i32 {
        if self.sign > 0 {
            self.base + cell
        } else {
            self.base - cell
        }
    }

    /// As `cell`, of one place.
    pub(in crate::planes) fn cell_alone(&self, along: f32) -> i32 {
        let cell = (along + self.fraction) as i32;
        cell.min(self.cells[1]).max(self.cells[0])
    }

    /// As `inside`, of one place, but along the rays' direction.
    pub(super) fn inside_alone(&self, along: f32, cell: i32) -> f32 {
        (along + self.fraction - cell as f32).clamp(0.0, 1.0)
    }
}
