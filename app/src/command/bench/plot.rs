//! The speeds as a chart: a panel a view, a row a caster, a mark for each number of threads and
//! scheme.

use super::figures::Figures;
use anyhow::{Result, anyhow};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Pixels from the left edge to the panels, for the casters' names.
const NAMES: i32 = 300;
/// Pixels from the right edge to the panels.
const MARGIN: i32 = 40;
/// Pixels above the legend: title and subtitle.
const HEAD: u32 = 68;
/// Pixels of a row of the legend, and how many marks it explains.
const LEGEND: u32 = 22;
const LEGEND_ACROSS: usize = 4;
/// Pixels of a panel above and below its rows: the view's name and the axis.
const PANEL: u32 = 62;
/// Pixels between marks of one caster.
const MARK: u32 = 14;
/// Pixels between casters.
const GAP: u32 = 8;
const WIDTH: u32 = 960;
/// Where the fastest is so many times as fast as the slowest, the axis is logarithmic.
const WIDE: f64 = 12.0;
const INK: RGBColor = RGBColor(38, 43, 51);
const PALE: RGBColor = RGBColor(222, 226, 231);
const GREY: RGBColor = RGBColor(110, 118, 129);
/// Okabe and Ito's colours, which people with any colour vision tell apart.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// Draws the median speeds in Mpix/s, each with a line from what 5 % to what 95 % of the frames
/// reached, as an SVG image. `threads` are those of the machine.
pub(super) fn svg(terrain: &str, threads: usize, lines: &[Figures]) -> Result<String> {
    let mut text = String::new();
    draw(&mut text, terrain, threads, lines).map_err(|error| anyhow!("cannot draw: {error}"))?;
    Ok(text)
}

type Drawn<T = ()> = Result<T, Box<dyn std::error::Error>>;

fn draw(text: &mut String, terrain: &str, threads: usize, lines: &[Figures]) -> Drawn {
    let views = distinct(lines, |line| line.view.as_str());
    let casters = distinct(lines, |line| line.caster.as_str());
    let series = distinct(lines, |line| (line.threads, line.scheme));
    let axis = Axis::over(lines);
    let row = MARK * series.len() as u32 + GAP;
    let panel = row * casters.len() as u32 + PANEL;
    let head = HEAD + LEGEND * series.len().div_ceil(LEGEND_ACROSS) as u32 + 8;
    let size = (WIDTH, head + panel * views.len() as u32 + 8);
    let root = SVGBackend::with_string(text, size).into_drawing_area();
    root.fill(&WHITE)?;
    let (head, rest) = root.split_vertically(head);
    draw_head(&head, terrain, threads, &axis, &series)?;
    for (place, view) in views.iter().enumerate() {
        let top = (panel * place as u32) as i32;
        let area = rest.clone().shrink((0, top), (WIDTH, panel));
        let of_view: Vec<_> = lines.iter().filter(|line| line.view == *view).collect();
        draw_panel(&area, view, &casters, &series, &axis, &of_view)?;
    }
    root.present()?;
    Ok(())
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw_head(
    area: &Area<'_>,
    terrain: &str,
    threads: usize,
    axis: &Axis,
    series: &[(usize, &str)],
) -> Drawn {
    let font = |size: u32| ("sans-serif", size).into_font();
    area.draw_text(
        &format!("Casting {terrain}"),
        &font(22).color(&INK),
        (16, 14),
    )?;
    area.draw_text(
        &format!(
            "Mpix/s{}: median, and 5th to 95th percentile of the frames; a machine with {threads} \
             threads",
            if axis.logarithmic {
                " (logarithmic)"
            } else {
                ""
            }
        ),
        &font(13).color(&GREY),
        (16, 44),
    )?;
    for (place, (threads, scheme)) in series.iter().enumerate() {
        let (column, row) = (place % LEGEND_ACROSS, place / LEGEND_ACROSS);
        let x = 22 + (WIDTH as usize / LEGEND_ACROSS * column) as i32;
        let y = HEAD as i32 + LEGEND as i32 * row as i32;
        let colour = COLOURS[place % COLOURS.len()];
        let plural = if *threads == 1 { "" } else { "s" };
        let label = format!("{threads} thread{plural}, {scheme}");
        area.draw(&Circle::new((x, y + 4), 4, colour.filled()))?;
        area.draw_text(&label, &font(13).color(&INK), (x + 12, y))?;
    }
    Ok(())
}

fn draw_panel(
    area: &Area<'_>,
    view: &str,
    casters: &[&str],
    series: &[(usize, &str)],
    axis: &Axis,
    lines: &[&Figures],
) -> Drawn {
    let font = |size: u32| ("sans-serif", size).into_font();
    area.draw_text(view, &font(15).color(&INK), (16, 10))?;
    let marks = (casters.len() as f64) * (f64::from(MARK) * series.len() as f64 + f64::from(GAP));
    let mut chart = ChartBuilder::on(area)
        .margin_top(32)
        .margin_bottom(PANEL - 32)
        .margin_left(NAMES)
        .margin_right(MARGIN)
        .build_cartesian_2d(axis.range[0]..axis.range[1], marks..0.0)?;
    let base = area.get_base_pixel();
    let plane = chart.plotting_area().clone();
    // A place in the plane, in the panel's own pixels.
    let pixel = |place: f64, down: f64| {
        let (x, y) = plane.map_coordinate(&(place, down));
        (x - base.0, y - base.1)
    };
    for &tick in &axis.ticks {
        chart.draw_series([PathElement::new(vec![(tick, 0.0), (tick, marks)], PALE)])?;
        let style = font(12).color(&GREY).pos(Pos::new(HPos::Center, VPos::Top));
        let (x, y) = pixel(tick, marks);
        area.draw_text(&axis.label(tick), &style, (x, y + 5))?;
    }
    let group = f64::from(MARK) * series.len() as f64 + f64::from(GAP);
    for (row, caster) in casters.iter().enumerate() {
        let top = row as f64 * group;
        let across = vec![(axis.range[0], top), (axis.range[1], top)];
        chart.draw_series([PathElement::new(across, PALE)])?;
        let (left, middle) = pixel(axis.range[0], top + 0.5 * group);
        let style = font(12)
            .color(&INK)
            .pos(Pos::new(HPos::Right, VPos::Center));
        area.draw_text(&fitted(caster, 44), &style, (left - 10, middle))?;
        for (place, (threads, scheme)) in series.iter().enumerate() {
            let is_it = |line: &&&Figures| {
                line.caster == *caster && line.threads == *threads && line.scheme == *scheme
            };
            let Some(line) = lines.iter().find(is_it) else {
                continue;
            };
            let y = top + 0.5 * f64::from(GAP) + f64::from(MARK) * (place as f64 + 0.5);
            let colour = COLOURS[place % COLOURS.len()];
            let speed = |time: Option<f64>| time.map(|ms| line.pixels as f64 / ms / 1e3);
            let speeds = [line.p95_ms, line.median_ms, line.p5_ms].map(speed);
            if let [Some(low), Some(middle), Some(high)] = speeds.map(|it| it.map(|it| axis.at(it)))
            {
                let whisker = vec![(low, y), (high, y)];
                chart.draw_series([PathElement::new(whisker, colour.stroke_width(2))])?;
                chart.draw_series([Circle::new((middle, y), 4, colour.filled())])?;
            } else if place == 0 {
                let style = font(12)
                    .color(&GREY)
                    .pos(Pos::new(HPos::Left, VPos::Center));
                let reason = line.refused.as_deref().unwrap_or("not timed");
                area.draw_text(
                    &fitted(&format!("refused: {reason}"), 96),
                    &style,
                    (left + 8, middle),
                )?;
            }
        }
    }
    Ok(())
}

/// The axis of speeds, the same in all panels.
struct Axis {
    logarithmic: bool,
    /// Where it begins and ends, in its own measure.
    range: [f64; 2],
    /// Where its labels stand, in its own measure.
    ticks: Vec<f64>,
}

impl Axis {
    fn over(lines: &[Figures]) -> Self {
        let speeds = lines
            .iter()
            .flat_map(|line| [line.p5_ms, line.p95_ms].map(|time| (line.pixels, time)))
            .filter_map(|(pixels, time)| time.map(|ms| pixels as f64 / ms / 1e3));
        let (low, high) = speeds.fold((f64::INFINITY, 0.0_f64), |(low, high), speed| {
            (low.min(speed), high.max(speed))
        });
        // Nothing was timed, or no pixel was: any axis will do.
        let (low, high) = if low > 0.0 && high.is_finite() && high > 0.0 {
            (low, high)
        } else {
            (0.5, 1.0)
        };
        let logarithmic = high / low > WIDE;
        if logarithmic {
            let range = [(0.8 * low).log10(), (1.25 * high).log10()];
            let decades = range[0].floor() as i32..=range[1].ceil() as i32;
            let ticks = decades
                .flat_map(|decade| {
                    [1.0, 2.0, 5.0].map(|step: f64| step.log10() + f64::from(decade))
                })
                .filter(|tick| (range[0]..=range[1]).contains(tick))
                .collect();
            return Self {
                logarithmic,
                range,
                ticks,
            };
        }
        let end = 1.08 * high;
        let decade = 10.0_f64.powf((end / 5.0).log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade);
        let step = steps.into_iter().find(|step| end / step <= 8.0);
        let step = step.unwrap_or(end);
        Self {
            logarithmic,
            range: [0.0, end],
            ticks: (0..=(end / step) as u32)
                .map(|k| f64::from(k) * step)
                .collect(),
        }
    }

    /// Where a speed lies.
    fn at(&self, speed: f64) -> f64 {
        if self.logarithmic {
            speed.log10()
        } else {
            speed
        }
    }

    fn label(&self, place: f64) -> String {
        let speed = if self.logarithmic {
            10.0_f64.powf(place)
        } else {
            place
        };
        // Three digits are more than any tick has.
        let digits = (2 - speed.max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{speed:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    }
}

/// Text of at most `most` letters, cut where there are more.
fn fitted(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

/// The values that lines have, each once, in the order in which they first come.
fn distinct<'a, T: PartialEq>(lines: &'a [Figures], value: impl Fn(&'a Figures) -> T) -> Vec<T> {
    let mut values = Vec::new();
    for line in lines {
        let value = value(line);
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}
