//! Picking: a single ray, for whoever points at the ground or doubts a pixel.

use crate::intersect::GridFrame;
use crate::shade::{Sight, sight_at};
use crate::tally::Uncounted;
use glam::DVec3;
use sandtable_terrain::Ground;
use sandtable_view::Ray;

/// Where `ray` meets the solid ground first, in world metres, as brute force sees it; `None` where
/// it meets none, and for a ray that is no ray.
#[must_use]
pub fn pick(ground: &Ground, ray: &Ray) -> Option<DVec3> {
    let proper =
        ray.origin.is_finite() && ray.direction.is_finite() && ray.direction.length_squared() > 0.0;
    if !proper {
        return None;
    }
    let hit = first_hit(ground, ray)?;
    Some(ray.origin + hit * ray.direction)
}

/// What brute force sees along `ray`, which must be one: its origin finite, its direction finite
/// and not zero. Through a pixel's centre it is that pixel's colour and, but for the rounding to
/// f32, its depth.
#[must_use]
pub fn sight(ground: &Ground, ray: &Ray) -> Sight {
    sight_at(ground, ray, first_hit(ground, ray))
}

fn first_hit(ground: &Ground, ray: &Ray) -> Option<f64> {
    let grid = GridFrame::new(ground);
    let clipped = grid.clip(ray)?;
    clipped.first_hit(clipped.enter, &mut Uncounted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Brute, CastPool, Scene, standpoints};
    use sandtable_terrain::TerrainSource;

    fn ground() -> Ground {
        let source: TerrainSource = "builtin:ridges?size=65&seed=1".parse().unwrap();
        sandtable_terrain::open(&source, None).unwrap().ground
    }

    #[test]
    fn what_is_pointed_at_from_above_is_the_ground_below() {
        let ground = ground();
        let middle = 0.5 * ground.grid().extent();
        let from = middle.extend(5e3);
        for tilt in [0.0, 0.01, -0.02] {
            let direction = DVec3::new(tilt, 0.5 * tilt, -1.0);
            let ray = Ray {
                origin: from,
                direction,
            };
            let hit = pick(&ground, &ray).unwrap();
            let height = ground.height_at(hit.x, hit.y).unwrap();
            assert!((hit.z - height).abs() < 1e-6, "{hit} is not at {height}");
            assert!((hit - from).cross(direction).length() < 1e-3);
        }
    }

    #[test]
    fn a_sight_is_the_pixel_that_brute_force_casts() {
        let scene = Scene::new(ground());
        let pool = CastPool::new(2).unwrap();
        for at in standpoints::level(&scene.ground, [24, 18]) {
            let image = pool.picture(&Brute, &scene, at.view).unwrap();
            for j in 0..18 {
                for i in 0..24 {
                    let sight = sight(&scene.ground, &at.view.ray(i, j));
                    let pixel = (j * 24 + i) as usize;
                    assert_eq!(image.depth[pixel], sight.depth as f32);
                    assert_eq!(image.colour()[pixel][..3], sight.colour);
                }
            }
        }
    }

    #[test]
    fn who_points_at_the_sky_points_at_nothing() {
        let ground = ground();
        let origin = (0.5 * ground.grid().extent()).extend(1e5);
        let at = |direction| pick(&ground, &Ray { origin, direction });
        assert_eq!(at(DVec3::Z), None);
        for nonsense in [DVec3::ZERO, DVec3::NAN, DVec3::splat(f64::INFINITY)] {
            assert_eq!(at(nonsense), None);
        }
        // Who is inside the ground points at where he is.
        let inside = origin.with_z(-1e4);
        let ray = Ray {
            origin: inside,
            direction: DVec3::X,
        };
        assert_eq!(pick(&ground, &ray), Some(inside));
    }
}
