//! How steep the ground is that is seen around each pixel.

use super::Steepness;
use crate::planes::sectors::ImageRays;
use glam::{DMat3, DVec3};

/// Pixels along a side of the image's squares, as a shift.
pub(in crate::planes) const SQUARE: u32 = 5;

/// Of the steepest ground, how steep any is taken to be.
const LEAST: f32 = 0.3;

/// For how steep the ground is in whatever direction, not along an axis.
pub(in crate::planes) const GRADIENT: usize = 2;

/// How many pixels aside of a block's picture it counts, along both axes: further than any ray begins from
/// a ray of an earlier step.
pub(in crate::planes) const AROUND: f64 = 24.0;

/// For each square of an image, how steep the ground is at most that may lie behind it or around it,
/// hidden or not: where rays of its pixels may be between a block's lowest and highest posts while they are
/// over the block.
pub(in crate::planes) struct SteepnessSeen {
    /// Squares from left to right.
    across: usize,
    /// What three neighbouring squares have at most, of which the first is meant, in a column and in a row of
    /// squares. Row by row from the top.
    squares: [Vec<Steepest>; 2],
}

/// Along the ground's axes x and y, and in whatever direction, metres a cell. (Four, as a processor takes as many
/// at once; the last one is not used.)
type Steepest = [f32; 4];

/// Makes a square at least as steep as another.
fn raise(square: &mut Steepest, other: &Steepest) {
    for (steep, &other) in square.iter_mut().zip(other) {
        *steep = if other > *steep { other } else { *steep };
    }
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
        let [x, y] = steepness.steepest();
        let least = [x, y, steepness.gradient(), 0.0].map(|steepest| LEAST * steepest);
        let mut squares = vec![least; across * along];
        let side = f64::from(steepness.side);
        let image = Projection::new(rays);
        for (number, block) in steepness.blocks.iter().enumerate() {
            let [x, y] = block.steepest;
            let steepest = [x, y, block.gradient, 0.0];
            if (0..3).all(|k| steepest[k] <= least[k]) {
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
                    for square in &mut squares[row * across + left..=row * across + right] {
                        raise(square, &steepest);
                    }
                }
            }
        }
        let with_next_two = |apart: usize| {
            let mut most = squares.clone();
            for next in [apart, 2 * apart] {
                let next = squares.get(next..).unwrap_or_default();
                most.iter_mut().zip(next).for_each(|(to, by)| raise(to, by));
            }
            most
        };
        Self {
            across,
            squares: [across, 1].map(with_next_two),
        }
    }

    /// Along the ground's axis `axis`, or in whatever direction (if that is [`GRADIENT`]), around the pixels of the
    /// image's column (if `image_axis` is 0) or row (if it is 1) `line`: a number for each square of them, which
    /// holds for those of the next two, too.
    pub(in crate::planes) fn along(
        &self,
        axis: usize,
        image_axis: usize,
        line: u32,
    ) -> impl Iterator<Item = f32> {
        let squares = &self.squares[image_axis];
        let line = (line >> SQUARE) as usize;
        let (first, next, count) = if image_axis == 1 {
            (line * self.across, 1, self.across)
        } else {
            (line, self.across, squares.len() / self.across)
        };
        let line = squares[first..].iter().step_by(next).take(count);
        line.map(move |steepest| steepest[axis])
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use sandtable_terrain::Ground;
    use sandtable_view::{Attitude, Camera, Screen, View};

    /// Gentle ground with two cliffs, between which it is even.
    fn ground() -> Ground {
        let height = |col: u32, row: u32| {
            let gentle = 4.0 * (0.07 * f64::from(col + row)).sin();
            let cliff = |near: bool| if near { 30.0 } else { 0.0 };
            let tower = cliff(col.abs_diff(50) < 3 && row.abs_diff(210) < 4);
            (gentle + tower + cliff(col > 230 && row > 90)) as f32
        };
        Ground::from_fn(300, 270, DVec2::new(1.0, 2.0), height).expect("a sound grid")
    }

    fn views() -> Vec<View> {
        let size = [400, 330];
        let looking = |eye: [f64; 3], [yaw, pitch, roll]: [f64; 3]| {
            Camera {
                eye: DVec3::from(eye),
                attitude: Attitude { yaw, pitch, roll },
                horizontal_fov: 1.2,
            }
            .view(size)
        };
        let table = View {
            eye: DVec3::new(140.0, -60.0, 150.0),
            window: Screen {
                lower_left: DVec3::new(-10.0, -10.0, 12.0),
                lower_right: DVec3::new(310.0, -10.0, 12.0),
                upper_left: DVec3::new(-10.0, 560.0, 12.0),
            },
            size,
        };
        vec![
            looking([150.0, 250.0, 200.0], [0.3, -1.5, 0.2]),
            looking([150.0, 250.0, 50.0], [2.3, -0.6, 0.8]),
            looking([150.0, 20.0, 8.0], [0.0, -0.1, 0.0]),
            // On a cliff's edge.
            looking([231.2, 300.0, 40.0], [0.0, -0.3, 0.1]),
            looking([-90.0, 800.0, 90.0], [2.6, -0.2, 1.5]),
            table,
        ]
    }

    #[test]
    fn what_is_steep_is_seen_around_its_pixels() {
        let ground = ground();
        let heights = ground.heights();
        let steepness = Steepness::new(heights);
        let per_metre = DVec3::new(1.0, 0.5, 1.0);
        for view in views() {
            let rays = ImageRays::new(&view, per_metre);
            let seen = SteepnessSeen::new(&steepness, &rays, view.eye * per_metre, 1e-4);
            let mut looked = 0;
            for (col, row) in (0..269).flat_map(|row| (0..299).map(move |col| (col, row))) {
                let [sw, se, nw, ne] = heights.cell(col, row);
                let [x, y] = [
                    (se - sw).abs().max((ne - nw).abs()),
                    (nw - sw).abs().max((ne - se).abs()),
                ];
                // All digits but the last two.
                let steep = [x, y, 0.999_999 * x.hypot(y)];
                for height in [sw, ne, 0.5 * (nw + se)] {
                    let place = DVec3::new(
                        f64::from(col) + 0.5,
                        2.0 * f64::from(row) + 1.0,
                        height.into(),
                    );
                    let Some(pixel) = view.pixel_of(place) else {
                        continue;
                    };
                    let beside = [-23.0, 0.0, 23.0].map(|x| [-23.0, 0.0, 23.0].map(|y| [x, y]));
                    for [x, y] in beside.into_iter().flatten() {
                        let [x, y] = [pixel.x + x, pixel.y + y].map(f64::floor);
                        let inside = x >= 0.0 && y >= 0.0 && x < 400.0 && y < 330.0;
                        if !inside {
                            continue;
                        }
                        for (image_axis, [line, at]) in [[x, y], [y, x]].into_iter().enumerate() {
                            let square = at as usize >> SQUARE;
                            for (axis, &steep) in steep.iter().enumerate() {
                                let around = seen.along(axis, image_axis, line as u32);
                                let around: Vec<_> = around.take(square + 1).collect();
                                for &around in &around[square.saturating_sub(2)..] {
                                    assert!(
                                        around >= steep,
                                        "{around} at {col}, {row} in {view:?}"
                                    );
                                }
                                looked += 1;
                            }
                        }
                    }
                }
            }
            assert!(looked > 10_000, "{looked} in {view:?}");
        }
    }

    /// Far from cliffs the ground is not taken to be as steep as they are.
    #[test]
    fn cliffs_are_steep_where_they_are() {
        let steepness = Steepness::new(ground().heights());
        let view = views()[0];
        let per_metre = DVec3::new(1.0, 0.5, 1.0);
        let rays = ImageRays::new(&view, per_metre);
        let seen = SteepnessSeen::new(&steepness, &rays, view.eye * per_metre, 1e-4);
        let steepest = steepness.steepest();
        for (axis, steepest) in steepest.into_iter().enumerate() {
            let squares = &seen.squares[1];
            let gentle = squares.iter().filter(|steep| steep[axis] < 0.5 * steepest);
            let (gentle, all) = (gentle.count(), squares.len());
            assert!(gentle > all / 4 && gentle < all, "{gentle} of {all}");
        }
    }
}
