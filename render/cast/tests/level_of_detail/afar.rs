//! From farther away than numbers tell cells apart.

use crate::ground::{mountains, photo};
use crate::truth::{compared, truth};
use crate::views::cast;
use glam::DVec3;
use sandtable_cast::{Planes, Scene};
use sandtable_view::{Attitude, Camera};

/// From ten times as far as numbers tell cells apart, in pixels of the same ground: no farther from the truth
/// than from where they do, by far nearer than points are, and calm when the eye moves.
#[test]
fn from_afar_it_is_as_near_to_the_truth() {
    let scene = Scene::new(mountains().with_photo(photo()));
    let look = |cells: f64, aside: f64| {
        let height = 0.6_f64;
        let attitude = Attitude {
            pitch: -height,
            ..Attitude::default()
        };
        let away = DVec3::new(0.0, -height.cos(), height.sin());
        Camera {
            eye: DVec3::new(350.0 + aside, 300.0, 0.0) + cells * away,
            attitude,
            // Pixels of nine metres.
            horizontal_fov: 2.0 * (0.5 * 9.0 * 128.0 / cells).atan(),
        }
        .view([128, 96])
    };
    let [near, far] = [1e5, 1e6].map(|cells| compared(&scene, look(cells, 0.0)));
    println!("without and with detail: {near:.2?} dB near, {far:.2?} dB far");
    assert!(far[1] > near[1] - 0.2 && far[1] > far[0] + 6.0);
    let moved = [0.0, 4.5].map(|aside| look(1e6, aside));
    let [change, in_truth] = [
        cast(Planes::WITH_DETAIL, &scene, &moved)
            .iter()
            .map(|image| image.colour().to_vec())
            .collect::<Vec<_>>(),
        moved.iter().map(|view| truth(&scene, view)).collect(),
    ]
    .map(|images| {
        let pixels = images[0].iter().zip(&images[1]);
        pixels
            .map(|(a, b)| f64::from(a[1].abs_diff(b[1])))
            .sum::<f64>()
    });
    println!("half a pixel aside it changes by {change}, the truth by {in_truth}");
    assert!(change < 1.2 * in_truth);
}
