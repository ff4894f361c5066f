//! A body that moves and turns at a steady speed: its velocity and its place ahead are exact.

use crate::streams::{irregular, live, steady};
use glam::{DQuat, DVec3};
use sandtable_motion::{
    FilterSettings, PoseDoubleExponential, Prediction, Signal, Smoothing, TrackerFilter, Velocity,
    VelocityWindow,
};
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

const VELOCITY: Velocity = Velocity {
    linear: DVec3::new(0.7, -0.2, 0.4),
    angular: DVec3::new(0.6, 1.5, -2.0),
};
const GAP: Duration = Duration::from_millis(100);

fn moving(seconds: f64) -> Rigid {
    let start = Rigid::new(
        DQuat::from_scaled_axis(DVec3::new(0.5, -0.4, 1.0)),
        DVec3::new(0.1, -0.9, 0.6),
    );
    VELOCITY.carry(&start, seconds)
}

/// Metres and radians from one pose to the other.
fn apart(a: &Rigid, b: &Rigid) -> (f64, f64) {
    (
        (a.translation - b.translation).length(),
        a.rotation.difference_from(b.rotation).length(),
    )
}

fn all_times() -> [Vec<Nanos>; 4] {
    [
        steady(20.0, 5.0),
        steady(50.0, 5.0),
        steady(103.3, 5.0),
        irregular(5, 5.0),
    ]
}

#[test]
fn least_squares_find_the_velocity_at_any_spacing() {
    for times in all_times() {
        let mut window = VelocityWindow::new(Duration::from_millis(50), GAP).unwrap();
        for time in times {
            // The other sign is the same attitude.
            let pose = moving(time.seconds());
            let sign = if time.0 % 3 == 0 { -1.0 } else { 1.0 };
            window.push(time, &Rigid::new(pose.rotation * sign, pose.translation));
        }
        let found = window.velocity().unwrap();
        assert!(
            (found.linear - VELOCITY.linear).length() < 1e-9,
            "{found:?}"
        );
        assert!(
            (found.angular - VELOCITY.angular).length() < 1e-9,
            "{found:?}"
        );
    }
}

#[test]
fn both_predictions_find_the_place_ahead_and_clamp_the_horizon() {
    let horizon = Duration::from_millis(40);
    let tau = Duration::from_millis(60);
    for prediction in [
        Prediction::ConstantVelocity { horizon },
        Prediction::DoubleExponential {
            position: tau,
            attitude: tau,
            horizon,
        },
    ] {
        for times in all_times() {
            let mut filter = TrackerFilter::new(FilterSettings {
                prediction,
                ..FilterSettings::default()
            })
            .unwrap();
            let mut newest = Nanos::default();
            for time in times {
                filter.push(&live(time, moving(time.seconds())));
                newest = time;
            }
            for (asked_ms, given_ms) in [(0, 0), (17, 17), (40, 40), (300, 40)] {
                let display = newest + Duration::from_millis(asked_ms);
                let given = Duration::from_millis(given_ms);
                let found = filter.pose_at(newest, display).unwrap();
                assert_eq!(found.predicted, given);
                let truth = moving((newest + given).seconds());
                let (metres, radians) = apart(&found.pose.frame_from_body, &truth);
                assert!(
                    metres < 1e-9,
                    "{metres} m at {asked_ms} ms by {prediction:?}"
                );
                assert!(
                    radians < 1e-9,
                    "{radians} at {asked_ms} ms by {prediction:?}"
                );
                // The time stays that of the measurement.
                assert_eq!(found.pose.time, newest);
            }
        }
    }
}

#[test]
fn double_exponential_smoothing_has_neither_lag_nor_error_of_slope() {
    let tau = Duration::from_millis(60);
    for times in all_times() {
        let mut filter = PoseDoubleExponential::new(tau, tau, GAP).unwrap();
        let mut newest = Nanos::default();
        for time in times {
            filter.push(time, &moving(time.seconds()));
            newest = time;
        }
        let (metres, radians) = apart(&filter.pose_after(0.0).unwrap(), &moving(newest.seconds()));
        assert!(metres < 1e-9 && radians < 1e-9, "{metres} m, {radians}");
        let found = filter.velocity().unwrap();
        assert!(
            (found.linear - VELOCITY.linear).length() < 1e-9,
            "{found:?}"
        );
        assert!(
            (found.angular - VELOCITY.angular).length() < 1e-9,
            "{found:?}"
        );
    }
}

#[test]
fn the_constant_velocity_is_that_of_smoothed_poses() {
    // Behind a steady motion One-Euro lags by a constant, so that its velocity is the body's.
    let mut filter = TrackerFilter::new(FilterSettings {
        smoothing: Smoothing::ONE_EURO,
        prediction: Prediction::CONSTANT_VELOCITY,
        ..FilterSettings::default()
    })
    .unwrap();
    let mut newest = Nanos::default();
    for time in steady(100.0, 10.0) {
        filter.push(&live(time, moving(time.seconds())));
        newest = time;
    }
    let now = filter.pose_at(newest, newest).unwrap();
    let velocity = now.velocity.unwrap();
    assert!((velocity.linear - VELOCITY.linear).length() < 1e-6);
    assert!((velocity.angular - VELOCITY.angular).length() < 1e-6);
    let later = filter
        .pose_at(newest, newest + Duration::from_millis(30))
        .unwrap();
    let expected = velocity.carry(&now.pose.frame_from_body, 0.03);
    let (metres, radians) = apart(&later.pose.frame_from_body, &expected);
    assert!(metres < 1e-12 && radians < 1e-12, "{metres} m, {radians}");
}
