//! Views, and images of them.

use glam::DVec3;
use sandtable_cast::{CastPool, Image, Scene, caster_by_name};
use sandtable_view::{Attitude, Camera, View};
use std::sync::Arc;

pub(crate) fn cast(caster: &str, scene: &Arc<Scene>, views: &[View]) -> Vec<Image> {
    let caster = caster_by_name(caster).expect("there is one");
    let pool = CastPool::new(2).expect("threads");
    let prepared = pool
        .run(|| caster.prepare(Arc::clone(scene)))
        .expect("suits");
    let mut images = vec![Image::default(); views.len()];
    pool.cast(&*prepared, views, &mut images).expect("accepted");
    images
}

pub(crate) fn camera(eye: DVec3, pitch: f64, size: [u32; 2]) -> View {
    let attitude = Attitude {
        yaw: 0.4,
        pitch,
        roll: 0.2,
    };
    let horizontal_fov = 1.0;
    Camera {
        eye,
        attitude,
        horizontal_fov,
    }
    .view(size)
}
