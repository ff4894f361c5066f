//! Simulated gloves, read by the real drivers of `sandtable record` and `sandtable doctor`.

use crate::program::{Folder, Running, sandtable, wait_for};
use crate::simulate::Simulated;
use sandtable_input::pinch::ContactGroups;
use sandtable_input::{Fingers, Replay, Sample};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

/// A desk with PINCH gloves at the link `pinch`, without the long pauses of a real box.
const PINCH: &str = "name = 'gloves'\n[camera]\n[devices.pinch]\nkind = 'pinch'\n\
                     port = '/dev/ttyS0'\nbyte_pause = 0.002\n";

const NONE: Fingers = Fingers(0);

/// Records a rig's devices while `act` does something, from when `device` streams on.
fn record(folder: &Folder, rig: &str, device: &str, ports: &str, file: &str, act: impl FnOnce()) {
    folder.write("rig.toml", rig);
    let mut command = sandtable(folder.path());
    let record = format!("record builtin:ridges?size=65 --rig rig.toml -o {file}{ports}");
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

/// What the PINCH gloves of a recording touched, one state after another, each once.
fn contacts(folder: &Folder, file: &str) -> Vec<ContactGroups> {
    let replay = Replay::open(&folder.file(file)).expect("a recording");
    let mut left = None;
    let mut states = Vec::new();
    for sample in replay.samples("pinch") {
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
    let (thumb, index) = (Fingers::THUMB, Fingers::INDEX);
    let pair = thumb.with(index);
    let wanted: [(&str, &[[Fingers; 2]]); 5] = [
        ("L:thumb+index", &[[pair, NONE]]),
        (
            "R:thumb+index, L:thumb+index",
            &[[NONE, pair], [pair, NONE]],
        ),
        ("open", &[]),
        ("L:thumb+index R:little", &[[pair, Fingers::LITTLE]]),
        ("open", &[]),
    ];
    record(
        &folder,
        PINCH,
        "pinch",
        " --device pinch=pinch",
        "a.mcap",
        || {
            for (line, groups) in wanted {
                gloves.tell(line);
                assert_eq!(gloves.answer(), format!("{}\n", groups.len()), "{line}");
                // Longer than a message takes; the recording has to hold each for a while.
                std::thread::sleep(std::time::Duration::from_millis(60));
            }
            // Nothing is answered to what is none.
            gloves.tell("L:thumb");
            gloves.tell("open");
            assert_eq!(gloves.answer(), "0\n");
        },
    );
    let state = |(_, groups): (&str, &[[Fingers; 2]])| {
        // As they are told by contacts: the left hand's fingers first.
        let groups = ContactGroups::new(groups).expect("groups");
        ContactGroups::of_contacts(&groups.contacts()).expect("groups")
    };
    let wanted: Vec<ContactGroups> = wanted.into_iter().map(state).collect();
    assert_eq!(contacts(&folder, "a.mcap"), wanted);
    drop(gloves);

    // Again, and from the beginning once it is over.
    let _played = Simulated::start(&folder, "pinch", "--from a.mcap --link pinch");
    record(
        &folder,
        PINCH,
        "pinch",
        " --device pinch=pinch",
        "b.mcap",
        || {
            std::thread::sleep(std::time::Duration::from_millis(2500));
        },
    );
    let played = contacts(&folder, "b.mcap");
    assert!(played.len() > wanted.len(), "{played:?}");
    for (played, wanted) in played.iter().zip(wanted.iter().cycle()) {
        assert_eq!(played, wanted);
    }
    let refused = folder.run("simulate pinch --from c.mcap");
    refused.failed(1, &["c.mcap"]);
}

#[test]
fn a_line_that_loses_bytes_lets_go_and_invents_nothing() {
    let folder = Folder::new();
    let _gloves = Simulated::start(
        &folder,
        "pinch",
        "--motion grab --drop-every 5 --without left --link pinch",
    );
    let ports = " --device pinch=pinch";
    record(&folder, PINCH, "pinch", ports, "a.mcap", || {
        std::thread::sleep(std::time::Duration::from_millis(4500));
    });
    let replay = Replay::open(&folder.file("a.mcap")).expect("a recording");
    let grab = THREE.without(Fingers::THUMB);
    let mut seen = [false; 3];
    for sample in replay.samples("pinch") {
        let Sample::Hand(hand) = sample else {
            panic!("{sample:?}");
        };
        let thumb = hand.hand.contacts.map(|contacts| contacts.own[0]);
        match thumb {
            None => seen[0] = true,
            Some(NONE) => seen[1] = true,
            Some(thumb) => {
                assert_eq!((hand.sensor, thumb), (2, grab));
                seen[2] = true;
            }
        }
    }
    // Messages were damaged, and some were not.
    assert_eq!(seen[0], true, "nothing was let go");
    assert!(seen[1] || seen[2], "nothing came through");
}

/// What the motion `grab` joins.
const THREE: Fingers = Fingers(0b00111);
