//! What a hub knows at which time, and what it lets go.

use super::*;
use crate::Flexion;
use glam::{DQuat, DVec3};
use sandtable_pose::Rigid;

fn hub() -> Hub {
    Hub::for_rig(&Rig::builtin("workbench").unwrap())
}

fn head() -> SensorName {
    SensorName {
        device: "flock".into(),
        number: 1,
    }
}

fn sample(ms: u64, x: f64) -> PoseSample {
    PoseSample {
        sensor: 1,
        time: Nanos(ms * 1_000_000),
        table_from_sensor: Rigid::new(DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0)),
        frozen: false,
    }
}

fn validity(hub: &Hub, ms: u64) -> Option<Validity> {
    hub.pose_at(&head(), Nanos(ms * 1_000_000))
        .map(|pose| pose.validity)
}

#[test]
fn a_pose_is_live_then_held_then_lost_and_keeps_its_place() {
    let hub = hub();
    assert_eq!(validity(&hub, 100), None);
    hub.push("flock", Sample::Pose(sample(100, 0.5)));
    assert_eq!(validity(&hub, 99), None);
    assert_eq!(validity(&hub, 100), Some(Validity::Live));
    assert_eq!(validity(&hub, 130), Some(Validity::Live));
    assert_eq!(validity(&hub, 131), Some(Validity::Held));
    assert_eq!(validity(&hub, 350), Some(Validity::Held));
    assert_eq!(validity(&hub, 351), Some(Validity::Lost));
    let lost = hub.pose_at(&head(), Nanos(10_000_000_000)).unwrap();
    assert_eq!(lost.frame_from_body.translation.x, 0.5);
    assert_eq!(lost.time, Nanos(100_000_000));
}

#[test]
fn an_earlier_time_gives_an_earlier_pose() {
    let hub = hub();
    for i in 0..2000 {
        hub.push("flock", Sample::Pose(sample(i * 10, i as f64)));
    }
    let at = |ms: u64| hub.pose_at(&head(), Nanos(ms * 1_000_000));
    assert_eq!(at(19_995).unwrap().frame_from_body.translation.x, 1999.0);
    assert_eq!(at(19_989).unwrap().frame_from_body.translation.x, 1998.0);
    // What is older than the history is not guessed.
    assert_eq!(at(1000), None);
}

#[test]
fn a_frozen_sensor_is_lost_however_young() {
    let hub = hub();
    hub.push(
        "flock",
        Sample::Pose(PoseSample {
            frozen: true,
            ..sample(100, 0.0)
        }),
    );
    assert_eq!(validity(&hub, 100), Some(Validity::Lost));
}

#[test]
fn sensors_that_the_rig_does_not_have_are_ignored() {
    let hub = hub();
    hub.push("glove", Sample::Pose(sample(0, 0.0)));
    hub.push(
        "flock",
        Sample::Pose(PoseSample {
            sensor: 9,
            ..sample(0, 0.0)
        }),
    );
    assert_eq!(validity(&hub, 0), None);
    assert_eq!(hub.sensors().count(), 2);
}

#[test]
fn a_sensors_settings_smooth_and_predict_it() {
    let text = Rig::builtin_text("workbench").unwrap().to_owned()
        + "\n[sensors.\"flock/1\"]\nprediction = { kind = \"constant-velocity\" }\n\
           ahead_ms = 20.0\n";
    let predicting = Hub::for_rig(&Rig::parse(&text, "test").unwrap());
    let plain = hub();
    for hub in [&predicting, &plain] {
        for i in 0..20 {
            hub.push("flock", Sample::Pose(sample(10 * i, 0.004 * i as f64)));
        }
    }
    let now = Nanos(190_000_000);
    let x = |hub: &Hub| {
        let estimate = hub.estimate_at(&head(), now).unwrap();
        assert!((estimate.velocity.unwrap().linear.x - 0.4).abs() < 1e-9);
        estimate.pose.frame_from_body.translation.x
    };
    assert_eq!(x(&plain), 0.004 * 19.0);
    assert!((x(&predicting) - 0.004 * 21.0).abs() < 1e-9);
    // A frozen sensor's pose is lost, and stays where it is.
    predicting.push(
        "flock",
        Sample::Pose(PoseSample {
            frozen: true,
            ..sample(200, 0.076)
        }),
    );
    let frozen = predicting.estimate_at(&head(), Nanos(200_000_000)).unwrap();
    assert_eq!(frozen.pose.validity, Validity::Lost);
    assert_eq!(frozen.pose.frame_from_body.translation.x, 0.076);
    predicting.clear();
    assert_eq!(predicting.estimate_at(&head(), now), None);
}

#[test]
fn buttons_and_hands_are_as_they_were_at_a_time() {
    let hub = hub();
    let time = |ms: u64| Nanos(ms * 1_000_000);
    let pressed = |ms: u64, pressed: u64| {
        hub.push(
            "flock",
            Sample::Buttons(ButtonsSample {
                sensor: 1,
                time: time(ms),
                pressed,
            }),
        );
    };
    assert_eq!(hub.buttons_at(&head(), time(5)), None);
    pressed(10, 0b1);
    pressed(20, 0b110);
    let at = |ms: u64| hub.buttons_at(&head(), time(ms));
    assert_eq!(
        [at(9), at(10), at(19), at(1000)],
        [None, Some(1), Some(1), Some(6)]
    );
    pressed(25, 0);
    let between = |from: u64, to: u64| hub.buttons_between(&head(), time(from), time(to));
    assert_eq!([between(0, 5), between(0, 10)], [None, Some(1)]);
    assert_eq!([between(12, 15), between(12, 40)], [Some(1), Some(7)]);
    assert_eq!([between(22, 40), between(25, 40)], [Some(6), Some(0)]);
    pressed(30, 0b110);
    let hand = HandState {
        flexion: [0.0, 0.25, 0.5, 0.75, 1.0].map(|bent| Some(Flexion::of_one_sensor(bent))),
        contacts: None,
    };
    hub.push(
        "flock",
        Sample::Hand(crate::HandSample {
            sensor: 1,
            time: time(10),
            hand,
        }),
    );
    assert_eq!(hub.hand_at(&head(), time(9)), None);
    assert_eq!(hub.hand_at(&head(), time(10)), Some(hand));
    let buttons = hub.buttons_since(&head(), time(20));
    assert_eq!(buttons, [time(25), time(30)]);
    assert_eq!(hub.hands_since(&head(), time(9)), [time(10)]);
    assert_eq!(hub.hands_since(&head(), time(10)), []);
    hub.clear();
    assert_eq!((at(1000), hub.hand_at(&head(), time(10))), (None, None));
}

#[test]
fn what_a_lost_device_holds_is_let_go_and_its_poses_stay() {
    let hub = hub();
    let time = |ms: u64| Nanos(ms * 1_000_000);
    let mut values = [0.0; AXES];
    values[1] = -1.0;
    hub.push("flock", Sample::Pose(sample(10, 0.5)));
    for sensor in 1..=2 {
        hub.push(
            "flock",
            Sample::Buttons(ButtonsSample {
                sensor,
                time: time(10),
                pressed: 0b11,
            }),
        );
    }
    hub.push(
        "flock",
        Sample::Axes(AxesSample {
            sensor: 1,
            time: time(10),
            values,
            count: 2,
        }),
    );
    hub.let_go("glove", time(20));
    assert_eq!(hub.buttons_at(&head(), time(30)), Some(0b11));
    hub.let_go("flock", time(20));
    assert_eq!(hub.buttons_at(&head(), time(19)), Some(0b11));
    assert_eq!(hub.buttons_at(&head(), time(20)), Some(0));
    let axes = hub.axes_at(&head(), time(20)).unwrap();
    assert_eq!((axes.values, axes.count), ([0.0; AXES], 2));
    assert_eq!(validity(&hub, 10), Some(Validity::Live));
    // What is let go already is not let go again.
    let heard = hub.listen(8);
    hub.let_go("flock", time(30));
    assert_eq!(heard.len(), 0);
}

#[test]
fn listeners_hear_all_that_they_have_room_for_and_hold_nobody_up() {
    let hub = hub();
    hub.push("flock", Sample::Pose(sample(0, 0.0)));
    let heard = hub.listen(3);
    for ms in 1..=5 {
        hub.push("flock", Sample::Pose(sample(ms, ms as f64)));
    }
    hub.push("glove", Sample::Pose(sample(6, 6.0)));
    let times: Vec<_> = heard
        .try_iter()
        .map(|(_, s)| s.time().0 / 1_000_000)
        .collect();
    assert_eq!(times, [1, 2, 3]);
    drop(heard);
    hub.push("flock", Sample::Pose(sample(7, 7.0)));
    assert_eq!(hub.listeners().len(), 0);
}
