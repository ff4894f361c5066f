//! What a rig knows of a glove's calibration.

use crate::RigError;
use crate::fields::{Fields, Value};
use std::ops::RangeInclusive;

/// The keys `auto_calibration` and `least_range`.
pub(super) fn read_auto_calibration(fields: &Fields<'_>) -> Result<(bool, f64), RigError> {
    let least_range = match fields.get("least_range") {
        Some(value) => value.number(0.001..=0.5, "of the whole range")?,
        None => 0.01,
    };
    Ok((fields.flag("auto_calibration", true)?, least_range))
}

/// `[lowest, highest]`, two raw values within `limits`.
pub(super) fn read_range(
    value: &Value<'_>,
    limits: RangeInclusive<f64>,
) -> Result<[f64; 2], RigError> {
    let [lowest, highest] = value.numbers::<2>(limits, "(the lowest and the highest raw value)")?;
    if lowest >= highest {
        return Err(value.error(
            &format!("goes from {lowest} to {highest}"),
            "write the lower value first",
        ));
    }
    Ok([lowest, highest])
}

/// Checks that a finger has a range where none can be learnt.
pub(super) fn need_range(
    finger: &Value<'_>,
    range: Option<[f64; 2]>,
    auto_calibration: bool,
) -> Result<(), RigError> {
    if range.is_none() && !auto_calibration {
        return Err(finger.error(
            "has no `range` beside auto_calibration = false",
            "write range = [lowest, highest], or auto_calibration = true",
        ));
    }
    Ok(())
}
