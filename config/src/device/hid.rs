//! HID devices as rig files name them.

use crate::RigError;
use crate::fields::Fields;
use std::time::Duration;

/// Which of several like HID devices is meant. Two of a kind are never told apart by the order in
/// which the system lists them: it changes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HidAddress {
    /// The serial number that the device gives.
    pub serial_number: Option<String>,
    /// The path that the system has for it, as `/dev/hidraw3`.
    pub path: Option<String>,
}

/// The hand that a glove is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The left hand.
    Left,
    /// The right hand.
    Right,
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// The most significant one.
    BigEndian,
    /// The least significant one.
    LittleEndian,
}

pub(super) fn read_address(fields: &Fields<'_>) -> Result<HidAddress, RigError> {
    let text = |key: &str, wanted: &str| -> Result<Option<String>, RigError> {
        let Some(value) = fields.get(key) else {
            return Ok(None);
        };
        let text = value.text(wanted)?;
        if text.is_empty() || text.len() > 1024 || text.chars().any(char::is_control) {
            return Err(value.error(
                &format!("is {text:?}"),
                &format!("write {wanted} as `sandtable doctor` lists it, or leave it out"),
            ));
        }
        Ok(Some(text.to_owned()))
    };
    Ok(HidAddress {
        serial_number: text("serial_number", "the device's serial number")?,
        path: text("path", "the device's path")?,
    })
}

pub(super) fn read_side(fields: &Fields<'_>) -> Result<Side, RigError> {
    fields
        .need("hand", "write the hand that it is for: left or right")?
        .choice(&[("left", Side::Left), ("right", Side::Right)])
}

pub(super) fn read_byte_order(
    fields: &Fields<'_>,
    default: ByteOrder,
) -> Result<ByteOrder, RigError> {
    match fields.get("byte_order") {
        Some(value) => value.choice(&[
            ("big", ByteOrder::BigEndian),
            ("little", ByteOrder::LittleEndian),
        ]),
        None => Ok(default),
    }
}

/// A USB id, such as 0x5D70.
pub(super) fn read_id(fields: &Fields<'_>, key: &str) -> Result<Option<u16>, RigError> {
    let Some(value) = fields.get(key) else {
        return Ok(None);
    };
    let id = value.integer(0..=0xFFFF, "(0xFFFF), as `sandtable doctor` lists it")?;
    Ok(u16::try_from(id).ok())
}

/// The silence after which a device is opened anew; 0 is never.
pub(super) fn read_silent_after(
    fields: &Fields<'_>,
    default: f64,
) -> Result<Option<Duration>, RigError> {
    let silence = fields.seconds("silent_after", default, 0.0..=60.0)?;
    Ok((!silence.is_zero()).then_some(silence))
}
