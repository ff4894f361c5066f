//! `sandtable calibrate` at a simulated Flock whose birds are put where a hand would put them.

mod bird;
mod field;
mod refusals;
mod talk;

use crate::program::Folder;
use bird::Bird;
use glam::{DQuat, DVec3, EulerRot};
use sandtable_config::{Device, Rig};
use sandtable_pose::Rigid;
use std::io::Write;
use std::time::Duration;
use talk::Talk;

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

/// Touches all marks, each `off` its place by what `error` says, up to the last prompt.
fn touch_all(folder: &Folder, arguments: &str, error: impl Fn(&str) -> DVec3) -> Talk {
    let mut bird = Bird::start(folder, "");
    let mut talk = Talk::start(folder, arguments);
    touch_each(&mut bird, &mut talk, &MARKS, error);
    talk.hear("q ends without");
    talk
}

/// Touches marks, each `off` its place by what `error` says.
fn touch_each(
    bird: &mut Bird,
    talk: &mut Talk,
    marks: &[(&str, DVec3)],
    error: impl Fn(&str) -> DVec3,
) {
    for (index, (name, place)) in marks.iter().enumerate() {
        talk.hear(&format!("touch \"{name}\""));
        let turn = index as f64;
        let angles = [20.0 * turn, 10.0 - 5.0 * turn, 15.0];
        bird.touch(*place + error(name), TIP, angles);
        talk.measure();
    }
}

/// A bird, and the talk of a dry run that finds where its tracker stands by the folder's marks.
fn dry_run(folder: &Folder) -> (Bird, Talk) {
    folder.write("rig.toml", with_tip());
    let arguments = "tracker --rig rig.toml --marks marks.toml --dry-run";
    (Bird::start(folder, ""), Talk::start(folder, arguments))
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
        panic!("the rig has a Flock");
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
        talk
    };
    let good = check(DVec3::ZERO, "2").end().done();
    assert!(good.out.contains("all 3 are within 2 mm"), "{good:?}");
    let far = ["3 of 3 marks are more than 5 mm off", "calibrate tracker"];
    let bad = check(DVec3::new(0.0, 0.0, 0.02), "5").fails(&far);
    assert!(
        bad.out.contains("+20.") || bad.out.contains("+19."),
        "{bad:?}"
    );
}

/// How far from "back right" it is touched, and no other mark.
fn slip(name: &str) -> DVec3 {
    let far = if name == "back right" { 0.04 } else { 0.0 };
    far * DVec3::X
}

/// The RMS of each table that was shown, in millimetres.
fn rms(out: &str) -> Vec<f64> {
    let lines = out.lines();
    let lines = lines.filter(|line| line.trim_start().starts_with("RMS"));
    lines
        .filter_map(|line| line.split_whitespace().nth(1)?.parse().ok())
        .collect()
}

#[test]
fn an_outlier_is_named_and_left_out_and_a_dry_run_changes_nothing() {
    let folder = folder();
    let more = [MARKS.as_slice(), &[("lamp", DVec3::new(-0.3, 0.2, 0.25))]].concat();
    folder.write("marks.toml", marks(&more));
    let (mut bird, mut talk) = dry_run(&folder);
    touch_each(&mut bird, &mut talk, &more, slip);
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
    let rms = rms(&ended.out);
    assert!(rms[0] > 5.0 && rms[1] < 1.0, "{rms:?}");
    assert_eq!(folder.read("rig.toml"), with_tip().as_bytes());
    assert_eq!(folder.names(), ["bird", "marks.toml", "rig.toml"]);
}

#[test]
fn a_mark_that_was_missed_may_be_touched_again() {
    let folder = folder();
    let (mut bird, mut talk) = dry_run(&folder);
    touch_each(&mut bird, &mut talk, &MARKS, slip);
    talk.hear("has it touched again");
    talk.say("t9");
    talk.hear("no point");
    talk.say("t 3");
    talk.hear("again: touch \"back right\"");
    bird.touch(MARKS[2].1, TIP, [0.0, 40.0, 20.0]);
    talk.measure();
    talk.hear("\"back right\" is touched again");
    talk.hear("Enter shows the lines");
    talk.say("");
    let ended = talk.end().done();
    let rms = rms(&ended.out);
    assert!(rms[0] > 5.0 && rms[1] < 1.0, "{rms:?}");
}

#[test]
fn marks_that_were_touched_in_each_others_place_are_named_and_touched_again() {
    let folder = folder();
    let (mut bird, mut talk) = dry_run(&folder);
    let across = MARKS[1].1 - MARKS[0].1;
    touch_each(&mut bird, &mut talk, &MARKS, |name| match name {
        "front left" => across,
        "front right" => -across,
        _ => DVec3::ZERO,
    });
    talk.hear("Enter shows the lines");
    for (name, place) in &MARKS[..2] {
        let number = if *name == "front left" { "t1" } else { "t2" };
        talk.say(number);
        talk.hear(&format!("again: touch \"{name}\""));
        bird.touch(*place, TIP, [0.0, 20.0, 10.0]);
        talk.measure();
        talk.hear("is touched again");
        talk.hear("Enter shows the lines");
    }
    talk.say("");
    let ended = talk.end().done();
    let note = "note: point 1 and point 2 seem to be touched in each other's place";
    assert_eq!(ended.out.matches(note).count(), 1, "{ended:?}");
    assert!(rms(&ended.out)[2] < 1.0, "{ended:?}");
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
        panic!("the rig has a Flock");
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
fn a_flight_says_how_old_its_rigs_calibration_is_and_what_of_the_rig_it_doubts() {
    let folder = folder();
    let flight = "fly builtin:ridges?size=65 --rig rig.toml --headless --seconds 0.05 -o a.avi";
    let said = folder.run(flight).done().err;
    let line = "calibrated: flock on no known day, eyes on no known day";
    assert_eq!(said.matches(line).count(), 1, "{said}");
    let doubt = "behind the glass";
    assert!(!said.contains(doubt), "{said}");
    // And doubts one whose corners are given left for right.
    let exchanged = RIG
        .replace("lower_left = [-0.90", "lower_left = [+0.90")
        .replace("lower_right = [0.90", "lower_right = [-0.90")
        .replace("upper_left = [-0.90", "upper_left = [+0.90");
    folder.write("rig.toml", exchanged);
    let flight = flight.replace("a.avi", "b.avi");
    let said = folder.run(&flight).done().err;
    assert_eq!(said.matches(doubt).count(), 1, "{said}");
}
