//! 5DT's Data Glove Ultra.

use super::calibration::{read_auto_calibration, read_range};
use super::gestures::{Gestures, read_gestures};
use super::hid::{
    ByteOrder, HidAddress, Side, read_address, read_byte_order, read_id, read_side,
    read_silent_after,
};
use crate::RigError;
use crate::fields::Fields;
use std::time::Duration;

/// A 5DT Data Glove Ultra as a USB HID device: how far each finger is bent, by 5 or 14 sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct DataGlove {
    /// The hand that it is for.
    pub side: Side,
    /// Its USB product id where it is not one of those known for its hand and number of sensors;
    /// 0 is a real one.
    pub product: Option<u16>,
    /// Which of several like gloves it is.
    pub address: HidAddress,
    /// Where in a report's 16 values each sensor is, the thumb's first; 5 or 14 of them. Without a
    /// word in the rig 0, 3, 6, 9, 12 for five sensors, as tested by others, and 0 to 13 for
    /// fourteen, as the maker's order of sensors has it.
    pub positions: Vec<usize>,
    /// Which byte of a value comes first; the high one without a word in the rig, as tested with
    /// five sensors.
    pub byte_order: ByteOrder,
    /// The lowest and highest raw value of each sensor to start from; empty to start from nothing.
    pub ranges: Vec<[f64; 2]>,
    /// Whether these ranges grow by what the glove sends.
    pub auto_calibration: bool,
    /// A sensor says nothing until its range is this share of the whole one, as noise would fill
    /// the scale; 0.01 without a word in the rig.
    pub least_range: f64,
    /// The silence after which the glove is opened anew and its fingers are unknown; 2 s without a
    /// word in the rig, as it sends at least 60 reports a second; `None` for never.
    pub silent_after: Option<Duration>,
    /// What the fingers mean.
    pub gestures: Gestures,
}

impl DataGlove {
    /// The highest raw value: 12 bits.
    pub const HIGHEST: f64 = 4095.0;

    /// How many sensors it has: 5, one a finger, or 14.
    #[must_use]
    pub fn sensors(&self) -> usize {
        self.positions.len()
    }
}

pub(super) fn read_data_glove(fields: &Fields<'_>) -> Result<DataGlove, RigError> {
    let sensors = fields
        .need("sensors", "write how many it has: 5 or 14")?
        .one_of(&[5, 14], "sensors")? as usize;
    let (auto_calibration, least_range) = read_auto_calibration(fields)?;
    let ranges = read_ranges(fields, sensors)?;
    if !auto_calibration && ranges.is_empty() {
        return Err(fields.error(
            "ranges",
            "is missing beside auto_calibration = false",
            "write [lowest, highest] of each sensor, or auto_calibration = true",
        ));
    }
    Ok(DataGlove {
        side: read_side(fields)?,
        product: read_id(fields, "product")?,
        address: read_address(fields)?,
        positions: read_positions(fields, sensors)?,
        byte_order: read_byte_order(fields, ByteOrder::BigEndian)?,
        ranges,
        auto_calibration,
        least_range,
        silent_after: read_silent_after(fields, 2.0)?,
        gestures: read_gestures(fields)?,
    })
}

fn read_positions(fields: &Fields<'_>, sensors: usize) -> Result<Vec<usize>, RigError> {
    let Some(value) = fields.get("positions") else {
        let apart = if sensors == 5 { 3 } else { 1 };
        return Ok((0..sensors).map(|sensor| sensor * apart).collect());
    };
    let wanted = format!("an array of {sensors} numbers from 0 to 15");
    let values = value.elements(&wanted)?;
    let mut positions = Vec::new();
    for position in &values {
        let number = position.integer(0..=15, "")? as usize;
        if positions.contains(&number) {
            return Err(position.error(
                &format!("is {number} a second time"),
                "write each sensor's own place",
            ));
        }
        positions.push(number);
    }
    if positions.len() != sensors {
        return Err(value.error(
            &format!("has {} elements", positions.len()),
            &format!("write {wanted}"),
        ));
    }
    Ok(positions)
}

fn read_ranges(fields: &Fields<'_>, sensors: usize) -> Result<Vec<[f64; 2]>, RigError> {
    let Some(value) = fields.get("ranges") else {
        return Ok(Vec::new());
    };
    let wanted = format!("an array of {sensors} pairs [lowest, highest]");
    let values = value.elements(&wanted)?;
    if values.len() != sensors {
        return Err(value.error(
            &format!("has {} elements", values.len()),
            &format!("write {wanted}"),
        ));
    }
    let range = |value| read_range(value, 0.0..=DataGlove::HIGHEST);
    values.iter().map(range).collect()
}
