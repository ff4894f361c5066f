//! The whole way of a DTrack body: datagrams on the loopback, the driver, the hub, a recording.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod replaying;
mod waiting;

use glam::{DMat3, DQuat, DVec3};
use replaying::{all_poses, played};
use sandtable_config::{Device, Rig, SensorName};
use sandtable_input::{Clock, Condition, Devices, Hub, Recorder, Sample, Stream, stream_of};
use sandtable_pose::{Nanos, Pose, Validity};
use std::net::UdpSocket;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use waiting::wait_for;

const UNIT: &str = "[1 0 0 0 1 0 0 0 1]";

fn rig(line: &str) -> Rig {
    let text = format!(
        "name = 'lab'\ncamera = {{ horizontal_fov = 60.0 }}\n[devices.art]\nkind = 'dtrack'\n\
         bind = '127.0.0.1'\nbodies = 2\nflysticks = 1\n{line}\n\
         table_from_tracker = {{ translation = [0.0, 0.0, -0.5] }}"
    );
    Rig::parse(&text, "lab.toml").unwrap()
}

/// A port that nobody has just now.
fn free_port() -> u16 {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.local_addr().unwrap().port()
}

/// One frame of body 0 and the Flystick, at `x` millimetres.
fn frame(number: u32, x: f64, buttons: u32) -> String {
    format!(
        "fr {number}\r\nts 39596.024831\r\n6dcal 3\r\n6d 1 [0 1.000][{x} 0 100 0 0 0]{UNIT}\r\n\
         6df2 1 1 [0 1.000 8 2][{x} 500 0]{UNIT}[{buttons} 0.25 -1.00]\r\n"
    )
}

fn sensor(number: u32) -> SensorName {
    SensorName {
        device: "art".into(),
        number,
    }
}

/// A rig's device at work, and a controller that sends to it.
struct Session {
    hub: Arc<Hub>,
    clock: Clock,
    devices: Devices,
    controller: UdpSocket,
    number: u32,
}

impl Session {
    fn start(line: &str, file: Option<&Path>) -> Self {
        let port = free_port();
        let rig = rig(&format!("port = {port}\n{line}"));
        let (clock, hub) = (Clock::start(), Arc::new(Hub::for_rig(&rig)));
        let recorder = file.map(|file| Recorder::create(file, &rig, None, clock.now()).unwrap());
        let devices = Devices::start(&rig, &hub, clock, recorder.as_ref()).unwrap();
        let controller = UdpSocket::bind("127.0.0.1:0").unwrap();
        controller.connect(("127.0.0.1", port)).unwrap();
        Self {
            hub,
            clock,
            devices,
            controller,
            number: 0,
        }
    }

    /// Sends one datagram; nobody may be there yet.
    fn send(&self, text: &str) {
        let _ = self.controller.send(text.as_bytes());
    }

    fn send_frame(&mut self, x: f64, buttons: u32) {
        self.number += 1;
        self.send(&frame(self.number, x, buttons));
    }

    fn pose(&self, number: u32) -> Option<Pose> {
        self.hub.pose_at(&sensor(number), self.clock.now())
    }

    fn condition(&self) -> Condition {
        self.devices.states().remove(0).condition
    }

    fn problem(&self, needle: &str) -> String {
        wait_for(needle, || match self.condition() {
            Condition::Waiting(text) => text.contains(needle).then_some(text),
            Condition::Starting | Condition::Streaming => None,
        })
    }

    fn wait_until_live(&mut self) {
        wait_for("live poses", || {
            self.send_frame(250.0, 0b101);
            let live = |n| self.pose(n).filter(|pose| pose.validity == Validity::Live);
            live(1).and(live(3))
        });
    }
}

#[test]
fn bodies_and_flysticks_are_sensors_in_the_tables_metres() {
    let mut session = Session::start("", None);
    session.wait_until_live();
    assert_eq!(session.condition(), Condition::Streaming);
    let place = |n| session.pose(n).unwrap().frame_from_body.translation;
    assert_eq!(place(1), DVec3::new(0.25, 0.0, -0.4));
    assert_eq!(place(3), DVec3::new(0.25, 0.5, -0.5));
    // Body 1 was never seen.
    assert_eq!(session.pose(2), None);
    let now = session.clock.now();
    assert_eq!(session.hub.buttons_at(&sensor(3), now), Some(0b101));
    let axes = session.hub.axes_at(&sensor(3), now).unwrap();
    assert_eq!(axes.values[..axes.count], [0.25, -1.0]);
    let start = Instant::now();
    session.devices.stop();
    assert!(start.elapsed() < Duration::from_secs(2));
}

#[test]
fn silence_is_said_with_port_and_remedy_and_ends() {
    let mut session = Session::start("silent_after = 0.5", None);
    let port = session.controller.peer_addr().unwrap().port();
    let problem = session.problem("no datagram has come");
    for needle in [
        &format!("127.0.0.1:{port}"),
        "0.5 s",
        "start DTrack's measurement",
    ] {
        assert!(problem.contains(needle), "{needle} is not in {problem}");
    }
    session.wait_until_live();
    session.problem("no datagram has come");
    // What its Flystick held is let go.
    wait_for("the release", || {
        let now = session.clock.now();
        (session.hub.buttons_at(&sensor(3), now) == Some(0)).then_some(())
    });
}

#[test]
fn datagrams_without_bodies_are_told_apart_from_none() {
    let session = Session::start("silent_after = 0.5", None);
    wait_for("the missing bodies", || {
        session.send("fr 1\r\n3d 1 [79 1.000][210.730 -90.669 -108.554]\r\n");
        match session.condition() {
            Condition::Waiting(text) => text.contains("no line `6d`").then_some(()),
            _ => None,
        }
    });
}

#[test]
fn only_the_named_controller_is_heard() {
    let session = Session::start("silent_after = 0.5\nfrom = '192.0.2.7'", None);
    wait_for("the stranger", || {
        session.send(&frame(1, 0.0, 0));
        match session.condition() {
            Condition::Waiting(text) => text.contains("from = 192.0.2.7").then_some(()),
            _ => None,
        }
    });
    assert_eq!(session.devices.states().remove(0).counts.records, 0);
}

#[test]
fn a_taken_port_is_named() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let rig = rig(&format!("port = {port}"));
    let hub = Arc::new(Hub::for_rig(&rig));
    let devices = Devices::start(&rig, &hub, Clock::start(), None).unwrap();
    let problem = wait_for("the error", || match devices.states().remove(0).condition {
        Condition::Waiting(text) => Some(text),
        _ => None,
    });
    assert!(problem.contains(&format!("127.0.0.1:{port}")), "{problem}");
    assert!(
        problem.contains("another program receives there"),
        "{problem}"
    );
}

#[test]
fn a_recorded_session_replays_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.mcap");
    let mut session = Session::start("silent_after = 0.5", Some(&file));
    session.wait_until_live();
    for step in 0..60 {
        session.send_frame(250.0 + f64::from(step), step);
        if step == 30 {
            session.send("fr 9\r\n6d 1 [0 nonsense\r\n");
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    session.problem("no datagram has come");
    session.wait_until_live();
    let Session { hub, devices, .. } = session;
    devices.stop();
    let (replayed, time) = played(&file);
    for number in [1, 3] {
        let live = all_poses(&hub, &sensor(number), time);
        assert!(live.len() > 30, "{}", live.len());
        assert_eq!(all_poses(&replayed, &sensor(number), time), live);
        assert_eq!(
            replayed.buttons_at(&sensor(number), time),
            hub.buttons_at(&sensor(number), time)
        );
        assert_eq!(
            replayed.axes_at(&sensor(number), time),
            hub.axes_at(&sensor(number), time)
        );
    }
}

/// The stream alone, and the datagrams of one body given as its columns.
fn stream() -> Box<dyn Stream> {
    let rig = rig("");
    let Device::Dtrack(_) = &rig.devices["art"] else {
        panic!("no DTrack");
    };
    stream_of(&rig.devices["art"])
}

fn samples(stream: &mut dyn Stream, datagrams: &[String]) -> Vec<Sample> {
    let mut samples = Vec::new();
    for (datagram, n) in datagrams.iter().zip(1..) {
        let arrival = Nanos(16_000_000 * n);
        stream.push(datagram.as_bytes(), arrival, &mut |sample| {
            samples.push(sample)
        });
    }
    samples
}

#[test]
fn a_matrix_that_is_no_rotation_is_no_pose() {
    let line = |columns: &str| format!("6d 1 [0 1.0][0 0 0 0 0 0][{columns}]\n");
    for columns in [
        "0 0 0 0 0 0 0 0 0",
        "-1 0 0 0 1 0 0 0 1",
        "1.02 0 0 0 1 0 0 0 1",
        "1 0 0 0 1 0 0 0 0.98",
        "1 0 0 0.1 0.995 0 0 0 1",
        "1 0 0 1 0 0 0 0 1",
    ] {
        let mut stream = stream();
        assert_eq!(
            samples(stream.as_mut(), &vec![line(columns); 3]),
            [],
            "{columns}"
        );
        assert_eq!(stream.counts().implausible, 3, "{columns}");
    }
    // Column by column: the body's x is the room's y.
    let quarter = line("0 1 0 -1 0 0 0 0 1");
    let samples = samples(stream().as_mut(), &vec![quarter; 2]);
    let turned = samples[0].pose().unwrap().table_from_sensor;
    assert!((turned.direction(DVec3::X) - DVec3::Y).length() < 1e-12);
    // The manual's, whose digits leave it a little off.
    let manual = DMat3::from_cols_array(&[
        -0.940508, -0.339238, -0.019025, 0.333599, -0.932599, 0.137735, -0.064467, 0.123194,
        0.990286,
    ]);
    let columns = manual.to_cols_array().map(|b| b.to_string()).join(" ");
    let samples = self::samples(stream().as_mut(), &vec![line(&columns); 2]);
    let rotation = samples[0].pose().unwrap().table_from_sensor.rotation;
    assert!((rotation.length() - 1.0).abs() < 1e-12);
    assert!(rotation.angle_between(DQuat::from_mat3(&manual).normalize()) < 1e-7);
    let off = (DMat3::from_quat(rotation) - manual).to_cols_array();
    assert!(off.iter().all(|o| o.abs() < 1e-5), "{off:?}");
}

#[test]
fn late_and_doubled_datagrams_are_refused_and_a_new_start_is_not() {
    let mut stream = stream();
    let numbers = [500, 501, 503, 502, 503, 504, 1, 2, 3];
    let datagrams: Vec<_> = numbers
        .iter()
        .map(|&n| frame(n, f64::from(n % 100), 0))
        .collect();
    let samples = samples(stream.as_mut(), &datagrams);
    let of_body: Vec<_> = samples
        .iter()
        .filter(|sample| sample.sensor() == 1)
        .map(|sample| (sample.pose().unwrap().table_from_sensor.translation.x * 1e3).round())
        .collect();
    assert_eq!(of_body, [1.0, 3.0, 4.0, 1.0, 2.0, 3.0]);
    // Of the Flystick's buttons and axes only what is new is told.
    let controls = samples
        .iter()
        .filter(|sample| sample.pose().is_none())
        .count();
    assert_eq!(controls, 2);
}

#[test]
fn bodies_that_the_rig_does_not_have_are_nobodys() {
    let strange = format!("6d 1 [2 1.0][0 0 0 0 0 0]{UNIT}\n6df2 2 1 [1 1.0 0 0][0 0 0]{UNIT}[]\n");
    let mut stream = stream();
    assert_eq!(samples(stream.as_mut(), &vec![strange; 3]), []);
    assert_eq!(stream.counts().foreign_records, 9);
}

#[test]
fn frozen_bodies_are_told() {
    let still: Vec<_> = (1..=120).map(|n| frame(n, 5.0, 0)).collect();
    let samples = samples(stream().as_mut(), &still);
    let of_body = samples
        .iter()
        .filter_map(Sample::pose)
        .filter(|pose| pose.sensor == 1);
    let frozen: Vec<_> = of_body.map(|pose| pose.frozen).collect();
    assert_eq!(frozen.iter().position(|&frozen| frozen), Some(98));
}
