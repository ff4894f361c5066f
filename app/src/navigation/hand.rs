//! What a hand does to the world: it carries it along, or flies by where it goes.

use glam::{DQuat, DVec3};
use sandtable_input::FlightAxes;
use sandtable_pose::Rigid;
use sandtable_view::Placement;

/// How far a hand goes from where it began to fly until it counts, in table metres and radians.
const REST: [f64; 2] = [0.02, 0.1];
/// How far until it flies as fast as can be.
const FULL: [f64; 2] = [0.15, 0.8];

/// The placement of a world that a hand holds which moves over the table from one place to
/// another: the point in the hand stays in it, and the world turns about it as the hand turns
/// about the vertical. A hand's other turns tilt nothing: the world stays level.
pub(crate) fn carried(placement: &Placement, from: &Rigid, to: &Rigid) -> Placement {
    let held = placement.world_from_table(from.translation);
    // A world that turns counter-clockwise lies under a table that turns clockwise.
    let yaw = placement.yaw + twist(from, to);
    let mut carried = Placement { yaw, ..*placement };
    carried.anchor = held - carried.world_vector_from_table(to.translation);
    carried.yaw = carried.yaw.rem_euclid(std::f64::consts::TAU);
    carried
}

/// The flight that a hand asks for by how far it has gone and turned since it began: where it goes
/// the flight goes, up included, and who turns it turns. Around where it began it rests.
pub(crate) fn hand_flight(from: &Rigid, to: &Rigid) -> FlightAxes {
    let gone = to.translation - from.translation;
    let length = gone.length();
    let share = |gone: f64, measure: usize| {
        ((gone - REST[measure]) / (FULL[measure] - REST[measure])).clamp(0.0, 1.0)
    };
    let direction = gone.try_normalize().unwrap_or(DVec3::ZERO);
    let pushed = share(length, 0) * direction;
    let turned = twist(from, to);
    FlightAxes {
        right: pushed.x,
        forward: pushed.y,
        up: pushed.z,
        // Counter-clockwise about the table's z is to the left.
        yaw: -share(turned.abs(), 1).copysign(turned),
        ..FlightAxes::default()
    }
}

/// The turn from one attitude to the other about the table's vertical, counter-clockwise seen from
/// above, in (−π, π]: that part of it whose axis is z.
fn twist(from: &Rigid, to: &Rigid) -> f64 {
    let turn = to.rotation * from.rotation.inverse();
    let about_z = DQuat::from_xyzw(0.0, 0.0, turn.z, turn.w);
    if about_z.length_squared() < 1e-12 {
        // Turned over: nothing can be said of the vertical.
        return 0.0;
    }
    let angle = 2.0 * turn.z.atan2(turn.w);
    let tau = std::f64::consts::TAU;
    angle - tau * (angle / tau).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn placement() -> Placement {
        Placement {
            anchor: DVec3::new(5000.0, 4000.0, 900.0),
            yaw: 0.4,
            scale: 10_000.0,
            exaggeration: 2.0,
        }
    }

    fn hand(at: [f64; 3], turn: DQuat) -> Rigid {
        Rigid::new(turn, DVec3::from_array(at))
    }

    fn near(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-6, "{a} is not {b}");
    }

    #[test]
    fn what_the_hand_holds_stays_in_it_and_turns_with_it() {
        let sensor = DQuat::from_euler(glam::EulerRot::ZYX, 0.3, -0.2, 2.8);
        let from = hand([0.1, -0.2, 0.05], sensor);
        let turn = DQuat::from_rotation_z(0.7);
        let to = hand([-0.3, 0.1, 0.12], turn * sensor);
        let before = placement();
        let after = carried(&before, &from, &to);
        let held = before.world_from_table(from.translation);
        near(after.world_from_table(to.translation), held);
        // A place beside it turns about it as the hand does, and as far away as it was.
        let beside = from.translation + DVec3::new(0.2, 0.0, 0.0);
        let world = before.world_from_table(beside);
        let now = to.translation + turn * DVec3::new(0.2, 0.0, 0.0);
        near(after.world_from_table(now), world);
        assert_eq!((after.scale, after.exaggeration), (10_000.0, 2.0));
    }

    #[test]
    fn a_way_in_steps_is_the_way_at_once() {
        let sensor = DQuat::from_rotation_x(0.4);
        let at = |share: f64| {
            let turn = DQuat::from_rotation_z(2.0 * share);
            hand([0.3 * share, -0.1 * share, 0.2 * share], turn * sensor)
        };
        let mut stepwise = placement();
        for step in 0..100 {
            let share = f64::from(step) / 100.0;
            stepwise = carried(&stepwise, &at(share), &at(share + 0.01));
        }
        let at_once = carried(&placement(), &at(0.0), &at(1.0));
        near(stepwise.anchor, at_once.anchor);
        assert!((stepwise.yaw - at_once.yaw).abs() < 1e-9);
    }

    #[test]
    fn a_hand_that_tilts_turns_nothing() {
        let from = hand([0.0, 0.0, 0.1], DQuat::IDENTITY);
        for tilt in [DQuat::from_rotation_x(0.8), DQuat::from_rotation_y(-0.8)] {
            let tilted = hand([0.0, 0.0, 0.1], tilt);
            near(
                carried(&placement(), &from, &tilted).anchor,
                placement().anchor,
            );
            assert_eq!(hand_flight(&from, &tilted), FlightAxes::default());
        }
        // Nor does one that is turned over.
        let over = hand([0.0, 0.0, 0.1], DQuat::from_rotation_x(PI));
        assert!(carried(&placement(), &from, &over).yaw.is_finite());
    }

    #[test]
    fn the_flight_goes_where_the_hand_goes_and_rests_where_it_began() {
        let from = hand([0.2, -0.4, 0.25], DQuat::IDENTITY);
        let at = |x: f64, y: f64, z: f64, angle: f64| {
            let to = hand([0.2 + x, -0.4 + y, 0.25 + z], DQuat::from_rotation_z(angle));
            hand_flight(&from, &to)
        };
        assert_eq!(at(0.0, 0.0, 0.0, 0.0), FlightAxes::default());
        assert_eq!(at(0.011, -0.011, 0.011, 0.09), FlightAxes::default());
        let ahead = at(0.0, 0.15, 0.0, 0.0);
        assert!((ahead.forward - 1.0).abs() < 1e-12 && ahead.right == 0.0);
        assert_eq!(at(0.0, 9.0, 0.0, 0.0).forward, 1.0);
        let slanting = at(0.3, 0.0, 0.3, 0.0);
        assert!((slanting.right - slanting.up).abs() < 1e-12);
        assert!((slanting.right.hypot(slanting.up) - 1.0).abs() < 1e-12);
        // Who turns the hand to the right flies to the right.
        assert_eq!(at(0.0, 0.0, 0.0, -FRAC_PI_2).yaw, 1.0);
        assert_eq!(at(0.0, 0.0, 0.0, FRAC_PI_2).yaw, -1.0);
        assert!((at(0.0, 0.0, 0.0, -0.45).yaw - 0.5).abs() < 1e-12);
    }
}
