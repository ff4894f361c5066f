//! A window on an X server of its own, and what people do to it.

use image::RgbaImage;
use std::cell::Cell;
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
        // Whoever comes after the last one has left must not find it beginning anew.
        .args(["-nolisten", "tcp", "-noreset"])
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
pub(crate) fn wait_for<T>(what: &str, mut value: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(value) = value() {
            return value;
        }
        assert!(begin.elapsed() < PATIENCE, "{what} never came");
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// How the program ends where there is a display and no graphics driver, and what it says; `None`,
/// told, where that cannot be tried here.
pub(crate) fn without_driver() -> Option<(ExitStatus, String)> {
    let Some((_server, display)) = x_server() else {
        eprintln!("skipped: Xvfb is not installed (Debian: xvfb)");
        return None;
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = Command::new(env!("CARGO_BIN_EXE_sandtable"))
        .args(["fly", "builtin:ridges?size=65", "--mute"])
        .current_dir(folder.path())
        .env("DISPLAY", &display)
        .env_remove("WAYLAND_DISPLAY")
        .env("HOME", folder.path())
        .env("XDG_RUNTIME_DIR", folder.path())
        .env("WGPU_BACKEND", "vulkan")
        .env("VK_ICD_FILENAMES", "/there/is/none")
        .env("VK_DRIVER_FILES", "/there/is/none")
        .output()
        .expect("the program is built");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    Some((output.status, said))
}

/// The program with its window on an X server of its own.
pub(crate) struct Session {
    program: Running,
    pub(crate) window: String,
    display: String,
    folder: tempfile::TempDir,
    /// Screenshots taken.
    shots: Cell<u32>,
    _server: Running,
}

impl Session {
    /// Opens the window by `fly` and these arguments, or says why it cannot be tried here.
    pub(crate) fn open(arguments: &[&str]) -> Option<Self> {
        Self::open_noting(arguments, Stdio::inherit())
    }

    /// The same, its notes going to `notes`.
    pub(crate) fn open_noting(arguments: &[&str], notes: Stdio) -> Option<Self> {
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
            .arg("fly")
            .args(arguments)
            .current_dir(folder.path())
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("HOME", folder.path())
            .env("XDG_RUNTIME_DIR", folder.path())
            .stdout(Stdio::null())
            .stderr(notes)
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

    pub(crate) fn xdotool(&self, arguments: &[&str]) {
        let done = xdotool(&self.display, arguments);
        assert!(done.is_some(), "xdotool failed: {arguments:?}");
    }

    pub(crate) fn key(&self, name: &str) {
        self.xdotool(&["windowfocus", &self.window]);
        self.xdotool(&["key", name]);
    }

    /// Takes screenshots until one is good, and returns that.
    pub(crate) fn shoot_until(&self, what: &str, good: impl Fn(&RgbaImage) -> bool) -> RgbaImage {
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

    /// Sends the program a signal by name, as `TERM`, and checks that it ends well.
    pub(crate) fn end_by(self, signal: &str) {
        let kill = format!("kill -{signal} {}", self.program.0.id());
        let done = Command::new("sh").args(["-c", &kill]).status();
        assert!(done.is_ok_and(|status| status.success()), "{kill}");
        self.ends_well(signal);
    }

    /// Has another program destroy the window and checks that the program ends well.
    pub(crate) fn destroy(self) {
        self.xdotool(&["windowclose", &self.window]);
        self.ends_well("the window's destruction");
    }

    /// Closes the window and checks that the program ends well.
    pub(crate) fn close(self) {
        self.key("Escape");
        self.ends_well("Escape");
    }

    fn ends_well(mut self, after: &str) {
        let status = wait_for("the end", || self.program.ended());
        assert!(status.success(), "after {after}: {status}");
    }
}
