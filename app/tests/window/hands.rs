//! Head and hand in the window: tracked by a simulated Flock of Birds, or moved by the mouse alone.

use crate::session::{Session, wait_for};
use glam::{DVec2, DVec3};
use sandtable_config::Rig;
use sandtable_input::flock::{Motion, Simulator, SimulatorSettings};
use sandtable_input::pinch;
use sandtable_input::recording::PLACEMENT_TOPIC;
use sandtable_input::{Fingers, Replay, Sample};
use sandtable_pose::Rigid;
use sandtable_view::Placement;
use serde::de::DeserializeOwned;
use std::path::Path;

/// The newest value of a topic in a recording, which may still grow.
fn newest<T: DeserializeOwned>(file: &Path, topic: &str) -> Option<T> {
    let replay = Replay::open(file).ok()?;
    let (_, value) = replay.values(topic).last()?;
    T::deserialize(value).ok()
}

fn placement(file: &Path) -> Option<Placement> {
    newest(file, PLACEMENT_TOPIC)
}

fn near(a: f64, b: f64, within: f64) -> bool {
    (a - b).abs() <= within
}

/// Bird 2 at `at` in table metres, its x pointing away from the user; the transmitter is the
/// workbench's: x away from the user, y right, z down, 30 cm under the glass.
pub(crate) fn held_at(at: DVec3, degrees_clockwise: f64) -> Motion {
    let inches = DVec3::new(at.y, at.x, -0.30 - at.z) / 0.0254;
    Motion::hold(inches.to_array(), [degrees_clockwise, 0.0, 0.0])
}

#[test]
fn a_gloved_hand_takes_the_world_along_while_it_pinches() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("s.mcap");
    let began = DVec3::new(0.10, -0.20, 0.15);
    let settings = SimulatorSettings {
        motions: vec![Motion::Still, held_at(began, 0.0)],
        ..SimulatorSettings::default()
    };
    let flock = Simulator::start(settings, None).expect("a pseudo-terminal");
    let gloves = pinch::SimulatorSettings {
        motion: pinch::Motion::Open,
        ..pinch::SimulatorSettings::default()
    };
    let gloves = pinch::Simulator::start(gloves, None).expect("a pseudo-terminal");
    let device = format!("flock={}", flock.path().display());
    let glove_device = format!("pinch={}", gloves.path().display());
    // On a loaded machine a hand is not seen for a while; one that is lost lets go.
    let patient = "lost_after_ms = 10000.0";
    let rig = Rig::builtin_text("workbench").expect("built in");
    let rig = rig.replace("lost_after_ms = 250.0", patient);
    assert!(rig.contains(patient));
    let gloved = "[devices.pinch]\nkind = \"pinch\"\nport = \"/dev/ttyS9\"\n\
                  [intents]\nact = [\"default\", \"pinch/2 pinch\"]\n";
    let rig = format!("{rig}\n{gloved}");
    let rig_file = folder.path().join("patient.toml");
    std::fs::write(&rig_file, rig).expect("it can be written");
    let Some(session) = Session::open(&[
        "builtin:jacksboro",
        "--rig",
        rig_file.to_str().expect("a plain path"),
        "--device",
        &device,
        "--device",
        &glove_device,
        "--stereo",
        "mono",
        "--mute",
        "--record",
        file.to_str().expect("a plain path"),
    ]) else {
        return;
    };
    let poses = |sensor: usize| {
        let replay = Replay::open(&file).ok()?;
        let samples = replay.samples("flock");
        let of_sensor = samples.iter().filter(|s| s.sensor() as usize == sensor);
        (of_sensor.count() > 50).then_some(())
    };
    wait_for("poses of the hand", || poses(2));
    let before = placement(&file).expect("it is recorded from the start");

    // A hand that does not act moves nothing.
    flock.set_motion(2, held_at(began + DVec3::new(0.0, 0.05, 0.0), 0.0));
    flock.set_motion(2, held_at(began, 0.0));
    // The right thumb and index finger: joined, then apart.
    let joins = |groups: &[[Fingers; 2]]| {
        let groups = pinch::ContactGroups::new(groups).expect("they are groups");
        gloves.change(move |gloves| gloves.join(groups));
    };
    let touching = || {
        let replay = Replay::open(&file).ok()?;
        let hands = replay.samples("pinch").into_iter().rev();
        let mut right = hands.filter_map(|sample| match sample {
            Sample::Hand(hand) if hand.sensor == 2 => hand.hand.contacts,
            _ => None,
        });
        right.next().map(|contacts| contacts.fingers())
    };
    let fingers = Fingers::THUMB.with(Fingers::INDEX);
    wait_for("the gloves", || {
        joins(&[[Fingers::default(), fingers]]);
        (touching()? == fingers).then_some(())
    });
    session.shoot_until("a frame in which the hand acts", |_| true);
    // By steps as a hand goes: a leap would not be believed.
    let (way, turn) = (DVec3::new(0.12, 0.08, 0.03), 30.0);
    for step in 1..=30 {
        let share = f64::from(step) / 30.0;
        flock.set_motion(2, held_at(began + share * way, share * turn));
        std::thread::sleep(std::time::Duration::from_millis(30));
    }
    // Turning the hand clockwise turns the world under it, and the table the other way.
    let yaw = (before.yaw - f64::to_radians(turn)).rem_euclid(std::f64::consts::TAU);
    let carried = wait_for("a world that is carried along", || {
        let now = placement(&file)?;
        near(now.yaw, yaw, 0.003).then_some(now)
    });
    let held = before.world_from_table(began);
    let off = carried.table_from_world(held) - (began + way);
    // The Flock tells places in steps of 0.1 mm, and angles in steps of 0.0055 degrees.
    assert!(
        off.length() < 2e-3,
        "what was held is {off} beside the hand"
    );
    assert_eq!(carried.scale, before.scale);

    // Let go, it stays.
    joins(&[]);
    wait_for("fingers that are apart", || {
        touching()?.is_empty().then_some(())
    });
    session.shoot_until("a frame in which it does not", |_| true);
    for step in 1..=20 {
        let share = f64::from(step) / 20.0;
        flock.set_motion(2, held_at(began + (1.0 - share) * way, turn));
        std::thread::sleep(std::time::Duration::from_millis(30));
    }
    session.close();
    let after = placement(&file).expect("the recording is whole");
    let moved = after.table_from_world(held) - carried.table_from_world(held);
    assert!(
        moved.length() < 2e-3,
        "it moved by {moved} after it was let go"
    );
    flock.stop();
    gloves.stop();
}

/// The window as the workbench's rig opens it.
const WINDOW: DVec2 = DVec2::new(1280.0, 782.0);

#[test]
fn the_mouse_moves_head_hand_and_world_of_a_table_without_trackers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("s.mcap");
    let Some(session) = Session::open(&[
        "builtin:jacksboro",
        "--rig",
        "workbench",
        "--device",
        "flock=/nowhere/flock",
        "--stereo",
        "mono",
        "--mute",
        "--record",
        file.to_str().expect("a plain path"),
    ]) else {
        return;
    };
    let before = wait_for("the recording", || placement(&file));
    let head = || newest::<Rigid>(&file, "/session/head").map(|head| head.translation);
    let hand = || newest::<Rigid>(&file, "/session/hand");
    let head_before = wait_for("the head", head);
    session.key("Tab");
    let to = |x: i32, y: i32| {
        let [x, y] = [x, y].map(|side| side.to_string());
        session.xdotool(&["mousemove", "--window", &session.window, &x, &y]);
    };
    // Glass metres a pixel: the window shows the glass.
    let metres = DVec2::new(1.80, 1.10) / WINDOW;
    let on_glass = |x: i32, y: i32| {
        let at = DVec2::new(f64::from(x), f64::from(y)) * metres;
        DVec2::new(-0.90 + at.x, 0.55 - at.y)
    };

    // The hand is over the pointer.
    to(400, 300);
    wait_for("the hand", || {
        let at = hand()?.translation;
        (at.truncate().distance(on_glass(400, 300)) < 0.005).then_some(())
    });
    // What it grabs comes along.
    session.xdotool(&["mousedown", "1"]);
    to(450, 300);
    to(500, 350);
    let held = before.world_from_table(on_glass(400, 300).extend(0.0));
    wait_for("a world that comes along", || {
        let now = placement(&file)?.table_from_world(held);
        (now.truncate().distance(on_glass(500, 350)) < 0.005).then_some(())
    });
    session.xdotool(&["mouseup", "1"]);

    // The other button moves the head, and neither the hand nor the world.
    let grabbed = placement(&file).expect("it is there");
    session.xdotool(&["mousedown", "3"]);
    to(600, 350);
    wait_for("the head", || {
        let moved = head()? - head_before;
        near(moved.x, 100.0 * metres.y, 0.005).then_some(())
    });
    session.xdotool(&["mouseup", "3"]);
    assert_eq!(placement(&file), Some(grabbed));

    // The middle one raises and turns the hand.
    let low = hand().expect("it is there");
    session.xdotool(&["mousedown", "2"]);
    to(600, 250);
    to(700, 250);
    wait_for("the hand's height", || {
        let high = hand()?;
        let raised = high.translation.z - low.translation.z;
        let turned = high.rotation.angle_between(low.rotation);
        let clockwise = 100.0 / WINDOW.y * std::f64::consts::PI;
        (near(raised, 100.0 * metres.y, 0.005) && near(turned, clockwise, 0.02)).then_some(())
    });
    session.xdotool(&["mouseup", "2"]);

    // The wheel brings the world nearer, by whole notches; a click that is made up counts for two.
    session.xdotool(&["click", "4"]);
    wait_for("a nearer world", || {
        let notches = (grabbed.scale / placement(&file)?.scale).ln() / 1.1f64.ln();
        (notches > 0.5 && near(notches, notches.round(), 1e-6)).then_some(())
    });
    session.close();
}
