//! Intents from samples and from the desk, through a rig's own words.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use proptest::prelude::*;
use sandtable_config::{Intent, IntentKind, KeyCode, Rig};
use sandtable_input::intent::{DeskState, IntentMapper, IntentState};
use sandtable_input::{
    AXES, AxesSample, ButtonsSample, Contacts, Fingers, FlightAxes, GamepadState, HandSample,
    HandState, Hub, PoseSample, Sample,
};
use sandtable_pose::{Nanos, Rigid};

const DEVICES: &str = "name = 'i'\n[camera]\n\
    [devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n\
    [devices.wand]\nkind = 'vrpn'\naddress = 'Wand0@lab'\nsensors = 2\n\
    table_from_tracker = { translation = [0.0, 0.0, 0.0] }\n\
    [hand]\nsensor = 'wand/2'\nrest = { position = [0.0, 0.0, 0.0] }\n";

fn ms(ms: u64) -> Nanos {
    Nanos(ms * 1_000_000)
}

/// A rig's mapper and hub, and a desk that nobody sits at.
struct People {
    hub: Hub,
    mapper: IntentMapper,
    desk: DeskState,
}

impl People {
    fn at(intents: &str) -> Self {
        let rig = Rig::parse(&format!("{DEVICES}[intents]\n{intents}\n"), "i").unwrap();
        Self {
            hub: Hub::for_rig(&rig),
            mapper: IntentMapper::new(&rig),
            desk: DeskState::default(),
        }
    }

    fn update(&mut self, time: u64) -> IntentState {
        self.mapper.update(ms(time), &self.hub, &self.desk)
    }

    fn touch(&self, time: u64, sensor: u32, contacts: Option<Contacts>) {
        let flexion = Default::default();
        let hand = HandState { flexion, contacts };
        let time = ms(time);
        self.hub
            .push("pinch", Sample::Hand(HandSample { sensor, time, hand }));
    }

    fn press(&self, time: u64, pressed: u64) {
        let (sensor, time) = (2, ms(time));
        self.hub.push(
            "wand",
            Sample::Buttons(ButtonsSample {
                sensor,
                time,
                pressed,
            }),
        );
    }
}

fn thumb_on(fingers: Fingers) -> Option<Contacts> {
    let mut contacts = Contacts::default();
    contacts.own[0] = fingers;
    Some(contacts)
}

#[test]
fn a_desks_keys_mouse_and_gamepad_ask_as_the_rig_says() {
    let mut people = People::at("");
    people.desk.keys = [KeyCode::KeyW, KeyCode::ArrowLeft, KeyCode::KeyM].into();
    people.desk.mouse = [false, true, false];
    let mut pad = GamepadState {
        right_stick: [0.0, 1.0],
        ..GamepadState::default()
    };
    pad.select_start[1] = true;
    people.desk.gamepad = Some(pad);
    let state = people.update(1);
    let expected = FlightAxes {
        forward: 1.0,
        yaw: -1.0,
        pitch: 1.0,
        ..FlightAxes::default()
    };
    assert_eq!(state.flight, expected);
    let held = |state: &IntentState| -> Vec<Intent> {
        Intent::ALL
            .into_iter()
            .filter(|i| state.holds(*i))
            .collect()
    };
    assert_eq!(
        held(&state),
        [Intent::NextMode, Intent::MoveHead, Intent::Menu]
    );
    assert!(state.begins(Intent::Menu) && state.is_active());
    // What is held goes on and begins once.
    let state = people.update(2);
    assert!(state.holds(Intent::Menu) && !state.begins(Intent::Menu));
    // Opposites cancel, and several devices push no further than one.
    people.desk.keys = [KeyCode::KeyS, KeyCode::KeyW, KeyCode::ArrowUp].into();
    people.desk.gamepad.as_mut().unwrap().select_start[1] = false;
    people.desk.mouse = [false; 3];
    let state = people.update(3);
    assert_eq!((state.flight.forward, state.flight.pitch), (0.0, 1.0));
    assert_eq!(held(&state), []);
    people.desk = DeskState::default();
    assert!(!people.update(4).is_active());
}

#[test]
fn a_minus_turns_an_axis_and_what_the_rig_leaves_out_does_nothing() {
    let mut people = People::at("yaw = ['-wand/1 channel 3', 'key A']\nright = []\nquit = []");
    let mut values = [0.0; AXES];
    values[3] = 1.0;
    let (sensor, count) = (1, 4);
    let axes = |ms_: u64, values| {
        Sample::Axes(AxesSample {
            sensor,
            time: ms(ms_),
            values,
            count,
        })
    };
    people.hub.push("wand", axes(1, values));
    assert_eq!(people.update(1).flight.yaw, -1.0);
    // The dead zone of sticks holds for channels, and half the way is less than half.
    values[3] = 0.575;
    people.hub.push("wand", axes(2, values));
    assert!((people.update(2).flight.yaw + 0.5).abs() < 1e-12);
    values[3] = -0.1;
    people.hub.push("wand", axes(3, values));
    people.desk.keys = [KeyCode::KeyD, KeyCode::Escape].into();
    let state = people.update(3);
    assert_eq!(state.flight, FlightAxes::default());
    assert!(!state.holds(Intent::Quit));
}

#[test]
fn a_button_pressed_for_a_moment_between_two_frames_is_not_missed() {
    let mut people = People::at("menu = ['wand/2 button 5']\ngrab = ['wand/2 button 0']");
    people.update(10);
    people.press(12, 1 << 5);
    people.press(14, 0b1);
    let state = people.update(20);
    assert!(state.begins(Intent::Menu) && state.begins(Intent::Grab));
    let state = people.update(30);
    assert!(!state.holds(Intent::Menu) && state.holds(Intent::Grab));
    assert!(!state.begins(Intent::Grab));
}

#[test]
fn hands_ask_by_gestures_and_touches_that_have_lasted() {
    let mut people = People::at(
        "act = ['pinch/2 grab']\ngrab = ['pinch/1 grab']\npoint = ['pinch/2 thumb-ring']\n\
         fly = ['pinch/2 other-hand']",
    );
    let held = |people: &mut People, time| {
        let state = people.update(time);
        [Intent::Act, Intent::Grab, Intent::Point, Intent::Fly].map(|i| state.holds(i))
    };
    let grab = Fingers::INDEX.with(Fingers::MIDDLE);
    people.touch(0, 2, thumb_on(grab));
    people.touch(0, 1, thumb_on(Fingers::INDEX));
    assert_eq!(held(&mut people, 0), [false; 4]);
    assert_eq!(held(&mut people, 49), [false; 4]);
    assert_eq!(held(&mut people, 50), [true, false, false, false]);
    // A contact that bounces is neither let go nor touched.
    people.touch(60, 2, thumb_on(Fingers::RING));
    assert_eq!(held(&mut people, 60), [true, false, false, false]);
    people.touch(70, 2, thumb_on(grab));
    assert_eq!(held(&mut people, 70), [true, false, false, false]);
    let mut both = thumb_on(Fingers::RING).unwrap();
    both.other[3] = Fingers::RING;
    people.touch(80, 2, Some(both));
    assert_eq!(held(&mut people, 80), [true, false, false, false]);
    assert_eq!(held(&mut people, 130), [false, false, true, true]);
    // A hand of which nothing is known any more lets go at once of a gesture and of its touches.
    people.touch(140, 2, None);
    assert!(!held(&mut people, 140)[0]);
    assert_eq!(held(&mut people, 141), [false; 4]);
}

#[test]
fn a_trigger_that_trembles_halfway_does_not_flicker() {
    let mut people = People::at("grab = ['gamepad right-trigger']");
    let mut begun = 0;
    for step in 0..200u32 {
        // Up to the middle and back, trembling by 4 % of the way.
        let way = f64::from(step.min(200 - step)) / 100.0;
        let tremble = if step % 2 == 0 { 0.04 } else { -0.04 };
        let pad = GamepadState {
            triggers: [0.0, 0.65 * way + tremble],
            ..GamepadState::default()
        };
        people.desk.gamepad = Some(pad);
        begun += u32::from(people.update(u64::from(step)).begins(Intent::Grab));
    }
    assert_eq!(begun, 1);
}

#[test]
fn where_people_look_and_reach_is_their_sensors_pose() {
    let mut people = People::at("");
    assert_eq!(people.update(5).reach, None);
    people.hub.push(
        "wand",
        Sample::Pose(PoseSample {
            sensor: 2,
            time: ms(10),
            table_from_sensor: Rigid::IDENTITY,
            frozen: false,
        }),
    );
    let state = people.update(12);
    assert_eq!(state.reach.unwrap().pose.frame_from_body, Rigid::IDENTITY);
    assert_eq!(state.look, None);
}

#[test]
fn a_session_that_begins_anew_begins_with_open_hands() {
    let mut people = People::at("act = ['pinch/2 pinch']");
    people.touch(1000, 2, thumb_on(Fingers::INDEX));
    people.update(1000);
    assert!(people.update(1060).holds(Intent::Act));
    people.hub.clear();
    people.touch(5, 2, thumb_on(Fingers::INDEX));
    assert!(!people.update(10).holds(Intent::Act));
    assert!(people.update(60).holds(Intent::Act));
}

proptest! {
    /// Whatever is pushed, axes stay within their range, and each intent begins only when it was
    /// not held.
    #[test]
    fn intents_are_sound(
        steps in prop::collection::vec((
            any::<[bool; 3]>(),
            any::<u64>(),
            prop::collection::vec(any::<f64>(), AXES),
            any::<[f64; 2]>(),
            0u8..32,
        ), 1..30),
    ) {
        let mut people = People::at(
            "yaw = ['wand/1 channel 0', '-wand/1 channel 1', 'gamepad left-stick-x', 'key A']\n\
             act = ['wand/2 button 0', 'pinch/2 thumb-index']",
        );
        let mut before = IntentState::default();
        for (index, (mouse, pressed, values, stick, fingers)) in (1u64..).zip(steps) {
            let time = index * 16;
            people.desk.mouse = mouse;
            people.desk.gamepad = Some(GamepadState { left_stick: stick, ..Default::default() });
            people.press(time, pressed);
            people.touch(time, 2, thumb_on(Fingers(fingers)));
            let values: [f64; AXES] = values.try_into().unwrap();
            let (sensor, count) = (1, AXES);
            let axes = AxesSample { sensor, time: ms(time), values, count };
            people.hub.push("wand", Sample::Axes(axes));
            let state = people.update(time);
            let FlightAxes { right, forward, up, yaw, pitch, roll } = state.flight;
            for axis in [right, forward, up, yaw, pitch, roll] {
                prop_assert!((-1.0..=1.0).contains(&axis), "{axis}");
            }
            for intent in Intent::ALL {
                let begins = state.holds(intent) && !before.holds(intent);
                prop_assert_eq!(state.begins(intent), begins);
                prop_assert!(intent.kind() != IntentKind::Axis || !state.holds(intent));
            }
            before = state;
        }
    }
}
