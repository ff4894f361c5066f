//! Sensors: how one's noise is smoothed and its poses are carried to the time of their picture.

use crate::RigError;
use crate::fields::{Fields, Value};
use sandtable_motion::{
    Derivative, FilterSettings, OneEuroSettings, Prediction, SettingsError, Smoothing,
};
use std::time::Duration;

/// What is set for one sensor, `[sensors."flock/1"]`. Without it nothing is smoothed or predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorSettings {
    /// Smoothing, prediction and what they need. When poses are held and lost is the device's.
    pub filter: FilterSettings,
    /// From when a pose is asked for to the middle of its picture's time on the glass.
    pub ahead: Duration,
}

/// The longest that a picture may take from its pose to the glass, in milliseconds.
const LONGEST_AHEAD: f64 = 200.0;

pub(crate) fn read_sensor_settings(value: &Value<'_>) -> Result<SensorSettings, RigError> {
    let fields = value.fields()?;
    let default = FilterSettings::default();
    let filter = FilterSettings {
        smoothing: match fields.get("smoothing") {
            Some(value) => read_smoothing(&value)?,
            None => default.smoothing,
        },
        prediction: match fields.get("prediction") {
            Some(value) => read_prediction(&value)?,
            None => default.prediction,
        },
        velocity_window: milliseconds(
            &fields,
            "velocity_window_ms",
            default.velocity_window,
            10.0..=500.0,
        )?,
        gap: milliseconds(&fields, "gap_ms", default.gap, 10.0..=10_000.0)?,
        ..default
    };
    let ahead = milliseconds(&fields, "ahead_ms", Duration::ZERO, 0.0..=LONGEST_AHEAD)?;
    if filter.prediction != Prediction::Off && ahead.is_zero() {
        return Err(fields.error(
            "ahead_ms",
            "is missing or 0 beside a prediction",
            "write how long a picture takes from its pose to the glass, such as 30",
        ));
    }
    if filter.prediction == Prediction::Off
        && !ahead.is_zero()
        && !value.is_recorded()
        && let Some(value) = fields.get("ahead_ms")
    {
        return Err(value.error(
            "is there, and nothing predicts",
            "write prediction = { kind = \"constant-velocity\" } beside it, or leave it out",
        ));
    }
    // Single fields are in their ranges; what is left is how they go together.
    filter
        .check()
        .map_err(|error: SettingsError| value.error("cannot be meant", &error.to_string()))?;
    fields.finish()?;
    Ok(SensorSettings { filter, ahead })
}

/// The kinds of filters, as they are written.
#[derive(Clone, Copy)]
enum Kind {
    Off,
    OneEuro,
    DoubleExponential,
    ConstantVelocity,
}

fn read_smoothing(value: &Value<'_>) -> Result<Smoothing, RigError> {
    let fields = value.fields()?;
    let kind = fields.need("kind", "write kind = \"one-euro\"")?.choice(&[
        ("off", Kind::Off),
        ("one-euro", Kind::OneEuro),
        ("double-exponential", Kind::DoubleExponential),
    ])?;
    let smoothing = match kind {
        Kind::OneEuro => Smoothing::OneEuro {
            position: read_one_euro(fields.get("position"), OneEuroSettings::POSITION)?,
            attitude: read_one_euro(fields.get("attitude"), OneEuroSettings::ATTITUDE)?,
        },
        Kind::DoubleExponential => {
            let (position, attitude) = time_constants(&fields)?;
            Smoothing::DoubleExponential { position, attitude }
        }
        _ => Smoothing::Off,
    };
    fields.finish()?;
    Ok(smoothing)
}

fn read_prediction(value: &Value<'_>) -> Result<Prediction, RigError> {
    let fields = value.fields()?;
    let kind = fields
        .need("kind", "write kind = \"constant-velocity\"")?
        .choice(&[
            ("off", Kind::Off),
            ("constant-velocity", Kind::ConstantVelocity),
            ("double-exponential", Kind::DoubleExponential),
        ])?;
    let horizon = |fields: &Fields<'_>| {
        milliseconds(fields, "horizon_ms", sandtable_motion::HORIZON, 0.0..=100.0)
    };
    let prediction = match kind {
        Kind::ConstantVelocity => Prediction::ConstantVelocity {
            horizon: horizon(&fields)?,
        },
        Kind::DoubleExponential => {
            let (position, attitude) = time_constants(&fields)?;
            Prediction::DoubleExponential {
                position,
                attitude,
                horizon: horizon(&fields)?,
            }
        }
        _ => Prediction::Off,
    };
    fields.finish()?;
    Ok(prediction)
}

fn read_one_euro(
    value: Option<Value<'_>>,
    default: OneEuroSettings,
) -> Result<OneEuroSettings, RigError> {
    let Some(value) = value else {
        return Ok(default);
    };
    let fields = value.fields()?;
    let hertz = |key: &str, default: f64| match fields.get(key) {
        Some(value) => value.number(0.001..=1000.0, "hertz"),
        None => Ok(default),
    };
    let settings = OneEuroSettings {
        min_cutoff_hz: hertz("min_cutoff_hz", default.min_cutoff_hz)?,
        beta: match fields.get("beta") {
            Some(value) => value.number(0.0..=10_000.0, "hertz for each unit a second")?,
            None => default.beta,
        },
        derivative_cutoff_hz: hertz("derivative_cutoff_hz", default.derivative_cutoff_hz)?,
        derivative: fields.choice_or(
            "derivative",
            default.derivative,
            &[
                ("from-filtered", Derivative::FromFiltered),
                ("from-raw", Derivative::FromRaw),
            ],
        )?,
    };
    fields.finish()?;
    Ok(settings)
}

/// The time constants of double exponential smoothing, for positions and attitudes.
fn time_constants(fields: &Fields<'_>) -> Result<(Duration, Duration), RigError> {
    let usual = Duration::from_millis(20);
    let position = milliseconds(fields, "position_ms", usual, 1.0..=1000.0)?;
    let attitude = milliseconds(fields, "attitude_ms", position, 1.0..=1000.0)?;
    Ok((position, attitude))
}

fn milliseconds(
    fields: &Fields<'_>,
    key: &str,
    default: Duration,
    range: std::ops::RangeInclusive<f64>,
) -> Result<Duration, RigError> {
    match fields.get(key) {
        Some(value) => value
            .number(range, "milliseconds")
            .map(|ms| Duration::from_secs_f64(ms * 1e-3)),
        None => Ok(default),
    }
}
