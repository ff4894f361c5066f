//! The VRPN server: read by a client made by hand, by our own, and by some that mean no good.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod vrpn_by_hand;
mod waiting;

use glam::{DQuat, DVec3};
use sandtable_config::{Rig, SensorName};
use sandtable_input::vrpn::{ServerError, VrpnServer, VrpnServerSettings};
use sandtable_input::{
    AXES, AxesSample, ButtonsSample, Clock, Contacts, Devices, Fingers, Flexion, HandSample,
    HandState, Hub, PoseSample, Sample,
};
use sandtable_pose::{Nanos, Rigid, Validity};
use std::collections::BTreeMap;
use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::Duration;
use vrpn_by_hand::{COOKIE, Message, Peer, kind, message, sender};
use waiting::{PATIENCE, wait_for};

const LOOPBACK: VrpnServerSettings = VrpnServerSettings {
    bind: SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0),
    most_guests: 256,
};

/// A hub of the workbench, whose Flock is what the test says, and its server.
struct Session {
    hub: Arc<Hub>,
    clock: Clock,
    server: VrpnServer,
}

impl Session {
    fn start() -> Self {
        Self::with(&LOOPBACK)
    }

    fn with(settings: &VrpnServerSettings) -> Self {
        let hub = Arc::new(Hub::for_rig(&Rig::builtin("workbench").unwrap()));
        let clock = Clock::start();
        let server = VrpnServer::start(settings, &hub, clock).unwrap();
        Self { hub, clock, server }
    }

    fn push(&self, sample: Sample) {
        self.hub.push("flock", sample);
    }

    fn pose(&self, sensor: u32, x: f64, frozen: bool) {
        self.push(Sample::Pose(PoseSample {
            sensor,
            time: self.clock.now(),
            table_from_sensor: Rigid::new(turn(), DVec3::new(x, -0.25, 0.5)),
            frozen,
        }));
    }

    fn press(&self, sensor: u32, pressed: u64) {
        let time = self.clock.now();
        self.push(Sample::Buttons(ButtonsSample {
            sensor,
            time,
            pressed,
        }));
    }

    fn connect(&self) -> Peer {
        Peer::new(TcpStream::connect(self.server.address()).unwrap())
    }

    /// A client that is known, and what it has been told.
    fn guest(&self) -> Guest {
        let mut peer = self.connect();
        peer.send(&COOKIE);
        assert_eq!(peer.bytes(24, PATIENCE).unwrap(), COOKIE);
        Guest {
            peer,
            senders: BTreeMap::new(),
            kinds: BTreeMap::new(),
        }
    }
}

fn turn() -> DQuat {
    DQuat::from_xyzw(0.5, -0.5, 0.5, 0.5)
}

/// A client by hand, which keeps the server's numbers.
struct Guest {
    peer: Peer,
    senders: BTreeMap<i32, String>,
    kinds: BTreeMap<i32, String>,
}

impl Guest {
    /// The next report: its sender, its type, and the message.
    fn report(&mut self) -> (String, String, Message) {
        self.report_within(PATIENCE).unwrap()
    }

    fn report_within(&mut self, within: Duration) -> Option<(String, String, Message)> {
        loop {
            let said = self.peer.message(within)?;
            match said.kind {
                -1 => drop(self.senders.insert(said.sender, said.name().to_owned())),
                -2 => drop(self.kinds.insert(said.sender, said.name().to_owned())),
                number => {
                    let sender = self.senders[&said.sender].clone();
                    return Some((sender, self.kinds[&number].clone(), said));
                }
            }
        }
    }

    /// Asks the first sender, by numbers of its own, and waits for the answer: what was said
    /// before has been heard then.
    fn ping(&mut self) {
        self.peer.send(
            &[
                sender(42, "flock"),
                kind(17, "vrpn_Base ping_message"),
                message(42, 17, &[]),
            ]
            .concat(),
        );
        let (sender, kind, said) = self.report();
        assert_eq!(
            (sender.as_str(), kind.as_str()),
            ("flock", "vrpn_Base pong_message")
        );
        assert!(said.payload.is_empty());
    }
}

#[test]
fn a_client_by_hand_reads_poses() {
    let session = Session::start();
    let mut guest = session.guest();
    guest.ping();
    assert_eq!(
        guest.senders.values().collect::<Vec<_>>(),
        ["flock", "flock/2"]
    );
    session.pose(2, 0.125, false);
    let (sender, kind, said) = guest.report();
    assert_eq!(
        (sender.as_str(), kind.as_str()),
        ("flock", "vrpn_Tracker Pos_Quat")
    );
    assert_eq!(said.payload.len(), 64);
    assert_eq!(said.integer(0), 1);
    let numbers: Vec<f64> = (0..7).map(|n| said.double(8 + 8 * n)).collect();
    assert_eq!(numbers, [0.125, -0.25, 0.5, 0.5, -0.5, 0.5, 0.5]);
    // Dated by this computer's own day.
    assert!(said.seconds > 1_700_000_000 && said.microseconds < 1_000_000);
    // Every sample once, and in its order.
    for step in 0..100 {
        session.pose(1, f64::from(step), false);
    }
    for step in 0..100 {
        let (_, _, said) = guest.report();
        assert_eq!((said.integer(0), said.double(8)), (0, f64::from(step)));
    }
}

#[test]
fn a_lost_sensor_goes_silent() {
    let session = Session::start();
    let mut guest = session.guest();
    guest.ping();
    session.pose(1, 1.0, true);
    session.pose(1, 2.0, false);
    assert_eq!(guest.report().2.double(8), 2.0);
    assert!(guest.report_within(Duration::from_millis(100)).is_none());
}

#[test]
fn a_late_client_learns_what_is_held() {
    let session = Session::start();
    session.press(2, 0b101);
    let mut early = session.guest();
    let (sender, kind, said) = early.report();
    assert_eq!(
        (sender.as_str(), kind.as_str()),
        ("flock/2", "vrpn_Button States")
    );
    let states: Vec<i32> = (0..said.payload.len() / 4)
        .map(|n| said.integer(4 * n))
        .collect();
    assert_eq!(states, [3, 1, 0, 1]);
    // Changes one by one.
    session.press(2, 0b110);
    session.press(2, 0b110);
    session.press(1, 1 << 63);
    let mut changes = Vec::new();
    for _ in 0..3 {
        let (sender, kind, said) = early.report();
        assert_eq!(kind, "vrpn_Button Change");
        changes.push((sender, said.integer(0), said.integer(4)));
    }
    let of = |sender: &str, button, state| (sender.to_owned(), button, state);
    assert_eq!(
        changes,
        [of("flock/2", 0, 0), of("flock/2", 1, 1), of("flock", 63, 1)]
    );
    let mut late = session.guest();
    let (sender, _, said) = late.report();
    assert_eq!((sender.as_str(), said.integer(0)), ("flock", 64));
    assert_eq!((said.integer(4), said.integer(4 * 64)), (0, 1));
    let (sender, _, said) = late.report();
    let states: Vec<i32> = (0..4).map(|n| said.integer(4 * n)).collect();
    assert_eq!(
        (sender.as_str(), states.as_slice()),
        ("flock/2", &[3, 0, 1, 1][..])
    );
}

#[test]
fn axes_and_bent_fingers_are_analogs() {
    let session = Session::start();
    let mut guest = session.guest();
    guest.ping();
    let mut values = [0.0; AXES];
    values[..2].copy_from_slice(&[-1.0, 0.75]);
    let time = session.clock.now();
    session.push(Sample::Axes(AxesSample {
        sensor: 2,
        time,
        values,
        count: 2,
    }));
    let mut hand = HandState {
        flexion: [0.0, 0.25, 0.5, 0.75, 1.0].map(|bent| Some(Flexion::of_one_sensor(bent))),
        contacts: None,
    };
    let push = |hand| {
        session.push(Sample::Hand(HandSample {
            sensor: 1,
            time,
            hand,
        }));
    };
    push(hand);
    // A finger that is not known any more stays as it was.
    hand.flexion[4] = None;
    hand.flexion[0] = Some(Flexion {
        near: 0.25,
        far: 0.75,
    });
    push(hand);
    for (expected, channels) in [
        ("flock/2", &[2.0, -1.0, 0.75][..]),
        ("flock", &[5.0, 0.0, 0.25, 0.5, 0.75, 1.0]),
        ("flock", &[5.0, 0.5, 0.25, 0.5, 0.75, 1.0]),
    ] {
        let (sender, kind, said) = guest.report();
        assert_eq!(
            (sender.as_str(), kind.as_str()),
            (expected, "vrpn_Analog Channel")
        );
        let numbers: Vec<f64> = (0..said.payload.len() / 8)
            .map(|n| said.double(8 * n))
            .collect();
        assert_eq!(numbers, channels);
    }
    // A late client is told them too.
    assert_eq!(session.guest().report().1, "vrpn_Analog Channel");
}

#[test]
fn touching_fingers_are_buttons_until_the_hand_is_let_go() {
    let session = Session::start();
    let mut guest = session.guest();
    guest.ping();
    let push = |contacts| {
        let (time, flexion) = (session.clock.now(), Default::default());
        let hand = HandState { flexion, contacts };
        session.push(Sample::Hand(HandSample {
            sensor: 2,
            time,
            hand,
        }));
    };
    let mut contacts = Contacts::default();
    contacts.own[0] = Fingers::INDEX;
    contacts.own[1] = Fingers::THUMB;
    contacts.other[4] = Fingers::THUMB;
    push(Some(contacts));
    push(None);
    for state in [1, 0] {
        for button in [0, 1, 4] {
            let (sender, kind, said) = guest.report();
            assert_eq!(
                (sender.as_str(), kind.as_str()),
                ("flock/2", "vrpn_Button Change")
            );
            assert_eq!([said.integer(0), said.integer(4)], [button, state]);
        }
    }
}

#[test]
fn a_hand_that_comes_with_axes_and_buttons_is_told_once() {
    let session = Session::start();
    let mut guest = session.guest();
    guest.ping();
    let channels = |said: &Message| -> Vec<f64> {
        let numbers = said.double(0) as usize;
        (1..=numbers).map(|n| said.double(8 * n)).collect()
    };
    // As a glove of another server comes: raw channels, a stick behind them, and fingers of both.
    let push = |raw: f64, bent: Option<f64>, touch: Option<Contacts>, own: u64| {
        let time = session.clock.now();
        let mut values = [0.0; AXES];
        values[..6].copy_from_slice(&[raw, raw, raw, raw, raw, 0.125]);
        session.push(Sample::Axes(AxesSample {
            sensor: 1,
            time,
            values,
            count: 6,
        }));
        session.press(1, own);
        session.push(Sample::Hand(HandSample {
            sensor: 1,
            time,
            hand: HandState {
                flexion: [bent.map(Flexion::of_one_sensor); 5],
                contacts: touch,
            },
        }));
    };
    let mut pinch = Contacts::default();
    pinch.own[0] = Fingers::INDEX;
    pinch.own[1] = Fingers::THUMB;
    // Until its fingers are known, what there is is the channels; a button of its own stays down.
    push(0.5, None, None, 1 << 5);
    assert_eq!(
        channels(&guest.report().2),
        [0.5, 0.5, 0.5, 0.5, 0.5, 0.125]
    );
    let button = |guest: &mut Guest| {
        let (_, kind, said) = guest.report();
        assert_eq!(kind, "vrpn_Button Change");
        [said.integer(0), said.integer(4)]
    };
    assert_eq!(button(&mut guest), [5, 1]);
    push(0.75, Some(1.0), Some(pinch), 1 << 5);
    // Known for the first time, they come behind the channels that they take the place of.
    assert_eq!(channels(&guest.report().2)[0], 0.75);
    assert_eq!(
        channels(&guest.report().2),
        [1.0, 1.0, 1.0, 1.0, 1.0, 0.125]
    );
    assert_eq!([(); 2].map(|()| button(&mut guest)), [[0, 1], [1, 1]]);
    // From then on once a sample, and no raw value among them; of buttons, what has changed.
    for bent in [0.25, 0.5] {
        push(0.625, Some(bent), Some(pinch), 1 << 5 | 1);
        assert_eq!(
            channels(&guest.report().2),
            [bent, bent, bent, bent, bent, 0.125]
        );
    }
    push(0.625, Some(0.5), Some(Contacts::default()), 0);
    assert_eq!(button(&mut guest), [5, 0]);
    assert_eq!(guest.report().1, "vrpn_Analog Channel");
    assert_eq!([(); 2].map(|()| button(&mut guest)), [[0, 0], [1, 0]]);
    assert!(guest.report_within(Duration::from_millis(100)).is_none());
}

#[test]
fn our_client_reads_our_server() {
    let session = Session::start();
    session.press(2, 0b10);
    let text = format!(
        "name = 'lab'\ncamera = {{ horizontal_fov = 60.0 }}\n[devices.t]\nkind = 'vrpn'\n\
         address = 'flock@{}'\nsensors = 2\nbuttons = {{ sender = 'flock/2', sensor = 2 }}\n\
         analogs = {{ sender = 'flock/2', sensor = 2 }}\n\
         table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}",
        session.server.address()
    );
    let rig = Rig::parse(&text, "lab.toml").unwrap();
    let hub = Arc::new(Hub::for_rig(&rig));
    let clock = Clock::start();
    let devices = Devices::start(&rig, &hub, clock, None).unwrap();
    let name = |number| SensorName {
        device: "t".into(),
        number,
    };
    wait_for("what is held", || {
        (hub.buttons_at(&name(2), clock.now()) == Some(0b10)).then_some(())
    });
    let mut x = 0.0;
    let pose = wait_for("live poses", || {
        x += 1e-3;
        session.pose(1, x, false);
        session.pose(2, x + 1.0, false);
        let live = |n| {
            let pose = hub.pose_at(&name(n), clock.now());
            pose.filter(|pose| pose.validity == Validity::Live)
        };
        live(1).and(live(2))
    });
    // To the bit: nothing is scaled or turned on the way.
    let place = pose.frame_from_body.translation;
    assert!((1.0..=1.0 + x).contains(&place.x) && (place.y, place.z) == (-0.25, 0.5));
    assert_eq!(pose.frame_from_body.rotation, turn());
    session.press(2, 0);
    wait_for("the release", || {
        (hub.buttons_at(&name(2), clock.now()) == Some(0)).then_some(())
    });
    assert_eq!(session.server.guests(), 1);
    devices.stop();
    wait_for("the client's end", || {
        (session.server.guests() == 0).then_some(())
    });
    assert_eq!(session.server.sent_away(), 0);
}

#[test]
fn a_client_that_never_reads_is_sent_away_and_the_others_miss_nothing() {
    let session = Session::start();
    let deaf = session.guest();
    let mut good = session.guest();
    good.ping();
    let mut step = 0.0;
    let mut next = 0.0;
    while session.server.sent_away() == 0 {
        for _ in 0..200 {
            session.pose(1, step, false);
            step += 1.0;
        }
        while next < step {
            let (_, _, said) = good.report();
            assert_eq!(said.double(8), next, "a sample is missing");
            next += 1.0;
        }
        assert!(
            step < 1e6,
            "a million samples wait for a client that never reads"
        );
    }
    wait_for("one guest less", || {
        (session.server.guests() == 1).then_some(())
    });
    drop(deaf);
    good.ping();
}

#[test]
fn clients_that_mean_no_good_harm_nobody() {
    let session = Session::start();
    let mut good = session.guest();
    good.ping();
    let mut strangers = Vec::new();
    for n in 0..60 {
        let mut peer = session.connect();
        let mut long = message(0, 5, &[]);
        long[..4].copy_from_slice(&0x8000_0000u32.to_be_bytes());
        let junk: Vec<u8> = match n % 5 {
            // Silent, half a cookie, a wrong one, half a header, an impossible length.
            0 => Vec::new(),
            1 => COOKIE[..11].to_vec(),
            2 => b"GET / HTTP/1.1\r\nHost: lab-pc\r\n\r\n".to_vec(),
            3 => [&COOKIE[..], &[0, 0, 0, 99, 1, 2]].concat(),
            _ => [&COOKIE[..], &long].concat(),
        };
        // It may be sent away while it still speaks.
        let _ = peer.socket.write_all(&junk);
        strangers.push(peer);
    }
    for step in 0..50 {
        session.pose(1, f64::from(step), false);
        assert_eq!(good.report().2.double(8), f64::from(step));
    }
    // All but those with half a header, who may yet finish it, and the good one.
    wait_for("the strangers' end", || {
        (session.server.guests() == 13).then_some(())
    });
    assert_eq!(session.server.sent_away(), 48);
    good.ping();
}

#[test]
fn pings_without_end_are_no_way_to_fill_the_memory() {
    let session = Session::start();
    let mut peer = session.guest().peer;
    let hello = [sender(1, "flock"), kind(2, "vrpn_Base ping_message")].concat();
    peer.send(&hello);
    let pings = message(1, 2, &[]).repeat(1000);
    peer.socket
        .set_write_timeout(Some(Duration::from_millis(20)))
        .unwrap();
    wait_for("the end of the pings", || {
        let _ = peer.socket.write(&pings);
        (session.server.sent_away() == 1).then_some(())
    });
    session.guest().ping();
}

#[test]
fn too_many_guests_are_turned_away_at_the_door() {
    let session = Session::with(&VrpnServerSettings {
        most_guests: 2,
        ..LOOPBACK
    });
    let mut guests = [session.guest(), session.guest()];
    guests.iter_mut().for_each(Guest::ping);
    // Who is let in is shown a cookie first of all.
    assert_eq!(session.connect().bytes(24, PATIENCE), None);
    assert_eq!(session.server.sent_away(), 1);
    let [first, mut second] = guests;
    drop(first);
    wait_for("the free place", || {
        (session.server.guests() == 1).then_some(())
    });
    session.guest().ping();
    second.ping();
}

#[test]
fn it_listens_on_the_loopback_and_says_what_is_wrong_elsewhere() {
    let default = VrpnServerSettings::default();
    assert_eq!(default.bind, "127.0.0.1:3883".parse().unwrap());
    let session = Session::start();
    let hub = &session.hub;
    let error = |bind: SocketAddr| {
        let settings = VrpnServerSettings { bind, ..LOOPBACK };
        let error = VrpnServer::start(&settings, hub, session.clock).unwrap_err();
        assert!(matches!(error, ServerError::Bind { .. }));
        error.to_string()
    };
    let taken = session.server.address();
    let said = error(taken);
    assert!(
        said.contains(&taken.to_string()) && said.contains("name a port"),
        "{said}"
    );
    let said = error("192.0.2.1:0".parse().unwrap());
    assert!(
        said.contains("192.0.2.1") && said.contains("0.0.0.0"),
        "{said}"
    );
}

#[test]
fn nothing_is_left_behind_after_a_stop() {
    let session = Session::start();
    let mut guest = session.guest();
    guest.ping();
    let address = session.server.address();
    // It waits for the thread, which owns all sockets.
    session.server.stop();
    assert!(guest.peer.is_closed());
    // The port is free, so nobody holds it.
    let again = VrpnServerSettings {
        bind: address,
        ..LOOPBACK
    };
    let server = VrpnServer::start(&again, &session.hub, session.clock).unwrap();
    assert_eq!(server.address(), address);
    // The hub forgets who has gone.
    session.hub.push(
        "flock",
        Sample::Buttons(ButtonsSample {
            sensor: 1,
            time: Nanos(0),
            pressed: 0,
        }),
    );
}
