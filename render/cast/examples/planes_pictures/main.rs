//! Draws the pictures of `docs/planes.md` into a folder.
//!
//! ```text
//! cargo run --release -p sandtable-cast --example planes_pictures -- docs/planes
//! ```

mod drawing;
mod roofs;
mod side_view;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{Rgb, RgbImage};
use sandtable_cast::{Scene, Survey, standpoints};
use sandtable_terrain::{TerrainSource, open};
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

/// The views, in reading order: upright, rolled, straight down, an eye at the table.
const VIEWS: [&str; 4] = ["horizon", "rolled", "down", "table"];

/// One in so many of a view's pixels is shown along each side.
const THIN: u32 = 4;

/// Pixels between panels.
const GAP: u32 = 4;

/// Colours from few to many looks, each for twice as many as the one before: 1, 2, 3 to 4, and so
/// on; black for none.
const HEAT: [[u8; 3]; 9] = [
    [10, 10, 30],
    [30, 20, 80],
    [72, 20, 110],
    [125, 35, 105],
    [180, 55, 80],
    [220, 90, 50],
    [245, 140, 30],
    [250, 195, 60],
    [255, 245, 180],
];

/// Colours of 1 to 7 steps back.
const STEPS: [[u8; 3]; 7] = [
    [214, 230, 244],
    [140, 190, 222],
    [70, 140, 195],
    [20, 90, 160],
    [110, 170, 80],
    [230, 190, 60],
    [225, 120, 40],
];
const NONE: [u8; 3] = [190, 20, 40];
const SKY: [u8; 3] = [235, 235, 235];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os()
        .nth(1)
        .ok_or("say into which folder: docs/planes")?;
    let folder = PathBuf::from(folder);
    std::fs::create_dir_all(&folder)?;
    let ridges = TerrainSource::Ridges {
        size: 1025,
        seed: 0,
    };
    let scene = Scene::new(open(&ridges, None)?.ground);
    let mut surveys = Vec::new();
    let standpoints = standpoints::mixed(&scene.ground);
    for name in VIEWS {
        let at = standpoints.iter().find(|at| at.name == name);
        let view = at.ok_or("a view of that name")?.view;
        surveys.push(Survey::of(&scene, &view).ok_or("a view from the air")?);
    }
    for (name, colour) in [
        ("sectors", sector as fn(&Survey, usize) -> [u8; 3]),
        ("looks", looks),
        ("begins", begins),
    ] {
        let file = File::create(folder.join(name).with_extension("png"))?;
        // Few colours side by side pack best as they are.
        let encoder = PngEncoder::new_with_quality(
            BufWriter::new(file),
            CompressionType::Best,
            FilterType::NoFilter,
        );
        panels(&surveys, colour).write_with_encoder(encoder)?;
    }
    std::fs::write(folder.join("coherence.svg"), side_view::drawing())?;
    std::fs::write(folder.join("roofs.svg"), roofs::drawing())?;
    for (name, survey) in VIEWS.iter().zip(&surveys) {
        print_shares(name, survey);
    }
    Ok(())
}

/// All views in two rows, each pixel in its colour.
fn panels(surveys: &[Survey], colour: impl Fn(&Survey, usize) -> [u8; 3]) -> RgbImage {
    let size = |survey: &Survey| survey.image.view.size.map(|pixels| pixels / THIN);
    let panel = surveys.iter().map(size).fold([0, 0], |largest, size| {
        [largest[0].max(size[0]), largest[1].max(size[1])]
    });
    let [width, height] = panel.map(|pixels| 2 * pixels + GAP);
    let mut picture = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    for (number, survey) in (0..).zip(surveys) {
        let [left, top] = [number % 2 * (panel[0] + GAP), number / 2 * (panel[1] + GAP)];
        let [width, height] = size(survey);
        for (i, j) in (0..height).flat_map(|j| (0..width).map(move |i| (i, j))) {
            let [i_there, j_there] = [i, j].map(|at| THIN * at + THIN / 2);
            let pixel = (j_there * survey.image.width() + i_there) as usize;
            picture.put_pixel(left + i, top + j, Rgb(colour(survey, pixel)));
        }
    }
    picture
}

/// A sector's tint, as bright as the pixel, in few levels: the picture stays small.
fn sector(survey: &Survey, pixel: usize) -> [u8; 3] {
    let [r, g, b, _] = survey.image.colour()[pixel].map(f32::from);
    let bright = (0.3 * r + 0.6 * g + 0.1 * b) / 255.0;
    let bright = 0.55 + 0.45 * (bright * 6.0).round() / 6.0;
    // Hues of neighbouring numbers lie far apart: the golden ratio.
    let hue = (survey.sectors[pixel] as f32 * 0.618_034).fract();
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|shift| {
        let wave = (std::f32::consts::TAU * (hue + shift)).cos();
        (255.0 * bright * (0.7 + 0.3 * wave)) as u8
    })
}

/// The heat of a pixel's looks.
fn looks(survey: &Survey, pixel: usize) -> [u8; 3] {
    match survey.looks[pixel] {
        0 => [0; 3],
        looks => HEAT[(looks.next_power_of_two().ilog2() as usize).min(HEAT.len() - 1)],
    }
}

/// How many steps back a pixel's ray begins; rays that meet no ground have a colour of their own.
fn begins(survey: &Survey, pixel: usize) -> [u8; 3] {
    match survey.begins[pixel] as usize {
        _ if survey.looks[pixel] == 0 => SKY,
        0 => NONE,
        steps => STEPS[steps - 1],
    }
}

/// What the pictures show, in numbers over the rays that are led anywhere.
fn print_shares(name: &str, survey: &Survey) {
    let led = survey.looks.iter().zip(&survey.begins);
    let led: Vec<_> = led.filter(|&(&looks, _)| looks > 0).collect();
    let share = |steps: u32| {
        let count = led.iter().filter(|&&(_, &begins)| begins == steps).count();
        100.0 * count as f64 / led.len() as f64
    };
    let back: u64 = led.iter().map(|&(_, &begins)| u64::from(begins)).sum();
    let looks: u64 = led.iter().map(|&(&looks, _)| u64::from(looks)).sum();
    let most = led.iter().map(|&(&looks, _)| looks).max().unwrap_or(0);
    let sectors = survey.sectors.iter().max().map_or(0, |last| last + 1);
    println!(
        "{name}: {sectors} sectors; {:.1} looks a ray, {most} at most; {:.1} steps back on \
         average: 1 {:.1} %, 2 {:.1} %, 3 to 7 {:.1} %, none {:.1} %",
        looks as f64 / led.len() as f64,
        back as f64
            / led
                .iter()
                .filter(|&&(_, &begins)| begins > 0)
                .count()
                .max(1) as f64,
        share(1),
        share(2),
        (3..8).map(share).sum::<f64>(),
        share(0)
    );
}
