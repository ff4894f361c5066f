//! Recordings: what was recorded comes back, whole or up to the damage, and never another pose.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use sandtable_config::{Device, Rig, SensorName};
use sandtable_input::flock::{
    Action, FlockStream, Motion, RecordedMotion, Scale, SimulatedFlock, SimulatorSettings, startup,
};
use sandtable_input::recording::{DeviceEvent, RecordError, ReplayError};
use sandtable_input::{Hub, PoseSample, Recorder, Replay, Sample, Stream};
use sandtable_pose::{Nanos, Pose};
use serde_json::{Value, json};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The reads of a simulated Flock's first `cycles` cycles, each with its time.
fn reads(rig: &Rig, cycles: u64) -> Vec<(Nanos, Vec<u8>)> {
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    let mut device = SimulatedFlock::new(SimulatorSettings {
        motions: vec![Motion::named("circle").unwrap()],
        ..SimulatorSettings::default()
    });
    let mut now = Duration::ZERO;
    for step in startup(flock) {
        match step.action {
            Action::Send(bytes) => device.receive(&bytes, now),
            Action::ExamineStatus | Action::PulseRts(_) => {}
        }
        now += step.silence;
    }
    (1..=cycles)
        .map(|cycle| {
            let since = Duration::from_micros(9_681 * cycle);
            let bytes = device.send(now + since);
            (Nanos(1_000_000_000) + since, bytes)
        })
        .collect()
}

fn placement() -> Value {
    // Numbers that survive only an exact way there and back.
    json!({ "anchor": [0.1 + 0.2, 1.0 / 3.0, -1e-300], "yaw": 0.7, "scale": 12_345.678_901_234_567 })
}

fn record(path: &Path, reads: &[(Nanos, Vec<u8>)]) -> Vec<PoseSample> {
    let rig = Rig::builtin("workbench").unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    let recorder = Recorder::create(path, &rig, Some(&placement()), Nanos(500)).unwrap();
    recorder.event("flock", Nanos(1000), DeviceEvent::Started);
    let mut stream = FlockStream::new(flock);
    let mut samples = Vec::new();
    for (arrival, bytes) in reads {
        recorder.bytes("flock", *arrival, bytes);
        stream.push(bytes, *arrival, &mut |sample| {
            let Sample::Pose(sample) = sample else {
                return;
            };
            recorder.pose("flock", sample);
            samples.push(sample);
        });
    }
    let summary = recorder.finish().unwrap().unwrap();
    assert_eq!(summary.dropped, 0);
    assert_eq!(summary.messages as usize, 3 + reads.len() + samples.len());
    assert_eq!(summary.bytes, std::fs::metadata(path).unwrap().len());
    samples
}

/// Every pose of a sensor that a hub has, the oldest first.
fn poses(hub: &Hub, number: u32) -> Vec<Pose> {
    let sensor = SensorName {
        device: "flock".into(),
        number,
    };
    let mut poses = Vec::new();
    let mut time = Nanos(u64::MAX);
    while let Some(pose) = hub.pose_at(&sensor, time) {
        time = pose.time - Duration::from_nanos(1);
        // As it was when it was young.
        poses.extend(hub.pose_at(&sensor, pose.time));
    }
    poses.reverse();
    poses
}

/// The poses that a recording gives, or why it gives none.
fn replayed(path: &Path) -> Result<(Vec<Pose>, Option<String>), ReplayError> {
    let mut replay = Replay::open(path)?;
    let hub = Hub::for_rig(replay.rig());
    replay.advance_to(Nanos(u64::MAX), &hub);
    assert!(replay.is_over());
    let all = [poses(&hub, 1), poses(&hub, 2)].concat();
    Ok((all, replay.cut().map(str::to_owned)))
}

fn file(folder: &tempfile::TempDir, name: &str) -> PathBuf {
    folder.path().join(name)
}

#[test]
fn what_was_recorded_comes_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "a.mcap");
    let rig = Rig::builtin("workbench").unwrap();
    let reads = reads(&rig, 150);
    let samples = record(&path, &reads);
    assert!(samples.len() > 290);
    let mut replay = Replay::open(&path).unwrap();
    assert_eq!(replay.rig().text(), rig.text());
    assert_eq!(replay.placement(), Some(&placement()));
    assert_eq!(replay.start(), Nanos(500));
    assert_eq!(replay.end(), reads.last().unwrap().0);
    assert_eq!(replay.cut(), None);
    let hub = Hub::for_rig(replay.rig());
    // Twice, and by steps that are no multiple of anything.
    for step in [7_000_001, 123_456_789] {
        let mut time = Nanos(0);
        while !replay.is_over() {
            time = time + Duration::from_nanos(step);
            replay.advance_to(time, &hub);
        }
        for number in 1..=2 {
            let sent: Vec<_> = samples.iter().filter(|s| s.sensor == number).collect();
            let got = poses(&hub, number);
            assert_eq!(got.len(), sent.len());
            for (pose, sample) in got.iter().zip(sent) {
                assert_eq!(pose.time, sample.time);
                assert_eq!(pose.frame_from_body, sample.table_from_sensor);
            }
        }
        replay.rewind();
        hub.clear();
    }
}

#[test]
fn a_recorded_flock_moves_a_simulated_one_as_it_moved() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "motion.mcap");
    let rig = Rig::builtin("workbench").unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    let samples = record(&path, &reads(&rig, 150));
    let replay = Replay::open(&path).unwrap();
    assert_eq!(replay.samples("glove"), []);
    assert_eq!(RecordedMotion::of(&replay, "glove"), None);
    let motion = RecordedMotion::of(&replay, "flock").unwrap();
    assert_eq!(motion.birds(), 2);
    let scale = Scale::of(flock);
    let tracker_from_table = flock.table_from_tracker.inverse();
    let first = samples.iter().map(|sample| sample.time).min().unwrap();
    let last = samples.iter().map(|sample| sample.time).max().unwrap();
    for sample in samples.iter().filter(|sample| sample.time < last) {
        let seconds = sample.time.since(first).as_secs_f64() + 1e-7;
        // On the line they are the same words.
        let words = scale.words(&(tracker_from_table * sample.table_from_sensor));
        let again = motion.pose(sample.sensor, seconds).unwrap();
        let off = scale
            .words(&again)
            .iter()
            .zip(words.iter())
            .map(|(a, b)| a.abs_diff(*b))
            .max();
        assert!(off <= Some(4), "{sample:?} {off:?}");
        // And once more, when it begins anew.
        let round = last.since(first).as_secs_f64();
        assert_eq!(motion.pose(sample.sensor, seconds + round), Some(again));
    }
    assert_eq!(motion.pose(3, 0.0), None);
}

#[test]
fn the_virtual_clock_gives_what_had_arrived_and_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "a.mcap");
    let reads = reads(&Rig::builtin("workbench").unwrap(), 40);
    record(&path, &reads);
    let mut replay = Replay::open(&path).unwrap();
    let hub = Hub::for_rig(replay.rig());
    let tenth = reads[10].0;
    replay.advance_to(tenth - Duration::from_nanos(1), &hub);
    let before = poses(&hub, 2).len();
    replay.advance_to(tenth, &hub);
    assert_eq!(poses(&hub, 2).len(), before + 1);
}

#[test]
fn other_values_come_back_under_their_topic() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "a.mcap");
    let rig = Rig::builtin("desktop").unwrap();
    let recorder = Recorder::create(&path, &rig, None, Nanos(0)).unwrap();
    recorder.placement(Nanos(7), placement());
    for i in 0..3 {
        recorder.json("/session/flight", Nanos(i), json!({ "forward": i }));
    }
    drop(recorder);
    let replay = Replay::open(&path).unwrap();
    assert_eq!(
        replay.values("/session/flight")[2],
        (Nanos(2), json!({ "forward": 2 }))
    );
    assert_eq!(replay.placement(), Some(&placement()));
    assert!(replay.values("/session/none").is_empty());
}

#[test]
fn viewers_find_poses_with_their_schema() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "a.mcap");
    let samples = record(&path, &reads(&Rig::builtin("workbench").unwrap(), 20));
    let bytes = std::fs::read(&path).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/poses/flock/2")
        .collect();
    let schema = messages[0].channel.schema.as_ref().unwrap();
    assert_eq!(schema.name, "foxglove.PoseInFrame");
    assert_eq!(schema.encoding, "jsonschema");
    let pose: Value = serde_json::from_slice(&messages[0].data).unwrap();
    let first = samples.iter().find(|s| s.sensor == 2).unwrap();
    assert_eq!(
        pose["pose"]["position"]["z"],
        json!(first.table_from_sensor.translation.z)
    );
    assert_eq!(pose["timestamp"]["sec"], json!(1));
    assert_eq!(pose["frame_id"], json!("table"));
}

#[test]
fn an_existing_file_is_never_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "a.mcap");
    std::fs::write(&path, "precious").unwrap();
    let rig = Rig::builtin("desktop").unwrap();
    let error = Recorder::create(&path, &rig, None, Nanos(0)).unwrap_err();
    assert!(matches!(error, RecordError::Exists { .. }));
    assert!(error.to_string().contains("a.mcap"), "{error}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");
    let nowhere = file(&folder, "none/a.mcap");
    let error = Recorder::create(&nowhere, &rig, None, Nanos(0)).unwrap_err();
    assert!(matches!(error, RecordError::Create { .. }), "{error}");
}

#[test]
fn a_recording_is_readable_while_it_is_being_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "a.mcap");
    let rig = Rig::builtin("workbench").unwrap();
    let recorder = Recorder::create(&path, &rig, None, Nanos(0)).unwrap();
    for (arrival, bytes) in reads(&rig, 30) {
        recorder.bytes("flock", arrival, &bytes);
    }
    // Nothing ends it: this is what a crash leaves behind.
    let start = Instant::now();
    loop {
        if let Ok((poses, cut)) = replayed(&path)
            && poses.len() == 58
        {
            assert!(cut.unwrap().contains("breaks off"));
            break;
        }
        assert!(
            start.elapsed() < Duration::from_secs(20),
            "nothing reached the disk"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_recording_cut_at_any_byte_replays_up_to_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "cut.mcap");
    // More than one chunk of it.
    record(&path, &reads(&Rig::builtin("workbench").unwrap(), 150));
    let (whole, _) = replayed(&path).unwrap();
    let cutting = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    let length = cutting.metadata().unwrap().len();
    let mut counts = std::collections::BTreeSet::new();
    for length in (0..length).rev().step_by(5) {
        cutting.set_len(length).unwrap();
        let count = match replayed(&path) {
            Ok((poses, cut)) => {
                assert!(
                    poses.iter().all(|pose| whole.contains(pose)),
                    "cut at {length}"
                );
                // Its end proper begins where all poses are in it.
                assert!(
                    cut.is_some() || poses.len() == whole.len(),
                    "cut at {length}"
                );
                poses.len()
            }
            Err(error) => {
                assert!(error.to_string().contains("cut.mcap"), "{error}");
                0
            }
        };
        // The more is cut off, the less is left.
        assert!(
            counts.first().is_none_or(|&least| count <= least),
            "cut at {length}"
        );
        counts.insert(count);
    }
    assert!(counts.contains(&0) && counts.contains(&whole.len()));
    assert!(counts.len() > 2, "{counts:?}");
}

#[test]
fn a_turned_bit_never_gives_another_pose() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "bad.mcap");
    record(&path, &reads(&Rig::builtin("workbench").unwrap(), 12));
    let (whole, _) = replayed(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    let mut write = |at: usize, byte: u8| {
        file.seek(SeekFrom::Start(at as u64)).unwrap();
        file.write_all(&[byte]).unwrap();
    };
    let mut damaged = 0;
    for (at, &byte) in bytes.iter().enumerate() {
        write(at, byte ^ (1 << (at % 8)));
        match replayed(&path) {
            Ok((poses, None)) => assert_eq!(poses, whole, "byte {at}"),
            Ok((poses, Some(_))) => {
                damaged += 1;
                assert!(poses.iter().all(|pose| whole.contains(pose)), "byte {at}");
            }
            Err(error) => {
                damaged += 1;
                assert!(error.to_string().contains("bad.mcap"), "byte {at}: {error}");
            }
        }
        write(at, byte);
    }
    assert!(damaged > 0);
}

#[test]
fn a_recording_damaged_before_its_rig_is_to_be_copied_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "fl.mcap");
    record(&path, &reads(&Rig::builtin("workbench").unwrap(), 12));
    let whole = std::fs::read(&path).unwrap();
    // Within the first chunk, and before it.
    let mut turned = whole.clone();
    turned[200] ^= 1;
    for (bytes, says) in [(&turned[..], "the chunk at byte"), (&whole[..20], "byte 8")] {
        std::fs::write(&path, bytes).unwrap();
        let error = Replay::open(&path).unwrap_err();
        assert!(
            matches!(error, ReplayError::DamagedBeginning { .. }),
            "{error}"
        );
        let said = error.to_string();
        assert!(said.contains("fl.mcap") && said.contains(says), "{said}");
        assert!(
            said.contains("; copy the file again from where it was recorded"),
            "{said}"
        );
    }
}

#[test]
fn what_is_no_recording_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("empty", &b""[..]), ("text", b"hello, this is text")] {
        let path = file(&folder, name);
        std::fs::write(&path, bytes).unwrap();
        let error = Replay::open(&path).unwrap_err();
        assert!(matches!(error, ReplayError::NotMcap { .. }));
        assert!(error.to_string().contains(name), "{error}");
    }
    let error = Replay::open(&file(&folder, "none")).unwrap_err();
    assert!(matches!(error, ReplayError::Unreadable { .. }), "{error}");
    assert!(Replay::open(folder.path()).is_err());
    assert!(Replay::open(Path::new("/dev/zero")).is_err());
    // Another program's MCAP file.
    let path = file(&folder, "other.mcap");
    let other = std::fs::File::create(&path).unwrap();
    mcap::Writer::new(other).unwrap().finish().unwrap();
    let error = Replay::open(&path).unwrap_err();
    assert!(matches!(error, ReplayError::NoRig { .. }), "{error}");
}

/// Names the folder for the part of the next test that runs on a small disk.
#[cfg(target_os = "linux")]
const SMALL_DISK: &str = "SANDTABLE_TEST_SMALL_DISK";

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_recording_with_one_message_and_leaves_it_whole() {
    if let Some(folder) = std::env::var_os(SMALL_DISK) {
        return record_until_full(&PathBuf::from(folder).join("full.mcap"));
    }
    let folder = tempfile::tempdir().unwrap();
    let script = "mount -t tmpfs -o size=128k small \"$0\" && exec \"$1\" --exact \
        a_full_disk_ends_the_recording_with_one_message_and_leaves_it_whole --nocapture";
    let run = std::process::Command::new("unshare")
        .args(["-rm", "sh", "-c", script])
        .arg(folder.path())
        .arg(std::env::current_exe().unwrap())
        .env(SMALL_DISK, folder.path())
        .output();
    match run {
        Ok(output) if output.status.success() => {
            assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"));
        }
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let refused = ["unshare:", "mount:"].iter().any(|by| said.starts_with(by));
            assert!(refused, "{said}{}", String::from_utf8_lossy(&output.stdout));
            println!(
                "skipped: this system gives no small disk of our own ({})",
                said.trim()
            );
        }
        Err(error) => println!("skipped: unshare cannot be run ({error})"),
    }
}

#[cfg(target_os = "linux")]
fn record_until_full(path: &Path) {
    let rig = Rig::builtin("workbench").unwrap();
    let recorder = Recorder::create(path, &rig, None, Nanos(0)).unwrap();
    let reads = reads(&rig, 200);
    for (arrival, bytes) in &reads {
        recorder.bytes("flock", *arrival, bytes);
    }
    let start = Instant::now();
    let mut noise = 1u32;
    while recorder.problem().is_none() {
        // Bytes that do not compress fill it soon.
        let bytes: Vec<u8> = (0..512)
            .map(|_| {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (noise >> 24) as u8
            })
            .collect();
        recorder.bytes("other", reads[199].0, &bytes);
        assert!(
            start.elapsed() < Duration::from_secs(20),
            "the disk never filled"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    let problem = recorder.problem().unwrap();
    assert!(
        problem.contains("full.mcap") && problem.contains("space"),
        "{problem}"
    );
    assert!(recorder.finish().is_err());
    assert!(recorder.finish().unwrap().is_none());
    let (poses, cut) = replayed(path).unwrap();
    assert_eq!(poses.len(), 2 * 199);
    assert!(cut.unwrap().contains("breaks off at byte"));
}
