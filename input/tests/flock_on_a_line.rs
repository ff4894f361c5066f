//! The whole way of a pose: simulated Flock on a pseudo-terminal, driver, hub.
#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod replaying;
mod waiting;

use replaying::{all_poses, played};
use sandtable_config::{Confirm, Device, Flock, FlockMode, RecordFormat, Rig, SensorName};
use sandtable_input::flock::{Faults, Motion, Simulator, SimulatorSettings};
use sandtable_input::{Clock, Condition, Devices, Hub, Recorder};
use sandtable_pose::{Nanos, Pose, Rigid, Validity};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use waiting::wait_for;

/// The workbench with its Flock at `port`, its silences short so that tests are.
fn rig(port: &Path) -> Rig {
    let mut rig = Rig::builtin("workbench").unwrap();
    rig.set_port("flock", port).unwrap();
    let Some(Device::Flock(flock)) = rig.devices.get_mut("flock") else {
        panic!("the workbench has a Flock");
    };
    flock.silence_before = Duration::from_millis(50);
    // Long enough for a simulator that a busy machine lets wait: what reaches it while it
    // configures itself is lost.
    flock.silence_after = Duration::from_millis(300);
    rig
}

/// The same with one bird that stands alone.
fn lone_rig(port: &Path) -> Rig {
    let text = Rig::builtin_text("workbench").unwrap();
    let text = text
        .replace("birds = 2", "birds = 1")
        .replace("group = true", "group = false")
        .replace("flock/2", "flock/1");
    let mut lone = Rig::parse(&text, "a bird alone").unwrap();
    lone.set_port("flock", port).unwrap();
    if let (Some(Device::Flock(to)), Device::Flock(from)) =
        (lone.devices.get_mut("flock"), &rig(port).devices["flock"])
    {
        to.silence_before = from.silence_before;
        to.silence_after = from.silence_after;
    }
    lone
}

fn settings() -> SimulatorSettings {
    SimulatorSettings {
        auto_configuration: Duration::from_millis(30),
        ..SimulatorSettings::default()
    }
}

/// A rig's devices at work.
struct Session {
    hub: Arc<Hub>,
    clock: Clock,
    devices: Devices,
    rig: Rig,
}

impl Session {
    fn start(port: &Path) -> Self {
        Self::start_recorded(rig(port), Clock::start(), None)
    }

    fn start_recorded(rig: Rig, clock: Clock, recorder: Option<&Recorder>) -> Self {
        let hub = Arc::new(Hub::for_rig(&rig));
        let devices = Devices::start(&rig, &hub, clock, recorder).unwrap();
        Self {
            hub,
            clock,
            devices,
            rig,
        }
    }

    fn now(&self) -> Nanos {
        self.clock.now()
    }

    fn pose(&self, number: u32) -> Option<Pose> {
        self.hub.pose_at(&sensor(number), self.now())
    }

    /// The error that its device shows, if it is waiting for one to end.
    fn problem(&self) -> Option<String> {
        match self.devices.states().remove(0).condition {
            Condition::Waiting(text) => Some(text),
            Condition::Starting | Condition::Streaming => None,
        }
    }

    fn expected(&self, motion: Motion, number: u32, seconds: f64) -> Rigid {
        let Device::Flock(flock) = &self.rig.devices["flock"] else {
            panic!("the workbench has a Flock");
        };
        flock.table_from_tracker * motion.pose(number, seconds)
    }

    /// Every pose that the sensor had since `from`.
    fn poses_since(&self, number: u32, from: Nanos) -> Vec<Pose> {
        let mut poses = all_poses(&self.hub, &sensor(number), self.now());
        poses.retain(|pose| pose.time > from);
        poses
    }
}

fn sensor(number: u32) -> SensorName {
    SensorName {
        device: "flock".into(),
        number,
    }
}

fn wait_until_live(session: &Session) {
    wait_for("live poses of both birds", || {
        let live = |n| {
            session
                .pose(n)
                .is_some_and(|p| p.validity == Validity::Live)
        };
        (live(1) && live(2)).then_some(())
    });
}

/// How far a pose is from the nearest that was ever sent, in metres.
fn off_path(session: &Session, motion: Motion, number: u32, pose: &Pose) -> f64 {
    (0..2000)
        .map(|cycle| {
            let sent = session.expected(motion, number, f64::from(cycle) / 103.3);
            (sent.translation - pose.frame_from_body.translation).length()
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn held_poses_arrive_to_a_third_of_a_millimetre() {
    let held = [
        Motion::hold([-28.0, 3.0, -30.0], [10.0, 20.0, -30.0]),
        Motion::hold([-12.0, 8.0, -20.0], [-90.0, 5.0, 170.0]),
    ];
    let simulator = Simulator::start(
        SimulatorSettings {
            motions: held.to_vec(),
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    wait_until_live(&session);
    for (number, motion) in (1..).zip(held) {
        let pose = session.pose(number).unwrap().frame_from_body;
        let sent = session.expected(motion, number, 0.0);
        // 72 inches: a step is 0.22 mm on each axis, of which the middle is off by a half.
        let off = (pose.translation - sent.translation).abs().max_element();
        assert!(off < 3e-4, "bird {number}: {off} m");
        assert!(pose.rotation.angle_between(sent.rotation) < 1e-3);
    }
    session.devices.stop();
    simulator.stop();
}

#[test]
fn every_fiftieth_byte_lost_lets_no_wrong_pose_out() {
    let motion = Motion::named("circle").unwrap();
    let simulator = Simulator::start(
        SimulatorSettings {
            motions: vec![motion],
            faults: Faults {
                drop_every: Some(50),
                ..Faults::default()
            },
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    wait_until_live(&session);
    let counts = wait_for("four hundred samples", || {
        let counts = session.devices.states().remove(0).counts;
        (counts.samples >= 400).then_some(counts)
    });
    // One byte in 50 takes one record in 3.3 with it, and never two.
    let lost = counts.cut_records;
    assert!(lost >= 100, "{counts:?}");
    assert!(counts.records >= 2 * lost, "{counts:?}");
    // How many the gate refused is not asked: it refuses the first after each gap, and a busy
    // machine makes gaps of its own.
    for number in 1..=2 {
        let poses = session.poses_since(number, Nanos(0));
        // Of 150 bytes, 10 records, bird 1 loses one and bird 2 two.
        assert!(poses.len() >= 160, "{}", poses.len());
        for pose in poses {
            let off = off_path(&session, motion, number, &pose);
            assert!(
                off < 2e-3,
                "bird {number} was never within {off} m of there"
            );
        }
    }
}

/// Damages a record in every way at each of its places, and checks every pose that comes out.
fn damage_everywhere(baud: u32, group: bool, edit: impl FnOnce(&mut Flock)) {
    const EVERY: u64 = 8;
    let motion = Motion::named("circle").unwrap();
    let simulator = Simulator::start(
        SimulatorSettings {
            birds: if group { 2 } else { 1 },
            baud,
            motions: vec![motion],
            faults: Faults {
                damage_every: Some(EVERY),
                ..Faults::default()
            },
            ..settings()
        },
        None,
    )
    .unwrap();
    let mut rig = if group {
        rig(simulator.path())
    } else {
        lone_rig(simulator.path())
    };
    let Some(Device::Flock(flock)) = rig.devices.get_mut("flock") else {
        panic!("the workbench has a Flock");
    };
    flock.baud = baud;
    edit(flock);
    let length = sandtable_input::flock::layout(flock).record_length() as u64;
    let session = Session::start_recorded(rig, Clock::start(), None);
    // Each way at each place, and the records between them.
    let damages = 2 * length;
    let counts = wait_for("as many records as are damaged and between", || {
        let counts = session.devices.states().remove(0).counts;
        (counts.records >= EVERY * (damages + 2)).then_some(counts)
    });
    let birds = if group { 2 } else { 1 };
    let mut poses = 0;
    for number in 1..=birds {
        for pose in session.poses_since(number, Nanos(0)) {
            let off = off_path(&session, motion, number, &pose);
            assert!(
                off < 2e-3,
                "bird {number} was never within {off} m of there"
            );
            poses += 1;
        }
    }
    // A damaged record takes at most its follower along, and each bird's first waits for its second.
    let fewest = counts.records - damages - 8;
    assert!(poses >= fewest, "{poses} poses of {counts:?}");
    session.devices.stop();
    simulator.stop();
}

#[test]
fn a_group_damaged_everywhere_lets_no_wrong_pose_out_on_a_fast_line() {
    damage_everywhere(115_200, true, |_| {});
}

#[test]
fn a_group_damaged_everywhere_lets_no_wrong_pose_out_on_a_slow_line() {
    damage_everywhere(9600, true, |_| {});
}

#[test]
fn a_bird_alone_damaged_everywhere_lets_no_wrong_pose_out_on_a_fast_line() {
    damage_everywhere(115_200, false, |_| {});
}

#[test]
fn a_bird_alone_damaged_everywhere_lets_no_wrong_pose_out_on_a_slow_line() {
    damage_everywhere(9600, false, |_| {});
}

#[test]
fn confirmed_records_of_another_format_survive_damage_too() {
    damage_everywhere(115_200, true, |flock| {
        flock.format = RecordFormat::PositionMatrix;
        flock.buttons = true;
        flock.confirm = Confirm::NextMark;
    });
}

#[test]
fn records_that_are_asked_for_come_one_by_one() {
    let motion = Motion::named("circle").unwrap();
    let simulator = Simulator::start(
        SimulatorSettings {
            motions: vec![motion],
            ..settings()
        },
        None,
    )
    .unwrap();
    let mut rig = rig(simulator.path());
    if let Some(Device::Flock(flock)) = rig.devices.get_mut("flock") {
        flock.mode = FlockMode::Point;
    }
    let session = Session::start_recorded(rig, Clock::start(), None);
    wait_until_live(&session);
    let from = session.now();
    wait_for("a hundred poses", || {
        (session.poses_since(1, from).len() >= 100).then_some(())
    });
    // Not faster than they are measured.
    let lasted = session.now().since(from);
    assert!(lasted >= Duration::from_millis(900), "{lasted:?}");
    session.devices.stop();
    simulator.stop();
}

#[test]
fn flow_controls_own_bytes_are_data() {
    // Words of the bytes 0x11 and 0x13, XON and XOFF, in x and y.
    let inches = |word: u16| f64::from(word) * 72.0 / 32768.0;
    let (x, y) = (inches(0x11 << 9 | 0x13 << 2), inches(0x13 << 9 | 0x11 << 2));
    let held = Motion::hold([x, y, -20.0], [0.0; 3]);
    let simulator = Simulator::start(
        SimulatorSettings {
            motions: vec![held],
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    wait_until_live(&session);
    wait_for("a hundred poses", || {
        (session.poses_since(1, Nanos(0)).len() >= 100).then_some(())
    });
    let sent = session.expected(held, 1, 0.0);
    for pose in session.poses_since(1, Nanos(0)) {
        let off = pose.frame_from_body.translation - sent.translation;
        assert!(off.abs().max_element() < 3e-4, "{off}");
    }
    session.devices.stop();
    simulator.stop();
}

#[test]
fn a_second_of_silence_is_held_then_lost_then_live_again() {
    let simulator = Simulator::start(
        SimulatorSettings {
            faults: Faults {
                stalls: vec![(Duration::from_millis(400), Duration::from_secs(1))],
                ..Faults::default()
            },
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    let last = wait_for("the silence", || {
        let pose = session.pose(1)?;
        (session.now().since(pose.time) > Duration::from_millis(600)).then_some(pose)
    });
    // By the sample's own time, so that a slow machine sees the same.
    let at = |ms| {
        session
            .hub
            .pose_at(&sensor(1), last.time + Duration::from_millis(ms))
    };
    assert_eq!(at(29).unwrap().validity, Validity::Live);
    assert_eq!(at(60).unwrap().validity, Validity::Held);
    assert_eq!(at(249).unwrap().validity, Validity::Held);
    assert_eq!(at(251).unwrap().validity, Validity::Lost);
    let held = at(251).unwrap().frame_from_body;
    assert_eq!(held, last.frame_from_body);
    let first = wait_for("the return", || {
        session.poses_since(1, last.time).first().copied()
    });
    let gap = first.time.since(last.time);
    assert!(gap > Duration::from_millis(600), "{gap:?}");
    // It was waited out: the device was not started anew.
    assert_eq!(session.problem(), None);
    assert!(off_path(&session, Motion::Still, 1, &first) < 1e-3);
}

#[test]
fn two_seconds_of_silence_start_the_device_anew() {
    let simulator = Simulator::start(
        SimulatorSettings {
            faults: Faults {
                stalls: vec![(Duration::from_millis(200), Duration::from_secs(3))],
                ..Faults::default()
            },
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    wait_for("the silence's error", || {
        let silent = |text: &String| text.contains("silent for 2 s");
        session.problem().filter(silent)
    });
    wait_until_live(&session);
    assert_eq!(session.problem(), None);
}

#[test]
fn a_missing_port_says_so_and_what_helps() {
    let session = Session::start(Path::new("/dev/ttyMISSING7"));
    let problem = wait_for("the error", || session.problem());
    for needle in ["/dev/ttyMISSING7", "No such file", "sandtable doctor"] {
        assert!(problem.contains(needle), "{problem}");
    }
    assert_eq!(session.pose(1), None);
}

#[test]
fn a_port_that_is_no_terminal_is_refused() {
    let session = Session::start(Path::new("/dev/null"));
    let problem = wait_for("the error", || session.problem());
    assert!(problem.contains("/dev/null"), "{problem}");
    assert!(problem.contains("serial port"), "{problem}");
}

#[test]
fn a_device_that_goes_away_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let link: PathBuf = folder.path().join("flock");
    let simulator = Simulator::start(settings(), Some(&link)).unwrap();
    let session = Session::start(&link);
    wait_until_live(&session);
    simulator.stop();
    assert!(!link.exists(), "the link outlived its simulator");
    let problem = wait_for("the unplugged device's error", || session.problem());
    assert!(problem.contains("flock"), "{problem}");
    let lost = wait_for("the loss", || {
        session
            .pose(1)
            .filter(|pose| pose.validity == Validity::Lost)
    });
    let simulator = Simulator::start(settings(), Some(&link)).unwrap();
    wait_until_live(&session);
    assert!(session.pose(1).unwrap().time > lost.time);
    session.devices.stop();
    simulator.stop();
}

#[test]
fn a_bird_that_the_flock_does_not_have_is_named() {
    let simulator = Simulator::start(
        SimulatorSettings {
            birds: 1,
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    let problem = wait_for("the error", || {
        let missing = |text: &String| text.contains("unit 2 does not answer");
        session.problem().filter(missing)
    });
    // The Flock's own word for it, by EXAMINE 10.
    assert!(problem.contains("error 13"), "{problem}");
}

#[test]
fn a_flock_that_missed_its_settings_is_started_anew() {
    // It streams, but no records that anyone could read.
    let simulator = Simulator::start(
        SimulatorSettings {
            faults: Faults {
                keep_format: true,
                ..Faults::default()
            },
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    let problem = wait_for("the error", || {
        session.problem().filter(|text| text.contains("no records"))
    });
    assert!(problem.contains("115200 baud"), "{problem}");
    assert_eq!(session.pose(1), None);
}

#[test]
fn a_silent_line_is_told_apart_from_a_missing_one() {
    // A terminal with nobody behind it.
    let (_host, device) = serialport::TTYPort::pair().unwrap();
    let path = serialport::SerialPort::name(&device).unwrap();
    let session = Session::start(Path::new(&path));
    let problem = wait_for("the error", || session.problem());
    assert!(problem.contains("does not answer (0 of 14"), "{problem}");
    assert!(problem.contains("115200 baud"), "{problem}");
}

#[test]
fn a_recorded_session_replays_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.mcap");
    let simulator = Simulator::start(
        SimulatorSettings {
            motions: vec![Motion::named("circle").unwrap()],
            faults: Faults {
                drop_every: Some(50),
                ..Faults::default()
            },
            ..settings()
        },
        None,
    )
    .unwrap();
    let rig = rig(simulator.path());
    let clock = Clock::start();
    let recorder = Recorder::create(&file, &rig, None, clock.now()).unwrap();
    let session = Session::start_recorded(rig, clock, Some(&recorder));
    wait_for("two hundred samples", || {
        let counts = session.devices.states().remove(0).counts;
        (counts.samples >= 200).then_some(())
    });
    let Session { hub, devices, .. } = session;
    devices.stop();
    recorder.finish().unwrap();
    let (replayed, time) = played(&file);
    for number in 1..=2 {
        let live = all_poses(&hub, &sensor(number), time);
        assert!(live.len() > 80);
        assert_eq!(all_poses(&replayed, &sensor(number), time), live);
    }
}

#[test]
fn a_frozen_flock_is_lost_though_it_streams() {
    let simulator = Simulator::start(
        SimulatorSettings {
            cycle_rate: 400.0,
            faults: Faults {
                freeze_at: Some(Duration::from_millis(100)),
                ..Faults::default()
            },
            ..settings()
        },
        None,
    )
    .unwrap();
    let session = Session::start(simulator.path());
    // Asked at the pose's own time, so that no age makes it lost.
    wait_for("the loss of a young pose", || {
        let newest = session.pose(1)?.time;
        let pose = session.hub.pose_at(&sensor(1), newest)?;
        (pose.validity == Validity::Lost).then_some(())
    });
    assert_eq!(session.problem(), None);
}

#[test]
fn a_taken_path_is_not_made_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine");
    std::fs::write(&path, "precious").unwrap();
    let error = Simulator::start(settings(), Some(&path)).unwrap_err();
    assert!(error.to_string().contains("mine"), "{error}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");
    let nowhere = folder.path().join("none/flock");
    assert!(Simulator::start(settings(), Some(&nowhere)).is_err());
}
