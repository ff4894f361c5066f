//! The whole way of a frame: a simulated Flock on a pseudo-terminal, the driver, the rig, two eyes,
//! two images; and the same from the recording.
#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use glam::{DVec2, DVec3};
use sandtable_cast::{Brute, CastPool, Caster, Coherent, Image, Scene};
use sandtable_config::{Device, Rig, SensorName, Viewing};
use sandtable_input::flock::{Motion, Simulator, SimulatorSettings};
use sandtable_input::{Clock, Devices, Hub, Recorder, Replay};
use sandtable_pose::{Nanos, Rigid, Validity};
use sandtable_tests::{Marker, centroid, marked_plane};
use sandtable_view::{EyesInHead, Placement, Screen, StereoPair, View};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [600, 366];
/// The way that the head goes to the right, in metres.
const SWAY: f64 = 0.1;
/// The world is the table, moved so that its ground has no negative coordinates.
const PLACEMENT: Placement = Placement {
    anchor: DVec3::new(1.5, 1.2, 0.0),
    yaw: 0.0,
    scale: 1.0,
    exaggeration: 1.0,
};

/// The workbench with its Flock at `port`, its silences short so that the test is.
fn workbench(port: &Path) -> Rig {
    let mut rig = Rig::builtin("workbench").unwrap();
    rig.set_port("flock", port).unwrap();
    let Some(Device::Flock(flock)) = rig.devices.get_mut("flock") else {
        panic!("the workbench has a Flock");
    };
    flock.silence_before = Duration::from_millis(50);
    flock.silence_after = Duration::from_millis(300);
    rig
}

fn screen(rig: &Rig) -> Screen {
    let Viewing::Table(table) = &rig.viewing else {
        panic!("the workbench is a table");
    };
    Screen {
        lower_left: table.lower_left,
        lower_right: table.lower_right,
        upper_left: table.upper_left,
    }
}

fn eyes_in_head(rig: &Rig) -> EyesInHead {
    let eyes = rig.head.as_ref().unwrap().eyes;
    EyesInHead {
        middle: eyes.middle,
        rightwards: eyes.rightwards,
        interpupillary: eyes.interpupillary,
    }
}

fn head_sensor(rig: &Rig) -> SensorName {
    rig.head.as_ref().unwrap().sensor.clone().unwrap()
}

/// Where the hub has the head at `time`, while it may be trusted.
fn head(hub: &Hub, rig: &Rig, time: Nanos) -> Option<Rigid> {
    hub.pose_at(&head_sensor(rig), time)
        .filter(|pose| pose.validity != Validity::Lost)
        .map(|pose| pose.frame_from_body)
}

fn views(rig: &Rig, head: &Rigid) -> [View; 2] {
    let eyes = eyes_in_head(rig).on_table(head);
    StereoPair::<View>::on_table(eyes, &screen(rig), &PLACEMENT, SIZE).into_array()
}

fn cast(caster: &dyn Caster, scene: &Arc<Scene>, views: &[View]) -> Vec<Image> {
    let mut images = vec![Image::default(); views.len()];
    let prepared = caster.prepare(Arc::clone(scene)).unwrap();
    CastPool::new(2)
        .unwrap()
        .cast(&*prepared, views, &mut images)
        .unwrap();
    images
}

/// Waits until `found` gives something; fails by name where it never does.
fn wait_for<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(
            begin.elapsed() < Duration::from_secs(30),
            "waited in vain for {what}"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_head_that_moves_right_shifts_the_picture_as_geometry_says_and_so_does_its_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sway.mcap");
    let sway = Motion::SwayRight {
        distance: SWAY,
        after: 0.8,
        during: 0.5,
    };
    let settings = SimulatorSettings {
        motions: vec![sway, Motion::Still],
        auto_configuration: Duration::from_millis(30),
        ..SimulatorSettings::default()
    };
    let simulator = Simulator::start(settings, None).unwrap();
    let rig = workbench(simulator.path());
    let hub = Arc::new(Hub::for_rig(&rig));
    let clock = Clock::start();
    let placement = serde_json::to_value(PLACEMENT).unwrap();
    let recorder = Recorder::create(&file, &rig, Some(&placement), clock.now()).unwrap();
    let devices = Devices::start(&rig, &hub, clock, Some(&recorder)).unwrap();

    let before = wait_for("the head", || head(&hub, &rig, clock.now()));
    let after = wait_for("the head to arrive", || {
        let now = head(&hub, &rig, clock.now())?;
        (now.translation.x - before.translation.x > SWAY - 5e-4).then_some(now)
    });
    let end = clock.now();
    devices.stop();
    recorder.finish().unwrap();
    simulator.stop();

    // The tracker's frame has come out as the table's: the head went right and nowhere else.
    let way = after.translation - before.translation;
    assert!((way - DVec3::new(SWAY, 0.0, 0.0)).length() < 6e-4, "{way}");
    the_picture_shifts_by_the_formula(&rig, &before, &after);
    the_recording_shows_the_same(&file, &rig, &hub, end);
}

/// Points above the glass go left, below it right, on it not at all, by the formula's pixels.
fn the_picture_shifts_by_the_formula(rig: &Rig, before: &Rigid, after: &Rigid) {
    let glass_width = screen(rig).across().length();
    for height in [0.15, 0.0, -0.2] {
        let at = PLACEMENT
            .world_from_table(DVec3::new(0.05, -0.15, height))
            .truncate();
        let scene = marked_plane(DVec2::new(3.0, 2.4), height, Marker { at, radius: 0.03 });
        let was = cast(&Brute, &scene, &views(rig, before));
        let is = cast(&Brute, &scene, &views(rig, after));
        let eyes = eyes_in_head(rig);
        let eye_heights = eyes.on_table(before).into_array().map(|eye| eye.z);
        for ((was, is), eye_height) in was.iter().zip(&is).zip(eye_heights) {
            let shift = centroid(is).unwrap() - centroid(was).unwrap();
            let moved = after.translation.x - before.translation.x;
            let on_glass = -moved * height / (eye_height - height);
            let wanted = on_glass / glass_width * f64::from(SIZE[0]);
            assert!(
                (shift.x - wanted).abs() < 0.1,
                "at {height} m: {shift}, not {wanted}"
            );
            assert!(shift.y.abs() < 0.1, "at {height} m: {shift}");
            if height == 0.0 {
                assert!(wanted.abs() < 1e-9);
            } else {
                assert!(wanted.abs() > 5.0 && wanted.signum() == -height.signum());
            }
        }
    }
}

/// Frames on the virtual clock are the same bytes each time; and what the recording says in the
/// end is, to the bit, what the live hub said.
fn the_recording_shows_the_same(file: &Path, rig: &Rig, live: &Hub, end: Nanos) {
    let at = DVec2::new(1.6, 1.1);
    let scene = marked_plane(DVec2::new(3.0, 2.4), 0.1, Marker { at, radius: 0.05 });
    let mut replay = Replay::open(file).unwrap();
    assert_eq!(replay.cut(), None);
    assert_eq!(replay.rig().name, rig.name);
    let placement: Placement = serde_json::from_value(replay.placement().unwrap().clone()).unwrap();
    assert_eq!(placement, PLACEMENT);

    let mut runs = Vec::new();
    for _ in 0..2 {
        replay.rewind();
        let hub = Hub::for_rig(replay.rig());
        let mut frames = Vec::new();
        for frame in 0.. {
            let time = replay.start() + Duration::from_nanos(frame * 1_000_000_000 / 60);
            if time > replay.end() {
                break;
            }
            replay.advance_to(time, &hub);
            // Every tenth frame is cast; all of them drive the decoders.
            if frame % 10 == 0
                && let Some(head) = head(&hub, replay.rig(), time)
            {
                frames.push(cast(&Coherent, &scene, &views(replay.rig(), &head)));
            }
        }
        runs.push(frames);
    }
    assert!(
        runs[0].len() >= 5,
        "only {} frames had a head",
        runs[0].len()
    );
    assert!(runs[0] == runs[1], "a replay is not the same twice");

    replay.rewind();
    let hub = Hub::for_rig(replay.rig());
    replay.advance_to(replay.end(), &hub);
    let mut compared = 0;
    for tenth in 1..=20 {
        let time = Nanos(end.0 / 20 * tenth);
        if let Some(pose) = head(live, rig, time) {
            let replayed = head(&hub, replay.rig(), time).expect("the recording has the head too");
            assert_eq!(replayed, pose);
            let (a, b) = (views(rig, &pose), views(replay.rig(), &replayed));
            assert!(cast(&Coherent, &scene, &a) == cast(&Coherent, &scene, &b));
            compared += 1;
        }
    }
    assert!(compared >= 5, "only {compared} times had a head");
}
