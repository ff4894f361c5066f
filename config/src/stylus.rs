//! The stylus: a sensor with a tip that marks are touched with.

use crate::fields::Value;
use crate::{RigError, SensorName};
use glam::DVec3;
use time::Date;

/// What marks are touched with, `[stylus]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Stylus {
    /// The sensor on it.
    pub sensor: SensorName,
    /// Its tip in the sensor's own axes, in metres.
    pub tip: DVec3,
    /// When the tip was measured, where it was.
    pub calibrated: Option<Date>,
}

pub(crate) fn read_stylus(
    value: &Value<'_>,
    sensor: impl Fn(&Value<'_>) -> Result<SensorName, RigError>,
) -> Result<Stylus, RigError> {
    let fields = value.fields()?;
    let stylus = Stylus {
        sensor: sensor(&fields.need("sensor", "write the sensor on the stylus, as \"flock/2\"")?)?,
        tip: DVec3::from_array(
            fields
                .need("tip", "write [x, y, z] in the sensor's metres")?
                .numbers::<3>(-1.0..=1.0, "metres")?,
        ),
        calibrated: fields.date("calibrated")?,
    };
    fields.finish()?;
    Ok(stylus)
}
