//! What is held, lost, late, interrupted or not a number is neither filtered nor predicted.

use crate::streams::{live, steady, swaying};
use glam::{DQuat, DVec3};
use sandtable_motion::{
    Arrival, Derivative, DoubleExponential, FilterSettings, OneEuro, OneEuroSettings, Prediction,
    Smoothing, TrackerFilter,
};
use sandtable_pose::{Nanos, Pose, Rigid, Validity};
use std::time::Duration;

fn ms(ms: u64) -> Nanos {
    Nanos(ms * 1_000_000)
}

/// A head that goes to the right at 1 m/s.
fn going(time: Nanos) -> Pose {
    let place = DVec3::new(time.seconds(), 0.0, 0.6);
    live(time, Rigid::new(DQuat::IDENTITY, place))
}

fn settings(smoothing: Smoothing, prediction: Prediction) -> FilterSettings {
    FilterSettings {
        smoothing,
        prediction,
        ..FilterSettings::default()
    }
}

/// Every pair of a smoothing and a prediction that does something.
fn active() -> Vec<FilterSettings> {
    let tau = Duration::from_millis(40);
    let smoothings = [
        Smoothing::Off,
        Smoothing::ONE_EURO,
        Smoothing::DoubleExponential {
            position: tau,
            attitude: tau,
        },
    ];
    let predictions = [
        Prediction::CONSTANT_VELOCITY,
        Prediction::DOUBLE_EXPONENTIAL,
    ];
    let pairs = smoothings.iter().flat_map(|smoothing| {
        predictions
            .iter()
            .map(|prediction| settings(*smoothing, *prediction))
    });
    pairs.collect()
}

/// A filter with a second of samples, ten milliseconds apart, the last at 1000 ms.
fn filled(settings: FilterSettings) -> TrackerFilter {
    let mut filter = TrackerFilter::new(settings).unwrap();
    for i in 0..=100 {
        filter.push(&going(ms(10 * i)));
    }
    filter
}

#[test]
fn off_by_default_and_then_poses_pass_to_the_bit() {
    let mut filter = TrackerFilter::new(FilterSettings::default()).unwrap();
    assert_eq!(filter.pose_at(ms(0), ms(0)), None);
    for time in steady(103.3, 2.0) {
        // In single precision no quaternion has a length of one.
        let exact = swaying(time.seconds());
        let pose = live(
            time,
            Rigid::new(exact.rotation.as_quat().as_dquat(), exact.translation),
        );
        filter.push(&pose);
        let found = filter
            .pose_at(time, time + Duration::from_millis(40))
            .unwrap();
        assert_eq!(found.pose, pose);
        assert_eq!(found.predicted, Duration::ZERO);
        assert_eq!(found.age, Duration::ZERO);
    }
}

#[test]
fn a_pose_is_predicted_while_live_and_stays_where_it_was_when_held_or_lost() {
    for settings in active() {
        let filter = filled(settings);
        let at = |now: u64| filter.pose_at(ms(now), ms(now + 20)).unwrap();
        let live = at(1030);
        assert_eq!(live.pose.validity, Validity::Live);
        assert_eq!(live.age, Duration::from_millis(30));
        assert_eq!(live.predicted, Duration::from_millis(50));
        assert!((live.velocity.unwrap().linear - DVec3::X).length() < 1e-3);
        let x = live.pose.frame_from_body.translation.x;
        assert!((x - 1.05).abs() < 0.02, "{x}");

        let held = at(1031);
        assert_eq!(held.pose.validity, Validity::Held);
        assert_eq!(held.predicted, Duration::ZERO);
        assert_eq!(held.velocity, None);
        let x = held.pose.frame_from_body.translation.x;
        assert!(x < 1.001, "{x}");
        for (now, validity) in [(1250, Validity::Held), (1251, Validity::Lost)] {
            let later = at(now);
            assert_eq!(later.pose.validity, validity);
            assert_eq!(later.age, Duration::from_millis(now - 1000));
            assert_eq!(later.velocity, None);
            assert_eq!(later.pose.frame_from_body, held.pose.frame_from_body);
        }
    }
}

#[test]
fn nothing_is_predicted_over_a_gap_even_if_it_counts_as_live() {
    for settings in active() {
        let filter = filled(FilterSettings {
            held_after: Duration::from_millis(200),
            ..settings
        });
        let before = filter.pose_at(ms(1100), ms(1120)).unwrap();
        assert_eq!(before.predicted, Duration::from_millis(50));
        let after = filter.pose_at(ms(1101), ms(1120)).unwrap();
        assert_eq!(after.pose.validity, Validity::Live);
        assert_eq!(after.predicted, Duration::ZERO);
        assert_eq!(after.velocity, None);
    }
}

#[test]
fn after_a_gap_the_first_pose_comes_out_as_it_is() {
    for settings in active() {
        let mut filter = filled(settings);
        assert_eq!(filter.push(&going(ms(1100))), Arrival::Continued);
        let first = live(
            ms(1201),
            Rigid::new(DQuat::from_rotation_x(1.0), DVec3::new(-5.0, 0.0, 0.6)),
        );
        assert_eq!(filter.push(&first), Arrival::Started);
        let found = filter.pose_at(ms(1201), ms(1231)).unwrap();
        let apart = found.pose.frame_from_body.translation - first.frame_from_body.translation;
        assert_eq!(apart, DVec3::ZERO);
        let turn = found.pose.frame_from_body.rotation - first.frame_from_body.rotation;
        assert!(turn.length() < 1e-15);
        assert_eq!(found.velocity, None);
    }
}

#[test]
fn a_pose_that_is_not_live_is_shown_and_ends_the_stream() {
    for settings in active() {
        for validity in [Validity::Held, Validity::Lost] {
            let mut filter = filled(settings);
            let frozen = Pose {
                validity,
                ..going(ms(1010))
            };
            assert_eq!(filter.push(&frozen), Arrival::Interrupted);
            let found = filter.pose_at(ms(1010), ms(1030)).unwrap();
            assert_eq!(found.pose, frozen);
            assert_eq!(found.velocity, None);
            let far = live(ms(1020), Rigid::new(DQuat::IDENTITY, DVec3::Y));
            assert_eq!(filter.push(&far), Arrival::Started);
            let found = filter.pose_at(ms(1020), ms(1040)).unwrap();
            assert_eq!(found.pose, far);
            assert_eq!(found.velocity, None);
        }
    }
}

#[test]
fn equal_and_reversed_times_and_what_is_no_pose_change_nothing() {
    for settings in active() {
        let mut filter = filled(settings);
        let before = filter.pose_at(ms(1005), ms(1020));
        let elsewhere = |time, rotation, place| live(time, Rigid::new(rotation, place));
        let turned = DQuat::from_rotation_y(0.5);
        for time in [ms(1000), ms(995), ms(0)] {
            let stale = elsewhere(time, turned, DVec3::ZERO);
            assert_eq!(filter.push(&stale), Arrival::Stale);
        }
        for (rotation, place) in [
            (turned, DVec3::new(f64::NAN, 0.0, 0.0)),
            (turned, DVec3::new(0.0, f64::NEG_INFINITY, 0.0)),
            (turned, DVec3::new(0.0, 0.0, 2e100)),
            (DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), DVec3::ZERO),
            (DQuat::from_xyzw(f64::NAN, 0.0, 0.0, 1.0), DVec3::ZERO),
            (DQuat::from_xyzw(0.0, 0.0, 0.5, 1.0), DVec3::ZERO),
        ] {
            let unusable = elsewhere(ms(1010), rotation, place);
            assert_eq!(filter.push(&unusable), Arrival::Unusable);
        }
        assert_eq!(filter.pose_at(ms(1005), ms(1020)), before);
        assert_eq!(filter.push(&going(ms(1010))), Arrival::Continued);
    }
}

#[test]
fn a_display_time_before_the_newest_sample_gives_that_sample() {
    for settings in active() {
        let filter = filled(settings);
        let newest = filter.pose_at(ms(1000), ms(1000)).unwrap();
        assert_eq!(filter.pose_at(ms(900), ms(950)).unwrap(), newest);
        assert_eq!(newest.predicted, Duration::ZERO);
    }
}

#[test]
fn a_velocity_needs_three_samples_over_half_the_window() {
    let mut filter = TrackerFilter::new(FilterSettings::default()).unwrap();
    let mut push = |time| {
        filter.push(&going(time));
        filter.pose_at(time, time).unwrap().velocity
    };
    assert_eq!(push(ms(0)), None);
    assert_eq!(push(ms(12)), None);
    assert_eq!(push(ms(24)), None);
    let velocity = push(ms(25)).unwrap();
    assert!((velocity.linear - DVec3::X).length() < 1e-12);
}

#[test]
fn what_is_cleared_begins_at_any_time() {
    let mut filter = filled(FilterSettings::default());
    filter.clear();
    assert_eq!(filter.pose_at(ms(1000), ms(1000)), None);
    assert_eq!(filter.push(&going(ms(5))), Arrival::Started);
}

#[test]
fn filters_of_numbers_begin_anew_after_a_gap() {
    let gap = Duration::from_millis(100);
    let settings = OneEuroSettings {
        beta: 0.0,
        derivative: Derivative::FromRaw,
        ..OneEuroSettings::POSITION
    };
    let mut one_euro = OneEuro::new(settings, gap).unwrap();
    let mut exponential = DoubleExponential::new(Duration::from_millis(40), gap).unwrap();
    let mut push = |time, x: f64| {
        let arrivals = (one_euro.push(time, x), exponential.push(time, x));
        assert_eq!(arrivals.0, arrivals.1);
        let values = (
            one_euro.value().unwrap(),
            exponential.value_after(0.0).unwrap(),
        );
        (arrivals.0, values)
    };
    assert_eq!(push(ms(0), 1.0), (Arrival::Started, (1.0, 1.0)));
    let (arrival, (one, two)) = push(ms(100), 2.0);
    assert_eq!(arrival, Arrival::Continued);
    assert!(
        one > 1.0 && one < 2.0 && two > 1.0 && two < 2.0,
        "{one}, {two}"
    );
    assert_eq!(push(ms(100), 9.0), (Arrival::Stale, (one, two)));
    assert_eq!(push(ms(110), f64::NAN), (Arrival::Unusable, (one, two)));
    assert_eq!(push(ms(201), 5.0), (Arrival::Started, (5.0, 5.0)));
}
