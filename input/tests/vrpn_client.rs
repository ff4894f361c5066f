//! The whole way of a VRPN pose: a server made by hand, the device's driver, the hub, a recording.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod replaying;
mod vrpn_by_hand;
mod waiting;

use replaying::{all_poses, played};
use sandtable_config::{Rig, SensorName};
use sandtable_input::{Clock, Condition, Devices, Hub, Recorder, Replay};
use sandtable_pose::{Pose, Validity};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use vrpn_by_hand::{COOKIE, Peer, doubles, integers, kind, message, pose, sender};
use waiting::wait_for;

const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

fn rig(address: &str, line: &str) -> Rig {
    let text = format!(
        "name = 'lab'\ncamera = {{ horizontal_fov = 60.0 }}\n[devices.t]\nkind = 'vrpn'\n\
         address = '{address}'\nsensors = 2\nbuttons = {{ sensor = 2 }}\n{line}\n\
         table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}"
    );
    Rig::parse(&text, "lab.toml").unwrap()
}

/// A rig's device at work, and the server that it is to find.
struct Session {
    listener: TcpListener,
    hub: Arc<Hub>,
    clock: Clock,
    devices: Devices,
}

impl Session {
    fn start(line: &str) -> Self {
        Self::recorded(line, None)
    }

    fn recorded(line: &str, file: Option<&Path>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let rig = rig(&format!("Tracker0@127.0.0.1:{port}"), line);
        let (clock, hub) = (Clock::start(), Arc::new(Hub::for_rig(&rig)));
        let recorder = file.map(|file| Recorder::create(file, &rig, None, clock.now()).unwrap());
        let devices = Devices::start(&rig, &hub, clock, recorder.as_ref()).unwrap();
        Self {
            listener,
            hub,
            clock,
            devices,
        }
    }

    /// Takes the client's next connection, cookies exchanged.
    fn accept(&self) -> Peer {
        let mut peer = self.accept_silently();
        peer.send(&COOKIE);
        peer
    }

    fn accept_silently(&self) -> Peer {
        let (socket, _) = self.listener.accept().unwrap();
        let mut peer = Peer::new(socket);
        let cookie = peer.bytes(24, waiting::PATIENCE).unwrap();
        assert_eq!(cookie, COOKIE);
        peer
    }

    fn condition(&self) -> Condition {
        self.devices.states().remove(0).condition
    }

    fn problem(&self) -> String {
        wait_for("an error", || match self.condition() {
            Condition::Waiting(text) => Some(text),
            Condition::Starting | Condition::Streaming => None,
        })
    }

    fn pose(&self, number: u32) -> Option<Pose> {
        self.hub.pose_at(&sensor_name(number), self.clock.now())
    }

    fn buttons(&self) -> Option<u64> {
        self.hub.buttons_at(&sensor_name(2), self.clock.now())
    }
}

fn sensor_name(number: u32) -> SensorName {
    SensorName {
        device: "t".into(),
        number,
    }
}

/// A server's numbers: of the tracker, and of the first of five types.
fn descriptions(tracker: i32, first: i32) -> Vec<u8> {
    [
        sender(tracker, "Tracker0"),
        sender(tracker + 1, "Button9"),
        kind(first, "vrpn_Tracker Pos_Quat"),
        kind(first + 1, "vrpn_Button Change"),
        kind(first + 2, "vrpn_Analog Channel"),
        kind(first + 3, "vrpn_Base pong_message"),
        kind(first + 4, "vrpn_Base text_message"),
    ]
    .concat()
}

/// Says of both sensors where they are until the client has heard it.
fn say_until_heard(session: &Session, peer: &mut Peer, tracker: i32, first: i32, x: f64) {
    wait_for("live poses", || {
        for number in 0..2 {
            let place = [x, f64::from(number), 0.0];
            peer.send(&message(tracker, first, &pose(number, place, IDENTITY)));
        }
        let is_there = |number| {
            let pose = session.pose(number)?;
            let near = (pose.frame_from_body.translation.x - x).abs() < 1e-9;
            (near && pose.validity == Validity::Live).then_some(())
        };
        is_there(1).and(is_there(2))
    });
}

#[test]
fn poses_buttons_and_analogs_of_a_server_reach_the_hub() {
    let session = Session::start("");
    let mut peer = session.accept();
    peer.send(&descriptions(4, 20));
    say_until_heard(&session, &mut peer, 4, 20, 0.25);
    assert_eq!(session.condition(), Condition::Streaming);
    // Two messages in one write, and one in two.
    let press = message(4, 21, &integers(&[3, 1]));
    let stick = message(4, 22, &doubles(&[2.0, -1.0, 0.5]));
    peer.send(&[press, stick[..40].to_vec()].concat());
    wait_for("the button", || {
        (session.buttons() == Some(0b1000)).then_some(())
    });
    peer.send(&stick[40..]);
    let axes = wait_for("the stick", || {
        session.hub.axes_at(&sensor_name(1), session.clock.now())
    });
    assert_eq!(axes.values[..axes.count], [-1.0, 0.5]);
    assert_eq!(session.pose(2).unwrap().frame_from_body.translation.y, 1.0);
    session.devices.stop();
    assert!(peer.is_closed());
}

#[test]
fn a_server_that_comes_back_may_number_anew_and_holds_nothing_over() {
    let session = Session::start("");
    let mut peer = session.accept();
    peer.send(&descriptions(4, 20));
    say_until_heard(&session, &mut peer, 4, 20, 0.25);
    peer.send(&message(4, 21, &integers(&[0, 1])));
    wait_for("the button", || {
        (session.buttons() == Some(1)).then_some(())
    });
    drop(peer);
    let problem = session.problem();
    assert!(problem.contains("127.0.0.1, port"), "{problem}");
    assert!(problem.contains("ended the connection"), "{problem}");
    // Its button is let go, and its poses are lost where they were.
    wait_for("the release", || {
        (session.buttons() == Some(0)).then_some(())
    });
    let lost = wait_for("the loss", || {
        session
            .pose(1)
            .filter(|pose| pose.validity == Validity::Lost)
    });
    assert_eq!(lost.frame_from_body.translation.x, 0.25);
    let mut peer = session.accept();
    // What was the tracker is the buttons now, and poses have the buttons' number.
    peer.send(&descriptions(3, 21));
    say_until_heard(&session, &mut peer, 3, 21, -0.5);
    assert_eq!(session.condition(), Condition::Streaming);
}

#[test]
fn nobody_there_is_said_with_host_port_and_remedy_and_waited_for() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    drop(listener);
    let rig = rig(&format!("Tracker0@127.0.0.1:{port}"), "");
    let hub = Arc::new(Hub::for_rig(&rig));
    let devices = Devices::start(&rig, &hub, Clock::start(), None).unwrap();
    let problem = wait_for("the error", || match devices.states().remove(0).condition {
        Condition::Waiting(text) => Some(text),
        _ => None,
    });
    for needle in [
        "127.0.0.1",
        &port.to_string(),
        "refused",
        "start the server",
    ] {
        assert!(problem.contains(needle), "{needle} is not in {problem}");
    }
    // It comes later.
    let listener = TcpListener::bind(("127.0.0.1", port)).unwrap();
    let (socket, _) = listener.accept().unwrap();
    assert_eq!(
        Peer::new(socket).bytes(24, waiting::PATIENCE).unwrap(),
        COOKIE
    );
}

#[test]
fn who_is_no_vrpn_server_is_named_by_its_greeting() {
    let session = Session::start("");
    let mut peer = session.accept_silently();
    peer.send(b"SSH-2.0-OpenSSH_9.2p1 Debian-2\r\n");
    let problem = session.problem();
    for needle in ["no VRPN server", "SSH-2.0-OpenSSH_9", "name the port"] {
        assert!(problem.contains(needle), "{needle} is not in {problem}");
    }
    assert!(peer.is_closed());
    let mut peer = session.accept_silently();
    peer.send(b"vrpn: ver. 08.01  0\0\0\0\0\0");
    wait_for("the other version", || {
        let said = |text: &String| text.contains("08.01") && text.contains("version 07");
        Some(session.problem()).filter(said)
    });
    // A minor one is as good.
    let mut peer = session.accept_silently();
    peer.send(b"vrpn: ver. 07.21  0\0\0\0\0\0");
    peer.send(&descriptions(0, 0));
    say_until_heard(&session, &mut peer, 0, 0, 0.5);
}

#[test]
fn a_server_that_takes_the_connection_and_says_nothing_is_noticed() {
    let session = Session::start("silent_after = 0.5");
    let peer = session.accept_silently();
    let problem = session.problem();
    assert!(problem.contains("silent for 0.5 s"), "{problem}");
    assert!(problem.contains("127.0.0.1, port"), "{problem}");
    drop(peer);
    // It is tried again.
    drop(session.accept());
}

#[test]
fn a_quiet_server_is_asked_and_only_a_dead_one_left() {
    let session = Session::start("silent_after = 2.5");
    let mut peer = session.accept();
    peer.send(&descriptions(7, 1));
    // The client names itself and its types before it asks.
    let (mut senders, mut kinds) = (Vec::new(), Vec::new());
    let mut pings = 0;
    while pings < 3 {
        let said = peer.message(waiting::PATIENCE).unwrap();
        match said.kind {
            -1 => senders.push((said.sender, said.name().to_owned())),
            -2 => kinds.push((said.sender, said.name().to_owned())),
            other => {
                let ping = kinds.iter().find(|(number, _)| *number == other).unwrap();
                assert_eq!(ping.1, "vrpn_Base ping_message");
                assert_eq!(senders, [(said.sender, "Tracker0".to_owned())]);
                assert!(said.payload.is_empty() && said.seconds > 1_700_000_000);
                peer.send(&message(7, 4, &[]));
                pings += 1;
            }
        }
    }
    // Three seconds without a pose, and all is well.
    assert_eq!(session.condition(), Condition::Streaming);
    let problem = session.problem();
    assert!(problem.contains("answers no ping"), "{problem}");
    assert!(problem.contains("silent for 2.5 s"), "{problem}");
}

#[test]
fn a_server_without_the_device_is_told_by_what_it_has() {
    let session = Session::start("");
    let mut peer = session.accept();
    peer.send(
        &[
            sender(0, "VRPN Control"),
            sender(1, "Trakcer0"),
            sender(2, "Wand"),
        ]
        .concat(),
    );
    let problem = session.problem();
    assert!(
        problem.contains("no device `Tracker0`; it has: Trakcer0, Wand"),
        "{problem}"
    );
}

#[test]
fn what_is_no_message_ends_the_connection_and_not_the_device() {
    let session = Session::start("");
    let mut peer = session.accept();
    peer.send(&descriptions(0, 0));
    let mut huge = message(0, 0, &pose(0, [0.0; 3], IDENTITY));
    huge[..4].copy_from_slice(&0x7fff_fff8u32.to_be_bytes());
    peer.send(&huge);
    let problem = session.problem();
    assert!(problem.contains("claims 2147483640 bytes"), "{problem}");
    assert!(peer.is_closed());
    let mut peer = session.accept();
    peer.send(&descriptions(0, 0));
    say_until_heard(&session, &mut peer, 0, 0, 0.125);
}

/// How long stopping the devices takes.
fn stopping(devices: Devices) -> Duration {
    let start = Instant::now();
    devices.stop();
    start.elapsed()
}

#[test]
fn no_network_makes_a_stop_wait() {
    // A server whose door is full: whoever comes next hears nothing for seconds.
    let full = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = full.local_addr().unwrap();
    let mut waiting = Vec::new();
    while let Ok(peer) = TcpStream::connect_timeout(&address, Duration::from_millis(200)) {
        waiting.push(peer);
        assert!(waiting.len() < 10_000, "the door is never full");
    }
    let full = format!("Tracker0@{address}");
    // An address for documentation only, which nobody has; and a name that nobody has.
    for address in [&full, "Tracker0@192.0.2.1", "Tracker0@no-such-host.invalid"] {
        let rig = rig(address, "");
        let hub = Arc::new(Hub::for_rig(&rig));
        let devices = Devices::start(&rig, &hub, Clock::start(), None).unwrap();
        std::thread::sleep(Duration::from_millis(100));
        // Half a second is promised; a busy machine takes its own time besides.
        let took = stopping(devices);
        assert!(took < Duration::from_secs(2), "{address}: {took:?}");
    }
    let session = Session::start("");
    let _peer = session.accept();
    assert!(stopping(session.devices) < Duration::from_secs(2));
}

#[test]
fn a_recorded_session_replays_to_the_bit_over_a_reconnection() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.mcap");
    let session = Session::recorded("", Some(&file));
    let mut peer = session.accept();
    // All at once with the cookie's end, and a pose behind it.
    let turn = [0.6, 0.0, 0.0, 0.8];
    let mut first = descriptions(4, 20);
    first.extend(message(4, 20, &pose(0, [0.1, 0.2, 1.0 / 3.0], turn)));
    peer.send(&first);
    let mut x = 0.0;
    while session.devices.states().remove(0).counts.samples < 60 {
        x += 1e-3;
        let both = [0, 1].map(|n| message(4, 20, &pose(n, [x, x * x, -0.1], turn)));
        peer.send(&both.concat());
        std::thread::sleep(Duration::from_millis(1));
    }
    peer.send(&message(4, 21, &integers(&[5, 1])));
    wait_for("the button", || {
        (session.buttons() == Some(32)).then_some(())
    });
    // Held for some of the steps that the buttons are compared at below.
    std::thread::sleep(Duration::from_millis(5));
    drop(peer);
    wait_for("the release", || {
        (session.buttons() == Some(0)).then_some(())
    });
    let mut peer = session.accept();
    peer.send(&descriptions(3, 21));
    say_until_heard(&session, &mut peer, 3, 21, 0.7);
    peer.send(&message(3, 22, &integers(&[1, 1])));
    peer.send(&message(3, 23, &doubles(&[1.0, 0.1])));
    wait_for("the stick", || {
        session.hub.axes_at(&sensor_name(1), session.clock.now())
    });
    let Session { hub, devices, .. } = session;
    devices.stop();

    let (replayed, time) = played(&file);
    for number in 1..=2 {
        let live = all_poses(&hub, &sensor_name(number), time);
        assert!(live.len() > 25, "{}", live.len());
        assert_eq!(all_poses(&replayed, &sensor_name(number), time), live);
    }
    let replay = Replay::open(&file).unwrap();
    let end = replay.end() + Duration::from_secs(1);
    let mut time = replay.start();
    let (mut pressed, wand) = (Vec::new(), sensor_name(2));
    while time < end {
        let buttons = hub.buttons_at(&wand, time);
        assert_eq!(replayed.buttons_at(&wand, time), buttons, "at {time:?}");
        if pressed.last() != Some(&buttons) {
            pressed.push(buttons);
        }
        time = time + Duration::from_micros(100);
    }
    assert_eq!(pressed, [None, Some(32), Some(0), Some(2)]);
    let stick = replayed.axes_at(&sensor_name(1), end);
    assert_eq!(stick, hub.axes_at(&sensor_name(1), end));
    assert!(stick.is_some());
}
