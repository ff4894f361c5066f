//! Simulated gloves, read by the real drivers of `sandtable record` and `sandtable doctor`.

use crate::program::{Folder, Running, sandtable, wait_for};
use crate::simulate::Simulated;
use sandtable_input::pinch::ContactGroups;
use sandtable_input::{Fingers, Replay, Sample};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

/// A desk with PINCH gloves at the link `pinch`, without the long pauses of a real box.
fn pinch_rig(folder: &Folder) -> String {
    let port = folder.file("pinch");
    format!(
        "name = 'gloves'\n[camera]\n[devices.pinch]\nkind = 'pinch'\nport = '{}'\n\
         byte_pause = 0.002\n",
        port.display()
    )
}

const NONE: Fingers = Fingers(0);

/// Records a rig's devices while `act` does something, from when `device` streams on.
fn record(folder: &Folder, rig: &str, device: &str, file: &str, act: impl FnOnce()) {
    folder.write("rig.toml", rig);
    let mut command = sandtable(folder.path());
    let record = format!("record builtin:ridges?size=65 --rig rig.toml -o {file}");
    command.args(record.split(' '));
    command.stderr(File::create(folder.file("said")).expect("a file"));
    let mut recorder = Running(command.spawn().expect("the program starts"));
    let said = || String::from_utf8_lossy(&folder.read("said")).into_owned();
    wait_for("the stream", || {
        let ended = recorder.0.try_wait().expect("it can be asked");
        assert!(ended.is_none(), "{}", said());
        said()
            .contains(&format!("{device}: streaming"))
            .then_some(())
    });
    act();
    recorder.signal("INT");
    assert_eq!(recorder.end().code(), Some(0), "{}", said());
}

/// All samples of a device so far; none while nothing of the recording has reached the disk.
fn samples(folder: &Folder, file: &str, device: &str) -> Vec<Sample> {
    let replay = Replay::open(&folder.file(file));
    replay.map_or(Vec::new(), |replay| replay.samples(device))
}

/// What the PINCH gloves of a recording touched, one state after another, each once.
fn contacts(folder: &Folder, file: &str) -> Vec<ContactGroups> {
    let mut left = None;
    let mut states = Vec::new();
    for sample in samples(folder, file, "pinch") {
        let Sample::Hand(hand) = sample else {
            panic!("{sample:?}");
        };
        let contacts = hand.hand.contacts.expect("nothing was damaged");
        if hand.sensor == 1 {
            left = Some(contacts);
        } else if let Some(left) = left.take() {
            states.push(ContactGroups::of_contacts(&[left, contacts]).expect("groups"));
        }
    }
    states.dedup();
    states
}

/// Simulated PINCH gloves that are told what to touch.
struct Steered {
    program: Running,
    answers: BufReader<std::process::ChildStdout>,
}

impl Steered {
    fn start(folder: &Folder, arguments: &str) -> Self {
        let mut command = sandtable(folder.path());
        command.args(format!("simulate pinch --steer {arguments}").split(' '));
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut program = Running(command.spawn().expect("the program starts"));
        let out = program.0.stdout.take().expect("it is piped");
        let answers = BufReader::new(out);
        Self { program, answers }
    }

    fn answer(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("an answer");
        line
    }

    fn tell(&mut self, line: &str) {
        let orders = self.program.0.stdin.as_mut().expect("it is piped");
        writeln!(orders, "{line}").expect("it listens");
    }
}

#[test]
fn fingers_that_are_joined_arrive_and_can_be_played_again() {
    let folder = Folder::new();
    let mut gloves = Steered::start(&folder, "--link pinch");
    assert_eq!(gloves.answer(), "pinch\n");
    let pair = Fingers::THUMB.with(Fingers::INDEX);
    let orders: [(&str, &[[Fingers; 2]]); 5] = [
        ("L:thumb+index", &[[pair, NONE]]),
        // As contacts tell them, the left hand's group comes first.
        (
            "L:thumb+index, R:thumb+index",
            &[[pair, NONE], [NONE, pair]],
        ),
        ("open", &[]),
        ("L:thumb+index R:little", &[[pair, Fingers::LITTLE]]),
        ("open", &[]),
    ];
    let joined = orders.map(|(_, groups)| ContactGroups::new(groups).expect("groups"));
    let rig = pinch_rig(&folder);
    record(&folder, &rig, "pinch", "a.mcap", || {
        for (number, (line, groups)) in (1..).zip(orders) {
            gloves.tell(line);
            assert_eq!(gloves.answer(), format!("{}\n", groups.len()), "{line}");
            wait_for(line, || {
                (contacts(&folder, "a.mcap").len() == number).then_some(())
            });
        }
        // Nothing is answered to what is none.
        gloves.tell("L:thumb");
        gloves.tell("open");
        assert_eq!(gloves.answer(), "0\n");
    });
    assert_eq!(contacts(&folder, "a.mcap"), joined);
    drop(gloves);

    // Again, and from the beginning once it is over.
    let _played = Simulated::start(&folder, "pinch", "--from a.mcap --link pinch");
    record(&folder, &rig, "pinch", "b.mcap", || {
        wait_for("the beginning again", || {
            (contacts(&folder, "b.mcap").len() > joined.len()).then_some(())
        });
    });
    let played = contacts(&folder, "b.mcap");
    for (played, joined) in played.iter().zip(joined.iter().cycle()) {
        assert_eq!(played, joined);
    }
    let refused = folder.run("simulate pinch --from c.mcap");
    refused.failed(1, &["c.mcap"]);
}

#[test]
fn a_line_that_loses_bytes_lets_go_and_invents_nothing() {
    let folder = Folder::new();
    let damaged = "--motion grab --drop-every 5 --without left --link pinch";
    let _gloves = Simulated::start(&folder, "pinch", damaged);
    // What each hand's thumb touches; `None` for a hand that was let go.
    let thumbs = || -> Vec<(u32, Option<Fingers>)> {
        let thumb = |sample| match sample {
            Sample::Hand(hand) => {
                let contacts = hand.hand.contacts;
                (hand.sensor, contacts.map(|contacts| contacts.own[0]))
            }
            _ => panic!("{sample:?}"),
        };
        let samples = samples(&folder, "a.mcap", "pinch");
        samples.into_iter().map(thumb).collect()
    };
    let grab = THREE.without(Fingers::THUMB);
    let rig = pinch_rig(&folder);
    record(&folder, &rig, "pinch", "a.mcap", || {
        wait_for("a grab, and its end unknown", || {
            let seen = |of| thumbs().contains(&(2, of));
            (seen(Some(grab)) && seen(None)).then_some(())
        });
    });
    for (hand, thumb) in thumbs() {
        let known = if hand == 1 { [NONE; 2] } else { [NONE, grab] };
        assert!(
            thumb.is_none_or(|thumb| known.contains(&thumb)),
            "{thumb:?}"
        );
    }
}

/// What the motion `grab` joins.
const THREE: Fingers = Fingers(0b00111);

/// What `doctor --json` says of the only device of rig.toml.
fn examined(folder: &Folder) -> Value {
    let said = folder.run("doctor --json --rig rig.toml");
    let report: Value = serde_json::from_str(&said.done().out).expect("JSON");
    report["devices"]["found"][0].clone()
}

#[test]
fn the_doctor_tells_how_often_a_gloves_hand_comes() {
    let folder = Folder::new();
    let glove = Simulated::start(&folder, "glove", "--rate 80 --vrpn 127.0.0.1:0");
    folder.write(
        "rig.toml",
        format!(
            "name = 'gloves'\n[camera]\n[devices.glove]\nkind = 'vrpn'\naddress = 'glove@{}'\n\
             fingers = {{ thumb = 0, index = 1, middle = 2, ring = 3, little = 4 }}\n\
             table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}\n",
            glove.path.display()
        ),
    );
    let found = examined(&folder);
    assert_eq!(found["condition"], "streaming", "{found}");
    let sensor = &found["sensors"][0];
    assert_eq!(sensor.get("poses"), None, "{sensor}");
    // A busy machine sends fewer than 80 a second, but what comes is counted in the two seconds or so of
    // listening.
    let rate = sensor["hands"]["rate_hz"].as_f64().expect("a rate");
    let hands = sensor["hands"]["samples"].as_f64().expect("a count");
    assert!((hands / 3.0..90.0).contains(&rate), "{sensor}");
    assert!(hands > 10.0, "{sensor}");
    assert!(sensor["hands"]["jitter_ms"].as_f64().is_some(), "{sensor}");

    let _pinch = Simulated::start(&folder, "pinch", "--link pinch");
    folder.write("rig.toml", pinch_rig(&folder));
    let found = examined(&folder);
    assert_eq!(found["condition"], "streaming", "{found}");
    for hand in 0..2 {
        let sensor = &found["sensors"][hand];
        // A change each 600 ms, for two seconds.
        let hands = sensor["hands"]["samples"].as_u64().expect("a count");
        assert!((1..=5).contains(&hands), "{sensor}");
        assert_eq!(sensor.get("poses"), None, "{sensor}");
    }
}

#[test]
fn simulated_devices_on_a_line_are_offered_by_vrpn_too() {
    let folder = Folder::new();
    let pinch = Simulated::start(&folder, "pinch", "--motion grab --vrpn 127.0.0.1:0");
    let table = "table_from_tracker = { translation = [0.0, 0.0, 0.0] }";
    let rig = |sender: &str, address: &std::path::Path, lines: &str| {
        let address = address.display();
        format!(
            "name = 'gloves'\n[camera]\n[devices.far]\nkind = 'vrpn'\n\
             address = '{sender}@{address}'\n{lines}\n{table}\n"
        )
    };
    let touching = "touching = { thumb = 0, index = 1, middle = 2, ring = 3, little = 4 }";
    let right = rig("pinch/2", &pinch.path, touching);
    let grab = THREE.without(Fingers::THUMB);
    let thumbs = || -> Vec<Fingers> {
        let thumb = |sample: &Sample| match sample {
            Sample::Hand(hand) => hand.hand.contacts.map(|contacts| contacts.own[0]),
            _ => None,
        };
        let samples = samples(&folder, "a.mcap", "far");
        samples.iter().filter_map(thumb).collect()
    };
    record(&folder, &right, "far", "a.mcap", || {
        wait_for("a grab", || thumbs().contains(&grab).then_some(()));
    });
    // Buttons come one by one, and the thumb's first.
    let known = |fingers: &Fingers| [NONE, Fingers::INDEX, grab].contains(fingers);
    assert!(thumbs().iter().all(known), "{:?}", thumbs());
    drop(pinch);

    let arguments = "--birds 1 --hold 12,3,-5,0,0,0 --vrpn 127.0.0.1:0";
    let flock = Simulated::start(&folder, "flock", arguments);
    let head = rig("flock", &flock.path, "");
    let pose = || {
        let samples = samples(&folder, "b.mcap", "far");
        samples.iter().find_map(Sample::pose).copied()
    };
    record(&folder, &head, "far", "b.mcap", || {
        wait_for("a pose", || pose().map(drop));
    });
    let pose = pose().expect("it was there");
    // In the workbench's frame the transmitter's x points away and its z down.
    let place = pose.table_from_sensor.translation / 0.0254;
    let off = [place.x - 3.0, place.y - 12.0, place.z - 5.0 + 0.3 / 0.0254];
    assert!(off.iter().all(|off| off.abs() < 0.03), "{place}");
}
