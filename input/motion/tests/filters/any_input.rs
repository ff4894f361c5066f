//! Whatever comes in, what comes out is a pose.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sandtable_motion::{
    Derivative, DoubleExponential, FilterSettings, OneEuro, OneEuroSettings, Prediction, Smoothing,
    TrackerFilter,
};
use sandtable_pose::{Nanos, Pose, Rigid, Validity};
use std::time::Duration;

/// Any finite number, and often one as it comes from a tracker.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -2.0..2.0,
        any::<f64>().prop_filter("finite", |x| x.is_finite()),
        Just(1e100),
        Just(-1e100),
        Just(f64::MAX),
        Just(5e-324),
    ]
}

/// A step to the next sample's time, in nanoseconds: mostly forwards, sometimes none or back.
fn step() -> impl Strategy<Value = i64> {
    prop_oneof![
        Just(0),
        Just(1),
        -20_000_000_i64..30_000_000,
        1_000_000_i64..20_000_000,
        Just(100_000_000),
        any::<i64>(),
    ]
}

fn rotation() -> impl Strategy<Value = DQuat> {
    prop_oneof![
        [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0]
            .prop_map(|q: [f64; 4]| DQuat::from_array(q).normalize())
            .prop_filter("a rotation", |q: &DQuat| q.is_finite()),
        [number(), number(), number(), number()].prop_map(DQuat::from_array),
        Just(DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0)),
        Just(DQuat::from_xyzw(0.0, 0.0, 0.0, -1.0)),
        Just(DQuat::from_xyzw(1e-170, 0.0, 0.0, 1.0)),
    ]
}

fn one_euro() -> impl Strategy<Value = OneEuroSettings> {
    (0.001..1000.0, 0.0..1e4, 0.001..1000.0, any::<bool>()).prop_map(
        |(min_cutoff_hz, beta, derivative_cutoff_hz, raw)| OneEuroSettings {
            min_cutoff_hz,
            beta,
            derivative_cutoff_hz,
            derivative: if raw {
                Derivative::FromRaw
            } else {
                Derivative::FromFiltered
            },
        },
    )
}

fn time_constant() -> impl Strategy<Value = Duration> {
    (1_000_000..=1_000_000_000_u64).prop_map(Duration::from_nanos)
}

fn horizon() -> impl Strategy<Value = Duration> {
    (0..=100_000_000_u64).prop_map(Duration::from_nanos)
}

fn settings() -> impl Strategy<Value = FilterSettings> {
    let smoothing = prop_oneof![
        Just(Smoothing::Off),
        (one_euro(), one_euro())
            .prop_map(|(position, attitude)| Smoothing::OneEuro { position, attitude }),
        (time_constant(), time_constant())
            .prop_map(|(position, attitude)| Smoothing::DoubleExponential { position, attitude }),
    ];
    let prediction = prop_oneof![
        Just(Prediction::Off),
        horizon().prop_map(|horizon| Prediction::ConstantVelocity { horizon }),
        (time_constant(), time_constant(), horizon()).prop_map(|(position, attitude, horizon)| {
            Prediction::DoubleExponential {
                position,
                attitude,
                horizon,
            }
        }),
    ];
    (smoothing, prediction, 10..=500_u64, 10..=10_000_u64).prop_map(
        |(smoothing, prediction, window_ms, gap_ms)| FilterSettings {
            smoothing,
            prediction,
            velocity_window: Duration::from_millis(window_ms),
            gap: Duration::from_millis(gap_ms),
            held_after: Duration::from_secs(20),
            lost_after: Duration::from_secs(30),
        },
    )
}

fn validity() -> impl Strategy<Value = Validity> {
    prop_oneof![
        20 => Just(Validity::Live),
        1 => Just(Validity::Held),
        1 => Just(Validity::Lost),
    ]
}

type Sample = (i64, [f64; 3], DQuat, Validity);

fn samples() -> impl Strategy<Value = Vec<Sample>> {
    let sample = (
        step(),
        [number(), number(), number()],
        rotation(),
        validity(),
    );
    prop::collection::vec(sample, 1..60)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn a_tracker_filter_gives_finite_places_and_rotations(
        settings in settings(),
        samples in samples(),
        ahead_ns in 0..200_000_000_u64,
    ) {
        let mut filter = TrackerFilter::new(settings).unwrap();
        let mut time = Nanos(1_000_000_000);
        for (step, place, rotation, validity) in samples {
            time = Nanos(time.0.saturating_add_signed(step));
            filter.push(&Pose {
                frame_from_body: Rigid::new(rotation, DVec3::from_array(place)),
                time,
                validity,
            });
            let display = time + Duration::from_nanos(ahead_ns);
            if let Some(found) = filter.pose_at(time, display) {
                let pose = found.pose.frame_from_body;
                prop_assert!(pose.translation.is_finite(), "{found:?}");
                prop_assert!((pose.rotation.length() - 1.0).abs() < 1e-3, "{found:?}");
                let velocity = found.velocity.unwrap_or_default();
                prop_assert!(velocity.linear.is_finite(), "{found:?}");
                prop_assert!(velocity.angular.is_finite(), "{found:?}");
            }
        }
    }

    #[test]
    fn filters_of_numbers_give_finite_numbers(
        settings in one_euro(),
        time_constant in time_constant(),
        samples in prop::collection::vec((step(), number()), 1..60),
        ahead_s in 0.0..0.1,
    ) {
        let gap = Duration::from_secs(10);
        let mut one_euro = OneEuro::new(settings, gap).unwrap();
        let mut exponential = DoubleExponential::new(time_constant, gap).unwrap();
        let mut time = Nanos(1_000_000_000);
        for (step, x) in samples {
            time = Nanos(time.0.saturating_add_signed(step));
            one_euro.push(time, x);
            exponential.push(time, x);
            prop_assert!(one_euro.value().is_none_or(f64::is_finite));
            prop_assert!(exponential.value_after(ahead_s).is_none_or(f64::is_finite));
            prop_assert!(exponential.slope().is_none_or(f64::is_finite));
        }
    }
}
