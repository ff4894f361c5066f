//! Settings of a sensor's filter, and the ranges that they must lie in.
//!
//! All are seconds, hertz, or hertz for a unit a second. None counts samples or frames.

use crate::one_euro::OneEuroSettings;
use crate::prediction::HORIZON;
use crate::velocity::VELOCITY_WINDOW;
use std::time::Duration;

/// How a sensor's noise is smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Smoothing {
    /// Not at all: poses come out to the bit as they were measured.
    #[default]
    Off,
    /// The One-Euro filter: calm at rest, quick in motion. Choose it first.
    OneEuro {
        /// For positions in metres.
        position: OneEuroSettings,
        /// For attitudes in radians.
        attitude: OneEuroSettings,
    },
    /// Double exponential smoothing: as calm in motion as at rest, and without lag in a steady
    /// motion; where the motion changes it overshoots.
    DoubleExponential {
        /// The time constant for positions, 1 ms to 1 s.
        position: Duration,
        /// The time constant for attitudes, 1 ms to 1 s.
        attitude: Duration,
    },
}

/// How a pose is carried to the time at which it is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Prediction {
    /// Not at all.
    #[default]
    Off,
    /// On at the velocity of the last moments.
    ConstantVelocity {
        /// The furthest that is predicted, 0 to 100 ms.
        horizon: Duration,
    },
    /// By double exponential smoothing, which smooths as well.
    DoubleExponential {
        /// The time constant for positions, 1 ms to 1 s.
        position: Duration,
        /// The time constant for attitudes, 1 ms to 1 s.
        attitude: Duration,
        /// The furthest that is predicted, 0 to 100 ms.
        horizon: Duration,
    },
}

impl Smoothing {
    /// The One-Euro filter as it suits a head.
    pub const ONE_EURO: Self = Self::OneEuro {
        position: OneEuroSettings::POSITION,
        attitude: OneEuroSettings::ATTITUDE,
    };
}

impl Prediction {
    /// On at the velocity of the last moments, as far as usual.
    pub const CONSTANT_VELOCITY: Self = Self::ConstantVelocity { horizon: HORIZON };

    /// Double exponential prediction as it suits a head.
    pub const DOUBLE_EXPONENTIAL: Self = Self::DoubleExponential {
        position: Duration::from_millis(20),
        attitude: Duration::from_millis(20),
        horizon: HORIZON,
    };
}

/// What one sensor's filter does, and when its poses are no longer live.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSettings {
    /// How noise is smoothed; off by default.
    pub smoothing: Smoothing,
    /// How a pose is carried to its display time; off by default.
    pub prediction: Prediction,
    /// Over how much time velocities are taken, 10 to 500 ms; 50 ms by default.
    pub velocity_window: Duration,
    /// Without a sample for longer than this, filters begin anew and nothing is predicted; 10 ms
    /// to 10 s, 100 ms by default. A sensor slower than ten samples a second needs more.
    pub gap: Duration,
    /// A pose older than this is held; 30 ms by default.
    pub held_after: Duration,
    /// A pose older than this is lost; not less than `held_after`, 250 ms by default.
    pub lost_after: Duration,
}

impl Default for FilterSettings {
    fn default() -> Self {
        Self {
            smoothing: Smoothing::default(),
            prediction: Prediction::default(),
            velocity_window: VELOCITY_WINDOW,
            gap: Duration::from_millis(100),
            held_after: Duration::from_millis(30),
            lost_after: Duration::from_millis(250),
        }
    }
}

/// A setting that cannot be meant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A number or a time is outside its range, or is no number.
    #[error("`{field}` is {value}: give {least} to {most} {unit}")]
    OutOfRange {
        /// Where it stands, such as `smoothing.position.beta`.
        field: String,
        /// What was given, in the unit of the range.
        value: f64,
        /// The smallest that is taken.
        least: f64,
        /// The largest that is taken.
        most: f64,
        /// The range's unit.
        unit: &'static str,
    },
    /// A pose would be lost before it is held.
    #[error(
        "`lost_after` is {lost_after:?}, less than `held_after`, {held_after:?}: \
         raise the one or lower the other"
    )]
    LostBeforeHeld {
        /// After what time a pose is held.
        held_after: Duration,
        /// After what time a pose is lost.
        lost_after: Duration,
    },
}

impl FilterSettings {
    /// Checks every range.
    ///
    /// # Errors
    /// The first setting that cannot be meant.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.smoothing.check("smoothing.")?;
        self.prediction.check("prediction.")?;
        check_window(self.velocity_window)?;
        check_gap(self.gap)?;
        if self.lost_after < self.held_after {
            return Err(SettingsError::LostBeforeHeld {
                held_after: self.held_after,
                lost_after: self.lost_after,
            });
        }
        Ok(())
    }
}

impl Smoothing {
    fn check(&self, at: &str) -> Result<(), SettingsError> {
        match self {
            Self::Off => Ok(()),
            Self::OneEuro { position, attitude } => {
                position.check(&format!("{at}position."))?;
                attitude.check(&format!("{at}attitude."))
            }
            Self::DoubleExponential { position, attitude } => {
                check_time_constant(&format!("{at}position"), *position)?;
                check_time_constant(&format!("{at}attitude"), *attitude)
            }
        }
    }
}

impl Prediction {
    pub(crate) fn check(&self, at: &str) -> Result<(), SettingsError> {
        match self {
            Self::Off => Ok(()),
            Self::ConstantVelocity { horizon } => check_horizon(at, *horizon),
            Self::DoubleExponential {
                position,
                attitude,
                horizon,
            } => {
                check_time_constant(&format!("{at}position"), *position)?;
                check_time_constant(&format!("{at}attitude"), *attitude)?;
                check_horizon(at, *horizon)
            }
        }
    }
}

impl OneEuroSettings {
    pub(crate) fn check(&self, at: &str) -> Result<(), SettingsError> {
        let cutoff = |name: &str, value| {
            let field = format!("{at}{name}");
            in_range(&field, value, 0.001, 1000.0, "Hz")
        };
        cutoff("min_cutoff_hz", self.min_cutoff_hz)?;
        cutoff("derivative_cutoff_hz", self.derivative_cutoff_hz)?;
        let field = format!("{at}beta");
        in_range(&field, self.beta, 0.0, 1e4, "Hz for each unit a second")
    }
}

pub(crate) fn check_gap(gap: Duration) -> Result<(), SettingsError> {
    in_range("gap", gap.as_secs_f64(), 0.01, 10.0, "seconds")
}

pub(crate) fn check_window(window: Duration) -> Result<(), SettingsError> {
    let seconds = window.as_secs_f64();
    in_range("velocity_window", seconds, 0.01, 0.5, "seconds")
}

pub(crate) fn check_time_constant(
    field: &str,
    time_constant: Duration,
) -> Result<(), SettingsError> {
    in_range(field, time_constant.as_secs_f64(), 0.001, 1.0, "seconds")
}

fn check_horizon(at: &str, horizon: Duration) -> Result<(), SettingsError> {
    let field = format!("{at}horizon");
    in_range(&field, horizon.as_secs_f64(), 0.0, 0.1, "seconds")
}

fn in_range(
    field: &str,
    value: f64,
    least: f64,
    most: f64,
    unit: &'static str,
) -> Result<(), SettingsError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(SettingsError::OutOfRange {
            field: field.to_owned(),
            value,
            least,
            most,
            unit,
        })
    }
}
