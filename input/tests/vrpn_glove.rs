//! The whole way of a glove by VRPN: a simulated one, its stream, our server, our client, its hand.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod waiting;

use sandtable_config::{Device, Gesture, Rig, SensorName};
use sandtable_input::data_glove::{Motion, SimulatedDataGlove, SimulatorSettings};
use sandtable_input::hand::GestureRecogniser;
use sandtable_input::pinch::{ContactGroups, ContactMessage};
use sandtable_input::vrpn::{VrpnServer, VrpnServerSettings};
use sandtable_input::{
    Clock, Contacts, Devices, Fingers, Flexion, HandState, Hub, Stream, stream_of,
};
use sandtable_pose::Nanos;
use std::net::SocketAddr;
use std::sync::Arc;
use waiting::wait_for;

/// On a slow machine.
fn rig(devices: &str) -> Rig {
    Rig::parse(&format!("name = 'g'\n[camera]\n{devices}"), "g.toml").unwrap()
}

fn sensor(device: &str, number: u32) -> SensorName {
    SensorName {
        device: device.into(),
        number,
    }
}

/// A rig's hands with the server that offers them.
struct Offered {
    rig: Rig,
    hub: Arc<Hub>,
    server: VrpnServer,
}

impl Offered {
    fn start(devices: &str) -> Self {
        let rig = rig(devices);
        let hub = Arc::new(Hub::for_rig(&rig));
        let settings = VrpnServerSettings {
            bind: SocketAddr::from(([127, 0, 0, 1], 0)),
            ..VrpnServerSettings::default()
        };
        let server = VrpnServer::start(&settings, &hub, Clock::start()).unwrap();
        Self { rig, hub, server }
    }

    fn stream(&self, device: &str) -> Box<dyn Stream> {
        stream_of(&self.rig.devices[device])
    }

    fn push(&self, device: &str, stream: &mut dyn Stream, bytes: &[u8], time: Nanos) {
        stream.push(bytes, time, &mut |sample| self.hub.push(device, sample));
    }

    fn hand(&self, device: &str, number: u32) -> Option<HandState> {
        self.hub.hand_at(&sensor(device, number), Nanos(u64::MAX))
    }
}

/// A rig of VRPN clients, all of them connected.
struct Clients {
    rig: Rig,
    hub: Arc<Hub>,
    _devices: Devices,
}

impl Clients {
    /// Each device is a name, a sender, and what else is said of it.
    fn connect(offered: &Offered, devices: &[(&str, &str, &str)]) -> Self {
        let address = offered.server.address();
        let device = |(name, sender, lines): &(&str, &str, &str)| {
            format!(
                "[devices.{name}]\nkind = 'vrpn'\naddress = '{sender}@{address}'\n{lines}\n\
                 table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}\n"
            )
        };
        let rig = rig(&devices.iter().map(device).collect::<String>());
        let hub = Arc::new(Hub::for_rig(&rig));
        let connected = Devices::start(&rig, &hub, Clock::start(), None).unwrap();
        wait_for("the guests", || {
            (offered.server.guests() == devices.len()).then_some(())
        });
        Self {
            rig,
            hub,
            _devices: connected,
        }
    }

    fn hand(&self, device: &str) -> Option<HandState> {
        self.hub.hand_at(&sensor(device, 1), Nanos(u64::MAX))
    }

    fn gestures(&self, device: &str) -> GestureRecogniser {
        GestureRecogniser::new(self.rig.devices[device].gestures().unwrap().clone())
    }
}

fn mean(hand: Option<HandState>) -> [Option<f64>; 5] {
    let flexion = hand.unwrap_or_default().flexion;
    flexion.map(|flexion| flexion.map(Flexion::mean))
}

#[test]
fn a_simulated_glove_is_the_same_hand_behind_a_server() {
    let range = |sensor| format!("{:?}", SimulatedDataGlove::range(sensor));
    let ranges: Vec<_> = (0..5).map(range).collect();
    let offered = Offered::start(&format!(
        "[devices.glove]\nkind = 'data-glove'\nhand = 'right'\nsensors = 5\n\
         auto_calibration = false\nranges = [{}]\n",
        ranges.join(", ")
    ));
    let Device::DataGlove(described) = &offered.rig.devices["glove"] else {
        panic!("it is a data glove");
    };
    let settings = SimulatorSettings {
        motion: Motion::Played(2),
        noise: 0,
        ..SimulatorSettings::default()
    };
    let glove = SimulatedDataGlove::new(described, settings);
    let mut stream = offered.stream("glove");
    // One that is told the ranges, and one that learns them.
    let known = "auto_calibration = false\nfingers = { thumb = { channel = 0, range = [0, 1] }, \
                 index = { channel = 1, range = [0, 1] }, middle = { channel = 2, range = [0, 1] }, \
                 ring = { channel = 3, range = [0, 1] }, little = { channel = 4, range = [0, 1] } }";
    let learns = "fingers = { thumb = 0, index = 1, middle = 2, ring = 3, little = 4 }";
    let clients = Clients::connect(
        &offered,
        &[("known", "glove", known), ("learns", "glove", learns)],
    );
    assert_eq!(clients.hand("known"), None);

    let mut ours = GestureRecogniser::new(described.gestures.clone());
    let mut theirs = ["known", "learns"].map(|device| clients.gestures(device));
    let mut seen = std::collections::BTreeSet::new();
    // Every fifth report, so that most of them differ from the one before; after two seconds the
    // hand has been opened and closed.
    for number in (0..75 * 12).step_by(5) {
        let time = Nanos(0) + glove.time(number);
        offered.push("glove", stream.as_mut(), &glove.report(number), time);
        let expected = mean(offered.hand("glove", 1));
        let played = number >= 2 * 75;
        wait_for("the hand", || {
            let known = mean(clients.hand("known")) == expected;
            let learns = !played || mean(clients.hand("learns")) == expected;
            (known && learns).then_some(())
        });
        let gesture = ours.update(time, offered.hand("glove", 1).as_ref());
        let [known, learns] = ["known", "learns"].map(|device| clients.hand(device));
        assert_eq!(theirs[0].update(time, known.as_ref()), gesture, "{number}");
        let learnt = theirs[1].update(time, learns.as_ref());
        if number >= 3 * 75 {
            assert_eq!(learnt, gesture, "{number}");
        }
        seen.extend(gesture.map(|gesture| format!("{gesture:?}")));
    }
    let all = [Gesture::Open, Gesture::Grab, Gesture::Point, Gesture::Pinch];
    for gesture in all {
        assert!(seen.contains(&format!("{gesture:?}")), "{seen:?}");
    }
}

#[test]
fn pinch_gloves_behind_a_server_tell_what_buttons_can() {
    let offered = Offered::start("[devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n");
    let mut stream = offered.stream("pinch");
    // Told before anyone listens: open hands, of which the server has only their standing to tell.
    offered.push("pinch", stream.as_mut(), &[0x80, 0x8F], Nanos(50_000_000));
    let touching = "touching = { thumb = 0, index = 1, middle = 2, ring = 3, little = 4 }";
    let clients = Clients::connect(
        &offered,
        &[("left", "pinch", touching), ("right", "pinch/2", touching)],
    );
    let none = Fingers(0);
    let (pinch, grab) = (Fingers(0b00011), Fingers(0b00111));
    let own = |fingers: Fingers| {
        let group = ContactGroups::new(&[[fingers, none]]).unwrap();
        group.contacts()[0]
    };
    let groups: [(&[[Fingers; 2]], [Contacts; 2]); 6] = [
        (&[[pinch, none]], [own(pinch), Contacts::default()]),
        (&[[none, grab], [pinch, none]], [own(pinch), own(grab)]),
        // Left thumb and index finger on the right little finger: what it touches is not told.
        (
            &[[pinch, Fingers::LITTLE]],
            [own(pinch), Contacts::default()],
        ),
        (&[[none, grab]], [Contacts::default(), own(grab)]),
        // Both thumbs: each touches something, and no more can be said.
        (&[[Fingers::THUMB; 2]], [Contacts::default(); 2]),
        (&[[pinch, none], [none, pinch]], [own(pinch), own(pinch)]),
    ];
    let mut bytes = Vec::new();
    for (step, (groups, expected)) in (1..).zip(groups) {
        let message = ContactMessage {
            groups: ContactGroups::new(groups).unwrap(),
            ticks: None,
        };
        bytes.clear();
        message.encode(&mut bytes);
        let time = Nanos(step * 100_000_000);
        offered.push("pinch", stream.as_mut(), &bytes, time);
        wait_for("the contacts", || {
            let told = ["left", "right"].map(|device| clients.hand(device));
            (told.map(|hand| hand?.contacts) == expected.map(Some)).then_some(())
        });
    }
}
