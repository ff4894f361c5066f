//! `sandtable calibrate field`: a Flock whose field is bent by a known function, straightened by
//! touched marks.

use super::bird::{Bird, rotation};
use super::talk::Talk;
use super::{RIG, TIP, calibrated, folder, marks, with_tip};
use crate::program::Folder;
use glam::DVec3;
use sandtable_config::{Calibrated, Device, Rig};
use sandtable_pose::Rigid;
use std::time::Duration;
use time::{Date, Month};

const FILE: &str = "rig.flock-field.toml";

/// How far the field moves what it measures at the rim of the volume, in metres.
const RIM: f64 = 0.03;

const LOW: DVec3 = DVec3::new(-0.7, -0.45, 0.0);
const HIGH: DVec3 = DVec3::new(0.7, 0.45, 0.4);

/// The tracker stands as the rig says: its axes are right, and 0.3 m below the glass.
fn table_from_tracker() -> Rigid {
    let rig = Rig::parse(RIG, "rig.toml").expect("a rig");
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the rig has a Flock");
    };
    flock.table_from_tracker
}

/// Where the field says that a place is: off by more the farther it is from the transmitter, and to
/// other sides.
fn bent(place: DVec3) -> DVec3 {
    let bend = |place: DVec3| {
        let away = place - table_from_tracker().translation;
        away.length().powi(3) * DVec3::new((1.5 * away.x).sin(), -0.5, (2.0 * away.y).cos())
    };
    let corner = bend(HIGH).length();
    place + RIM / corner * bend(place)
}

/// Marks evenly over the volume.
fn pegs([x, y, z]: [u32; 3]) -> Vec<(String, DVec3)> {
    let share = |k: u32, count: u32| f64::from(k) / f64::from(count - 1);
    (0..x * y * z)
        .map(|k| {
            let part = DVec3::new(share(k % x, x), share(k / x % y, y), share(k / x / y, z));
            (format!("peg {}", k + 1), LOW + part * (HIGH - LOW))
        })
        .collect()
}

fn write_marks(folder: &Folder, name: &str, pegs: &[(String, DVec3)]) {
    let pegs: Vec<_> = pegs
        .iter()
        .map(|(name, place)| (name.as_str(), *place))
        .collect();
    folder.write(name, marks(&pegs));
}

/// Touches each mark with the stylus held otherwise, `slip` off its place, where the tracker says
/// what `field` makes of the sensor's place.
fn touch(
    bird: &mut Bird,
    talk: &mut Talk,
    pegs: &[(String, DVec3)],
    field: impl Fn(DVec3) -> DVec3,
    slip: impl Fn(usize) -> DVec3,
) {
    let tracker_from_table = table_from_tracker().inverse();
    for (index, (name, place)) in pegs.iter().enumerate() {
        talk.hear(&format!("touch \"{name}\""));
        let turn = (index % 5) as f64;
        let angles = [25.0 * turn - 50.0, 10.0 * turn - 20.0, 15.0];
        let offset = table_from_tracker().direction(rotation(angles) * TIP);
        let sensor = *place + slip(index) - offset;
        bird.put(tracker_from_table.point(field(sensor)), angles);
        // What was sent before is read by then: else half a second of it could pass for the mark.
        std::thread::sleep(Duration::from_millis(250));
        talk.measure();
    }
}

/// The numbers behind RMS, one line a fit: before, after, unseen.
fn rms(out: &str) -> Vec<[f64; 3]> {
    let lines = out
        .lines()
        .filter_map(|line| line.trim().strip_prefix("RMS"));
    lines
        .map(|line| {
            let numbers = line.split_whitespace().take(3);
            let numbers: Vec<f64> = numbers.map(|n| n.parse().expect("a number")).collect();
            [numbers[0], numbers[1], numbers[2]]
        })
        .collect()
}

/// How far `check` finds three marks off, in millimetres.
fn checked(folder: &Folder, pegs: &[(String, DVec3)]) -> Vec<f64> {
    write_marks(folder, "other.toml", pegs);
    let mut bird = Bird::start(folder, "");
    let arguments = "check --rig rig.toml --marks other.toml --within 4";
    let mut talk = Talk::start(folder, arguments);
    touch(&mut bird, &mut talk, pegs, bent, |_| DVec3::ZERO);
    let ended = talk.end();
    let lines = ended
        .out
        .lines()
        .filter_map(|line| line.split_once(" mm off ("));
    let off: Vec<f64> = lines
        .filter_map(|(line, _)| line.rsplit(' ').next()?.parse().ok())
        .collect();
    assert_eq!(off.len(), 3, "{ended:?}");
    let is_near = off.iter().all(|off| *off <= 4.0);
    assert_eq!(ended.status.code(), Some(i32::from(!is_near)), "{ended:?}");
    off
}

#[test]
fn a_field_bent_by_thirty_millimetres_is_straightened_to_three() {
    let folder = folder();
    folder.write("rig.toml", with_tip());
    let all = pegs([4, 3, 3]);
    write_marks(&folder, "many.toml", &all);
    let others = [(-0.5, 0.35, 0.3), (0.6, -0.35, 0.1), (0.4, 0.4, 0.35)];
    let others: Vec<_> = (1..)
        .zip(others)
        .map(|(n, (x, y, z))| (format!("other {n}"), DVec3::new(x, y, z)))
        .collect();
    let before = checked(&folder, &others);
    assert!(before.iter().all(|off| *off > 8.0), "{before:?}");

    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start(&folder, "field --rig rig.toml --marks many.toml");
    talk.hear("`sandtable calibrate tracker` comes before this");
    let slip = |index| {
        if index == 16 {
            0.04 * DVec3::X
        } else {
            DVec3::ZERO
        }
    };
    touch(&mut bird, &mut talk, &all, bent, slip);
    talk.hear("Enter writes");
    talk.say("17");
    talk.hear("\"peg 17\" is left out");
    talk.hear("Enter writes");
    talk.say("");
    let ended = talk.end().done();
    drop(bird);
    assert!(ended.out.contains("note: sample 17 lies "), "{ended:?}");
    assert_eq!(ended.out.matches("note: ").count(), 1, "{ended:?}");
    let fits = rms(&ended.out);
    assert!(fits[0][2] > 5.0, "{fits:?}");
    assert!(
        fits[1][0] > 8.0 && fits[1][1] < 1.0 && fits[1][2] < 3.0,
        "{fits:?}"
    );

    // The rig has a line more, and its old self is kept.
    let written = String::from_utf8(folder.read("rig.toml")).expect("text");
    let line = format!("correction = \"{FILE}\"\n");
    assert_eq!(written.replace(&line, ""), with_tip());
    let rig = calibrated(&folder, "rig.toml");
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the rig has a Flock");
    };
    let correction = flock.correction.as_ref().expect("it is named");
    let kept = format!("rig.toml.bak-{}", correction.calibrated());
    assert_eq!(folder.read(&kept), with_tip().as_bytes());
    let names = [
        "bird",
        "many.toml",
        "marks.toml",
        "other.toml",
        FILE,
        "rig.toml",
        &kept,
    ];
    assert_eq!(folder.names(), names);

    // All over the volume that was touched, not at the marks alone.
    let (mut before, mut after, mut worst) = (0.0, 0.0, 0.0_f64);
    let places = pegs([9, 8, 7]);
    for (_, place) in &places {
        let measured = bent(*place);
        let off = correction.grid().correct(measured).distance(*place);
        before += measured.distance_squared(*place);
        after += off * off;
        worst = worst.max(off);
    }
    let root = |sum: f64| 1e3 * (sum / places.len() as f64).sqrt();
    let (before, after) = (root(before), root(after));
    println!(
        "{before:.2} mm RMS before, {after:.2} after, {:.2} at worst",
        1e3 * worst
    );
    assert!(before > 10.0 && after < 3.0 && worst < 0.01);

    let after = checked(&folder, &others);
    let rms = (after.iter().map(|off| off * off).sum::<f64>() / 3.0).sqrt();
    println!("check: {after:?}");
    assert!(rms < 3.0, "{after:?}");
}

/// A rig whose correction moves everything by 2 cm.
fn shifted(folder: &Folder) {
    let file = "calibrated = 2026-11-20\n\
                table_from_tracker = { translation = [0.0, 0.0, -0.3], quaternion = [0, 0.707106781, 0.707106781, 0] }\n\
                [correction]\norigin = [-1, -1, -1]\nspacing = [2, 2, 2]\ncounts = [2, 2, 2]\n\
                displacements = [[0.02, 0, 0], [0.02, 0, 0], [0.02, 0, 0], [0.02, 0, 0], \
                [0.02, 0, 0], [0.02, 0, 0], [0.02, 0, 0], [0.02, 0, 0]]\n";
    folder.write(FILE, file);
    let entry = Calibrated::Field {
        device: "flock".into(),
        file: FILE.into(),
    };
    let day = Date::from_calendar_date(2026, Month::November, 20).expect("a day");
    let rig = entry.write_into(&with_tip(), "rig.toml", day);
    folder.write("rig.toml", rig.expect("a rig"));
}

#[test]
fn a_tracker_is_calibrated_without_its_correction_and_drops_it() {
    let folder = folder();
    shifted(&folder);
    let marks = [
        ("a", DVec3::new(-0.6, -0.4, 0.0)),
        ("b", DVec3::new(0.6, -0.4, 0.1)),
        ("c", DVec3::new(0.5, 0.4, 0.0)),
        ("d", DVec3::new(-0.4, 0.3, 0.3)),
    ];
    let pegs = marks.map(|(name, place)| (name.to_owned(), place));
    write_marks(&folder, "marks.toml", &pegs);
    let mut bird = Bird::start(&folder, "");
    let straight = |place| place;
    let mut talk = Talk::start(&folder, "check --rig rig.toml --marks marks.toml");
    touch(&mut bird, &mut talk, &pegs[..3], straight, |_| DVec3::ZERO);
    let checked = talk.fails(&["3 of 3 marks"]);
    for line in checked.out.lines().take(3) {
        assert!(
            line.contains("(+20.") || line.contains("(+19."),
            "{checked:?}"
        );
    }
    drop(bird);

    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start(&folder, "tracker --rig rig.toml --marks marks.toml");
    touch(&mut bird, &mut talk, &pegs, straight, |_| DVec3::ZERO);
    talk.hear("Enter writes");
    talk.say("");
    let ended = talk.end().done();
    let told = format!("no longer names {FILE}: that correction was for where the tracker stood");
    assert!(ended.out.contains(&told), "{ended:?}");
    let rig = calibrated(&folder, "rig.toml");
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the rig has a Flock");
    };
    assert_eq!(flock.correction, None);
    for (name, place) in marks {
        let measured = table_from_tracker().inverse().point(place);
        let off = flock.table_from_tracker.point(measured).distance(place);
        assert!(off < 1e-3, "{name} is {off} m off");
    }
    assert!(
        folder.names().contains(&FILE.to_owned()),
        "it stays where it is"
    );
}

#[test]
fn what_does_not_help_is_not_recommended_and_an_old_correction_is_not_measured() {
    let folder = folder();
    shifted(&folder);
    let few = pegs([2, 2, 3]);
    write_marks(&folder, "many.toml", &few);
    let straight = |place| place;
    let run = "field --rig rig.toml --marks many.toml";
    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start(&folder, run);
    // A hand that misses every mark by 5 mm, each otherwise.
    let miss = |index| {
        let turn = 2.4 * index as f64;
        5e-3 * DVec3::new(
            turn.sin(),
            turn.cos() * (3.0 * turn).cos(),
            (2.0 * turn).sin(),
        )
    };
    touch(&mut bird, &mut talk, &few, straight, miss);
    let prompt = talk.hear("has it touched again; q ends without");
    assert!(!prompt.contains("writes"), "{prompt}");
    talk.say("");
    talk.hear("Enter writes nothing here");
    talk.say("w");
    talk.hear("\"w\" is no sample");
    for _ in 0..4 {
        talk.say("1");
        talk.hear("is left out");
    }
    // What the fit needs stays.
    talk.say("1");
    talk.hear("stays: otherwise, 7 samples of the field are too few");
    talk.say("q");
    let ended = talk.fails(&["ended with q", "nothing is written"]);
    assert!(
        ended.out.contains("no correction helps at marks"),
        "{ended:?}"
    );
    drop(bird);

    // The old correction moves places by 20 mm; what is there without it are a Flock's steps.
    let (old, rig) = (folder.read(FILE), folder.read("rig.toml"));
    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start(&folder, run);
    touch(&mut bird, &mut talk, &few, straight, |_| DVec3::ZERO);
    talk.hear("w writes it all the same");
    talk.say("");
    talk.hear("Enter writes nothing here");
    talk.say("w");
    let ended = talk.end().done();
    assert!(ended.out.contains("better do not write it"), "{ended:?}");
    assert!(rms(&ended.out)[0][0] < 0.5, "{ended:?}");
    let new = calibrated(&folder, "rig.toml");
    let correction = new.devices["flock"].correction().expect("it is named");
    let moves = correction.grid().displacements().iter();
    assert!(moves.map(|d| d.length()).fold(0.0, f64::max) < 1e-3);
    let kept = format!("{FILE}.bak-{}", correction.calibrated());
    assert_eq!(folder.read(&kept), old);
    assert_eq!(folder.read("rig.toml"), rig, "it names the file already");
    let names = ["bird", "many.toml", "marks.toml", FILE, &kept, "rig.toml"];
    assert_eq!(folder.names(), names);
}

#[test]
fn a_full_disk_keeps_the_old_correction_and_prints_the_new_one() {
    let folder = folder();
    shifted(&folder);
    let few = pegs([2, 2, 3]);
    write_marks(&folder, "many.toml", &few);
    let (old, rig, names) = (folder.read(FILE), folder.read("rig.toml"), folder.names());
    let mut bird = Bird::start(&folder, "");
    let run = "field --rig rig.toml --marks many.toml";
    let mut talk = Talk::start_on_a_full_disk(&folder, run);
    touch(&mut bird, &mut talk, &few, |place| place, |_| DVec3::ZERO);
    talk.hear("w writes it all the same");
    talk.say("w");
    let ended = talk.fails(&["cannot write", FILE, "full"]);
    let (_, printed) = ended
        .out
        .split_once("this is what was measured, for rig.flock-field.toml:\n")
        .expect("it is printed");
    let day = printed
        .lines()
        .nth(1)
        .and_then(|line| line.split_once(" = "));
    let (_, day) = day.expect("the day it was measured");
    assert_eq!((folder.read(FILE), folder.read("rig.toml")), (old, rig));
    let kept = format!("{FILE}.bak-{day}");
    let left = folder
        .names()
        .into_iter()
        .filter(|name| *name != kept && name != "bird");
    assert_eq!(left.collect::<Vec<_>>(), names);
    // Copied into the file, it is what would have been written.
    folder.write(FILE, printed);
    let rig = calibrated(&folder, "rig.toml");
    let moves = rig.devices["flock"].correction().expect("it is named");
    let moves = moves.grid().displacements().iter().map(|d| d.length());
    assert!(moves.fold(0.0, f64::max) < 1e-3);
}

#[test]
fn what_tells_no_field_is_refused_before_anything_is_touched() {
    let folder = folder();
    folder.write("rig.toml", with_tip());
    let flat: Vec<_> = pegs([4, 3, 2]).into_iter().take(12).collect();
    write_marks(&folder, "flat.toml", &flat);
    write_marks(&folder, "many.toml", &pegs([3, 3, 2]));
    folder.write("mine.flock-field.toml", "mine");
    for (arguments, says) in [
        (
            "--rig rig.toml --marks marks.toml",
            &[
                "marks.toml",
                "5 samples of the field are too few",
                "at least 8",
            ][..],
        ),
        (
            "--rig rig.toml --marks flat.toml",
            &["flat.toml", "nearly in a plane", "raise some of them"],
        ),
        (
            "--rig rig.toml --marks many.toml -o mine.toml",
            &["mine.flock-field.toml", "never overwritten"],
        ),
    ] {
        folder
            .run(&format!("calibrate field {arguments}"))
            .failed(1, says);
    }
    assert_eq!(folder.read("rig.toml"), with_tip().as_bytes());
    assert_eq!(folder.read("mine.flock-field.toml"), b"mine");

    // Every command tells what is wrong with the file that a rig names.
    shifted(&folder);
    let torn = folder.read(FILE);
    folder.write(FILE, &torn[..torn.len() - 10]);
    for command in ["calibrate check --marks marks.toml", "doctor", "serve-vrpn"] {
        let refused = folder.run(&format!("{command} --rig rig.toml"));
        let says = [
            "rig.toml, line 24",
            "devices.flock.correction",
            FILE,
            "line 7",
            "measure the field anew",
        ];
        refused.failed(1, &says);
    }
}
