//! Outputs that end early: a full disk, a reader that has had enough.

use crate::program::{Ended, Folder, isolate, sandtable};
use std::process::{Command, Stdio};

const VIEW: &str = "size = [400, 300]\neye = [15000.0, -500.0, 3000.0]\n\
                    camera = { pitch = -20.0, horizontal_fov = 60.0 }\n";

/// Runs the program where no file may grow above 8 KiB, as on a disk that fills up.
#[cfg(unix)]
fn on_a_full_disk(folder: &Folder, arguments: &str) -> Ended {
    let program = env!("CARGO_BIN_EXE_sandtable");
    let script = format!("trap '' XFSZ; ulimit -f 16; exec '{program}' {arguments}");
    let mut command = Command::new("sh");
    isolate(&mut command, folder.path());
    Ended::of(command.args(["-c", &script]))
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_one_error_and_what_was_there_stays() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    for name in ["i.png", "i.jpg", "d.tif", "f.avi"] {
        folder.write(name, "an earlier one");
    }
    for (arguments, says) in [
        ("render --view v.toml -o i.png", "i.png"),
        ("render --view v.toml -o i.jpg", "i.jpg"),
        (
            "fly --headless --size 320x240 --seconds 0.2 -o f.avi",
            "f.avi",
        ),
        (
            "fly --headless --size 320x240 --seconds 0.2 -o frames",
            "frames",
        ),
    ] {
        let failed = on_a_full_disk(&folder, arguments);
        failed.failed(1, &["cannot write", says, "too large"]);
    }
    // The image fits where its depth does not.
    folder.write("v.toml", VIEW.replace("[400, 300]", "[60, 40]"));
    let failed = on_a_full_disk(&folder, "render --view v.toml -o i.png --depth d.tif");
    failed.failed(1, &["cannot write", "d.tif", "full"]);
    for name in ["i.jpg", "d.tif", "f.avi"] {
        assert_eq!(folder.read(name), b"an earlier one", "{name}");
    }
    // Nothing half-written lies about either.
    assert_eq!(
        folder.names(),
        ["d.tif", "f.avi", "i.jpg", "i.png", "v.toml"]
    );
}

/// Runs the program where it may have no more than 1.5 GB of memory.
#[cfg(target_os = "linux")]
fn with_little_memory(folder: &Folder, arguments: &str) -> Ended {
    let program = env!("CARGO_BIN_EXE_sandtable");
    let script = format!("ulimit -v 1500000; exec '{program}' {arguments}");
    let mut command = Command::new("sh");
    isolate(&mut command, folder.path());
    Ended::of(command.args(["-c", &script]))
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_there_is_not_is_one_error_with_how_much_and_what_to_make_smaller() {
    let folder = grid_and_view();
    let render = "render --threads 1 --view v.toml -o i.png";
    let failed = with_little_memory(&folder, &format!("{render} 'builtin:ridges?size=16385'"));
    failed.failed(1, &["size=16385", "MiB of memory", "a smaller terrain"]);
    for [width, height] in [[32_768, 32_768], [16_384, 16_384]] {
        let size = format!("[{width}, {height}]");
        folder.write("v.toml", VIEW.replace("[400, 300]", &size));
        let failed = with_little_memory(&folder, &format!("{render} grid.asc"));
        failed.failed(
            1,
            &[&format!("{width} by {height}"), "MiB of memory", "smaller"],
        );
    }
    assert_eq!(folder.names(), ["grid.asc", "v.toml"]);
}

/// What prints figures and paths: a script must hear that they are lost.
const PRINTING: [&str; 5] = [
    "info grid.asc",
    "info grid.asc --json",
    "bench grid.asc --view v.toml --threads 1 --frames 1",
    "bench grid.asc --view v.toml --threads 1 --frames 1 --json",
    "simulate flock",
];

fn grid_and_view() -> Folder {
    let folder = Folder::new();
    let grid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2\n3 4\n";
    folder.write("grid.asc", grid);
    folder.write("v.toml", VIEW.replace("[400, 300]", "[8, 8]"));
    folder
}

#[cfg(target_os = "linux")]
#[test]
fn lost_output_is_an_error() {
    let folder = grid_and_view();
    for arguments in PRINTING {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
        let full = full.expect("Linux has /dev/full");
        let mut command = sandtable(folder.path());
        let child = command
            .args(arguments.split(' '))
            .stdout(full)
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let output = child.wait_with_output().expect("it ends");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments}: {said}");
        assert!(said.contains("No space left"), "{arguments}: {said}");
    }
}

/// A pipe whose reader is gone before anything is written.
fn read_by_nobody() -> std::io::PipeWriter {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer
}

#[test]
fn a_reader_that_has_had_enough_is_no_error() {
    let folder = grid_and_view();
    for arguments in PRINTING {
        let mut command = sandtable(folder.path());
        let output = command
            .args(arguments.split(' '))
            .stdout(read_by_nobody())
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
        assert!(!said.contains("panicked"), "{arguments}: {said}");
    }
    // A flight is written though nobody reads where.
    let mut command = sandtable(folder.path());
    command.args([
        "fly",
        "grid.asc",
        "--size",
        "16x16",
        "--seconds",
        "0.05",
        "-o",
        "f.avi",
    ]);
    let mut child = command
        .stdout(read_by_nobody())
        .spawn()
        .expect("the program starts");
    assert!(child.wait().expect("it ends").success());
    assert!(folder.file("f.avi").is_file());
}
