//! The real window, on a virtual X server.

mod calibration;
mod ending;
mod hands;
mod latency;
mod session;

use image::RgbaImage;
use session::Session;
use std::collections::HashSet;

/// Rows of the picture that show terrain, whatever lies above and below.
const TERRAIN_ROWS: [f64; 2] = [0.3, 0.6];

fn shows_terrain(image: &RgbaImage) -> bool {
    colours(image, [0.0, 1.0], TERRAIN_ROWS) > 300
}

/// How many colours a part of the image has, on every fourth pixel.
fn colours(image: &RgbaImage, columns: [f64; 2], rows: [f64; 2]) -> usize {
    let span = |share: [f64; 2], side: u32| share.map(|share| (share * f64::from(side)) as u32);
    let ([left, right], [top, bottom]) = (span(columns, image.width()), span(rows, image.height()));
    (top..bottom)
        .step_by(4)
        .flat_map(|j| (left..right).step_by(4).map(move |i| (i, j)))
        .map(|(i, j)| image.get_pixel(i, j).0)
        .collect::<HashSet<_>>()
        .len()
}

#[test]
fn a_screenshot_shows_terrain_and_panel_and_stereo_halves() {
    let Some(session) = Session::open(&["builtin:jacksboro"]) else {
        return;
    };
    // The first casts may still be under way at the first shots.
    let with_panel = session.shoot_until("terrain", shows_terrain);
    session.key("Tab");
    let bare = session.shoot_until("a picture without the panel", |image| *image != with_panel);
    assert_eq!(with_panel.dimensions(), bare.dimensions());
    let bottom = |image: &RgbaImage| colours(image, [0.0, 1.0], [0.97, 1.0]);
    assert!(bottom(&with_panel) < bottom(&bare), "no panel below");
    let top = |image: &RgbaImage| {
        let rows = image.rows().take(100);
        rows.flatten().copied().collect::<Vec<_>>()
    };
    assert_eq!(top(&with_panel), top(&bare), "the panel hides the picture");

    session.key("2");
    let pair = session.shoot_until("a stereo pair", |image| {
        let half = image.width() / 2;
        let rows = image.height() * 3 / 10..image.height() * 6 / 10;
        let differing = rows
            .flat_map(|j| (0..half).map(move |i| (i, j)))
            .filter(|&(i, j)| image.get_pixel(i, j) != image.get_pixel(i + half, j))
            .count();
        *image != bare && differing > 100
    });
    for half in [[0.0, 0.5], [0.5, 1.0]] {
        let seen = colours(&pair, half, TERRAIN_ROWS);
        assert!(seen > 300, "one eye sees no terrain");
    }
    session.close();
}

#[test]
fn resizes_and_being_unmapped_are_survived() {
    let Some(session) = Session::open(&["builtin:jacksboro"]) else {
        return;
    };
    session.shoot_until("terrain", shows_terrain);
    let window = session.window.clone();
    for step in 0..30 {
        let width = (300 + step * 137 % 700).to_string();
        let height = (200 + step * 253 % 500).to_string();
        session.xdotool(&["windowsize", &window, &width, &height]);
    }
    session.xdotool(&["windowunmap", "--sync", &window]);
    session.xdotool(&["windowmap", "--sync", &window]);
    session.xdotool(&["windowsize", &window, "905", "603"]);
    session.shoot_until("terrain at the new size", |image| {
        image.dimensions() == (905, 603) && shows_terrain(image)
    });
    session.close();
}
