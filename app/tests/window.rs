//! The real window, on a virtual X server: panel, terrain and stereo on a screenshot.

use image::RgbaImage;
use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Long enough for a loaded machine with a software GPU.
const PATIENCE: Duration = Duration::from_secs(60);

/// A child process that does not outlive the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A virtual X server and its display's name, or `None` where none is installed.
fn x_server() -> Option<(Running, String)> {
    let mut server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1280x800x24"])
        .args(["-nolisten", "tcp"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()
        .map(Running)?;
    let mut number = String::new();
    let out = server.0.stdout.take().expect("it is piped");
    BufReader::new(out).read_line(&mut number).ok()?;
    (!number.trim().is_empty()).then(|| (server, format!(":{}", number.trim())))
}

/// What xdotool prints, or `None` where it fails.
fn xdotool(display: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new("xdotool")
        .args(arguments)
        .env("DISPLAY", display)
        .output()
        .ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Tries until there is a value.
fn wait_for<T>(what: &str, mut value: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(value) = value() {
            return value;
        }
        assert!(begin.elapsed() < PATIENCE, "{what} never came");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// The finished screenshot, or `None` while it is being written.
fn screenshot(path: &Path) -> Option<RgbaImage> {
    Some(image::open(path).ok()?.into_rgba8())
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
    let Some((_server, display)) = x_server() else {
        eprintln!("skipped: Xvfb is not installed (Debian: xvfb)");
        return;
    };
    if xdotool(&display, &["version"]).is_none() {
        eprintln!("skipped: xdotool is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let program = Command::new(env!("CARGO_BIN_EXE_sandtable"))
        .args(["fly", "builtin:jacksboro"])
        .current_dir(folder.path())
        .env("DISPLAY", &display)
        .env_remove("WAYLAND_DISPLAY")
        .env("HOME", folder.path())
        .env("XDG_RUNTIME_DIR", folder.path())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut program = Running(program);
    let window = wait_for("the window", || {
        assert!(
            program.0.try_wait().unwrap().is_none(),
            "the program ended before its window opened"
        );
        let found = xdotool(
            &display,
            &["search", "--onlyvisible", "--name", "^sandtable"],
        )?;
        found.lines().next().map(str::to_owned)
    });
    let key = |name: &str| {
        xdotool(&display, &["windowfocus", &window]).expect("the window takes the keyboard");
        xdotool(&display, &["key", name]).expect("xdotool sends keys");
    };
    let mut number = 0;
    let mut shoot_until = |what: &str, good: &dyn Fn(&RgbaImage) -> bool| {
        wait_for(what, || {
            number += 1;
            let path = folder.path().join(format!("sandtable-{number:04}.png"));
            key("F12");
            let image = wait_for("a screenshot", || screenshot(&path));
            good(&image).then_some(image)
        })
    };

    // The first casts may still be under way at the first shots.
    let upper = [0.3, 0.6];
    let with_panel = shoot_until("terrain", &|image| colours(image, [0.0, 1.0], upper) > 300);
    key("Tab");
    let bare = shoot_until("a picture without the panel", &|image| *image != with_panel);
    assert_eq!(with_panel.dimensions(), bare.dimensions());
    let panel_row = |image: &RgbaImage| colours(image, [0.0, 1.0], [0.97, 1.0]);
    assert!(panel_row(&with_panel) < panel_row(&bare), "no panel below");
    let top = |image: &RgbaImage| {
        image
            .rows()
            .take(100)
            .flatten()
            .copied()
            .collect::<Vec<_>>()
    };
    assert_eq!(top(&with_panel), top(&bare), "the panel hides the picture");

    key("2");
    let pair = shoot_until("a stereo pair", &|image| {
        let half = image.width() / 2;
        let rows = image.height() * 3 / 10..image.height() * 6 / 10;
        let differing = rows
            .flat_map(|j| (0..half).map(move |i| (i, j)))
            .filter(|&(i, j)| image.get_pixel(i, j) != image.get_pixel(i + half, j))
            .count();
        *image != bare && differing > 100
    });
    for half in [[0.0, 0.5], [0.5, 1.0]] {
        assert!(colours(&pair, half, upper) > 300, "one eye sees no terrain");
    }

    key("Escape");
    let status = wait_for("the end", || program.0.try_wait().unwrap());
    assert!(status.success(), "{status}");
}
