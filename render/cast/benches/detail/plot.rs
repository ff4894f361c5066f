//! Quality against time as a chart.

use super::curve::{Curve, FRAME};
use std::fmt::Write;

/// Width and height of the drawing, and the pixels around the plane: left, top, right, bottom.
const SIZE: [f64; 2] = [720.0, 420.0];
const AROUND: [f64; 4] = [56.0, 40.0, 24.0, 48.0];

/// Okabe and Ito's colours, which people with any colour vision tell apart; one a scene.
const COLOURS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000"];

/// An axis: from where to where it goes, in its own measure and in pixels.
struct Axis {
    range: [f64; 2],
    pixels: [f64; 2],
    step: f64,
}

impl Axis {
    /// An axis over all of `values` that ends on whole steps.
    fn over(values: impl Iterator<Item = f64>, pixels: [f64; 2]) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        let (low, high) = if low < high { (low, high) } else { (0.0, 1.0) };
        let step = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
            .into_iter()
            .find(|step| (high - low) / step <= 9.0)
            .unwrap_or(100.0);
        Self {
            range: [(low / step).floor() * step, (high / step).ceil() * step],
            pixels,
            step,
        }
    }

    fn at(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let [from, to] = self.pixels;
        from + (value - low) / (high - low) * (to - from)
    }

    fn ticks(&self) -> impl Iterator<Item = f64> {
        let [low, high] = self.range;
        let steps = ((high - low) / self.step).round() as u32;
        (0..=steps).map(move |k| low + f64::from(k) * self.step)
    }

    fn label(&self, tick: f64) -> String {
        let digits = usize::from(self.step < 1.0);
        format!("{tick:.digits$}")
    }
}

/// Draws a line a scene, with a mark for each `cell`, as an SVG image.
pub(super) fn svg(curves: &[Curve]) -> String {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let [left, top, right, bottom] = AROUND;
    let foot = SIZE[1] - bottom;
    let times = points().map(|point| point.ms).chain([0.0, FRAME]);
    let across = Axis::over(times, [left, SIZE[0] - right]);
    let up = Axis::over(points().map(|point| point.psnr), [foot, top]);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" \
         height=\"{h}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>\n",
        w = SIZE[0],
        h = SIZE[1]
    );
    for tick in across.ticks() {
        let x = across.at(tick);
        svg += &line([x, top], [x, foot], "#dee2e7", "none");
        let below = [x, foot + 18.0];
        svg += &text(below, &across.label(tick), "middle", "#6e7681");
    }
    for tick in up.ticks() {
        let y = up.at(tick);
        svg += &line([left, y], [SIZE[0] - right, y], "#dee2e7", "none");
        let beside = [left - 8.0, y + 4.0];
        svg += &text(beside, &up.label(tick), "end", "#6e7681");
    }
    let frame = across.at(FRAME);
    svg += &line([frame, top], [frame, foot], "#6e7681", "2 3");
    let (ink, middle) = ("#262b33", 0.5 * (left + SIZE[0] - right));
    svg += &text(
        [frame, top - 6.0],
        &format!("{FRAME} ms"),
        "middle",
        "#6e7681",
    );
    svg += &text([8.0, top - 18.0], "PSNR, dB", "start", ink);
    let below = [middle, SIZE[1] - 10.0];
    svg += &text(below, "both eyes on two threads, ms", "middle", ink);
    for (place, curve) in curves.iter().enumerate() {
        let colour = COLOURS[place % COLOURS.len()];
        let at = |ms, psnr| [across.at(ms), up.at(psnr)];
        for pair in curve.points.windows(2) {
            let [from, to] = [0, 1].map(|end| at(pair[end].ms, pair[end].psnr));
            svg += &line(from, to, colour, "none");
        }
        for point in &curve.points {
            let [x, y] = at(point.ms, point.psnr);
            // Writing to a string cannot fail.
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>"
            );
            let beside = [x + 5.0, y + 14.0];
            svg += &text(beside, &point.cell.to_string(), "start", colour);
        }
        let y = foot - 12.0 - 18.0 * (curves.len() - 1 - place) as f64;
        let x = SIZE[0] - right - 150.0;
        svg += &line([x, y - 4.0], [x + 28.0, y - 4.0], colour, "none");
        svg += &text([x + 36.0, y], &curve.scene, "start", ink);
    }
    svg + "</svg>\n"
}

fn line([x1, y1]: [f64; 2], [x2, y2]: [f64; 2], colour: &str, dashes: &str) -> String {
    format!(
        "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{colour}\" \
         stroke-width=\"1.5\" stroke-dasharray=\"{dashes}\"/>\n"
    )
}

fn text([x, y]: [f64; 2], text: &str, anchor: &str, colour: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{text}</text>\n"
    )
}
