//! `sandtable record` of a simulated Flock, and `sandtable fly --replay` of what it recorded.

use crate::program::Folder;

/// A small table whose Flock starts as quickly as its manual allows.
const RIG: &str = r#"
name = "a small table"
[table]
lower_left = [-0.90, -0.55, 0.0]
lower_right = [0.90, -0.55, 0.0]
upper_left = [-0.90, 0.55, 0.0]
pixels = [60, 36]
[stereo]
mode = "side-by-side"
[head]
sensor = "flock/1"
rest = { position = [0.0, -0.75, 0.60], axes = ["+y", "+x", "-z"] }
eyes = { middle = [0.04, 0.0, 0.03], rightwards = [0.0, 1.0, 0.0], interpupillary = 0.063 }
[devices.flock]
kind = "flock-of-birds"
port = "/dev/there-is-no-such-port"
birds = 1
range = 72
hemisphere = "upper"
silence_before = 0.6
silence_after = 0.6
table_from_tracker = { translation = [0.0, 0.0, -0.30], axes = ["+y", "+x", "-z"] }
"#;

#[cfg(unix)]
mod of_a_flock {
    use super::RIG;
    use crate::formats::avi;
    use crate::program::{Folder, Running, sandtable, wait_for};
    use crate::simulate::Simulated;
    use std::fs::File;
    use std::time::Duration;

    /// Records a second and a half of a moving head to whole.mcap; gives what was said.
    fn record(folder: &Folder, rig: &str, terrain: &str) -> String {
        folder.write("rig.toml", rig);
        let _flock = Simulated::start(folder, "flock", "--birds 1 --motion sway-right --link bird");
        let mut command = sandtable(folder.path());
        command.args(["record", terrain, "--rig", "rig.toml"]);
        command.args("--device flock=bird -o whole.mcap".split(' '));
        command.stderr(File::create(folder.file("said")).expect("a file"));
        let mut recorder = Running(command.spawn().expect("the program starts"));
        let said = || String::from_utf8_lossy(&folder.read("said")).into_owned();
        wait_for("the stream", || {
            let ended = recorder.0.try_wait().expect("it can be asked");
            assert!(ended.is_none(), "{}", said());
            said().contains("flock: streaming").then_some(())
        });
        // The length of what is recorded, not a wait for something.
        std::thread::sleep(Duration::from_millis(1500));
        recorder.signal("INT");
        assert_eq!(recorder.end().code(), Some(0), "{}", said());
        let said = said();
        assert!(
            said.contains("whole.mcap") && said.contains(" 0 dropped"),
            "{said}"
        );
        said
    }

    #[test]
    fn a_recording_replays_the_same_twice_and_a_torn_one_up_to_the_cut() {
        let folder = Folder::new();
        record(&folder, RIG, "builtin:ridges?size=65");
        let replay = |name: &str| {
            let arguments = format!("fly --replay {name}.mcap --headless -o {name}.avi");
            let ended = folder.run(&arguments).done();
            (ended, folder.read(&format!("{name}.avi")))
        };
        let (told, bytes) = replay("whole");
        assert!(
            told.out.contains("ridges"),
            "the recorded terrain: {told:?}"
        );
        assert!(!told.err.contains("torn"), "{told:?}");
        let whole = avi(&bytes);
        assert_eq!((whole.size, whole.frames_per_second), ([120, 36], 60));
        // Its start, which takes 1.2 s of silence at least, and the second and a half.
        assert!(whole.frames > 160, "{} frames", whole.frames);
        assert_eq!(whole.pictures.len(), whole.frames as usize);
        let last = &whole.pictures[whole.pictures.len() - 1];
        assert_ne!(&whole.pictures[0], last, "the recorded head moves nothing");
        assert!(
            replay("whole").1 == bytes,
            "another film from the same recording"
        );

        // Twice as fast, each frame shows what every other one did.
        let fast = "fly --replay whole.mcap --headless --replay-speed 2 --once -o fast.avi";
        folder.run(fast).done();
        let fast = avi(&folder.read("fast.avi"));
        assert_eq!(fast.frames, whole.frames.div_ceil(2));
        for (frame, picture) in fast.pictures.iter().enumerate() {
            assert!(*picture == whole.pictures[2 * frame], "frame {frame}");
        }

        let recording = folder.read("whole.mcap");
        folder.write("torn.mcap", &recording[..recording.len() * 7 / 10]);
        let (told, bytes) = replay("torn");
        for part in ["torn.mcap", "torn: it breaks off", "byte", "up to there"] {
            assert!(told.err.contains(part), "no {part:?} in {told:?}");
        }
        let torn = avi(&bytes);
        assert!(torn.frames < whole.frames, "{} frames", torn.frames);
        assert!(torn.pictures.len() > whole.pictures.len() / 4);
        let same = torn
            .pictures
            .iter()
            .zip(&whole.pictures)
            .take_while(|(t, w)| t == w);
        assert_eq!(same.count(), torn.pictures.len());
    }

    #[test]
    fn each_device_that_told_nothing_is_named_at_the_end() {
        let folder = Folder::new();
        let port = std::net::UdpSocket::bind("127.0.0.1:0")
            .and_then(|socket| socket.local_addr())
            .expect("a port")
            .port();
        let silent = format!(
            "[devices.art]\nkind = 'dtrack'\nport = {port}\n\
             table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}\n"
        );
        let said = record(&folder, &format!("{RIG}{silent}"), "builtin:ridges?size=65");
        assert!(said.contains("art: no pose was recorded"), "{said}");
        assert!(said.contains("doctor --rig rig.toml"), "{said}");
        assert!(!said.contains("flock: no pose"), "{said}");
    }

    /// A small ESRI grid whose middle post is `middle` metres high.
    fn grid(middle: u32) -> String {
        let rows = format!("0 10 20\n5 {middle} 25\n10 20 30\n");
        format!("ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 30\n{rows}")
    }

    #[test]
    fn a_replay_says_where_its_ground_is_gone_changed_or_another() {
        let folder = Folder::new();
        folder.write("g.asc", grid(15));
        record(&folder, RIG, "g.asc");
        let replay = |terrain: &str, recording: &str| {
            let arguments = format!("--replay {recording} --headless --replay-speed 60 -o f.avi");
            folder.run(&format!("fly {terrain}{arguments}"))
        };
        let said = replay("", "whole.mcap").done().err;
        assert!(!said.contains("recorded over"), "{said}");
        folder.write("same.asc", grid(15));
        let said = replay("same.asc ", "whole.mcap").done().err;
        assert!(!said.contains("recorded over"), "{said}");

        folder.write("other.asc", grid(300));
        let said = replay("other.asc ", "whole.mcap").done().err;
        let told = "whole.mcap was recorded over g.asc (3 x 3 posts";
        assert!(
            said.contains(told) && said.contains("over other.asc"),
            "{said}"
        );
        folder.write("g.asc", grid(16));
        let said = replay("", "whole.mcap").done().err;
        assert!(
            said.contains("g.asc has changed since whole.mcap"),
            "{said}"
        );
        assert!(said.contains("other heights"), "{said}");

        std::fs::remove_file(folder.file("g.asc")).expect("it is there");
        let remedy = "sandtable fly TERRAIN --replay whole.mcap";
        replay("", "whole.mcap").failed(1, &["g.asc", "whole.mcap was recorded over", remedy]);
    }
}

#[test]
fn an_existing_recording_is_never_overwritten() {
    let folder = Folder::new();
    folder.write("rig.toml", RIG);
    folder.write("mine.mcap", "precious");
    let refused = folder.run("record --rig rig.toml --seconds 1 -o mine.mcap");
    refused.failed(1, &["mine.mcap", "never overwritten"]);
    assert_eq!(folder.read("mine.mcap"), b"precious");
}

#[test]
fn a_missing_port_is_told_once_with_the_remedy() {
    let folder = Folder::new();
    folder.write("rig.toml", RIG);
    let arguments = "record --rig rig.toml --device flock=./none --seconds 0.5 -o a.mcap";
    let said = folder.run(arguments).failed(1, &["holds nothing of flock"]);
    let port = folder.file("none").display().to_string();
    assert_eq!(said.matches(&port).count(), 1, "{said}");
    assert!(said.contains("plug the device in"), "{said}");
}

#[test]
fn what_cannot_be_recorded_is_refused() {
    let folder = Folder::new();
    folder.write("rig.toml", RIG);
    for (arguments, code, says) in [
        ("--rig desktop -o a.mcap", 1, "no devices"),
        ("--rig rig.toml --seconds 0 -o a.mcap", 2, "above 0"),
        ("--rig rig.toml --seconds 1e300 -o a.mcap", 2, "at most"),
        (
            "--rig rig.toml --seconds 1 -o no/such/a.mcap",
            1,
            "no/such/a.mcap",
        ),
        ("--rig rig.toml", 2, "--output"),
    ] {
        let refused = folder.run(&format!("record {arguments}"));
        refused.failed(code, &[says]);
    }
    assert_eq!(folder.names(), ["rig.toml"]);
}
