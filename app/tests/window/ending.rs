//! How the window ends when the system asks for it, or who started the program.

use crate::session::{Session, without_driver};
use std::fs::File;

/// What a whole MCAP file ends with.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Opens a window that records, has `end` end it, and checks that the recording is whole and told of. Gives what the
/// program said; nothing where there can be no window. `how` names the end.
fn leaves_a_whole_recording(how: &str, end: impl FnOnce(Session)) -> Option<String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [notes, recording] = ["notes.txt", "r.mcap"].map(|name| folder.path().join(name));
    let device = format!("flock={}", folder.path().join("none").display());
    let arguments = [
        "builtin:ridges?size=65",
        "--rig",
        "workbench",
        "--device",
        &device,
        "--size",
        "320x200",
        "--mute",
        "--latency",
        "--record",
        recording.to_str().expect("it is UTF-8"),
    ];
    let file = File::create(&notes).expect("it can be written");
    end(Session::open_noting(&arguments, file.into())?);
    let bytes = std::fs::read(&recording).expect("it is there");
    assert!(bytes.ends_with(MAGIC), "after {how} it has no end");
    let said = std::fs::read_to_string(&notes).expect("it is there");
    for part in ["latency: ", "r.mcap: ", " 0 dropped"] {
        assert!(said.contains(part), "no {part:?} after {how}: {said}");
    }
    Some(said)
}

#[test]
fn a_request_to_end_closes_the_window_and_leaves_a_whole_recording() {
    for signal in ["INT", "TERM", "HUP"] {
        leaves_a_whole_recording(signal, |session| session.end_by(signal));
    }
}

#[test]
fn a_window_that_is_destroyed_leaves_a_whole_recording() {
    let said = leaves_a_whole_recording("its destruction", |session| {
        // Until it has drawn something, drivers may not survive that.
        session.shoot_until("a picture", |_| true);
        // Frames are on their way then.
        session.xdotool(&["keydown", "w"]);
        session.destroy();
    });
    let told = said.is_none_or(|said| said.contains("another program has destroyed the window"));
    assert!(told, "nothing tells why the program ended");
}

#[test]
fn without_a_graphics_driver_the_error_comes_before_what_helps() {
    let Some((status, said)) = without_driver() else {
        return;
    };
    assert_eq!(status.code(), Some(1), "{said}");
    let error = said.lines().find(|line| line.starts_with("sandtable: "));
    let error = error.unwrap_or_else(|| panic!("no error in {said}"));
    let [what, helps, instead] =
        ["no graphics", "mesa-vulkan-drivers", "fly --headless"].map(|part| {
            error
                .find(part)
                .unwrap_or_else(|| panic!("no {part:?} in {error}"))
        });
    assert!(what < helps && helps < instead, "{error}");
    assert!(!error.contains("{}"), "{error}");
}
