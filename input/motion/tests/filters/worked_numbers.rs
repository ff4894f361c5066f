//! The filters of the papers, on numbers worked by hand.

use glam::{DQuat, DVec3};
use sandtable_motion::{
    Derivative, DoubleExponential, OneEuro, OneEuroSettings, VelocityWindow, time_constant,
};
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

const GAP: Duration = Duration::from_secs(1);

/// A hundredth of a second apart.
fn at_100_hz(i: u32) -> Nanos {
    Nanos(10_000_000 * u64::from(i))
}

#[test]
fn one_euro_gives_the_papers_numbers() {
    let settings = OneEuroSettings {
        min_cutoff_hz: 1.0,
        beta: 0.5,
        derivative_cutoff_hz: 1.0,
        derivative: Derivative::FromFiltered,
    };
    let mut filter = OneEuro::new(settings, GAP).unwrap();
    let steps = [
        (0.0, 0.0),
        (0.0, 0.0),
        (1.0, 0.199_074),
        (1.0, 0.422_267),
        (1.0, 0.608_184),
        (0.5, 0.575_649),
        (0.5, 0.554_256),
    ];
    for (i, (sample, expected)) in (0..).zip(steps) {
        filter.push(at_100_hz(i), sample);
        let found = filter.value().unwrap();
        assert!((found - expected).abs() < 1e-6, "step {i}: {found}");
    }
}

#[test]
fn one_euro_takes_the_speed_from_the_raw_sample_before_where_asked_to() {
    // Of a cutoff of 1/(2πΔt) a low-pass takes in one half. So the jump's rate of 100 a second
    // becomes a speed of 50; then raw samples rest, and it becomes 25.
    let cutoff = 1.0 / std::f64::consts::TAU * 100.0;
    let settings = OneEuroSettings {
        min_cutoff_hz: cutoff,
        beta: 1.0,
        derivative_cutoff_hz: cutoff,
        derivative: Derivative::FromRaw,
    };
    let mut filter = OneEuro::new(settings, GAP).unwrap();
    let share = |speed: f64| {
        let ratio = 1.0 + speed * std::f64::consts::TAU / 100.0;
        ratio / (1.0 + ratio)
    };
    let first = share(50.0);
    let second = first + share(25.0) * (1.0 - first);
    for (i, (sample, expected)) in (0..).zip([(0.0, 0.0), (1.0, first), (1.0, second)]) {
        filter.push(at_100_hz(i), sample);
        let found = filter.value().unwrap();
        assert!((found - expected).abs() < 1e-12, "step {i}: {found}");
    }
}

#[test]
fn double_exponential_prediction_gives_laviolas_numbers() {
    let tau = time_constant(0.5, Duration::from_millis(10));
    let mut filter = DoubleExponential::new(tau, GAP).unwrap();
    let expected = [0.0, 1.5, 3.25, 4.875, 6.3125, 7.59375, 8.765625, 9.867188];
    for (i, expected) in (0..).zip(expected) {
        filter.push(at_100_hz(i), f64::from(i));
        let found = filter.value_after(0.03).unwrap();
        assert!((found - expected).abs() < 1e-6, "step {i}: {found}");
    }
}

#[test]
fn double_exponential_prediction_is_laviolas_recursion_at_any_alpha_rate_and_step() {
    for (alpha, interval_ms, k) in [(0.2, 7, 1.0), (0.5, 20, 2.5), (0.9, 10, 5.0)] {
        let interval = Duration::from_millis(interval_ms);
        let mut filter = DoubleExponential::new(time_constant(alpha, interval), GAP).unwrap();
        let (mut once, mut twice) = (0.3, 0.3);
        for i in 0..50 {
            let sample = 0.3 + (0.4 * f64::from(i)).sin() * f64::from(i);
            once += alpha * (sample - once);
            twice += alpha * (once - twice);
            let factor = alpha * k / (1.0 - alpha);
            let expected = (2.0 + factor) * once - (1.0 + factor) * twice;
            filter.push(Nanos::default() + interval * i, sample);
            let found = filter.value_after(k * interval.as_secs_f64()).unwrap();
            // The time constant is rounded to nanoseconds.
            assert!((found - expected).abs() < 1e-4, "step {i}: {found}");
        }
    }
}

#[test]
fn a_velocity_is_the_slope_of_the_line_of_least_squares() {
    let mut window = VelocityWindow::new(Duration::from_millis(50), GAP).unwrap();
    // About their means, 25 ms and 1 mm, the products sum to 50 and the squares to 1700.
    for (ms, mm) in [(0, 0.0), (10, 1.0), (40, 1.0), (50, 2.0)] {
        let place = DVec3::new(0.0, 1e-3 * mm, 0.6);
        let turn = DQuat::from_rotation_z(1e-3 * mm);
        window.push(Nanos(ms * 1_000_000), &Rigid::new(turn, place));
    }
    let velocity = window.velocity().unwrap();
    let slope = 50.0 / 1700.0;
    assert!((velocity.linear - slope * DVec3::Y).length() < 1e-12);
    assert!((velocity.angular - slope * DVec3::Z).length() < 1e-12);
}
