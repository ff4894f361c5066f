//! What filters do to noise, to steps, and to the two signs of one attitude.

use crate::streams::{Random, live, steady, swaying};
use glam::{DQuat, DVec3};
use sandtable_motion::{
    DoubleExponential, FilterSettings, OneEuro, OneEuroSettings, Prediction, Signal, Smoothing,
    TrackerFilter,
};
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

const GAP: Duration = Duration::from_millis(100);
const TAU: Duration = Duration::from_millis(40);

const STILL: Rigid = Rigid::new(
    DQuat::from_xyzw(0.5, -0.5, 0.5, 0.5),
    DVec3::new(0.1, -0.9, 0.6),
);

/// The root mean square distance from [`STILL`], in metres and radians, of a still sensor's poses
/// shown so much later. Its noise is within 0.5 mm and 0.1 degree on each axis.
fn jitter(smoothing: Smoothing, prediction: Prediction, ahead_ms: u64) -> (f64, f64) {
    let mut filter = TrackerFilter::new(FilterSettings {
        smoothing,
        prediction,
        ..FilterSettings::default()
    })
    .unwrap();
    let mut random = Random(7);
    let (mut metres, mut radians, mut count) = (0.0, 0.0, 0.0);
    for time in steady(103.3, 60.0) {
        let rotation = STILL.rotation.moved_by(random.vector(0.1_f64.to_radians()));
        let place = STILL.translation + random.vector(0.5e-3);
        filter.push(&live(time, Rigid::new(rotation, place)));
        let display = time + Duration::from_millis(ahead_ms);
        let shown = filter.pose_at(time, display).unwrap().pose.frame_from_body;
        if time > Nanos::from_seconds(2.0) {
            metres += (shown.translation - STILL.translation).length_squared();
            radians += shown
                .rotation
                .difference_from(STILL.rotation)
                .length_squared();
            count += 1.0;
        }
    }
    ((metres / count).sqrt(), (radians / count).sqrt())
}

/// By what factors a setting lessens a still sensor's jitter, in place and in attitude.
fn calmer(smoothing: Smoothing, prediction: Prediction, ahead_ms: u64) -> (f64, f64) {
    let raw = jitter(Smoothing::Off, Prediction::Off, 0);
    let found = jitter(smoothing, prediction, ahead_ms);
    (raw.0 / found.0, raw.1 / found.1)
}

#[test]
fn one_euro_calms_a_still_sensor_threefold() {
    let (place, attitude) = calmer(Smoothing::ONE_EURO, Prediction::Off, 0);
    assert!(place > 3.0 && attitude > 3.0, "{place}, {attitude}");
}

#[test]
fn one_euro_keeps_a_still_sensor_calm_under_prediction() {
    for prediction in [
        Prediction::CONSTANT_VELOCITY,
        Prediction::DOUBLE_EXPONENTIAL,
    ] {
        let (place, attitude) = calmer(Smoothing::ONE_EURO, prediction, 30);
        assert!(place > 2.5 && attitude > 2.5, "{place}, {attitude}");
        // Without it, there is more of the noise, or nearly as much.
        let (place, attitude) = calmer(Smoothing::Off, prediction, 30);
        assert!(place < 1.2 && attitude < 1.2, "{place}, {attitude}");
    }
}

#[test]
fn double_exponential_smoothing_halves_a_still_sensors_jitter() {
    let smoothing = Smoothing::DoubleExponential {
        position: TAU,
        attitude: TAU,
    };
    let (place, attitude) = calmer(smoothing, Prediction::Off, 0);
    assert!(place > 1.9 && attitude > 1.9, "{place}, {attitude}");
}

/// What comes out for 0.3 at rest and then 0.6, a hundred times a second; the step is the tenth.
fn stepped(mut filtered: impl FnMut(Nanos, f64) -> f64) -> Vec<f64> {
    let at = |i: u64| Nanos(10_000_000 * i);
    (0..200)
        .map(|i| filtered(at(i), if i < 10 { 0.3 } else { 0.6 }))
        .collect()
}

#[test]
fn one_euro_follows_a_step_without_overshoot_and_the_quicker_for_beta() {
    let follow = |beta| {
        let settings = OneEuroSettings {
            beta,
            ..OneEuroSettings::POSITION
        };
        let mut filter = OneEuro::new(settings, GAP).unwrap();
        let out = stepped(|time, x| {
            filter.push(time, x);
            filter.value().unwrap()
        });
        assert!(out.is_sorted() && out[199] <= 0.6, "{out:?}");
        assert!(out[..10].iter().all(|x| *x == 0.3));
        // How many samples until nine tenths of the step are done.
        out.iter().position(|x| *x > 0.57).unwrap() - 10
    };
    // A low-pass at 1 Hz is there after ln 10 / 2π = 0.37 s.
    assert!((35..=38).contains(&follow(0.0)), "{}", follow(0.0));
    assert!(follow(80.0) <= 1, "{}", follow(80.0));
}

#[test]
fn double_exponential_smoothing_overshoots_a_step_by_less_than_a_fifth_and_settles() {
    let mut filter = DoubleExponential::new(TAU, GAP).unwrap();
    let out = stepped(|time, x| {
        filter.push(time, x);
        filter.value_after(0.0).unwrap()
    });
    let most = out.iter().copied().fold(0.0, f64::max);
    // Beyond it, as must be where there is no lag in steady motion.
    assert!((0.61..0.66).contains(&most), "{most}");
    let settled = out.iter().skip(10 + 40);
    assert!(settled.clone().all(|x| (x - 0.6).abs() < 1e-3));
}

#[test]
fn both_signs_of_an_attitude_are_filtered_as_one() {
    let settings = |smoothing, prediction| FilterSettings {
        smoothing,
        prediction,
        ..FilterSettings::default()
    };
    let exponential = Smoothing::DoubleExponential {
        position: TAU,
        attitude: TAU,
    };
    for settings in [
        settings(Smoothing::ONE_EURO, Prediction::Off),
        settings(exponential, Prediction::Off),
        settings(Smoothing::Off, Prediction::CONSTANT_VELOCITY),
        settings(Smoothing::Off, Prediction::DOUBLE_EXPONENTIAL),
    ] {
        let mut one = TrackerFilter::new(settings).unwrap();
        let mut two = TrackerFilter::new(settings).unwrap();
        for (i, time) in steady(100.0, 3.0).into_iter().enumerate() {
            let pose = swaying(time.seconds());
            let sign = if i % 3 == 1 { -1.0 } else { 1.0 };
            one.push(&live(time, pose));
            two.push(&live(
                time,
                Rigid::new(pose.rotation * sign, pose.translation),
            ));
            let display = time + Duration::from_millis(30);
            let at = |filter: &TrackerFilter| filter.pose_at(time, display).unwrap();
            let (one, two) = (at(&one).pose, at(&two).pose);
            let (one, two) = (one.frame_from_body, two.frame_from_body);
            let apart = one.rotation.difference_from(two.rotation).length();
            assert!(apart < 1e-12, "{apart} at {time:?} by {settings:?}");
        }
    }
}
