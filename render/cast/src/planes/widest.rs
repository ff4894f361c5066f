//! How many posts pixels cover at most.

use super::sectors::ImageRays;
use glam::{DMat3, DVec2, DVec3};

/// At how many places along each side of the image, and of the part of it that has the ground's heights, it is
/// looked at.
const LOOKS: u32 = 17;

impl ImageRays {
    /// How many cells a pixel covers at most, about, across its vertical plane, wherever ground of so
    /// many `cells` along x and y and between two `heights` may be seen in it by an `eye` (cells along x
    /// and y, and metres): of pixels at even distances over the image, and over where the ground's heights lie
    /// in it. 0 where no ground can be seen.
    pub(super) fn widest(&self, eye: DVec3, cells: [i32; 2], heights: [f64; 2]) -> f64 {
        let places = |[first, last]: [f64; 2]| {
            let by = (last - first) / f64::from(LOOKS - 1);
            (0..LOOKS).map(move |k| first + by * f64::from(k))
        };
        // Ground that is small in the image lies between its places, and walls reach down beyond the ground's.
        [self.whole(), self.around(eye, cells, heights)]
            .into_iter()
            .flat_map(|[columns, rows]| {
                places(rows).flat_map(move |j| places(columns).map(move |i| [i, j]))
            })
            .map(|[i, j]| {
                let d = self.first + i * self.steps[0] + j * self.steps[1];
                // Lanes run along the axis of the image along which planes follow more closely.
                let across = self.steps.map(|step| (step.x * d.y - step.y * d.x).abs());
                let length = d.truncate().length();
                let by_length = if length > 0.0 {
                    across[0].max(across[1]) / length
                } else {
                    let lengths = self.steps.map(|step| step.truncate().length());
                    lengths[0].max(lengths[1])
                };
                by_length * farthest(eye, d, cells, heights)
            })
            .fold(0.0, f64::max)
    }

    /// The first and the last column, and row.
    fn whole(&self) -> [[f64; 2]; 2] {
        self.size.map(|side| [0.0, f64::from(side - 1)])
    }

    /// The first and the last column, and row, of the image that may have ground of so many `cells` between
    /// two `heights`: all of them where that is not all before the `eye`.
    fn around(&self, eye: DVec3, cells: [i32; 2], heights: [f64; 2]) -> [[f64; 2]; 2] {
        let whole = self.whole();
        let image = DMat3::from_cols(self.steps[0], self.steps[1], self.first).inverse();
        let ends = cells.map(|cells| [0.0, f64::from(cells)]);
        let mut around = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for k in 0..8 {
            let corner = DVec3::new(ends[0][k & 1], ends[1][k >> 1 & 1], heights[k >> 2]);
            let at = image * (corner - eye);
            // A window that is seen edgewise has no inverse.
            if !at.is_finite() || at.z <= 0.0 {
                return whole;
            }
            for ([first, last], at) in around.iter_mut().zip([at.x / at.z, at.y / at.z]) {
                (*first, *last) = (first.min(at), last.max(at));
            }
        }
        std::array::from_fn(|axis| {
            let [first, last] = whole[axis];
            around[axis].map(|at| at.clamp(first, last))
        })
    }
}

/// How many times as far as its direction `d` leads a ray may meet ground at most; 0 where it meets none.
fn farthest(eye: DVec3, d: DVec3, cells: [i32; 2], [low, high]: [f64; 2]) -> f64 {
    let ends = DVec2::from_array(cells.map(f64::from));
    let (mut begin, mut end) = (0.0_f64, f64::INFINITY);
    for axis in 0..2 {
        if d[axis] == 0.0 {
            if !(0.0..=ends[axis]).contains(&eye[axis]) {
                return 0.0;
            }
            continue;
        }
        let lines = [0.0, ends[axis]].map(|line| (line - eye[axis]) / d[axis]);
        begin = begin.max(lines[0].min(lines[1]));
        end = end.min(lines[0].max(lines[1]));
    }
    // Over all ground a ray meets none, and below all of it no more than a wall.
    if d.z > 0.0 {
        end = end.min((high - eye.z) / d.z);
    } else if d.z < 0.0 {
        end = end.min(begin.max((low - eye.z) / d.z));
    } else if eye.z > high {
        return 0.0;
    }
    if end < begin { 0.0 } else { end }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::{Isa, PlanesScene};
    use crate::{Image, PreparedScene, Scene, Scheme, standpoints};
    use sandtable_terrain::Ground;
    use sandtable_view::{Attitude, Camera, View};
    use std::f64::consts::FRAC_PI_2;

    fn camera(eye: [f64; 3], [yaw, pitch, roll]: [f64; 3], size: [u32; 2]) -> View {
        let attitude = Attitude { yaw, pitch, roll };
        Camera {
            eye: DVec3::from_array(eye),
            attitude,
            horizontal_fov: 1.0,
        }
        .view(size)
    }

    fn widest(view: &View, ground: &Ground) -> f64 {
        let grid = ground.grid();
        let per_metre = DVec3::new(1.0 / grid.spacing.x, 1.0 / grid.spacing.y, 1.0);
        let cells = [grid.cols, grid.rows].map(|posts| posts as i32 - 1);
        ImageRays::new(view, per_metre).widest(
            view.eye * per_metre,
            cells,
            ground.range().map(f64::from),
        )
    }

    #[test]
    fn straight_down_it_is_a_pixel_of_the_lowest_ground() {
        let ground = Ground::from_fn(101, 101, DVec2::new(2.0, 4.0), |col, _| {
            if col == 0 { -10.0 } else { 0.0 }
        })
        .expect("a sound grid");
        let view = camera([100.0, 200.0, 40.0], [0.0, -FRAC_PI_2, 0.0], [101, 101]);
        // 50 m below, in cells of 2 m.
        let expected = 50.0 * 2.0 * 0.5_f64.tan() / 101.0 / 2.0;
        let widest = widest(&view, &ground);
        assert!(
            (widest - expected).abs() < 0.01 * expected,
            "{widest}, {expected}"
        );
    }

    /// From so far away that all ground lies in a few pixels somewhere in the image.
    #[test]
    fn ground_that_is_small_in_the_image_is_found() {
        let ground = Ground::from_fn(101, 101, DVec2::splat(2.0), |col, row| {
            (col % 9 + row) as f32
        })
        .expect("a sound grid");
        for pixels in [0.3, 3.0, 30.0] {
            // Where all of its 200 m, or 100 cells, are so many pixels wide.
            let far = 200.0 / pixels * 200.0 / 0.5_f64.tan();
            for aside in [-0.25, 0.0, 0.31] {
                let height = 0.5_f64;
                let eye = [100.0, 100.0 - far * height.cos(), far * height.sin()];
                let view = camera(eye, [aside, aside - height, 0.2], [400, 300]);
                let middle = 100.0 / pixels;
                let widest = widest(&view, &ground);
                assert!(
                    (0.5 * middle..2.0 * middle).contains(&widest),
                    "{widest}, {middle}, {pixels} pixels, {aside}"
                );
            }
        }
    }

    #[test]
    fn where_no_ground_can_be_seen_it_is_nothing() {
        let ground = Ground::from_fn(50, 50, DVec2::ONE, |col, row| (col + row) as f32)
            .expect("a sound grid");
        for view in [
            camera([25.0, 25.0, 200.0], [0.0, 1.0, 0.0], [64, 48]),
            camera([25.0, 200.0, 20.0], [0.0, 0.0, 0.0], [64, 48]),
        ] {
            assert_eq!(widest(&view, &ground), 0.0);
        }
    }

    /// It is not less than any pixel's width where that pixel meets the ground, and not much more where
    /// ground is seen at its far end.
    #[test]
    fn no_pixel_is_wider() {
        let height = |col: u32, row: u32| {
            let [x, y] = [col, row].map(f64::from);
            (9.0 * (0.11 * x).sin() * (0.07 * y).cos()) as f32
        };
        let ground = Ground::from_fn(150, 120, DVec2::new(1.0, 1.5), height).expect("a grid");
        let scene = Scene::new(ground);
        let ground = &scene.ground;
        let size = [120, 90];
        let mut views = vec![
            standpoints::at_table(ground, DVec3::new(0.0, -0.7, 0.6), size),
            standpoints::wan(ground, 0.7),
            camera([-40.0, -60.0, 5.0], [0.5, -0.1, 0.3], size),
            camera([-40.0, 300.0, -50.0], [2.5, 0.4, 0.0], size),
        ];
        for k in 0..12 {
            let turn = 0.5 * f64::from(k);
            let pitch = -0.2 - 0.1 * f64::from(k);
            views.push(camera([70.0, 80.0, 30.0], [turn, pitch, turn], size));
        }
        for view in views {
            let prepared = PlanesScene::new(Isa::best(), None, scene.clone());
            let mut images = [Image::default()];
            prepared
                .cast(&[view], &mut images, Scheme::default())
                .expect("accepted");
            let [image] = images;
            let rays = ImageRays::new(&view, DVec3::new(1.0, 1.0 / 1.5, 1.0));
            let mut most = 0.0_f64;
            for (j, i) in (0..view.size[1]).flat_map(|j| (0..view.size[0]).map(move |i| (j, i))) {
                let Some(point) = image.point(i, j) else {
                    continue;
                };
                let d = rays.first + f64::from(i) * rays.steps[0] + f64::from(j) * rays.steps[1];
                let far = (point - view.eye).length() / view.ray(i, j).direction.length();
                let across = |v: DVec3| (v.x * d.y - v.y * d.x).abs() / d.truncate().length();
                most = most.max(far * across(rays.steps[0]).max(across(rays.steps[1])));
            }
            let widest = widest(&view, ground);
            assert!(
                most <= 1.05 * widest && widest < 4.0 * most,
                "{most} and {widest} in {view:?}"
            );
        }
    }
}
