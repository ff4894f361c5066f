//! `sandtable calibrate` at a simulated Flock whose birds are put where a hand would put them.

use crate::program::{Ended, Folder, Running, isolate, sandtable};
use glam::{DQuat, DVec3, EulerRot};
use sandtable_config::{Device, Rig};
use sandtable_pose::Rigid;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// A small table whose Flock starts quickly, and believes a hand that jumps.
const RIG: &str = r#"# Our table, by the window.
name = "a small table"
[table]
lower_left = [-0.90, -0.55, 0.0]
lower_right = [0.90, -0.55, 0.0]
upper_left = [-0.90, 0.55, 0.0]
pixels = [60, 36]
[head]
sensor = "flock/1"
rest = { position = [0.0, -0.75, 0.60], axes = ["+y", "+x", "-z"] }
eyes = { middle = [0.0, 0.0, 0.0], rightwards = [0.0, 1.0, 0.0] } # by ruler
[devices.flock] # bought in 1999
kind = "flock-of-birds"
port = "/dev/there-is-no-such-port"
birds = 1
range = 72
hemisphere = "upper"
silence_before = 0.6
silence_after = 0.6
lost_after_ms = 1000.0
max_speed = 100.0
max_turn = 20000.0
table_from_tracker = { translation = [0.0, 0.0, -0.30], axes = ["+y", "+x", "-z"] } # by ruler
# The end.
"#;

const TIP: DVec3 = DVec3::new(0.12, -0.015, 0.03);

const MARKS: [(&str, DVec3); 5] = [
    ("front left", DVec3::new(-0.7, -0.45, 0.0)),
    ("front right", DVec3::new(0.7, -0.45, 0.0)),
    ("back right", DVec3::new(0.6, 0.45, 0.0)),
    ("back left", DVec3::new(-0.6, 0.4, 0.0)),
    ("post", DVec3::new(0.1, 0.1, 0.35)),
];

/// How the tracker truly stands: turned, tilted, and not where the rig says.
fn table_from_tracker() -> Rigid {
    let rotation = DQuat::from_euler(EulerRot::ZYX, 0.35, 0.08, 3.05);
    Rigid::new(rotation, DVec3::new(0.05, -0.1, -0.35))
}

/// A rig, and a file of marks.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("rig.toml", RIG);
    folder.write("marks.toml", marks(&MARKS));
    folder
}

fn with_tip() -> String {
    let [x, y, z] = TIP.to_array();
    format!("{RIG}[stylus]\nsensor = \"flock/1\"\ntip = [{x}, {y}, {z}]\n")
}

fn marks(marks: &[(&str, DVec3)]) -> String {
    let line = |(name, p): &(&str, DVec3)| format!("\"{name}\" = [{}, {}, {}]\n", p.x, p.y, p.z);
    "[marks]\n".to_owned() + &marks.iter().map(line).collect::<String>()
}

/// A simulated bird that goes where it is told.
struct Bird {
    _program: Running,
    orders: ChildStdin,
    answers: BufReader<std::process::ChildStdout>,
}

impl Bird {
    fn start(folder: &Folder, arguments: &str) -> Self {
        let mut command = sandtable(folder.path());
        command.args("simulate flock --birds 1 --steer --link bird".split(' '));
        command.args(arguments.split(' ').filter(|argument| !argument.is_empty()));
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut program = command.spawn().expect("the program starts");
        let orders = program.stdin.take().expect("it is piped");
        let out = program.stdout.take().expect("it is piped");
        let mut bird = Self {
            _program: Running(program),
            orders,
            answers: BufReader::new(out),
        };
        assert_eq!(bird.answer(), "bird\n");
        bird
    }

    fn answer(&mut self) -> String {
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("an answer");
        line
    }

    /// Puts the sensor there: tracker frame, and azimuth, elevation and roll in degrees.
    fn put(&mut self, position: DVec3, [azimuth, elevation, roll]: [f64; 3]) {
        let inches = position / 0.0254;
        let line = format!(
            "1,{},{},{},{azimuth},{elevation},{roll}\n",
            inches.x, inches.y, inches.z
        );
        self.orders.write_all(line.as_bytes()).expect("it listens");
        assert_eq!(self.answer(), "1\n");
    }

    /// Puts `tip` of a stylus held at these angles on a place of the table.
    fn touch(&mut self, place: DVec3, tip: DVec3, angles: [f64; 3]) {
        self.touch_from(&table_from_tracker(), place, tip, angles);
    }

    /// The same from a tracker that stands elsewhere.
    fn touch_from(
        &mut self,
        table_from_tracker: &Rigid,
        place: DVec3,
        tip: DVec3,
        angles: [f64; 3],
    ) {
        let offset = rotation(angles) * tip;
        self.put(table_from_tracker.inverse().point(place) - offset, angles);
    }
}

fn rotation([azimuth, elevation, roll]: [f64; 3]) -> DQuat {
    DQuat::from_euler(
        EulerRot::ZYX,
        azimuth.to_radians(),
        elevation.to_radians(),
        roll.to_radians(),
    )
}

/// `sandtable calibrate` while it asks.
struct Talk {
    program: Running,
    answers: Option<ChildStdin>,
    prompts: Receiver<String>,
    said: String,
}

impl Talk {
    fn start(folder: &Folder, arguments: &str) -> Self {
        let mut command = sandtable(folder.path());
        command.arg("calibrate").args(arguments.split(' '));
        command.args("--device flock=bird".split(' '));
        Self::with(command)
    }

    /// The same where no file may grow above 8 KiB, as on a disk that fills up.
    fn start_on_a_full_disk(folder: &Folder, arguments: &str) -> Self {
        let program = env!("CARGO_BIN_EXE_sandtable");
        let script = format!(
            "trap '' XFSZ; ulimit -f 16; exec '{program}' calibrate {arguments} --device flock=bird"
        );
        let mut command = Command::new("sh");
        isolate(&mut command, folder.path());
        command.args(["-c", &script]);
        Self::with(command)
    }

    fn with(mut command: Command) -> Self {
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut program = command.spawn().expect("the program starts");
        let err = program.stderr.take().expect("it is piped");
        let (sender, prompts) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(err).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Self {
            answers: program.stdin.take(),
            program: Running(program),
            prompts,
            said: String::new(),
        }
    }

    /// Reads on until a line contains `part`, and returns it.
    #[track_caller]
    fn hear(&mut self, part: &str) -> String {
        self.hear_one(&[part])
    }

    /// The same with any of `parts`.
    #[track_caller]
    fn hear_one(&mut self, parts: &[&str]) -> String {
        loop {
            match self.prompts.recv_timeout(Duration::from_secs(60)) {
                Ok(line) => {
                    self.said += &format!("{line}\n");
                    if parts.iter().any(|part| line.contains(part)) {
                        return line;
                    }
                }
                Err(_) => panic!("no {parts:?} in\n{}", self.said),
            }
        }
    }

    fn say(&mut self, line: &str) {
        let answers = self.answers.as_mut().expect("not ended");
        answers
            .write_all(format!("{line}\n").as_bytes())
            .expect("it listens");
    }

    /// Answers the prompt that is there until the measurement is taken: a busy machine may show the
    /// sensor where it was a moment ago.
    #[track_caller]
    fn measure(&mut self) {
        for _ in 0..20 {
            self.say("");
            if self.hear_one(&["got it", "again: "]).contains("got it") {
                return;
            }
            self.hear("Enter");
        }
        panic!("never taken:\n{}", self.said);
    }

    /// No more answers; how it ends.
    fn end(mut self) -> Ended {
        drop(self.answers.take());
        let status = self.program.end();
        let mut out = String::new();
        let pipe = self.program.0.stdout.as_mut().expect("it is piped");
        pipe.read_to_string(&mut out).expect("text");
        while let Ok(line) = self.prompts.recv() {
            self.said += &format!("{line}\n");
        }
        Ended {
            status,
            out,
            err: self.said,
        }
    }
}

/// Touches all marks, each `off` its place by what `error` says, up to the last prompt.
fn touch_all(folder: &Folder, arguments: &str, error: impl Fn(&str) -> DVec3) -> Talk {
    let mut bird = Bird::start(folder, "");
    let mut talk = Talk::start(folder, arguments);
    for (index, (name, place)) in MARKS.into_iter().enumerate() {
        talk.hear(&format!("touch \"{name}\""));
        let turn = index as f64;
        bird.touch(
            place + error(name),
            TIP,
            [20.0 * turn, 10.0 - 5.0 * turn, 15.0],
        );
        talk.measure();
    }
    talk.hear("q ends without");
    talk
}

fn calibrated(folder: &Folder, name: &str) -> Rig {
    Rig::load(&folder.file(name)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_tracker_is_found_to_a_millimetre_and_every_comment_kept() {
    let folder = folder();
    folder.write("rig.toml", with_tip());
    let mut talk = touch_all(&folder, "tracker --rig rig.toml --marks marks.toml", |_| {
        DVec3::ZERO
    });
    talk.say("");
    let ended = talk.end().done();
    assert!(ended.out.contains("RMS"), "{ended:?}");

    let rig = calibrated(&folder, "rig.toml");
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    for (name, place) in MARKS {
        let measured = table_from_tracker().inverse().point(place);
        let off = flock.table_from_tracker.point(measured).distance(place);
        assert!(off < 1e-3, "{name} is {off} m off");
    }
    assert!(flock.calibrated.is_some());
    let written = String::from_utf8(folder.read("rig.toml")).unwrap();
    let old = with_tip();
    let changed: Vec<_> = written.lines().filter(|l| !old.contains(l)).collect();
    assert_eq!(changed.len(), 1, "{written}");
    assert!(changed[0].ends_with(" # by ruler"), "{}", changed[0]);
    assert_eq!(written.lines().count(), old.lines().count());
    // The old one is beside it, and nothing else is left.
    let day = flock.calibrated.unwrap();
    let kept = format!("rig.toml.bak-{day}");
    assert_eq!(folder.read(&kept), old.as_bytes());
    assert_eq!(folder.names(), ["bird", "marks.toml", "rig.toml", &kept]);

    // And the check finds every mark where it is.
    let check = |moved: DVec3, within: &str| {
        let mut bird = Bird::start(&folder, "");
        let arguments = format!("check --rig rig.toml --marks marks.toml --within {within}");
        let mut talk = Talk::start(&folder, &arguments);
        for (name, place) in &MARKS[..3] {
            talk.hear(&format!("touch \"{name}\""));
            bird.touch(*place + moved, TIP, [0.0, 30.0, 0.0]);
            talk.measure();
        }
        talk.end()
    };
    let good = check(DVec3::ZERO, "2").done();
    assert!(good.out.contains("all 3 are within 2 mm"), "{good:?}");
    let bad = check(DVec3::new(0.0, 0.0, 0.02), "5");
    assert!(
        bad.out.contains("+20.") || bad.out.contains("+19."),
        "{bad:?}"
    );
    bad.failed(
        1,
        &["3 of 3 marks are more than 5 mm off", "calibrate tracker"],
    );
}

#[test]
fn an_outlier_is_named_and_left_out_and_a_dry_run_changes_nothing() {
    let folder = folder();
    let more = [MARKS.as_slice(), &[("lamp", DVec3::new(-0.3, 0.2, 0.25))]].concat();
    folder.write("marks.toml", marks(&more));
    folder.write("rig.toml", with_tip());
    let arguments = "tracker --rig rig.toml --marks marks.toml --dry-run";
    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start(&folder, arguments);
    for (name, place) in &more {
        talk.hear(&format!("touch \"{name}\""));
        let slip = if *name == "back right" { 0.04 } else { 0.0 };
        bird.touch(*place + slip * DVec3::X, TIP, [10.0, 20.0, 0.0]);
        talk.measure();
    }
    talk.hear("Enter shows the lines");
    talk.say("9");
    talk.hear("no point");
    talk.hear("leaves that point out");
    talk.say("3");
    talk.hear("\"back right\" is left out");
    talk.hear("Enter shows the lines");
    talk.say("");
    let ended = talk.end().done();
    assert!(ended.out.contains("point 3 lies"), "{ended:?}");
    let shown: Vec<_> = ended
        .out
        .lines()
        .filter(|line| line.starts_with(['-', '+']))
        .collect();
    assert_eq!(shown.len(), 2, "{ended:?}");
    assert!(shown[0].starts_with("- table_from_tracker"), "{ended:?}");
    assert!(shown[1].starts_with("+ table_from_tracker"), "{ended:?}");
    // Without the slip the rest fits to the tracker's steps.
    let rms: Vec<f64> = ended
        .out
        .lines()
        .filter(|line| line.trim_start().starts_with("RMS"))
        .filter_map(|line| line.split_whitespace().nth(1)?.parse().ok())
        .collect();
    assert!(rms[0] > 5.0 && rms[1] < 1.0, "{rms:?}");
    assert_eq!(folder.read("rig.toml"), with_tip().as_bytes());
    assert_eq!(folder.names(), ["bird", "marks.toml", "rig.toml"]);
}

#[test]
fn a_stylus_tip_is_found_by_pivoting() {
    let folder = folder();
    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start(
        &folder,
        "stylus --rig rig.toml --sensor flock/1 --seconds 60",
    );
    let spot = DVec3::new(0.1, 0.0, 0.0);
    bird.touch(spot, TIP, [0.0, 0.0, 0.0]);
    talk.hear("stand the tip");
    talk.say("");
    talk.hear("now");
    for step in 0..16 {
        let turn = f64::from(step);
        let angles = [
            40.0 * (0.9 * turn).sin(),
            35.0 * (0.7 * turn).cos(),
            12.0 * turn - 90.0,
        ];
        bird.touch(spot, TIP, angles);
        // As long as a hand stays there.
        std::thread::sleep(Duration::from_millis(60));
    }
    talk.say("");
    talk.hear("q ends without");
    talk.say("");
    let ended = talk.end().done();
    assert!(ended.out.contains("tip: "), "{ended:?}");
    let stylus = calibrated(&folder, "rig.toml").stylus.unwrap();
    assert!(stylus.tip.distance(TIP) < 2e-3, "{:?}", stylus.tip);
    assert_eq!(stylus.sensor.to_string(), "flock/1");
    let written = String::from_utf8(folder.read("rig.toml")).unwrap();
    assert!(written.starts_with(RIG.trim_end()), "{written}");
}

#[test]
fn eyes_are_found_by_sightings() {
    let folder = folder();
    let middle = DVec3::new(0.04, 0.003, 0.03);
    let rightwards = DVec3::new(0.05, 1.0, -0.03).normalize();
    let interpupillary = 0.066;
    let rig = calibrated(&folder, "rig.toml");
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    let arguments = "eyes --rig rig.toml --marks marks.toml -o mine.toml --sightings 4 \
                     --pair post=back_left --pair post=back_right";
    let named = marks(&MARKS).replace("back left", "back_left");
    folder.write("marks.toml", named.replace("back right", "back_right"));
    let (near, far) = (MARKS[4].1, [MARKS[3].1, MARKS[2].1]);
    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start(&folder, arguments);
    for (name, side) in [("left", -0.5), ("right", 0.5)] {
        let eye = middle + side * interpupillary * rightwards;
        for index in 0..4 {
            talk.hear(&format!("{name} eye, {} of 4", index + 1));
            let turn = index as f64;
            let towards = (near - far[index % 2]).normalize();
            let place = near + (0.3 + 0.05 * turn) * towards;
            let angles = [25.0 * turn - 40.0, 12.0 * (turn - 1.5), 8.0 * turn];
            bird.touch_from(&flock.table_from_tracker, place, eye, angles);
            talk.measure();
        }
    }
    talk.hear("q ends without");
    talk.say("");
    let ended = talk.end().done();
    assert!(ended.out.contains("left eye: "), "{ended:?}");
    assert_eq!(folder.read("rig.toml"), RIG.as_bytes());
    let eyes = calibrated(&folder, "mine.toml").head.unwrap().eyes;
    assert!(eyes.middle.distance(middle) < 2e-3, "{eyes:?}");
    assert!(eyes.rightwards.angle_between(rightwards) < 0.05, "{eyes:?}");
    assert!(
        (eyes.interpupillary - interpupillary).abs() < 2e-3,
        "{eyes:?}"
    );
    assert!(eyes.calibrated.is_some());
}

#[test]
fn a_full_disk_keeps_the_old_rig_and_prints_what_was_measured() {
    let folder = folder();
    // What it was still fits, and with the measured numbers it does not.
    let old = with_tip() + &"#".repeat(8192 - 10 - with_tip().len()) + "\n";
    folder.write("rig.toml", &old);
    folder.write("marks.toml", marks(&MARKS[..3]));
    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start_on_a_full_disk(&folder, "tracker --rig rig.toml --marks marks.toml");
    for (name, place) in &MARKS[..3] {
        talk.hear(&format!("touch \"{name}\""));
        bird.touch(*place, TIP, [0.0, 30.0, 0.0]);
        talk.measure();
    }
    talk.hear("q ends without");
    talk.say("");
    let ended = talk.end();
    assert!(ended.out.contains("\n+ table_from_tracker = "), "{ended:?}");
    ended.failed(1, &["cannot write", "rig.toml", "full"]);
    assert_eq!(folder.read("rig.toml"), old.as_bytes());
    let left: Vec<_> = folder.names();
    assert!(!left.iter().any(|name| name.ends_with(".part")), "{left:?}");
}

#[test]
fn a_sensor_that_falls_silent_is_refused_with_its_reason() {
    let folder = folder();
    let _bird = Bird::start(&folder, "--stall 0.3,100000");
    let mut talk = Talk::start(
        &folder,
        "tracker --rig rig.toml --marks marks.toml --sensor flock/1",
    );
    talk.hear("no stylus tip on flock/1");
    talk.hear("touch \"front left\"");
    // Until a pose is lost.
    std::thread::sleep(Duration::from_millis(1500));
    talk.say("");
    let refused = talk.hear("again: ");
    assert!(refused.contains("flock/1 is not live"), "{refused}");
    talk.hear("touch \"front left\"");
    let ended = talk.end();
    ended.failed(1, &["standard input ended", "nothing is written"]);
    assert_eq!(folder.read("rig.toml"), RIG.as_bytes());
}

#[test]
fn a_sensor_that_moves_is_refused_and_asked_again() {
    let folder = folder();
    let mut bird = Bird::start(&folder, "--motion circle");
    let arguments = "check --rig rig.toml --marks marks.toml --sensor flock/1";
    let mut talk = Talk::start(&folder, arguments);
    talk.hear("touch \"front left\"");
    talk.say("");
    let refused = talk.hear("again: ");
    for part in ["flock/1 moved by", "2 mm are allowed", "hold it still"] {
        assert!(refused.contains(part), "no {part:?} in {refused}");
    }
    talk.hear("touch \"front left\"");
    bird.put(DVec3::new(-0.1, 0.2, -0.5), [0.0; 3]);
    talk.measure();
    talk.hear("touch \"front right\"");
    talk.say("q");
    // Not by `failed`: a busy machine may ask for the first mark more often than twice.
    let ended = talk.end();
    assert_eq!(ended.status.code(), Some(1), "{ended:#?}");
    for part in ["ended with q", "nothing is written"] {
        assert!(ended.err.contains(part), "no {part:?} in {ended:#?}");
    }
}

#[test]
fn a_port_that_is_not_there_is_told_before_anything_is_asked() {
    let folder = folder();
    let refused = folder.run("calibrate check --rig rig.toml --marks marks.toml --sensor flock/1");
    let said = refused.failed(1, &["nothing comes from flock/1", "no-such-port"]);
    assert!(!said.contains("touch \""), "{said}");
}

#[test]
fn what_cannot_end_well_is_refused_before_anything_is_touched() {
    let folder = folder();
    let line: Vec<_> = (0..4)
        .map(|i| {
            (
                "abcd".get(i..=i).unwrap(),
                DVec3::new(0.2 * i as f64, 0.0, 0.0),
            )
        })
        .collect();
    folder.write("line.toml", marks(&line));
    folder.write("two.toml", marks(&MARKS[..2]));
    let torn = marks(&MARKS);
    folder.write("torn.toml", &torn[..torn.len() - 12]);
    folder.write("taken.toml", "mine");
    let tracker = |rest: &str| format!("tracker --sensor flock/1 {rest}");
    for (arguments, code, says) in [
        (
            tracker("--rig rig.toml --marks line.toml"),
            1,
            &["line.toml", "nearly in the line", "well off that line"][..],
        ),
        (
            tracker("--rig rig.toml --marks two.toml"),
            1,
            &["too few", "at least 3"],
        ),
        (
            tracker("--rig rig.toml --marks torn.toml"),
            1,
            &["torn.toml, line 6", "TOML"],
        ),
        (
            tracker("--rig rig.toml --marks none.toml"),
            1,
            &["none.toml", "[marks]"],
        ),
        (
            tracker("--rig workbench --marks marks.toml"),
            2,
            &["built in", "-o"],
        ),
        (
            tracker("--rig rig.toml --marks marks.toml -o taken.toml"),
            1,
            &["taken.toml", "never overwritten"],
        ),
        (
            tracker("--rig rig.toml --marks marks.toml -o /sys/rig.toml"),
            1,
            &["/sys/rig.toml", "writable"],
        ),
        (
            "tracker --rig rig.toml --marks marks.toml".to_owned(),
            2,
            &["--sensor"],
        ),
        (
            "tracker --rig rig.toml --marks marks.toml --sensor flock/2".to_owned(),
            2,
            &["flock/2", "flock/1"],
        ),
        (
            "eyes --rig rig.toml --marks marks.toml --pair post=lamp".to_owned(),
            2,
            &["lamp", "back left"],
        ),
        (
            "eyes --rig rig.toml --marks marks.toml --pair post".to_owned(),
            2,
            &["NEAR=FAR"],
        ),
        (
            "check --rig rig.toml --marks marks.toml --sensor flock/1 --within 0".to_owned(),
            2,
            &["above 0"],
        ),
        (
            "stylus --rig rig.toml --sensor flock/1 --seconds 0".to_owned(),
            2,
            &["1 to 60"],
        ),
    ] {
        let refused = folder.run(&format!("calibrate {arguments}"));
        refused.failed(code, says);
    }
    assert_eq!(folder.read("rig.toml"), RIG.as_bytes());
    assert_eq!(folder.read("taken.toml"), b"mine");

    let mut permissions = folder.file("rig.toml").metadata().unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(folder.file("rig.toml"), permissions).unwrap();
    let arguments = tracker("--rig rig.toml --marks marks.toml");
    let refused = folder.run(&format!("calibrate {arguments}"));
    refused.failed(1, &["read-only", "-o"]);
    let names = [
        "line.toml",
        "marks.toml",
        "rig.toml",
        "taken.toml",
        "torn.toml",
        "two.toml",
    ];
    assert_eq!(folder.names(), names);
}

#[test]
fn a_simulator_is_steered_by_lines_and_refuses_others() {
    let folder = Folder::new();
    let mut bird = Bird::start(&folder, "");
    for line in ["2,0,0,0,0,0,0\n", "1,0,0\n", "jump\n"] {
        bird.orders.write_all(line.as_bytes()).unwrap();
    }
    // Only what is obeyed is answered.
    bird.put(DVec3::new(0.1, 0.2, -0.3), [0.0; 3]);
}

#[test]
fn a_flight_says_how_old_its_rigs_calibration_is() {
    let folder = folder();
    let flight = "fly builtin:ridges?size=65 --rig rig.toml --headless --seconds 0.05 -o a.avi";
    let said = folder.run(flight).done().err;
    let line = "calibrated: flock on no known day, eyes on no known day";
    assert_eq!(said.matches(line).count(), 1, "{said}");
}
