//! The same motion at another rate comes out the same, within stated bounds.

use crate::streams::{irregular, live, steady, swaying};
use glam::DVec3;
use sandtable_motion::{
    Derivative, FilterSettings, HORIZON, OneEuroSettings, Prediction, Signal, Smoothing,
    TrackerFilter,
};
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

/// Poses at times in seconds.
type Track = Vec<(f64, Rigid)>;

const SECONDS: f64 = 12.0;

/// What comes out at each of the times, for a display so much later.
fn filtered(settings: FilterSettings, times: &[Nanos], ahead: Duration) -> Track {
    let mut filter = TrackerFilter::new(settings).unwrap();
    let at = |time: &Nanos| {
        filter.push(&live(*time, swaying(time.seconds())));
        let estimate = filter.pose_at(*time, *time + ahead).unwrap();
        (time.seconds(), estimate.pose.frame_from_body)
    };
    times.iter().map(at).collect()
}

/// The track at a time between two of its own, by a cubic through the four nearest: straight lines
/// would be off by more than filters differ.
fn between(track: &[(f64, Rigid)], seconds: f64) -> Rigid {
    let later = track.partition_point(|(time, _)| *time <= seconds);
    let near = &track[later - 2..later + 2];
    let base = near[1].1.rotation;
    let (mut place, mut turn) = (DVec3::ZERO, DVec3::ZERO);
    for (i, (time, pose)) in near.iter().enumerate() {
        let others = near.iter().enumerate().filter(|(j, _)| *j != i);
        let weight: f64 = others
            .map(|(_, (other, _))| (seconds - other) / (time - other))
            .product();
        place += pose.translation * weight;
        turn += pose.rotation.difference_from(base) * weight;
    }
    Rigid::new(base.moved_by(turn), place)
}

/// The worst difference between tracks, in millimetres and degrees, once both have settled.
fn worst(a: &Track, b: &Track) -> (f64, f64) {
    let mut worst: (f64, f64) = (0.0, 0.0);
    for i in 0..1000 {
        let seconds = 1.5 + 0.01 * f64::from(i);
        let (a, b) = (between(a, seconds), between(b, seconds));
        let way = (a.translation - b.translation).length();
        let turn = a.rotation.difference_from(b.rotation).length();
        worst = (worst.0.max(1e3 * way), worst.1.max(turn.to_degrees()));
    }
    worst
}

/// Filters the motion at three rates and irregularly, and checks that each differs from a reference
/// rate by no more than the bounds.
#[track_caller]
fn check(settings: FilterSettings, ahead_ms: u64, reference_hz: f64, most_mm: f64, most_deg: f64) {
    let ahead = Duration::from_millis(ahead_ms);
    let reference = filtered(settings, &steady(reference_hz, SECONDS), ahead);
    let streams = [
        ("50 Hz", steady(50.0, SECONDS)),
        ("103.3 Hz", steady(103.3, SECONDS)),
        ("144 Hz", steady(144.0, SECONDS)),
        ("1 to 25 ms", irregular(3, SECONDS)),
    ];
    for (name, times) in streams {
        let (mm, degrees) = worst(&reference, &filtered(settings, &times, ahead));
        assert!(
            mm <= most_mm && degrees <= most_deg,
            "{mm} mm and {degrees} degrees at {name}"
        );
    }
}

fn smoothed(smoothing: Smoothing) -> FilterSettings {
    FilterSettings {
        smoothing,
        ..FilterSettings::default()
    }
}

fn predicted(prediction: Prediction) -> FilterSettings {
    FilterSettings {
        prediction,
        ..FilterSettings::default()
    }
}

#[test]
fn one_euro_by_raw_speed_stays_within_035_mm() {
    let raw = |settings| OneEuroSettings {
        derivative: Derivative::FromRaw,
        ..settings
    };
    let settings = smoothed(Smoothing::OneEuro {
        position: raw(OneEuroSettings::POSITION),
        attitude: raw(OneEuroSettings::ATTITUDE),
    });
    check(settings, 0, 1000.0, 0.35, 0.07);
}

#[test]
fn one_euro_by_the_papers_speed_stays_within_08_mm_of_144_hz() {
    // Its cutoff rises without end with the rate, so that there is no finest rate to compare with.
    check(smoothed(Smoothing::ONE_EURO), 0, 144.0, 0.8, 0.15);
}

#[test]
fn double_exponential_smoothing_stays_within_02_mm() {
    let tau = Duration::from_millis(40);
    let settings = smoothed(Smoothing::DoubleExponential {
        position: tau,
        attitude: tau,
    });
    check(settings, 0, 1000.0, 0.2, 0.03);
}

#[test]
fn double_exponential_prediction_by_40_ms_stays_within_06_mm() {
    let tau = Duration::from_millis(40);
    let settings = predicted(Prediction::DoubleExponential {
        position: tau,
        attitude: tau,
        horizon: HORIZON,
    });
    check(settings, 40, 1000.0, 0.6, 0.1);
}

#[test]
fn constant_velocity_by_40_ms_stays_within_12_mm() {
    // Most of it where 25 ms without a sample leave the window half empty; else 0.3 mm.
    check(
        predicted(Prediction::CONSTANT_VELOCITY),
        40,
        1000.0,
        1.2,
        0.2,
    );
}
