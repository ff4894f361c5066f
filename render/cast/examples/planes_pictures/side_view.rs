//! The argument of coherence as a drawing.

use crate::drawing::{EARTH, THIN, document, dot, filled, label, stroke};

/// Width and height of the drawing, and where its right part begins.
const SIZE: [f64; 2] = [900.0, 330.0];
const PART: f64 = 450.0;

/// The eye, and where the ground of the side view ends.
const EYE: [f64; 2] = [40.0, 60.0];
const END: f64 = 400.0;

/// Where ray a ends, on its ground.
const HIT: f64 = 262.0;

/// The ground under a's plane, in the drawing's own units, down from the top.
fn ground(x: f64) -> f64 {
    250.0 - 26.0 * (x / 37.0).sin() - 0.16 * x + 16.0 * (x / 91.0).cos()
}

/// The drawing, as SVG: on the left two rays from the side, on the right both at one t from behind.
pub(crate) fn drawing() -> String {
    document(SIZE, &(from_the_side() + "\n" + &from_behind() + "\n"))
}

const A: &str = "stroke=\"#b03020\" stroke-width=\"2\"";
const P: &str = "stroke=\"#2050a0\" stroke-width=\"2\"";

/// Where the ground's fill ends.
const FOOT: f64 = SIZE[1] - 30.0;

fn from_the_side() -> String {
    let hit = [HIT, ground(HIT)];
    let slope = (hit[1] - EYE[1]) / (hit[0] - EYE[0]);
    let a_at = |x: f64| EYE[1] + slope * (x - EYE[0]);
    let p_at = |x: f64| EYE[1] + (slope - 0.12) * (x - EYE[0]);
    let steps = (0..=72).map(|k| EYE[0] + (END - EYE[0]) * f64::from(k) / 72.0);
    let meets = steps.clone().find(|&x| x > HIT && p_at(x) >= ground(x));
    let meets = meets.unwrap_or(END);
    let places = steps.map(|x| [x, ground(x)]);
    let start = [HIT, p_at(HIT)];
    [
        filled(FOOT, places, [EYE[0], END], EARTH),
        stroke(EYE, [HIT, a_at(HIT)], A),
        stroke(EYE, start, &format!("{P} stroke-dasharray=\"3 4\"")),
        stroke(start, [meets, p_at(meets)], P),
        stroke(start, hit, THIN),
        dot([meets, p_at(meets)], "#2050a0"),
        dot(EYE, "black"),
        dot(hit, "#b03020"),
        dot(start, "#2050a0"),
        label([EYE[0] - 12.0, EYE[1] - 12.0], "eye", ""),
        label(
            [64.0, a_at(150.0) + 34.0],
            "ray a, step k − n",
            "fill=\"#b03020\"",
        ),
        label(
            [HIT + 10.0, p_at(HIT) - 8.0],
            "ray p, step k, begins at a’s t",
            "fill=\"#2050a0\"",
        ),
        label([EYE[0], 24.0], "From the side", "font-weight=\"bold\""),
        label([120.0, SIZE[1] - 42.0], "ground that a has passed", ""),
    ]
    .concat()
}

fn from_behind() -> String {
    let left = PART + 90.0;
    let right = PART + 310.0;
    let (ground_a, above) = (225.0, 22.0);
    // The steepest that the ground may rise from a's to p's, and how it does rise.
    let rise = 95.0;
    let bound = |x: f64| ground_a - rise * (x - left) / (right - left);
    let foot = [PART + 30.0, PART + 400.0];
    let places = (0..=74).map(|k| {
        let x = foot[0] + (foot[1] - foot[0]) * f64::from(k) / 74.0;
        let share = (x - left) / (right - left);
        let wave = 14.0 * (std::f64::consts::TAU * share).sin();
        [x, ground_a - 0.55 * rise * share + wave]
    });
    let a = [left, ground_a - above];
    let p = [right, bound(right) - above - 26.0];
    let limit = [right, a[1] - rise];
    [
        filled(FOOT, places, foot, EARTH),
        stroke([left, ground_a], [right, bound(right)], THIN),
        stroke(a, limit, &format!("{A} stroke-dasharray=\"3 4\"")),
        stroke(a, [left, ground_a], "stroke=\"#b03020\""),
        stroke([right, 70.0], [right, 262.0], THIN),
        stroke([left, 265.0], [right, 265.0], "stroke=\"black\""),
        dot(a, "#b03020"),
        dot(p, "#2050a0"),
        label([a[0] - 22.0, a[1] - 6.0], "a", "fill=\"#b03020\""),
        label([p[0] + 10.0, p[1] + 2.0], "p", "fill=\"#2050a0\""),
        label([left + 62.0, 282.0], "|Δadvance| · t cells", ""),
        label(
            [left - 40.0, 110.0],
            "a, and L metres a cell up",
            "fill=\"#b03020\"",
        ),
        label([right + 8.0, bound(right) + 12.0], "steepest ground", ""),
        label(
            [PART + 40.0, 24.0],
            "From behind, both rays at one t",
            "font-weight=\"bold\"",
        ),
    ]
    .concat()
}
