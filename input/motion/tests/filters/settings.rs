//! Each setting outside its range is refused by name.

use sandtable_motion::{
    DoubleExponential, FilterSettings, OneEuro, OneEuroSettings, Prediction, Smoothing,
    TrackerFilter, VelocityWindow, time_constant,
};
use std::time::Duration;

fn refused(settings: FilterSettings) -> String {
    TrackerFilter::new(settings).unwrap_err().to_string()
}

fn one_euro(position: OneEuroSettings, attitude: OneEuroSettings) -> FilterSettings {
    FilterSettings {
        smoothing: Smoothing::OneEuro { position, attitude },
        ..FilterSettings::default()
    }
}

const GOOD: OneEuroSettings = OneEuroSettings::POSITION;
const MS: Duration = Duration::from_millis(1);

#[test]
fn one_euro_names_its_part_field_and_range() {
    let zero = OneEuroSettings {
        min_cutoff_hz: 0.0,
        ..GOOD
    };
    assert_eq!(
        refused(one_euro(zero, GOOD)),
        "`smoothing.position.min_cutoff_hz` is 0: give 0.001 to 1000 Hz"
    );
    let endless = OneEuroSettings {
        derivative_cutoff_hz: f64::INFINITY,
        ..GOOD
    };
    assert_eq!(
        refused(one_euro(GOOD, endless)),
        "`smoothing.attitude.derivative_cutoff_hz` is inf: give 0.001 to 1000 Hz"
    );
    for beta in [-0.1, f64::NAN] {
        let bad = OneEuroSettings { beta, ..GOOD };
        assert_eq!(
            refused(one_euro(GOOD, bad)),
            format!(
                "`smoothing.attitude.beta` is {beta}: give 0 to 10000 Hz for each unit a second"
            )
        );
        let alone = OneEuro::<f64>::new(bad, 100 * MS).unwrap_err().to_string();
        assert!(alone.starts_with("`beta` is"), "{alone}");
    }
}

#[test]
fn time_constants_and_horizons_are_named_with_their_stage() {
    let with = |prediction| FilterSettings {
        prediction,
        ..FilterSettings::default()
    };
    let smoothing = FilterSettings {
        smoothing: Smoothing::DoubleExponential {
            position: 40 * MS,
            attitude: Duration::ZERO,
        },
        ..FilterSettings::default()
    };
    assert_eq!(
        refused(smoothing),
        "`smoothing.attitude` is 0: give 0.001 to 1 seconds"
    );
    let prediction = Prediction::DoubleExponential {
        position: 2000 * MS,
        attitude: 40 * MS,
        horizon: 50 * MS,
    };
    assert_eq!(
        refused(with(prediction)),
        "`prediction.position` is 2: give 0.001 to 1 seconds"
    );
    let horizon = 101 * MS;
    assert_eq!(
        refused(with(Prediction::ConstantVelocity { horizon })),
        "`prediction.horizon` is 0.101: give 0 to 0.1 seconds"
    );
}

#[test]
fn windows_gaps_and_times_of_loss_are_named() {
    let usual = FilterSettings::default();
    let velocity_window = 9 * MS;
    assert_eq!(
        refused(FilterSettings {
            velocity_window,
            ..usual
        }),
        "`velocity_window` is 0.009: give 0.01 to 0.5 seconds"
    );
    let gap = Duration::MAX;
    assert!(refused(FilterSettings { gap, ..usual }).starts_with("`gap` is 18446744073709"));
    assert!(DoubleExponential::<f64>::new(40 * MS, gap).is_err());
    assert!(VelocityWindow::new(50 * MS, gap).is_err());
    assert_eq!(
        refused(FilterSettings {
            lost_after: 20 * MS,
            ..usual
        }),
        "`lost_after` is 20ms, less than `held_after`, 30ms: raise the one or lower the other"
    );
}

#[test]
fn an_alpha_that_is_no_share_gives_no_filter() {
    assert_eq!(time_constant(0.5, 10 * MS), 10 * MS);
    for alpha in [0.0, 1.0, -1.0, 2.0, f64::NAN] {
        let tau = time_constant(alpha, 10 * MS);
        assert!(DoubleExponential::<f64>::new(tau, 100 * MS).is_err());
    }
}
