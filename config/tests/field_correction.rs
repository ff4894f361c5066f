//! Corrections of bent fields: what a rig's line and the file beside it say, and what is refused.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use glam::{DQuat, DVec3, UVec3};
use sandtable_config::{Calibrated, Device, FieldCorrection, Rig, RigError};
use sandtable_field::Correction;
use sandtable_pose::Rigid;
use std::collections::BTreeMap;
use std::path::PathBuf;
use time::{Date, Month};

const FLOCK: &str = "kind = 'flock-of-birds'\nport = '/dev/ttyS0'\nbirds = 1\nrange = 72\n\
                     hemisphere = 'upper'\n";

/// Two nodes a metre apart, x running from one to the other, of a tracker that stands turned.
const FILE: &str = "\
calibrated = 2026-11-20
table_from_tracker = { translation = [0.0, 0.5, -0.25], quaternion = [0.0, 1.0, 0.0, 0.0] }

[correction]
origin = [0.0, 0.0, 0.0]
spacing = [1.0, 1.0, 1.0]
counts = [2, 1, 1]
displacements = [
    [0.01, 0.0, 0.0],
    [0.03, -0.02, 0.004],
]
";

fn rig_text(device: &str) -> String {
    format!(
        "name = 'lab'\ncamera = {{ horizontal_fov = 60.0 }}\n[devices.t]\n{device}\
         table_from_tracker = {{ translation = [0.0, 0.5, -0.25], axes = ['x', '-y', '-z'] }} # by ruler\n\
         correction = 'lab.t-field.toml'\n"
    )
}

fn with(device: &str, file: &str) -> Result<Rig, RigError> {
    let files = BTreeMap::from([("lab.t-field.toml".to_owned(), file.to_owned())]);
    Rig::parse_with(&rig_text(device), "lab.toml", &files)
}

fn correction(device: &str, file: &str) -> FieldCorrection {
    with(device, file).unwrap().devices["t"]
        .correction()
        .unwrap()
        .clone()
}

fn day() -> Date {
    Date::from_calendar_date(2026, Month::November, 20).unwrap()
}

#[test]
fn every_tracker_reads_it_and_moves_places_by_what_its_numbers_say() {
    for device in [
        FLOCK,
        "kind = 'vrpn'\naddress = 'T@h'\n",
        "kind = 'dtrack'\n",
    ] {
        let correction = correction(device, FILE);
        assert_eq!(correction.calibrated(), day());
        assert_eq!(correction.file(), "lab.t-field.toml");
        let turn = DQuat::from_rotation_y(0.3);
        // A quarter of the way: 0.75 of the first node, 0.25 of the second.
        let corrected = correction.apply(&Rigid::new(turn, DVec3::new(0.25, 0.0, 0.0)));
        let expected = DVec3::new(0.25 + 0.015, -0.005, 0.001);
        assert!(corrected.translation.distance(expected) < 1e-15);
        assert_eq!(corrected.rotation, turn);
    }
    let Device::Dtrack(dtrack) = &with("kind = 'dtrack'\n", FILE).unwrap().devices["t"] else {
        panic!("it is one");
    };
    // 0.25 m beyond the grid half of it is left.
    let told = Rigid::new(DQuat::IDENTITY, DVec3::new(1.0, 0.25, -0.25));
    let table = dtrack.tracking.table_from_sensor(&told).translation;
    let expected = DVec3::new(1.0 + 0.015, 0.25 - 0.01, 0.002);
    assert!(table.distance(expected) < 1e-15, "{table}");
}

#[test]
fn a_rig_reads_it_from_its_own_folder_and_gives_its_text_away() {
    let folder = Folder::new("own");
    folder.write("lab.toml", &rig_text(FLOCK));
    folder.write("lab.t-field.toml", FILE);
    let rig = Rig::load(&folder.0.join("lab.toml")).unwrap();
    let files = BTreeMap::from([("lab.t-field.toml".to_owned(), FILE.to_owned())]);
    assert_eq!(rig.files(), files);
    assert_eq!(Rig::parse_with(rig.text(), "again", &files).unwrap(), rig);
    let mut straight = rig.clone();
    straight.devices.get_mut("t").unwrap().leave_field_bent();
    assert_eq!(straight.devices["t"].correction(), None);
    assert_eq!(straight.files(), BTreeMap::new());

    folder.write("lab.t-field.toml", &FILE[..FILE.len() - 3]);
    let torn = Rig::load(&folder.0.join("lab.toml")).unwrap_err();
    says(&torn, &["cannot be used (line 10", "calibrate field"]);
    std::fs::remove_file(folder.0.join("lab.t-field.toml")).unwrap();
    let missing = Rig::load(&folder.0.join("lab.toml")).unwrap_err();
    says(&missing, &["cannot be read (", "remove this line"]);
    std::fs::create_dir(folder.0.join("lab.t-field.toml")).unwrap();
    let no_file = Rig::load(&folder.0.join("lab.toml")).unwrap_err();
    says(&no_file, &["it is no plain file"]);
}

/// The rig, its line, the key and the file are always named.
#[track_caller]
fn says(error: &RigError, parts: &[&str]) {
    let error = error.to_string();
    assert!(
        error.contains("lab.toml, line 10: `devices.t.correction`"),
        "{error}"
    );
    for part in ["\"lab.t-field.toml\"", "; "].iter().chain(parts) {
        assert!(error.contains(part), "no {part:?} in {error}");
    }
}

#[test]
fn a_file_that_is_none_is_refused_by_rig_line_file_and_remedy() {
    for (from, to, parts) in [
        (
            "calibrated = 2026-11-20",
            "",
            &["missing field `calibrated`"][..],
        ),
        ("2026-11-20", "2026-11-20T10:00:00", &["no day"]),
        ("[correction]", "[corection]", &["line 4", "corection"]),
        (
            "counts = [2, 1, 1]",
            "counts = [2, 1, 2]",
            &["2 displacements, where 4 nodes"],
        ),
        ("counts = [2, 1, 1]", "counts = [2, -1, 1]", &["line 7"]),
        (
            "spacing = [1.0, 1.0",
            "spacing = [1.0, 0.0",
            &["spacing must be finite"],
        ),
        ("0.03", "nan", &["displacements must be finite"]),
        ("0.03", "inf", &["displacements must be finite"]),
        ("0.03", "30.0", &["by up to 30.00 m", "more than 0.5 m"]),
        ("origin = [0.0", "origin = [1e6", &["beyond 100 m"]),
        (
            "[0.0, 0.5, -0.25]",
            "[0.0, 0.5, -0.26]",
            &["another `table_from_tracker`"],
        ),
        (
            "[0.0, 1.0, 0.0, 0.0]",
            "[1.0, 0.0, 0.0, 0.0]",
            &["another `table_from_tracker`"],
        ),
        ("    [0.03", "# cut\n    [0.03, 'a", &["line 12"]),
    ] {
        let file = FILE.replacen(from, to, 1);
        assert_ne!(file, FILE);
        says(&with(FLOCK, &file).unwrap_err(), parts);
    }
    // The same attitude, written otherwise.
    let turned = FILE.replace("[0.0, 1.0, 0.0, 0.0]", "[0.0, -1.0, 0.0, 0.0]");
    assert!(with(FLOCK, &turned).is_ok());
    says(
        &Rig::parse(&rig_text(FLOCK), "lab.toml").unwrap_err(),
        &["did not come with"],
    );
    for cut in 0..FILE.len() - 1 {
        says(&with(FLOCK, &FILE[..cut]).unwrap_err(), &["cannot be used"]);
    }
}

#[test]
fn a_rig_names_no_file_outside_its_folder() {
    let folder = "write the name of a file in the rig's folder";
    for (name, shown) in [
        ("'/etc/passwd'", ["/etc/passwd", folder]),
        ("'../lab.toml'", ["../lab.toml", folder]),
        ("''", ["\"\"", folder]),
        ("7", ["is a number", "in quotes"]),
    ] {
        let text = rig_text(FLOCK).replace("'lab.t-field.toml'", name);
        let error = Rig::parse(&text, "lab.toml").unwrap_err().to_string();
        let line = "lab.toml, line 10: `devices.t.correction`";
        for part in [line].iter().chain(&shown) {
            assert!(error.contains(*part), "no {part:?} in {error}");
        }
    }
}

#[test]
fn what_is_composed_is_read_to_the_micrometre_and_composed_again_the_same() {
    let field = |p: DVec3| 0.01 * DVec3::new((2.0 * p.x).sin(), p.y * p.z, -(p.x + p.y).cos());
    let counts = UVec3::new(5, 4, 3);
    let origin = DVec3::new(-0.912_345_678_9, -0.55, 0.1);
    let measured = Correction::sampled(origin, DVec3::splat(0.1), counts, field).unwrap();
    let rotation = DQuat::from_rotation_x(std::f64::consts::PI);
    let place = Rigid::new(rotation, DVec3::new(0.0, 0.5, -0.25));
    let text = FieldCorrection::compose("t", &measured, &place, day());
    assert!(
        text.starts_with("# How the field of the tracker `t` is bent"),
        "{text}"
    );
    let read = correction(FLOCK, &text);
    assert_eq!(read.grid().counts(), counts);
    for (read, measured) in read
        .grid()
        .displacements()
        .iter()
        .zip(measured.displacements())
    {
        assert!((*read - *measured).abs().max_element() <= 0.501e-6);
    }
    assert!(read.grid().origin().distance(origin) < 1e-9);
    assert_eq!(
        FieldCorrection::compose("t", read.grid(), &place, day()),
        text
    );
}

#[test]
fn a_correction_is_named_in_place_and_dropped_when_the_tracker_is_calibrated_anew() {
    let named = rig_text(FLOCK);
    let plain = named.replace("correction = 'lab.t-field.toml'\n", "# The end.\n");
    let entry = |file: &str| Calibrated::Field {
        device: "t".into(),
        file: file.into(),
    };
    let written = entry("lab.t-field.toml")
        .write_into(&plain, "lab.toml", day())
        .unwrap();
    let added = "# by ruler\ncorrection = \"lab.t-field.toml\"\n# The end.\n";
    assert_eq!(written, plain.replace("# by ruler\n# The end.\n", added));
    let commented = named.replace(".toml'\n", ".toml' # mine\n");
    let renamed = entry("b.toml")
        .write_into(&commented, "lab.toml", day())
        .unwrap();
    assert_eq!(
        renamed,
        commented.replace("'lab.t-field.toml'", "\"b.toml\"")
    );
    let tracker = Calibrated::Tracker {
        device: "t".into(),
        table_from_tracker: Rigid::IDENTITY,
    };
    let moved = tracker.write_into(&named, "lab.toml", day()).unwrap();
    assert!(
        !moved.contains("correction") && moved.contains("calibrated = 2026-11-20"),
        "{moved}"
    );
    assert!(Rig::parse(&moved, "lab.toml").is_ok());
    let other = Calibrated::Field {
        device: "u".into(),
        file: "a.toml".into(),
    };
    let refused = other.write_into(&plain, "lab.toml", day()).unwrap_err();
    assert!(matches!(refused, RigError::NoSensor { .. }), "{refused}");
}

/// A folder that goes away with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let name = format!("sandtable-field-{name}-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.join(name), text).unwrap();
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
