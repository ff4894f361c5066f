//! `sandtable simulate`: its path, its link, its end.

use crate::program::{Folder, Running, sandtable};
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::Stdio;

/// A simulated device that runs until it is dropped.
pub(crate) struct Simulated {
    pub(crate) program: Running,
    /// The first line that it printed: its path, or its address.
    pub(crate) path: PathBuf,
}

impl Simulated {
    /// Starts one in `folder`; it is there when this returns.
    pub(crate) fn start(folder: &Folder, device: &str, arguments: &str) -> Self {
        let mut command = sandtable(folder.path());
        command.args(["simulate", device]);
        command.args(arguments.split(' ').filter(|argument| !argument.is_empty()));
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        let mut program = Running(command.spawn().expect("the program starts"));
        let out = program.0.stdout.take().expect("it is piped");
        let mut line = String::new();
        BufReader::new(out).read_line(&mut line).expect("its path");
        let path = PathBuf::from(line.strip_suffix('\n').expect("a whole line"));
        Self { program, path }
    }
}

#[test]
fn its_path_stands_alone_on_the_first_line() {
    let folder = Folder::new();
    let flock = Simulated::start(&folder, "flock", "--birds 1");
    assert!(flock.path.is_absolute(), "{:?}", flock.path);
    let kind = std::fs::metadata(&flock.path).unwrap().file_type();
    use std::os::unix::fs::FileTypeExt;
    assert!(kind.is_char_device(), "no terminal at {:?}", flock.path);
}

#[test]
fn its_link_lasts_as_long_as_it_runs() {
    let folder = Folder::new();
    for signal in ["INT", "TERM", "HUP"] {
        let mut flock = Simulated::start(&folder, "flock", "--link flock");
        assert_eq!(flock.path, PathBuf::from("flock"));
        let target = std::fs::read_link(folder.file("flock")).unwrap();
        assert!(target.exists(), "{target:?}");
        flock.program.signal(signal);
        let status = flock.program.end();
        assert_eq!(status.code(), Some(0), "after {signal}");
        assert_eq!(folder.names(), [""; 0], "after {signal}");
    }
}

#[test]
fn the_link_of_a_killed_one_is_taken_over_and_nothing_else() {
    let folder = Folder::new();
    // As a killed one leaves it: to a terminal that is gone.
    std::os::unix::fs::symlink("/dev/pts/1048576", folder.file("flock")).unwrap();
    let flock = Simulated::start(&folder, "flock", "--link flock");
    assert_eq!(flock.path, PathBuf::from("flock"));

    let refused = folder.run("simulate flock --link flock");
    refused.failed(1, &["flock", "remove it or name another path"]);
    drop(flock);
    folder.write("mine", "");
    let refused = folder.run("simulate flock --link mine");
    refused.failed(1, &["mine", "exists"]);
    assert_eq!(folder.read("mine"), b"");
    let refused = folder.run("simulate flock --link no/such/folder");
    refused.failed(1, &["no/such/folder", "name a path"]);
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    let folder = Folder::new();
    for (arguments, says) in [
        ("flock --motion jump", &["jump", "still", "circle"][..]),
        ("flock --birds 15", &["15", "1..=14"]),
        ("flock --birds 2 --erc 4", &["1 to 3"]),
        ("flock --stall 2", &["AT,FOR"]),
        (
            "flock --birds 1 --hold 1,2,3,4,5,6 --hold 1,2,3,4,5,6",
            &["--birds 2"],
        ),
        ("flock --hold 1,2,3", &["6 numbers"]),
        ("flock --hold 1,2,3,4,5,nan", &["inches and degrees"]),
        ("flock --baud 0", &["115200"]),
        ("flock --baud 14400", &["9600"]),
        ("flock --vrpn --link here", &["--link", "--vrpn"]),
        ("pinch --motion fist", &["fist", "open, pinch, grab, play"]),
        ("pinch --baud 14400", &["9600"]),
        ("pinch --without thumb", &["left", "right"]),
        ("pinch --from a.mcap --motion grab", &["--from", "--motion"]),
        ("glove --motion grab", &["grab", "fist, point, pinch, play"]),
        ("glove --hold 0,0,0,0,1.1", &["0 to 1"]),
        ("glove --hold 0,0,0", &["5 numbers"]),
        ("glove --sensors 16", &["5 or 14"]),
        ("glove --vrpn here", &["--vrpn"]),
    ] {
        let refused = folder.run(&format!("simulate {arguments}"));
        refused.failed(2, says);
    }
}
