//! What the rig says of any tracker's poses: how old they may get, how fast sensors move, and where
//! the tracker's frame lies.

use super::AxisMap;
use super::axis_map::read_axis_map;
use crate::field_correction::read_correction;
use crate::fields::Fields;
use crate::rigid::read_measured_rigid;
use crate::{FieldCorrection, RigError};
use sandtable_pose::Rigid;
use std::time::Duration;
use time::Date;

/// How the poses of a tracker on the network are taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracking {
    /// How often it sends each sensor's pose, a second; it may send more often.
    pub rate: f64,
    /// A pose older than this is held, no longer live.
    pub held_after: Duration,
    /// A pose older than this is lost.
    pub lost_after: Duration,
    /// No sensor is believed to move faster, in metres a second.
    pub max_speed: f64,
    /// No sensor is believed to turn faster, in degrees a second.
    pub max_turn: f64,
    /// After so many equal poses in a row a sensor is frozen; `None` for one that may stand still.
    pub frozen_after: Option<u32>,
    /// From the tracker's own convention of axes to the one that `table_from_tracker` is told in.
    pub axes: AxisMap,
    /// From the tracker's frame, its axes mapped by `axes`, in metres, to the table's.
    pub table_from_tracker: Rigid,
    /// The day on which `table_from_tracker` was measured.
    pub calibrated: Option<Date>,
    /// How its field is bent, where that was measured.
    pub correction: Option<FieldCorrection>,
}

impl Tracking {
    /// From one pose of a sensor to the next.
    #[must_use]
    pub fn period(&self) -> Duration {
        Duration::from_secs_f64(self.rate.recip())
    }

    /// A pose as the tracker tells it, in metres, in the table's frame, its place corrected for a
    /// bent field.
    #[must_use]
    pub fn table_from_sensor(&self, told: &Rigid) -> Rigid {
        let pose = self.table_from_tracker * self.axes.apply(told);
        match &self.correction {
            Some(correction) => correction.apply(&pose),
            None => pose,
        }
    }
}

pub(super) fn read_tracking(fields: &Fields<'_>) -> Result<Tracking, RigError> {
    let (held_after, lost_after) = read_ages(fields)?;
    let (max_speed, max_turn) = read_speeds(fields)?;
    let (table_from_tracker, calibrated) = read_measured_rigid(
        &fields.need(
            "table_from_tracker",
            "write { translation = [..], axes = [..] }: where the tracker's frame lies",
        )?,
        "translation",
    )?;
    Ok(Tracking {
        rate: match fields.get("rate") {
            Some(value) => value.number(1.0..=2000.0, "poses a second")?,
            None => 60.0,
        },
        held_after,
        lost_after,
        max_speed,
        max_turn,
        frozen_after: match fields.get("frozen_after") {
            Some(value) => match value.integer(0..=1_000_000, "equal poses (0: never)")? {
                0 => None,
                poses => Some(poses),
            },
            None => Some(100),
        },
        axes: match fields.get("axes") {
            Some(value) => read_axis_map(&value)?,
            None => AxisMap::IDENTITY,
        },
        correction: read_correction(fields, &table_from_tracker)?,
        table_from_tracker,
        calibrated,
    })
}

/// `held_after_ms` and `lost_after_ms`.
pub(super) fn read_ages(fields: &Fields<'_>) -> Result<(Duration, Duration), RigError> {
    let milliseconds = |key: &str, default: f64| match fields.get(key) {
        Some(value) => value
            .number(1.0..=60_000.0, "milliseconds")
            .map(|ms| Duration::from_secs_f64(ms * 1e-3)),
        None => Ok(Duration::from_secs_f64(default * 1e-3)),
    };
    let held_after = milliseconds("held_after_ms", 30.0)?;
    let lost_after = milliseconds("lost_after_ms", 250.0)?;
    if lost_after < held_after {
        return Err(fields.error(
            "lost_after_ms",
            "is less than `held_after_ms`",
            "write at least as much: a pose is held before it is lost",
        ));
    }
    Ok((held_after, lost_after))
}

/// `max_speed`, in metres a second, and `max_turn`, in degrees a second.
pub(super) fn read_speeds(fields: &Fields<'_>) -> Result<(f64, f64), RigError> {
    let max_speed = match fields.get("max_speed") {
        Some(value) => value.number(0.1..=100.0, "metres a second")?,
        None => 5.0,
    };
    let max_turn = match fields.get("max_turn") {
        Some(value) => value.number(10.0..=20_000.0, "degrees a second")?,
        None => 1000.0,
    };
    Ok((max_speed, max_turn))
}

/// `silent_after`: how long the line may be silent until it is opened anew.
pub(super) fn read_silence(fields: &Fields<'_>, default: f64) -> Result<Duration, RigError> {
    match fields.get("silent_after") {
        Some(value) => value
            .number(0.5..=60.0, "seconds")
            .map(Duration::from_secs_f64),
        None => Ok(Duration::from_secs_f64(default)),
    }
}
