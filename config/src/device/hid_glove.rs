//! Gloves that are HID devices, described by the rig.

use super::calibration::{need_range, read_auto_calibration, read_range};
use super::fingers::read_fingers;
use super::gestures::{Gestures, read_gestures};
use super::hid::{
    ByteOrder, HidAddress, Side, read_address, read_byte_order, read_id, read_side,
    read_silent_after,
};
use crate::RigError;
use crate::fields::{Fields, Value};
use std::time::Duration;

/// Any glove that is a HID device: where in its reports the fingers and buttons are.
#[derive(Clone, Debug, PartialEq)]
pub struct HidGlove {
    /// The hand that it is for.
    pub side: Side,
    /// Its USB vendor id.
    pub vendor: u16,
    /// Its USB product id; 0 is a real one.
    pub product: u16,
    /// Which of several like gloves it is.
    pub address: HidAddress,
    /// The id of the report that the fingers are in, which is its first byte; `None` for a glove
    /// whose reports have no id.
    pub report_id: Option<u8>,
    /// The report's length in bytes, its id included, where reports of another length are none;
    /// `None` for any that has all fields in it.
    pub report_length: Option<usize>,
    /// Where each finger is, the thumb first; `None` for one that the glove does not measure.
    pub fingers: [Option<HidFinger>; 5],
    /// Where each button is; button 0 first.
    pub buttons: Vec<HidBit>,
    /// Whether the fingers' ranges grow by what the glove sends.
    pub auto_calibration: bool,
    /// A finger says nothing until its range is this share of the field's whole one; 0.01 without
    /// a word in the rig.
    pub least_range: f64,
    /// The silence after which the glove is opened anew and its fingers are unknown; `None` for
    /// never, which is so without a word in the rig, as a glove may send changes only.
    pub silent_after: Option<Duration>,
    /// What the fingers mean.
    pub gestures: Gestures,
}

/// Where a finger is in a report, and how it is scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HidFinger {
    /// Where its raw value is.
    pub field: HidField,
    /// Whether the value is less the further the finger is bent.
    pub inverted: bool,
    /// The lowest and highest raw value to start from; `None` to start from nothing.
    pub range: Option<[f64; 2]>,
}

/// A whole number in a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HidField {
    /// The byte that it begins in, from 0; a report's id is byte 0.
    pub byte: usize,
    /// The bit of that byte that it begins at, from 0, the least significant one.
    pub bit: u32,
    /// How many bits it has, 1 to 32.
    pub bits: u32,
    /// Whether it is a two's complement.
    pub signed: bool,
    /// Which byte comes first. The high one: the field is of whole bytes then.
    pub byte_order: ByteOrder,
}

impl HidField {
    /// The lowest and the highest value that it can have.
    #[must_use]
    pub fn limits(&self) -> [f64; 2] {
        let values = f64::from(self.bits).exp2();
        if self.signed {
            [-values / 2.0, values / 2.0 - 1.0]
        } else {
            [0.0, values - 1.0]
        }
    }

    /// How many bytes a report must have to hold it.
    #[must_use]
    pub fn end(&self) -> usize {
        self.byte + (self.bit + self.bits).div_ceil(8) as usize
    }
}

/// One bit of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HidBit {
    /// The byte that it is in, from 0; a report's id is byte 0.
    pub byte: usize,
    /// The bit, from 0, the least significant one.
    pub bit: u32,
}

/// The most bytes that a report has.
const LONGEST_REPORT: u32 = 1024;

pub(super) fn read_hid_glove(fields: &Fields<'_>) -> Result<HidGlove, RigError> {
    let id = |key: &str| -> Result<u16, RigError> {
        read_id(fields, key)?.ok_or_else(|| {
            let remedy = "write its USB id as `sandtable doctor` lists it, as 0x1234";
            fields.error(key, "is missing", remedy)
        })
    };
    let (auto_calibration, least_range) = read_auto_calibration(fields)?;
    let report_id = match fields.get("report_id") {
        // No report has the id 0: it stands for none in the systems' own interfaces.
        Some(value) => Some(value.integer(1..=255, "(leave it out where there is none)")? as u8),
        None => None,
    };
    let glove = HidGlove {
        side: read_side(fields)?,
        vendor: id("vendor")?,
        product: id("product")?,
        address: read_address(fields)?,
        report_id,
        report_length: match fields.get("report_length") {
            Some(value) => Some(value.integer(1..=LONGEST_REPORT, "bytes")? as usize),
            None => None,
        },
        fingers: read_described(fields, auto_calibration)?,
        buttons: read_buttons(fields)?,
        auto_calibration,
        least_range,
        silent_after: read_silent_after(fields, 0.0)?,
        gestures: read_gestures(fields)?,
    };
    if let Some(length) = glove.report_length
        && length < glove.shortest_report()
    {
        return Err(fields.error(
            "report_length",
            &format!("is {length}"),
            &format!(
                "write at least {}: so far do its fields reach",
                glove.shortest_report()
            ),
        ));
    }
    Ok(glove)
}

impl HidGlove {
    /// How many bytes a report must have to hold every field.
    #[must_use]
    pub fn shortest_report(&self) -> usize {
        let fingers = self.fingers.iter().flatten();
        let ends = fingers.map(|finger| finger.field.end());
        let buttons = self.buttons.iter().map(|button| button.byte + 1);
        let id = usize::from(self.report_id.is_some());
        ends.chain(buttons).max().unwrap_or(0).max(id)
    }
}

fn read_described(
    fields: &Fields<'_>,
    auto_calibration: bool,
) -> Result<[Option<HidFinger>; 5], RigError> {
    let value = fields.need(
        "fingers",
        "write where they are in a report, as fingers = { index = { byte = 2 } }",
    )?;
    read_fingers(&value, |value| {
        let finger = read_finger(value)?;
        need_range(value, finger.range, auto_calibration)?;
        Ok(finger)
    })
}

fn read_finger(value: &Value<'_>) -> Result<HidFinger, RigError> {
    let fields = value.fields()?;
    let bits = match fields.get("bits") {
        Some(value) => value.integer(1..=32, "bits")?,
        None => 8,
    };
    let HidBit { byte, bit } = read_bit(&fields)?;
    let field = HidField {
        byte,
        bit,
        bits,
        signed: fields.flag("signed", false)?,
        byte_order: read_byte_order(&fields, ByteOrder::LittleEndian)?,
    };
    if field.byte_order == ByteOrder::BigEndian && (bit != 0 || bits % 8 != 0) {
        return Err(fields.error(
            "byte_order",
            "is \"big\" for a field that is not of whole bytes",
            "write bits = 8, 16, 24 or 32 and no `bit`, or byte_order = \"little\"",
        ));
    }
    let [lowest, highest] = field.limits();
    let range = match fields.get("range") {
        Some(value) => Some(read_range(&value, lowest..=highest)?),
        None => None,
    };
    let finger = HidFinger {
        field,
        inverted: fields.flag("inverted", false)?,
        range,
    };
    fields.finish()?;
    Ok(finger)
}

fn read_buttons(fields: &Fields<'_>) -> Result<Vec<HidBit>, RigError> {
    let Some(value) = fields.get("buttons") else {
        return Ok(Vec::new());
    };
    let values = value.elements("an array of { byte = B, bit = N }")?;
    if values.len() > 64 {
        return Err(value.error(
            &format!("has {} elements", values.len()),
            "write 64 buttons at most",
        ));
    }
    let button = |value: &Value<'_>| {
        let fields = value.fields()?;
        let bit = read_bit(&fields)?;
        fields.finish()?;
        Ok(bit)
    };
    values.iter().map(button).collect()
}

fn read_bit(fields: &Fields<'_>) -> Result<HidBit, RigError> {
    // Asked for first, lest it be taken for a misspelt `byte`.
    let bit = match fields.get("bit") {
        Some(value) => value.integer(0..=7, "")?,
        None => 0,
    };
    let byte = fields
        .need("byte", "write the byte of the report that it begins in")?
        .integer(0..=LONGEST_REPORT - 4, "")?;
    Ok(HidBit {
        byte: byte as usize,
        bit,
    })
}
