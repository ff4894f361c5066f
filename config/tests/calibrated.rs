//! What is measured goes into a rig's text, and nothing else of it changes.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use glam::{DQuat, DVec3, EulerRot};
use sandtable_config::{Calibrated, Device, Rig, RigError};
use sandtable_pose::Rigid;
use time::{Date, Month};

fn date() -> Date {
    Date::from_calendar_date(2026, Month::November, 21).unwrap()
}

fn workbench() -> &'static str {
    Rig::builtin_text("workbench").unwrap()
}

fn tracker() -> (Calibrated, Rigid) {
    let rotation = DQuat::from_euler(EulerRot::ZYX, 2.9, -0.4, 0.1);
    let table_from_tracker = Rigid::new(rotation, DVec3::new(0.25, 0.7, -0.312_345_678));
    let entry = Calibrated::Tracker {
        device: "flock".into(),
        table_from_tracker,
    };
    (entry, table_from_tracker)
}

fn eyes() -> Calibrated {
    Calibrated::Eyes {
        middle: DVec3::new(0.05, 0.001, 0.02),
        rightwards: DVec3::new(0.1, 1.0, 0.0).normalize(),
        interpupillary: 0.0642,
    }
}

fn stylus() -> Calibrated {
    Calibrated::Stylus {
        sensor: Rig::builtin("workbench")
            .unwrap()
            .sensor("flock/2")
            .unwrap(),
        tip: DVec3::new(0.12, -0.003, 0.0),
    }
}

/// The lines of `new` that `old` does not have, and the other way round.
fn changed<'a>(old: &'a str, new: &'a str) -> (Vec<&'a str>, Vec<&'a str>) {
    let without = |from: &'a str, other: &str| {
        from.lines()
            .filter(|line| !other.lines().any(|l| l == *line))
            .collect()
    };
    (without(old, new), without(new, old))
}

#[test]
fn a_tracker_changes_one_line_and_reads_as_it_was_measured() {
    let (entry, truth) = tracker();
    let written = entry.write_into(workbench(), "w.toml", date()).unwrap();
    let (old, new) = changed(workbench(), &written);
    assert_eq!((old.len(), new.len()), (1, 1), "{new:#?}");
    assert!(new[0].starts_with("table_from_tracker = { translation = [0.25, 0.7, -0.312346], "));
    assert!(
        new[0].ends_with(", calibrated = 2026-11-21 }"),
        "{}",
        new[0]
    );
    let rig = Rig::parse(&written, "w.toml").unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    assert_eq!(flock.calibrated, Some(date()));
    let off = flock.table_from_tracker.inverse() * truth;
    assert!(off.translation.length() < 1e-6);
    assert!(off.rotation.angle_between(DQuat::IDENTITY) < 1e-7);
    // The next one replaces it.
    let again = entry.write_into(&written, "w.toml", date()).unwrap();
    assert_eq!(again, written);
}

#[test]
fn entries_keep_their_comments_however_they_are_written() {
    let line = workbench()
        .lines()
        .find(|line| line.starts_with("table_from_tracker"))
        .unwrap();
    let (entry, truth) = tracker();
    for (form, kept) in [
        (format!("{line} # by ruler"), "# by ruler"),
        (
            "[devices.flock.table_from_tracker] # a table of its own\n# where\n\
             translation = [0, 0, 0] # the corner\naxes = [\"x\", \"y\", \"z\"]\n"
                .to_owned(),
            "# a table of its own\n# where\ntranslation = [0.25, 0.7, -0.312346] # the corner\n",
        ),
        (
            "table_from_tracker.translation = [0, 0, 0] # dots\n\
             table_from_tracker.angles = [1, 2, 3]"
                .to_owned(),
            "= [0.25, 0.7, -0.312346] # dots\n",
        ),
    ] {
        let text = workbench().replacen(line, &form, 1);
        let written = entry.write_into(&text, "w.toml", date()).unwrap();
        assert!(written.contains(kept), "{written}");
        let rig = Rig::parse(&written, "w.toml").unwrap();
        let Device::Flock(flock) = &rig.devices["flock"] else {
            panic!("the workbench has a Flock");
        };
        let off = flock.table_from_tracker.translation - truth.translation;
        assert!(off.length() < 1e-6, "{written}");
    }
}

#[test]
fn a_stylus_comes_at_the_end_and_is_then_changed_in_place() {
    let written = stylus().write_into(workbench(), "w.toml", date()).unwrap();
    let (before, table) = written.split_once("[stylus]\n").unwrap();
    assert!(before.starts_with(workbench()), "{written}");
    assert_eq!(
        table,
        "sensor = \"flock/2\"\ntip = [0.12, -0.003, 0.0]\ncalibrated = 2026-11-21\n"
    );
    let other = written.replace("[0.12, -0.003, 0.0]", "[0.2, 0, 0] # long");
    let again = stylus().write_into(&other, "w.toml", date()).unwrap();
    assert_eq!(again, written.replace("0.0]\ncal", "0.0] # long\ncal"));
    let stylus = Rig::parse(&again, "w.toml").unwrap().stylus.unwrap();
    assert_eq!(stylus.tip, DVec3::new(0.12, -0.003, 0.0));
    assert_eq!(stylus.sensor.to_string(), "flock/2");
}

#[test]
fn a_comment_at_the_end_stays_before_what_is_added() {
    for end in ["# The end.\n", "# The end."] {
        let text = workbench().to_owned() + end;
        let written = stylus().write_into(&text, "w.toml", date()).unwrap();
        let (before, _) = written.split_once("\n\n# Marks are touched").unwrap();
        assert!(before.ends_with("\n# The end."), "{written}");
        assert_eq!(written.matches("# The end.").count(), 1, "{written}");
    }
}

#[test]
fn eyes_change_one_line_and_line_ends_stay() {
    let dos = workbench().replace('\n', "\r\n");
    let written = eyes().write_into(&dos, "w.toml", date()).unwrap();
    assert_eq!(
        written.matches('\n').count(),
        written.matches("\r\n").count()
    );
    let (old, new) = changed(&dos, &written);
    assert_eq!((old.len(), new.len()), (1, 1), "{new:#?}");
    let eyes = Rig::parse(&written, "w.toml").unwrap().head.unwrap().eyes;
    assert_eq!(eyes.middle, DVec3::new(0.05, 0.001, 0.02));
    assert_eq!(
        (eyes.interpupillary, eyes.calibrated),
        (0.0642, Some(date()))
    );
    assert!((eyes.rightwards - DVec3::new(0.1, 1.0, 0.0).normalize()).length() < 1e-8);
}

#[test]
fn what_does_not_belong_to_the_rig_is_refused() {
    let desktop = Rig::builtin_text("desktop").unwrap();
    let refused = |entry: &Calibrated| entry.write_into(desktop, "d.toml", date()).unwrap_err();
    assert!(matches!(refused(&eyes()), RigError::NoHead { .. }));
    assert!(matches!(refused(&stylus()), RigError::NoSensor { .. }));
    assert!(matches!(refused(&tracker().0), RigError::NoSensor { .. }));
    let (torn, _) = workbench().split_once("interpupillary").unwrap();
    let error = eyes().write_into(torn, "w.toml", date()).unwrap_err();
    assert!(error.to_string().contains("w.toml, line"), "{error}");
}

#[test]
fn a_day_is_a_day() {
    for (day, says) in [
        ("2026-11-31", "line"),
        ("2026-11-21T10:00:00", "2026-11-21"),
        ("\"today\"", "a date such as"),
    ] {
        let text = workbench().replacen(
            "interpupillary = 0.063",
            &format!("interpupillary = 0.063, calibrated = {day}"),
            1,
        );
        let error = Rig::parse(&text, "w.toml").unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}
