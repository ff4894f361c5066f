//! The whole way of a contact: simulated PINCH gloves on a pseudo-terminal, driver, hub, recording.
#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod replaying;
mod waiting;

use replaying::played;
use sandtable_config::{Rig, SensorName};
use sandtable_input::pinch::{
    self, ContactGroups, Faults, Motion, SimulatedPinch, Simulator, SimulatorSettings,
};
use sandtable_input::{
    Clock, Condition, Contacts, Devices, Fingers, HandState, Hub, Recorder, Replay,
    SimulatedDevice, StreamCounts,
};
use sandtable_pose::Nanos;
use serialport::{FlowControl, SerialPort};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use waiting::wait_for;

/// Pauses and patience short, so that tests are.
const QUICK: &str =
    "byte_pause = 0.002\nanswer_within = 0.2\nrelease_after = 0.05\nask_every = 0\n";

fn rig(port: &Path, settings: &str) -> Rig {
    let port = port.display();
    let text = format!(
        "name = 'p'\n[camera]\n[devices.pinch]\nkind = 'pinch'\nport = '{port}'\n{settings}"
    );
    Rig::parse(&text, "p").unwrap()
}

const NONE: Fingers = Fingers(0);
const PINCH: Fingers = Fingers(0b00011);
/// Thumb and little finger are the byte 0x11, which is XON; with the ring finger it is XOFF.
const XON: Fingers = Fingers(0b10001);
const XOFF: Fingers = Fingers(0b11001);

/// Both hands by turns, then nothing; each for so many milliseconds.
fn by_turns(lasting: u64, left: Fingers, right: Fingers) -> Motion {
    let states: [&[[Fingers; 2]]; 3] = [&[[left, NONE]], &[[NONE, right]], &[]];
    let lasting = Duration::from_millis(lasting);
    let state = |groups| (lasting, ContactGroups::new(groups).unwrap());
    Motion::Repeat(states.into_iter().map(state).collect())
}

fn settings(motion: Motion) -> SimulatorSettings {
    SimulatorSettings {
        baud: 38_400,
        motion,
        ..SimulatorSettings::default()
    }
}

/// A rig's gloves at work.
struct Session {
    hub: Arc<Hub>,
    clock: Clock,
    devices: Devices,
}

impl Session {
    fn start(port: &Path, settings: &str) -> Self {
        Self::start_recorded(&rig(port, settings), Clock::start(), None)
    }

    fn start_recorded(rig: &Rig, clock: Clock, recorder: Option<&Recorder>) -> Self {
        let hub = Arc::new(Hub::for_rig(rig));
        let devices = Devices::start(rig, &hub, clock, recorder).unwrap();
        Self {
            hub,
            clock,
            devices,
        }
    }

    fn counts(&self) -> StreamCounts {
        self.devices.states().remove(0).counts
    }

    /// The error that its device shows, if it is waiting for one to end.
    fn problem(&self) -> Option<String> {
        match self.devices.states().remove(0).condition {
            Condition::Waiting(text) => Some(text),
            Condition::Starting | Condition::Streaming => None,
        }
    }

    fn wait_for_problem(&self, words: &str) -> String {
        wait_for(words, || self.problem().filter(|text| text.contains(words)))
    }

    /// What the hands touch now, the left one first; `None` for one of which nothing is known.
    fn contacts(&self) -> [Option<Contacts>; 2] {
        contacts_at(&self.hub, self.clock.now())
    }

    /// Waits until a hand's thumb touches these fingers of its own hand, and no others.
    fn wait_until_thumb_touches(&self, hand: usize, fingers: Fingers) {
        wait_for(&format!("{fingers:?}"), || {
            let contacts = self.contacts()[hand]?;
            (contacts.own[0] == fingers).then_some(())
        });
    }

    /// The same, where the device has no problem until then.
    fn wait_until_thumb_touches_at_once(&self, hand: usize, fingers: Fingers) {
        wait_for(&format!("{fingers:?}"), || {
            assert_eq!(self.problem(), None);
            let contacts = self.contacts()[hand]?;
            (contacts.own[0] == fingers).then_some(())
        });
    }
}

fn hand_at(hub: &Hub, number: u32, time: Nanos) -> Option<HandState> {
    let sensor = SensorName {
        device: "pinch".into(),
        number,
    };
    hub.hand_at(&sensor, time)
}

fn contacts_at(hub: &Hub, time: Nanos) -> [Option<Contacts>; 2] {
    [1, 2].map(|number| hand_at(hub, number, time)?.contacts)
}

/// How often hands were let go by the mere passing of time, each of which is replayed at its time.
fn releases(file: &Path) -> usize {
    let bytes = std::fs::read(file).unwrap();
    let messages = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap);
    let empty = messages
        .filter(|message| message.channel.topic == "/devices/pinch/bytes")
        .filter(|message| message.data.is_empty());
    let times: Vec<_> = empty.map(|message| Nanos(message.log_time)).collect();
    let mut replay = Replay::open(file).unwrap();
    let hub = Hub::for_rig(replay.rig());
    for time in &times {
        replay.advance_to(*time, &hub);
        assert_eq!(contacts_at(&hub, *time), [None; 2], "at {time:?}");
    }
    times.len()
}

#[test]
fn contacts_arrive_on_either_hand_with_and_without_timestamps() {
    for timestamps in [false, true] {
        let motion = by_turns(150, PINCH, Fingers(0b00101));
        let simulator = Simulator::start(settings(motion), None).unwrap();
        let quick = format!("{QUICK}timestamps = {timestamps}");
        let session = Session::start(simulator.path(), &quick);
        session.wait_until_thumb_touches(0, Fingers::INDEX);
        session.wait_until_thumb_touches(1, Fingers::MIDDLE);
        session.wait_until_thumb_touches(1, NONE);
        let counts = session.counts();
        assert_eq!((counts.stray_bytes, counts.implausible), (0, 0));
        assert_eq!(session.problem(), None);
        session.devices.stop();
        simulator.stop();
    }
}

#[test]
fn the_bytes_of_xon_and_xoff_are_fingers() {
    let simulator = Simulator::start(settings(by_turns(150, XON, XOFF)), None).unwrap();
    // As another program may have left the line.
    let path = simulator.path().display().to_string();
    let other = serialport::new(path, 9600).flow_control(FlowControl::Software);
    let other = other.open_native().unwrap();
    assert_eq!(other.flow_control().unwrap(), FlowControl::Software);
    drop(other);
    let session = Session::start(simulator.path(), QUICK);
    session.wait_until_thumb_touches(0, Fingers::LITTLE);
    session.wait_until_thumb_touches(1, Fingers::LITTLE.with(Fingers::RING));
    assert_eq!(session.counts().implausible, 0);
}

#[test]
fn a_box_left_amid_a_command_gets_into_step() {
    let mut device = SimulatedPinch::new(settings(by_turns(150, PINCH, PINCH)));
    device.receive(b"C", Duration::ZERO);
    let simulator = Simulator::start(device, None).unwrap();
    let session = Session::start(simulator.path(), QUICK);
    session.wait_until_thumb_touches_at_once(0, Fingers::INDEX);
}

#[test]
fn a_silent_line_is_no_hang_and_is_named_with_its_remedy() {
    // A terminal with nobody behind it.
    let (_host, device) = serialport::TTYPort::pair().unwrap();
    let path = device.name().unwrap();
    let session = Session::start(Path::new(&path), QUICK);
    let problem = session.wait_for_problem("does not answer");
    for needle in [path.as_str(), "to get into step", "power", "9600 baud"] {
        assert!(problem.contains(needle), "{problem}");
    }
    // It is tried again, and can be stopped at any time.
    wait_for("another try", || session.problem().is_none().then_some(()));
    session.devices.stop();
}

#[test]
fn a_missing_port_says_so_and_what_helps() {
    let session = Session::start(Path::new("/dev/ttyMISSING7"), QUICK);
    let problem = session.wait_for_problem("/dev/ttyMISSING7");
    assert!(problem.contains("sandtable doctor"), "{problem}");
}

/// What another device, or one at another speed, sends before it answers, if it ever does.
#[derive(Debug)]
struct Garbage {
    bytes: &'static [u8],
    left: usize,
    then: Option<SimulatedPinch>,
}

impl SimulatedDevice for Garbage {
    fn receive(&mut self, bytes: &[u8], now: Duration) {
        if let (0, Some(then)) = (self.left, &mut self.then) {
            then.receive(bytes, now);
        }
    }

    fn send(&mut self, now: Duration) -> Vec<u8> {
        if self.left > 0 {
            self.left -= 1;
            return self.bytes.to_vec();
        }
        let then = self.then.as_mut();
        then.map_or_else(Vec::new, |then| then.send(now))
    }

    fn quiet_for(&self, _: Duration) -> Option<Duration> {
        Some(Duration::from_millis(5))
    }
}

#[test]
fn garbage_is_told_apart_from_silence_and_believed_never() {
    let device = Garbage {
        bytes: &[0x55, 0x18, 0x8F, 0xFF, 0x80, 0x18],
        left: usize::MAX,
        then: None,
    };
    let simulator = sandtable_input::Simulator::<Garbage>::start(device, None).unwrap();
    let session = Session::start(simulator.path(), QUICK);
    let problem = session.wait_for_problem("no messages of a PINCH box");
    assert!(problem.contains("9600 baud"), "{problem}");
    assert_eq!(session.contacts(), [None; 2]);
    assert_eq!(session.counts().samples, 0);
}

#[test]
fn garbage_before_the_first_message_does_no_harm() {
    let device = Garbage {
        // An answer to somebody else is among it.
        bytes: &[0xFF, 0x18, 0x82, 0x30, 0x8F, 0x80, 0x18],
        left: 20,
        then: Some(SimulatedPinch::new(settings(by_turns(150, PINCH, PINCH)))),
    };
    let simulator = sandtable_input::Simulator::<Garbage>::start(device, None).unwrap();
    let session = Session::start(simulator.path(), QUICK);
    session.wait_until_thumb_touches_at_once(0, Fingers::INDEX);
    assert!(session.counts().stray_bytes > 0);
}

/// A box that says something at the first byte of each command, as an answer to another host that
/// comes late, and takes its time for its own.
#[derive(Debug)]
struct Chatty {
    gloves: SimulatedPinch,
    amid_command: bool,
    said: Vec<u8>,
    asked: Duration,
}

impl SimulatedDevice for Chatty {
    fn receive(&mut self, bytes: &[u8], now: Duration) {
        for byte in bytes {
            self.amid_command = !self.amid_command;
            if self.amid_command {
                pinch::encode_text("9", &mut self.said);
            } else {
                self.asked = now;
            }
            self.gloves.receive(&[*byte], now);
        }
    }

    fn send(&mut self, now: Duration) -> Vec<u8> {
        let mut bytes = std::mem::take(&mut self.said);
        if now > self.asked + Duration::from_millis(70) {
            bytes.extend(self.gloves.send(now));
        }
        bytes
    }

    fn quiet_for(&self, _: Duration) -> Option<Duration> {
        Some(Duration::from_millis(1))
    }
}

#[test]
fn what_came_before_a_commands_end_answers_something_else() {
    let device = Chatty {
        gloves: SimulatedPinch::new(settings(by_turns(150, PINCH, PINCH))),
        amid_command: false,
        said: Vec::new(),
        asked: Duration::ZERO,
    };
    let simulator = sandtable_input::Simulator::<Chatty>::start(device, None).unwrap();
    // Long enough for it to be read before the second byte is sent.
    let slowly = QUICK.replace("byte_pause = 0.002", "byte_pause = 0.1");
    let slowly = slowly.replace("answer_within = 0.2", "answer_within = 1.0");
    let session = Session::start(simulator.path(), &slowly);
    wait_for("a box that streams", || {
        assert_eq!(session.problem(), None);
        let condition = session.devices.states().remove(0).condition;
        (condition == Condition::Streaming).then_some(())
    });
}

#[test]
fn a_glove_may_be_missing_but_not_both() {
    let one = SimulatorSettings {
        gloves: [false, true],
        ..settings(by_turns(150, PINCH, PINCH))
    };
    let simulator = Simulator::start(one.clone(), None).unwrap();
    let session = Session::start(simulator.path(), QUICK);
    session.wait_until_thumb_touches(1, Fingers::INDEX);
    let none = SimulatorSettings {
        gloves: [false; 2],
        ..one
    };
    let simulator = Simulator::start(none, None).unwrap();
    let session = Session::start(simulator.path(), QUICK);
    let problem = session.wait_for_problem("no glove is plugged into");
    assert!(problem.contains("plug one in"), "{problem}");
}

#[test]
fn a_box_that_no_longer_answers_lets_go_and_comes_back() {
    let held = ContactGroups::new(&[[PINCH, NONE]]).unwrap();
    let simulator = Simulator::start(
        SimulatorSettings {
            faults: Faults {
                stalls: vec![(Duration::from_secs(1), Duration::from_millis(2000))],
                ..Faults::default()
            },
            ..settings(Motion::Repeat(vec![(Duration::from_millis(3500), held)]))
        },
        None,
    )
    .unwrap();
    let quick = QUICK.replace("ask_every = 0", "ask_every = 0.2");
    let session = Session::start(simulator.path(), &quick);
    session.wait_until_thumb_touches(0, Fingers::INDEX);
    // Held without a word, and asked several times meanwhile.
    let problem = session.wait_for_problem("does not answer when asked whether it is there");
    assert!(problem.contains("power"), "{problem}");
    assert_eq!(session.contacts(), [None; 2]);
    session.wait_until_thumb_touches(0, Fingers::INDEX);
    assert_eq!(session.problem(), None);
}

#[test]
fn a_box_that_is_not_asked_holds_for_as_long_as_it_is_silent() {
    let held = ContactGroups::new(&[[PINCH, NONE]]).unwrap();
    let motion = Motion::Repeat(vec![(Duration::from_secs(3600), held)]);
    let simulator = Simulator::start(settings(motion), None).unwrap();
    let session = Session::start(simulator.path(), QUICK);
    session.wait_until_thumb_touches(0, Fingers::INDEX);
    let hour = session.clock.now() + Duration::from_secs(3600);
    assert!(contacts_at(&session.hub, hour)[0].is_some());
}

#[test]
fn lost_bytes_and_a_closed_port_tell_no_false_contact_and_all_of_it_replays() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("p.mcap"), folder.path().join("pinch"));
    let bad = SimulatorSettings {
        faults: Faults {
            drop_every: Some(11),
            ..Faults::default()
        },
        ..settings(by_turns(120, PINCH, XON))
    };
    let simulator = Simulator::start(bad.clone(), Some(&link)).unwrap();
    let rig = rig(&link, QUICK);
    let clock = Clock::start();
    let recorder = Recorder::create(&file, &rig, None, clock.now()).unwrap();
    let session = Session::start_recorded(&rig, clock, Some(&recorder));
    let heard = |samples| {
        wait_for("samples", || {
            (session.counts().samples >= samples).then_some(())
        });
    };
    heard(24);
    simulator.stop();
    session.wait_for_problem("pinch");
    assert_eq!(session.contacts(), [None; 2]);
    let simulator = Simulator::start(bad.clone(), Some(&link)).unwrap();
    heard(48);
    simulator.stop();
    session.wait_for_problem("pinch");
    let Session { hub, devices, .. } = session;
    let counts = devices.states().remove(0).counts;
    devices.stop();
    recorder.finish().unwrap();
    // One of eleven bytes lost is one of three or four messages.
    assert!(counts.stray_bytes + counts.implausible > 4, "{counts:?}");

    let (replayed, time) = played(&file);
    assert!(releases(&file) > 2, "a release is a read of nothing");
    let states: Vec<[Contacts; 2]> = (0..3)
        .map(|number| bad.motion.change(number).unwrap().1.contacts())
        .collect();
    let (mut seen, mut let_go, mut before) = ([false; 3], 0, false);
    for step in 0..time.0 / 200_000 {
        let time = Nanos(step * 200_000);
        for number in 1..=2 {
            let live = hand_at(&hub, number, time);
            assert_eq!(hand_at(&replayed, number, time), live, "at {time:?}");
        }
        let known = match contacts_at(&hub, time) {
            [Some(left), Some(right)] => {
                let told = states.iter().position(|state| *state == [left, right]);
                seen[told.expect("a state was told that was never sent")] = true;
                true
            }
            [None, None] => false,
            one => panic!("one hand is known and the other not: {one:?}"),
        };
        let_go += u32::from(before && !known);
        before = known;
    }
    assert_eq!(seen, [true; 3]);
    // Twice by the port, and else by damage.
    assert!(let_go > 4, "{let_go}");
}
