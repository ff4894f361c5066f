//! The argument of coherence as a drawing.

use std::fmt::Write;

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
    let mut svg = String::new();
    let [width, height] = SIZE;
    let mut line = |text: &str| {
        svg.push_str(text);
        svg.push('\n');
    };
    line(&format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="14">"#
    ));
    line(&format!(
        r#"<rect width="{width}" height="{height}" fill="white"/>"#
    ));
    line(&from_the_side());
    line(&from_behind());
    line("</svg>");
    svg
}

/// An element from one place to another.
fn stroke([x1, y1]: [f64; 2], [x2, y2]: [f64; 2], style: &str) -> String {
    format!("<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {style}/>\n")
}

fn label([x, y]: [f64; 2], text: &str, style: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{text}</text>\n")
}

fn dot([x, y]: [f64; 2], fill: &str) -> String {
    format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{fill}\"/>\n")
}

/// A filled outline from a line's places down to the drawing's foot.
fn filled(places: impl Iterator<Item = [f64; 2]>, [from, to]: [f64; 2], style: &str) -> String {
    let foot = SIZE[1] - 30.0;
    let mut path = format!("<path d=\"M{from:.1} {foot:.1}");
    for [x, y] in places {
        // Writing to a string cannot fail.
        let _ = write!(path, " L{x:.1} {y:.1}");
    }
    path + &format!(" L{to:.1} {foot:.1} Z\" {style}/>\n")
}

const A: &str = "stroke=\"#b03020\" stroke-width=\"2\"";
const P: &str = "stroke=\"#2050a0\" stroke-width=\"2\"";
const THIN: &str = "stroke=\"#555\" stroke-dasharray=\"4 3\"";
const EARTH: &str = "fill=\"#d8c8a8\" stroke=\"#806840\"";

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
        filled(places, [EYE[0], END], EARTH),
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
        filled(places, foot, EARTH),
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
