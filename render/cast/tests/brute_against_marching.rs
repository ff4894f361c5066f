//! Brute force against small steps along random rays over random ground.

use glam::{DVec2, DVec3};
use sandtable_cast::{Brute, CastPool, Caster, Image, Scene};
use sandtable_terrain::Ground;
use sandtable_view::{Screen, View};
use std::sync::Arc;

/// SplitMix64, from 0 to 1.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

const SPACING: DVec2 = DVec2::new(1.5, 0.8);
const STEP: f64 = 2e-3;

fn ground(random: &mut Random) -> Ground {
    let heights: Vec<f32> = (0..12 * 15)
        .map(|_| random.between(0.0, 3.0) as f32)
        .collect();
    Ground::from_fn(12, 15, SPACING, |col, row| {
        heights[(row * 12 + col) as usize]
    })
    .expect("a sound grid")
}

/// How far above the ground a point is; `None` beside the terrain.
fn clearance(ground: &Ground, at: DVec3) -> Option<f64> {
    Some(at.z - ground.height_at(at.x, at.y)?)
}

#[test]
fn no_step_before_the_hit_is_inside_and_the_hit_is_on_the_ground() {
    let mut random = Random(3);
    let pool = CastPool::new(2).expect("two threads");
    let (mut hits, mut walls, mut skies) = (0, 0, 0);
    for _ in 0..20 {
        let ground = ground(&mut random);
        let extent = ground.grid().extent();
        let scene = Scene::new(ground);
        let eye = DVec3::new(
            random.between(-6.0, extent.x + 6.0),
            random.between(-6.0, extent.y + 6.0),
            random.between(-1.0, 6.0),
        );
        let mut corner = || {
            eye + DVec3::new(
                random.between(-1.0, 1.0),
                random.between(-1.0, 1.0),
                random.between(-0.7, 0.4),
            )
        };
        let window = Screen {
            lower_left: corner(),
            lower_right: corner(),
            upper_left: corner(),
        };
        let view = View {
            eye,
            window,
            size: [12, 10],
        };
        let mut images = [Image::default()];
        pool.cast(
            &*Brute.prepare(Arc::clone(&scene)).expect("no options"),
            &[view],
            &mut images,
        )
        .expect("any view will do");
        let ground = &scene.ground;
        for j in 0..10 {
            for i in 0..12 {
                let direction = view.ray(i, j).direction.normalize();
                let depth = f64::from(images[0].depth[(j * 12 + i) as usize]);
                let end = depth.min(40.0);
                let mut t = 0.0;
                while t < end - 1e-5 {
                    let above = clearance(ground, eye + t * direction);
                    assert!(
                        above.is_none_or(|above| above > -1e-5),
                        "missed at {t} of {depth}"
                    );
                    t += STEP;
                }
                if depth.is_infinite() {
                    skies += 1;
                    continue;
                }
                // Just behind the hit lies ground; at it, the surface or the border's wall.
                let at = clearance(ground, eye + depth * direction);
                if at.is_some_and(|above| above.abs() < 1e-4) {
                    hits += 1;
                } else {
                    let behind = clearance(ground, eye + (depth + 1e-4) * direction);
                    assert!(
                        behind.is_some_and(|above| above < 1e-3),
                        "{behind:?} behind {depth}"
                    );
                    walls += 1;
                }
            }
        }
    }
    assert!(
        hits > 300 && walls > 30 && skies > 300,
        "{hits} hits, {walls} walls, {skies} skies"
    );
}
