//! How steep the ground is that is seen around each pixel.

use super::Steepness;
use crate::planes::sectors::ImageRays;
use glam::{DMat3, DVec3};

/// Pixels along a side of the image's squares, as a shift.
pub(in crate::planes) const SQUARE: u32 = 5;

/// Of the steepest ground, how steep any is taken to be.
const LEAST: f32 = 0.3;

/// How many pixels aside of a block's picture it counts, along both axes: further than any ray begins from
/// a ray of an earlier step.
pub(in crate::planes) const AROUND: f64 = 24.0;

/// For each square of an image, how steep the ground is at most that may lie behind it or around it,
/// hidden or not: where rays of its pixels may be between a block's lowest and highest posts while they are
/// over the block.
pub(in crate::planes) struct SteepnessSeen {
    /// Squares from left to right.
    across: usize,
    /// Along the ground's axes x and y, metres a cell: what three neighbouring squares have at most, of
    /// which the first is meant, in a column and in a row of squares. Row by row from the top.
    squares: [[Vec<f32>; 2]; 2],
}

impl SteepnessSeen {
    /// For rays from `eye`, which lies so many cells, and metres, from the ground's south-west post; heights
    /// are rounded by up to `rounding` metres.
    pub(in crate::planes) fn new(
        steepness: &Steepness,
        rays: &ImageRays,
        eye: DVec3,
        rounding: f32,
    ) -> Self {
        let [across, along] = rays
            .size
            .map(|pixels| pixels.div_ceil(1 << SQUARE) as usize);
        // What is less steep than this is not worth its projection.
        let least = steepness.steepest().map(|steepest| LEAST * steepest);
        let mut squares = least.map(|least| vec![least; across * along]);
        let side = f64::from(steepness.side);
        let image = Projection::new(rays);
        for (number, block) in steepness.blocks.iter().enumerate() {
            if block.steepest[0] <= least[0] && block.steepest[1] <= least[1] {
                continue;
            }
            let [low, high] = block.heights;
            let first = DVec3::new(
                (number % steepness.across) as f64 * side,
                (number / steepness.across) as f64 * side,
                f64::from(low - rounding),
            );
            let size = DVec3::new(side, side, f64::from(high - low + 2.0 * rounding));
            if let Some([[left, right], [top, bottom]]) = image.of_box(first - eye, size) {
                for row in top..=bottom {
                    for (squares, steep) in squares.iter_mut().zip(block.steepest) {
                        for square in &mut squares[row * across + left..=row * across + right] {
                            *square = square.max(steep);
                        }
                    }
                }
            }
        }
        Self {
            across,
            squares: squares.map(|squares| {
                [across, 1].map(|next| {
                    (0..squares.len())
                        .map(|at| {
                            let three = squares[at..].iter().step_by(next).take(3);
                            three.fold(0.0, |a: f32, &b| a.max(b))
                        })
                        .collect()
                })
            }),
        }
    }

    /// Along the ground's axis `axis`, around the pixels of the image's column (if `image_axis` is 0) or row
    /// (if it is 1) `line`: a number for each square of them, which holds for those of the next two, too.
    pub(in crate::planes) fn along(
        &self,
        axis: usize,
        image_axis: usize,
        line: u32,
    ) -> impl Iterator<Item = f32> {
        let squares = &self.squares[axis][image_axis];
        let line = (line >> SQUARE) as usize;
        let (first, next, count) = if image_axis == 1 {
            (line * self.across, 1, self.across)
        } else {
            (line, self.across, squares.len() / self.across)
        };
        squares[first..].iter().step_by(next).take(count).copied()
    }
}

/// Where in the image places lie.
struct Projection {
    /// Columns, rows and 1, times how many of the first ray's direction's lengths away a place is, for each
    /// 1 of x, y, z.
    by_axis: [DVec3; 3],
    size: [f64; 2],
}

impl Projection {
    fn new(rays: &ImageRays) -> Self {
        let [column, row] = rays.steps;
        let inverse = DMat3::from_cols(column, row, rays.first).inverse();
        Self {
            by_axis: [inverse.x_axis, inverse.y_axis, inverse.z_axis],
            size: rays.size.map(f64::from),
        }
    }

    fn of(&self, place: DVec3) -> DVec3 {
        let [x, y, z] = self.by_axis;
        x * place.x + y * place.y + z * place.z
    }

    /// The first and the last column and row of squares around the picture of a box, or `None` where it
    /// lies off the image.
    fn of_box(&self, first: DVec3, size: DVec3) -> Option<[[usize; 2]; 2]> {
        let first = self.of(first);
        let [x, y, z] = self.by_axis;
        let [x, y, z] = [x * size.x, y * size.y, z * size.z];
        let corners = [
            first,
            first + x,
            first + y,
            first + x + y,
            first + z,
            first + x + z,
            first + y + z,
            first + x + y + z,
        ];
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let mut is_before = true;
        for corner in corners {
            is_before &= corner.z > 0.0;
            let near = 1.0 / corner.z;
            for (range, along) in range.iter_mut().zip([corner.x, corner.y]) {
                let at = along * near;
                *range = [range[0].min(at), range[1].max(at)];
            }
        }
        let last = self.size.map(|size| size - 1.0);
        if !is_before {
            // It reaches behind the eye, where places have no picture: what lies wholly on the outer side of
            // one of the image's sides is not seen.
            let all = |is_outside: &dyn Fn(DVec3) -> bool| corners.iter().copied().all(is_outside);
            let is_off = all(&|c| c.z <= 0.0)
                || all(&|c| c.x < -AROUND * c.z)
                || all(&|c| c.y < -AROUND * c.z)
                || all(&|c| c.x > (last[0] + AROUND) * c.z)
                || all(&|c| c.y > (last[1] + AROUND) * c.z);
            if is_off {
                return None;
            }
            range = last.map(|last| [0.0, last]);
        }
        let mut squares = [[0; 2]; 2];
        for ((squares, [from, to]), last) in squares.iter_mut().zip(range).zip(last) {
            let (from, to) = (from - AROUND, to + AROUND);
            if to < 0.0 || from > last {
                return None;
            }
            *squares = [from.max(0.0), to.min(last)].map(|at| at as usize >> SQUARE);
        }
        Some(squares)
    }
}
