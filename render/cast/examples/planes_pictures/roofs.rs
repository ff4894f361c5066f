//! Roofs and flat bounds of blocks as a drawing.

use crate::drawing::{EARTH, THIN, document, dot, filled, label, stroke};

const SIZE: [f64; 2] = [900.0, 300.0];

/// Where the ground begins and ends, and how wide a block is.
const GROUND: [f64; 2] = [40.0, 860.0];
const BLOCK: f64 = 102.5;

/// The ray's height where the ground begins, and how it falls.
const RAY: [f64; 2] = [48.0, 0.235];

/// The ground, in the drawing's own units, down from the top.
fn ground(x: f64) -> f64 {
    238.0 - 0.13 * x - 30.0 * (x / 84.0).sin() - 9.0 * (x / 31.0).cos()
}

fn ray(x: f64) -> f64 {
    RAY[0] + RAY[1] * (x - GROUND[0])
}

/// Places of the ground from one x to another.
fn places(from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> {
    let step = (to - from) / 40.0;
    (0..=40).map(move |k| {
        let x = from + step * f64::from(k);
        [x, ground(x)]
    })
}

/// The roof over the ground between two x: it rises as the ground does there on the whole, and lies
/// on its highest place.
fn roof(from: f64, to: f64) -> impl Fn(f64) -> f64 {
    let middle = 0.5 * (from + to);
    let squares: f64 = places(from, to).map(|[x, _]| (x - middle).powi(2)).sum();
    let product: f64 = places(from, to).map(|[x, y]| (x - middle) * y).sum();
    let rise = product / squares;
    let over = places(from, to).map(|[x, y]| y - rise * (x - middle));
    let height = over.fold(f64::INFINITY, f64::min);
    move |x| height + rise * (x - middle)
}

/// The drawing, as SVG: a ray over blocks' roofs, with their flat bounds beside them.
pub(crate) fn drawing() -> String {
    let foot = SIZE[1] - 30.0;
    let whole = (0..=8).flat_map(|k| {
        let from = GROUND[0] + BLOCK * f64::from(k);
        places(from, (from + BLOCK).min(GROUND[1]))
    });
    let mut parts = vec![filled(foot, whole, GROUND, EARTH)];
    let mut dots = Vec::new();
    let mut hit = None;
    let mut begin = GROUND[0];
    while begin < GROUND[1] - 1.0 {
        let end = begin + BLOCK;
        let heights = places(begin, end).map(|[_, y]| y);
        let highest = heights.fold(f64::INFINITY, f64::min);
        parts.push(stroke([begin, highest], [end, highest], THIN));
        let roof = roof(begin, end);
        parts.push(stroke(
            [begin, roof(begin)],
            [end, roof(end)],
            "stroke=\"#2a7a3a\" stroke-width=\"2\"",
        ));
        if hit.is_none() {
            dots.push(dot([begin, ray(begin)], "#2050a0"));
            let mut along = (0..=400).map(|k| begin + BLOCK * f64::from(k) / 400.0);
            if let Some(under) = along.find(|&x| ray(x) >= roof(x)) {
                dots.push(dot([under, ray(under)], "#2a7a3a"));
                hit = along.find(|&x| ray(x) >= ground(x));
            }
        }
        begin = end;
    }
    let hit = hit.unwrap_or(GROUND[1]);
    parts.push(stroke(
        [GROUND[0], ray(GROUND[0])],
        [hit, ray(hit)],
        "stroke=\"#2050a0\" stroke-width=\"2\"",
    ));
    dots.push(dot([hit, ray(hit)], "#b03020"));
    parts.extend(dots);
    parts.push(label([60.0, ray(60.0) - 12.0], "ray", "fill=\"#2050a0\""));
    parts.push(label([700.0, 40.0], "flat bounds, dashed", "fill=\"#555\""));
    parts.push(label([700.0, 60.0], "roofs of blocks", "fill=\"#2a7a3a\""));
    document(SIZE, &parts.concat())
}
