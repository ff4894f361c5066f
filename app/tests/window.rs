//! The real window, on a virtual X server: panel, terrain and stereo on a screenshot.

use image::RgbaImage;
use std::cell::Cell;
use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Long enough for a loaded machine with a software GPU.
const PATIENCE: Duration = Duration::from_secs(60);

/// A child process that does not outlive the test.
struct Running(Child);

impl Running {
    /// How it ended, once it has.
    fn ended(&mut self) -> Option<ExitStatus> {
        self.0.try_wait().expect("it can be asked")
    }
}

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

/// The program with its window on an X server of its own.
struct Session {
    program: Running,
    window: String,
    display: String,
    folder: tempfile::TempDir,
    /// Screenshots taken.
    shots: Cell<u32>,
    _server: Running,
}

impl Session {
    /// Opens the window, or says why it cannot be tried here.
    fn open() -> Option<Self> {
        let Some((server, display)) = x_server() else {
            eprintln!("skipped: Xvfb is not installed (Debian: xvfb)");
            return None;
        };
        if xdotool(&display, &["version"]).is_none() {
            eprintln!("skipped: xdotool is not installed (Debian: xdotool)");
            return None;
        }
        let folder = tempfile::tempdir().expect("a temporary folder");
        let program = Command::new(env!("CARGO_BIN_EXE_sandtable"))
            .args(["fly", "builtin:jacksboro"])
            .current_dir(folder.path())
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("HOME", folder.path())
            .env("XDG_RUNTIME_DIR", folder.path())
            .stdout(Stdio::null())
            .spawn()
            .expect("the program is built");
        let mut program = Running(program);
        let window = wait_for("the window", || {
            assert!(
                program.ended().is_none(),
                "the program ended before its window opened"
            );
            let search = ["search", "--onlyvisible", "--name", "^sandtable"];
            let found = xdotool(&display, &search)?;
            found.lines().next().map(str::to_owned)
        });
        Some(Self {
            program,
            window,
            display,
            folder,
            shots: Cell::new(0),
            _server: server,
        })
    }

    fn xdotool(&self, arguments: &[&str]) {
        let done = xdotool(&self.display, arguments);
        assert!(done.is_some(), "xdotool failed: {arguments:?}");
    }

    fn key(&self, name: &str) {
        self.xdotool(&["windowfocus", &self.window]);
        self.xdotool(&["key", name]);
    }

    /// Takes screenshots until one is good, and returns that.
    fn shoot_until(&self, what: &str, good: impl Fn(&RgbaImage) -> bool) -> RgbaImage {
        wait_for(what, || {
            self.shots.set(self.shots.get() + 1);
            let name = format!("sandtable-{:04}.png", self.shots.get());
            let path = self.folder.path().join(name);
            self.key("F12");
            // While it is being written it cannot be decoded.
            let image = wait_for("a screenshot", || image::open(&path).ok());
            let image = image.into_rgba8();
            good(&image).then_some(image)
        })
    }

    /// Closes the window and checks that the program ends well.
    fn close(mut self) {
        self.key("Escape");
        let status = wait_for("the end", || self.program.ended());
        assert!(status.success(), "{status}");
    }
}

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
    let Some(session) = Session::open() else {
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
    let Some(session) = Session::open() else {
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
