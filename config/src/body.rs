//! Heads and hands: which sensor they wear, where they rest, where the eyes sit.

use crate::RigError;
use crate::fields::{Fields, Value};
use crate::rigid::read_rigid;
use glam::DVec3;
use sandtable_pose::Rigid;
use std::fmt;
use time::Date;

/// A sensor: a device of the rig and the sensor's number on it, written `flock/1`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SensorName {
    /// The device's name in the rig.
    pub device: String,
    /// The sensor's number on it, from 1.
    pub number: u32,
}

impl fmt::Display for SensorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.device, self.number)
    }
}

/// The viewer's head.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// The sensor that it wears; none where nothing tracks it.
    pub sensor: Option<SensorName>,
    /// `table_from_sensor` while nothing tracks it, in table metres.
    pub rest: Rigid,
    /// Where the eyes sit.
    pub eyes: Eyes,
}

/// Where the eyes sit on a head, in the head sensor's own axes and metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eyes {
    /// The middle between the eyes.
    pub middle: DVec3,
    /// The unit vector from the left eye to the right eye.
    pub rightwards: DVec3,
    /// The distance between the eyes.
    pub interpupillary: f64,
    /// When they were measured, where they were.
    pub calibrated: Option<Date>,
}

/// The viewer's hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Hand {
    /// The sensor that it wears; none where nothing tracks it.
    pub sensor: Option<SensorName>,
    /// `table_from_sensor` while nothing tracks it, in table metres.
    pub rest: Rigid,
    /// The unit vector in which it points, in the sensor's own axes; x without a word in the rig.
    pub forward: DVec3,
}

pub(crate) fn read_head(
    value: &Value<'_>,
    sensor: impl Fn(&Value<'_>) -> Result<SensorName, RigError>,
) -> Result<Head, RigError> {
    let fields = value.fields()?;
    let head = Head {
        sensor: fields
            .get("sensor")
            .map(|value| sensor(&value))
            .transpose()?,
        rest: read_rest(&fields)?,
        eyes: read_eyes(&fields.need(
            "eyes",
            "write eyes = { middle = [..], rightwards = [..], interpupillary = 0.063 }",
        )?)?,
    };
    fields.finish()?;
    Ok(head)
}

pub(crate) fn read_hand(
    value: &Value<'_>,
    sensor: impl Fn(&Value<'_>) -> Result<SensorName, RigError>,
) -> Result<Hand, RigError> {
    let fields = value.fields()?;
    let hand = Hand {
        sensor: fields
            .get("sensor")
            .map(|value| sensor(&value))
            .transpose()?,
        rest: read_rest(&fields)?,
        forward: match fields.get("forward") {
            Some(value) => read_direction(&value)?,
            None => DVec3::X,
        },
    };
    fields.finish()?;
    Ok(hand)
}

/// A unit vector.
fn read_direction(value: &Value<'_>) -> Result<DVec3, RigError> {
    let direction = DVec3::from_array(value.numbers::<3>(-1.0..=1.0, "")?);
    if (direction.length() - 1.0).abs() > 0.01 {
        return Err(value.error(
            &format!("has length {:.3}", direction.length()),
            "write a direction of length 1",
        ));
    }
    Ok(direction.normalize())
}

fn read_rest(fields: &Fields<'_>) -> Result<Rigid, RigError> {
    let value = fields.need(
        "rest",
        "write rest = { position = [x, y, z] } in table metres",
    )?;
    read_rigid(&value, "position")
}

fn read_eyes(value: &Value<'_>) -> Result<Eyes, RigError> {
    let fields = value.fields()?;
    let middle = fields
        .need("middle", "write [x, y, z] in the sensor's metres")?
        .numbers::<3>(-1.0..=1.0, "metres")?;
    let rightwards_value = fields.need(
        "rightwards",
        "write the direction from the left to the right eye in the sensor's axes",
    )?;
    let rightwards = read_direction(&rightwards_value)?;
    let interpupillary = match fields.get("interpupillary") {
        // 54 to 74 mm covers adults; nothing beyond helps, and zero is mono.
        Some(value) => value.number(0.0..=0.1, "metres")?,
        None => 0.063,
    };
    let calibrated = fields.date("calibrated")?;
    fields.finish()?;
    Ok(Eyes {
        middle: DVec3::from_array(middle),
        rightwards,
        interpupillary,
        calibrated,
    })
}
