//! The program under test, its folder, and how it ended.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Longer than any of these runs takes, on a loaded machine too.
const PATIENCE: Duration = Duration::from_secs(60);

/// The program, with no display, in `folder`.
pub(crate) fn sandtable(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sandtable"));
    isolate(&mut command, folder);
    command
}

/// Runs `command` in `folder`, away from this machine's display, home and settings.
pub(crate) fn isolate(command: &mut Command, folder: &Path) {
    command
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("SANDTABLE_LOG")
        .env("HOME", folder)
        .env("XDG_RUNTIME_DIR", folder)
        .stdin(Stdio::null());
}

/// The shared terrain files, or `None`, told, where they are absent.
pub(crate) fn shared_data() -> Option<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    if data.join("expected.json").is_file() {
        return Some(data);
    }
    eprintln!("skipped: there is no ../shared/data beside the repository");
    None
}

/// A temporary folder to run the program in.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// A file in it.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.file(name), bytes).expect("the folder can be written");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The names of what is in it, in order.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(self.path())
            .expect("the folder can be read")
            .map(|entry| entry.expect("an entry").file_name())
            .map(|name| name.to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// Runs `sandtable` with the arguments, which are parted by single spaces, to its end.
    pub(crate) fn run(&self, arguments: &str) -> Ended {
        let mut command = sandtable(self.path());
        command.args(arguments.split(' '));
        Ended::of(&mut command)
    }
}

/// How a run ended.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) status: ExitStatus,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ended {
    /// Runs a command to its end, both outputs kept unless the command says otherwise.
    pub(crate) fn of(command: &mut Command) -> Self {
        let aside = tempfile::tempdir().expect("a temporary folder");
        let [out, err] = ["out", "err"].map(|name| aside.path().join(name));
        let create = |path: &Path| File::create(path).expect("a file for what it says");
        let child = command.stdout(create(&out)).stderr(create(&err)).spawn();
        let status = Running(child.expect("the program starts")).end();
        let text = |path: &Path| std::fs::read_to_string(path).expect("what it says is text");
        Self {
            status,
            out: text(&out),
            err: text(&err),
        }
    }

    /// It must have done what it was asked for.
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert_eq!(self.status.code(), Some(0), "{self:#?}");
        self
    }

    /// It must have failed with `code` and one error that says all of `says`; returns the error.
    #[track_caller]
    pub(crate) fn failed(self, code: i32, says: &[&str]) -> String {
        assert_eq!(self.status.code(), Some(code), "{self:#?}");
        let errors = |line: &&str| line.starts_with("sandtable: ") || line.starts_with("error: ");
        assert_eq!(self.err.lines().filter(errors).count(), 1, "{self:#?}");
        for part in says {
            assert!(self.err.contains(part), "no {part:?} in {self:#?}");
        }
        // A cause that follows an error which has told it already.
        for part in self.err.trim_end().split(": ").skip(1) {
            let twice = part.len() > 20 && self.err.matches(part).count() > 1;
            assert!(!twice, "{part:?} is told twice: {self:#?}");
        }
        assert!(!self.err.contains('\u{1b}'), "colours: {self:#?}");
        self.err
    }
}

/// A child process that does not outlive the test.
pub(crate) struct Running(pub(crate) Child);

impl Running {
    /// Waits for its end.
    pub(crate) fn end(&mut self) -> ExitStatus {
        let id = self.0.id();
        wait_for(&format!("the end of process {id}"), || {
            self.0.try_wait().expect("it can be asked")
        })
    }

    /// Sends it a signal by name, as `TERM`.
    #[cfg(unix)]
    pub(crate) fn signal(&self, name: &str) {
        let kill = format!("kill -{name} {}", self.0.id());
        let done = Command::new("sh").args(["-c", &kill]).status();
        assert!(done.is_ok_and(|status| status.success()), "{kill}");
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Tries until there is a value.
#[track_caller]
pub(crate) fn wait_for<T>(what: &str, mut value: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(value) = value() {
            return value;
        }
        assert!(begin.elapsed() < PATIENCE, "{what} never came");
        std::thread::sleep(Duration::from_millis(5));
    }
}
