//! A tracker whose field is bent: its stream, its recording and the replay of it.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod vrpn_by_hand;
mod waiting;

use glam::{DQuat, DVec3};
use sandtable_config::{Device, Rig};
use sandtable_input::flock::{Layout, Record, RecordedMotion, Scale, layout};
use sandtable_input::recording::ReplayError;
use sandtable_input::{PoseSample, Recorder, Replay, stream_of};
use sandtable_pose::{Nanos, Rigid};
use std::path::Path;

const FLOCK: &str = "kind = 'flock-of-birds'\nport = '/dev/ttyS0'\nbirds = 1\ngroup = false\n\
                     range = 72\nhemisphere = 'upper'\n";
const VRPN: &str = "kind = 'vrpn'\naddress = 'Tracker0@lab-pc'\n";
const DTRACK: &str = "kind = 'dtrack'\n";

/// The tracker lies 0.5 m below the glass, its axes along the table's.
const PLACE: &str = "table_from_tracker = { translation = [0.0, 0.0, -0.5] }\n";

/// Two nodes, 1 m from one another along x, both at z = -1: of what the trackers here say.
const FIELD: &str = "\
calibrated = 2026-11-20
table_from_tracker = { translation = [0.0, 0.0, -0.5], quaternion = [1.0, 0.0, 0.0, 0.0] }
[correction]
origin = [0.0, 0.0, -1.0]
spacing = [1.0, 1.0, 1.0]
counts = [2, 1, 1]
displacements = [[0.02, 0.0, 0.0], [0.04, -0.02, 0.004]]
";

/// A rig in a folder, with and without a correction beside it.
fn rigs(folder: &Path, device: &str) -> [Rig; 2] {
    rigs_in(folder, device, FIELD)
}

/// The same with another field.
fn rigs_in(folder: &Path, device: &str, field: &str) -> [Rig; 2] {
    let text =
        format!("name = 'lab'\ncamera = {{ horizontal_fov = 60.0 }}\n[devices.t]\n{device}{PLACE}");
    let bent = Rig::parse(&text, "lab.toml").unwrap();
    let path = folder.join("lab.toml");
    std::fs::write(&path, text + "correction = 'field.toml'\n").unwrap();
    std::fs::write(folder.join("field.toml"), field).unwrap();
    [Rig::load(&path).unwrap(), bent]
}

fn ms(ms: u64) -> Nanos {
    Nanos(ms * 1_000_000)
}

/// Where the sensor is said to be at a step: tracker frame, metres.
fn told(step: u64) -> DVec3 {
    DVec3::new(0.25 + 0.01 * step as f64, 0.0, -0.5)
}

/// Five reads of each kind of tracker.
fn reads(rig: &Rig) -> Vec<(Nanos, Vec<u8>)> {
    let mut reads = Vec::new();
    for step in 0..5 {
        let place = told(step);
        let bytes = match &rig.devices["t"] {
            Device::Flock(flock) => {
                let mut bytes = Vec::new();
                let words = Scale::of(flock).words(&Rigid::new(DQuat::IDENTITY, place));
                let layout: Layout = layout(flock);
                let record = Record {
                    bird: 1,
                    words,
                    buttons: None,
                };
                layout.encode(&record, &mut bytes);
                bytes
            }
            Device::Vrpn(_) => [
                vrpn_by_hand::sender(1, "Tracker0"),
                vrpn_by_hand::kind(10, "vrpn_Tracker Pos_Quat"),
                vrpn_by_hand::message(
                    1,
                    10,
                    &vrpn_by_hand::pose(0, place.to_array(), [0.0, 0.0, 0.0, 1.0]),
                ),
            ]
            .concat(),
            Device::Dtrack(_) => {
                let [x, y, z] = (1e3 * place).to_array();
                format!("fr {step}\r\n6d 1 [0 1.0][{x} {y} {z} 0 0 0][1 0 0 0 1 0 0 0 1]\r\n")
                    .into_bytes()
            }
            other => panic!("{other:?} is no tracker"),
        };
        reads.push((ms(100 + 16 * step), bytes));
    }
    reads
}

fn poses(rig: &Rig, reads: &[(Nanos, Vec<u8>)]) -> Vec<PoseSample> {
    let mut stream = stream_of(&rig.devices["t"]);
    let mut poses = Vec::new();
    for (arrival, bytes) in reads {
        stream.push(bytes, *arrival, &mut |sample| {
            poses.extend(sample.pose().copied());
        });
    }
    poses
}

#[test]
fn every_trackers_places_are_corrected_and_nothing_else_of_its_samples() {
    for device in [FLOCK, VRPN, DTRACK] {
        let folder = tempfile::tempdir().unwrap();
        let [corrected, bent] = rigs(folder.path(), device);
        let reads = reads(&corrected);
        let (corrected, bent) = (poses(&corrected, &reads), poses(&bent, &reads));
        // The first waits for a second to vouch for it.
        assert_eq!((corrected.len(), bent.len()), (4, 4), "{device}");
        for (step, (corrected, bent)) in (1..).zip(corrected.iter().zip(&bent)) {
            assert_eq!((corrected.time, corrected.sensor), (bent.time, bent.sensor));
            let (now, then) = (corrected.table_from_sensor, bent.table_from_sensor);
            assert_eq!(now.rotation, then.rotation);
            // A Flock's steps are 0.22 mm.
            let along = 0.25 + 0.01 * f64::from(step);
            assert!(
                then.translation.distance(DVec3::new(along, 0.0, -1.0)) < 2e-4,
                "{device}"
            );
            let moved = DVec3::new(0.02 + 0.02 * along, -0.02 * along, 0.004 * along);
            let off = now.translation.distance(then.translation + moved);
            assert!(off < 1e-5, "{device} {step}: {off}");
        }
    }
}

/// What a field does to a pose must not make the gate believe other records.
#[test]
fn the_gate_judges_what_the_tracker_says() {
    // 1 cm in 16 ms is 0.63 m/s by the tracker; corrected it would be 0.88 m/s.
    let steep = FIELD.replace("[0.04", "[0.42");
    for device in [FLOCK, VRPN, DTRACK] {
        let folder = tempfile::tempdir().unwrap();
        let slow = format!("{device}max_speed = 0.75\n");
        let [corrected, bent] = rigs_in(folder.path(), &slow, &steep);
        let reads = reads(&corrected);
        let counts = [&bent, &corrected].map(|rig| poses(rig, &reads).len());
        assert_eq!(counts, [4, 4], "{device}");
    }
}

fn record(path: &Path, rig: &Rig, reads: &[(Nanos, Vec<u8>)]) {
    let recorder = Recorder::create(path, rig, None, Nanos(0)).unwrap();
    for (arrival, bytes) in reads {
        recorder.bytes("t", *arrival, bytes);
    }
    recorder.finish().unwrap();
}

fn replayed(replay: &Replay) -> Vec<PoseSample> {
    let samples = replay.samples("t");
    samples
        .iter()
        .filter_map(|sample| sample.pose().copied())
        .collect()
}

#[test]
fn a_recording_replays_to_the_bit_when_the_correction_has_changed_or_gone() {
    for device in [FLOCK, VRPN, DTRACK] {
        let folder = tempfile::tempdir().unwrap();
        let [corrected, bent] = rigs(folder.path(), device);
        let reads = reads(&corrected);
        let path = folder.path().join("a.mcap");
        record(&path, &corrected, &reads);
        let live = poses(&corrected, &reads);
        let other = FIELD.replace("0.02", "0.3");
        std::fs::write(folder.path().join("field.toml"), other).unwrap();
        assert_eq!(replayed(&Replay::open(&path).unwrap()), live);
        std::fs::remove_file(folder.path().join("field.toml")).unwrap();
        std::fs::remove_file(folder.path().join("lab.toml")).unwrap();
        let replay = Replay::open(&path).unwrap();
        assert_eq!(replay.rig(), &corrected);
        assert_eq!(replayed(&replay), live);
        assert_ne!(live, poses(&bent, &reads));
    }
}

/// A simulated Flock that moves as a recorded one says what that one said, so that whoever hears it
/// corrects it once.
#[test]
fn a_recorded_motion_is_what_the_line_said() {
    let folder = tempfile::tempdir().unwrap();
    let [corrected, bent] = rigs(folder.path(), FLOCK);
    let reads = reads(&corrected);
    let motions = [&corrected, &bent].map(|rig| {
        let path = folder.path().join(format!("{}.mcap", rig.files().len()));
        record(&path, rig, &reads);
        RecordedMotion::of(&Replay::open(&path).unwrap(), "t").unwrap()
    });
    assert_eq!(motions[0], motions[1]);
    let first = motions[0].pose(1, 0.0).unwrap();
    assert!(first.translation.distance(told(1)) < 2e-4);
}

#[test]
fn a_recording_without_files_opens_unless_its_rig_names_one() {
    let folder = tempfile::tempdir().unwrap();
    let [mut corrected, bent] = rigs(folder.path(), DTRACK);
    let reads = reads(&bent);
    let path = folder.path().join("old.mcap");
    record(&path, &bent, &reads);
    assert_eq!(
        replayed(&Replay::open(&path).unwrap()),
        poses(&bent, &reads)
    );

    let path = folder.path().join("lacking.mcap");
    corrected.devices.get_mut("t").unwrap().leave_field_bent();
    record(&path, &corrected, &reads);
    let error = Replay::open(&path).unwrap_err();
    assert!(matches!(error, ReplayError::BadRig { .. }), "{error}");
    for part in ["lacking.mcap", "line 6", "field.toml", "did not come with"] {
        assert!(error.to_string().contains(part), "no {part:?} in {error}");
    }
}
