//! The truth, and how near images are to it.

use crate::views::cast;
use sandtable_cast::{Image, Planes, Scene};
use sandtable_terrain::LinearLight;
use sandtable_view::View;
use std::sync::Arc;

/// The mean colours of 8 × 8 rays a pixel, in linear light.
pub(crate) fn truth(scene: &Arc<Scene>, view: &View) -> Vec<[u8; 4]> {
    const SIDE: u32 = 8;
    let right = (view.ray(1, 0).direction - view.ray(0, 0).direction) / f64::from(SIDE);
    let down = (view.ray(0, 1).direction - view.ray(0, 0).direction) / f64::from(SIDE);
    let shifted: Vec<_> = (0..SIDE * SIDE)
        .map(|k| {
            let middle = f64::from(SIDE - 1) / 2.0;
            let [i, j] = [k % SIDE, k / SIDE].map(|at| f64::from(at) - middle);
            let shift = right * i + down * j;
            let mut view = *view;
            view.window.upper_left += shift;
            view.window.lower_left += shift;
            view.window.lower_right += shift;
            view
        })
        .collect();
    let light = LinearLight::tables();
    let images = cast("planes", scene, &shifted);
    (0..images[0].colour().len())
        .map(|at| {
            let mean = |channel: usize| {
                let light_of = |image: &Image| light.decode(image.colour()[at][channel]);
                let sum: f32 = images.iter().map(light_of).sum();
                light.encode(sum / images.len() as f32)
            };
            [mean(0), mean(1), mean(2), 255]
        })
        .collect()
}

/// The ratio of signal to noise in decibels.
fn decibels(colours: &[[u8; 4]], truth: &[[u8; 4]]) -> f64 {
    let error = |(a, b): (&[u8; 4], &[u8; 4])| {
        let channel = |k: usize| (f64::from(a[k]) - f64::from(b[k])).powi(2);
        channel(0) + channel(1) + channel(2)
    };
    let sum: f64 = colours.iter().zip(truth).map(error).sum();
    10.0 * (255.0 * 255.0 * 3.0 * colours.len() as f64 / sum.max(1e-9)).log10()
}

/// Point sampling's and level of detail's decibels.
pub(crate) fn compared(scene: &Arc<Scene>, view: View) -> [f64; 2] {
    let truth = truth(scene, &view);
    ["planes", Planes::WITH_DETAIL].map(|caster| {
        let images = cast(caster, scene, &[view]);
        decibels(images[0].colour(), &truth)
    })
}
