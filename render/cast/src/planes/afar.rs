//! How far away the ground may be, and how narrow pixels.

use super::sectors::ImageRays;
use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;

/// How far away the ground's farthest corner may be in any case, along an axis, in lengths of a cell's shorter
/// side: up to there the kernels' numbers have digits enough for a hundredth of one.
const ALWAYS: f64 = 131_072.0;

/// What the kernels' numbers have digits enough for.
struct Limits {
    /// How far away the ground may be, as [`ALWAYS`] has it, where pixels are so wide that rays are nearer to where
    /// they should be than a hundredth of one: a way is rounded by a part of itself, and pixels widen with it.
    farthest: f64,
    /// Which pixels are so wide, as the angle from one to the next.
    narrowest_afar: f64,
    /// The same where no ground is that far away.
    narrowest: f64,
}

/// For rays over the ground's own resolution: a hit is told to a tenth of a cell.
const EXACT: Limits = Limits {
    farthest: 262_144.0,
    narrowest_afar: 1.0 / 8192.0,
    narrowest: 1e-6,
};

/// Where the ground is coarsened: cells are as wide as pixels.
const COARSENED: Limits = Limits {
    farthest: 8_388_608.0,
    narrowest_afar: 1.0 / 131_072.0,
    narrowest: 0.0,
};

/// At how many places along each side of the image it is looked how narrow pixels are.
const LOOKS: u32 = 5;

impl ImageRays {
    /// Whether the ground is so far away from an `eye` (metres), or pixels so narrow, that the kernels'
    /// numbers have too few digits.
    pub(super) fn are_too_fine(&self, ground: &Ground, eye: DVec3, coarsens: bool) -> bool {
        let grid = ground.grid();
        let ends = DVec2::ZERO.extend(f64::from(ground.range()[0]));
        let other_ends = grid.extent().extend(f64::from(ground.range()[1]));
        let farthest = (eye - ends).abs().max((eye - other_ends).abs());
        let farthest = farthest.max_element() / grid.cell_length();
        let may = if coarsens { COARSENED } else { EXACT };
        let narrowest = if farthest > ALWAYS {
            may.narrowest_afar
        } else {
            may.narrowest
        };
        farthest > may.farthest || self.narrowest(grid.spacing) < narrowest
    }

    /// The least angle from a pixel to the next one, about: of pixels at even distances over the whole image, of
    /// ground with such a `spacing` of posts.
    fn narrowest(&self, spacing: DVec2) -> f64 {
        let metres = spacing.extend(1.0);
        let (first, steps) = (self.first * metres, self.steps.map(|step| step * metres));
        let places = |side: u32| {
            let last = f64::from(side - 1);
            (0..LOOKS).map(move |k| last * f64::from(k) / f64::from(LOOKS - 1))
        };
        let [width, height] = self.size;
        places(height)
            .flat_map(|j| places(width).map(move |i| first + i * steps[0] + j * steps[1]))
            .flat_map(|d| steps.map(|step| step.cross(d).length() / d.length_squared()))
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use crate::lanes::Isa;
    use crate::planes::PlanesScene;
    use crate::planes::detail::DetailOptions;
    use crate::units::UnitCaster;
    use glam::{DVec2, DVec3};
    use sandtable_terrain::Ground;
    use sandtable_view::{Attitude, Camera};
    use std::f64::consts::FRAC_PI_2;

    /// Where each pixel is cast alone, without detail and with it.
    #[test]
    fn pixels_are_cast_alone_only_where_digits_are_too_few() {
        let ground = Ground::from_fn(65, 65, DVec2::splat(2.0), |col, row| (col + row) as f32);
        let scene = Scene::new(ground.expect("a sound grid"));
        let options = DetailOptions {
            cell: 1.5,
            blur: 1.9,
        };
        let prepared = [None, Some(options)]
            .map(|options| PlanesScene::new(Isa::best(), options, scene.clone()));
        // So many cells away, to the side and above, in pixels of so many radians.
        let alone = |aside: f64, above: f64, pixel: f64| {
            let away = 2.0 * DVec3::new(0.0, -aside, above);
            let camera = Camera {
                eye: DVec3::new(64.0, 64.0, 0.0) + away,
                attitude: Attitude {
                    pitch: if aside == 0.0 {
                        -FRAC_PI_2
                    } else {
                        -above.atan2(aside)
                    },
                    ..Attitude::default()
                },
                horizontal_fov: 2.0 * (0.5 * 96.0 * pixel).atan(),
            };
            let view = camera.view([96, 80]);
            prepared.each_ref().map(|prepared| {
                prepared
                    .frame(&view)
                    .expect("a proper view")
                    .alone
                    .is_some()
            })
        };
        for [aside, above] in [[1.0, 0.0], [1.0, 0.2], [0.8, 0.8], [0.0, 1.0]] {
            let alone = |cells: f64, pixel: f64| alone(cells * aside, cells * above, pixel);
            assert_eq!(alone(100_000.0, 5e-7), [true; 2]);
            assert_eq!(alone(100_000.0, 2e-6), [false; 2]);
            assert_eq!(alone(100_000.0, 1e-3), [false; 2]);
            // There pixels are 3 cells wide, then 30, and less than half a cell.
            assert_eq!(alone(200_000.0, 1.5e-5), [true, false]);
            assert_eq!(alone(200_000.0, 1.5e-4), [false; 2]);
            assert_eq!(alone(200_000.0, 1e-6), [true; 2]);
            assert_eq!(alone(600_000.0, 1e-3), [true, false]);
            assert_eq!(alone(6_000_000.0, 1e-3), [true, false]);
            assert_eq!(alone(20_000_000.0, 1e-3), [true; 2]);
        }
    }
}
