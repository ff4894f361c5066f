//! Gloves of VRPN servers: the channels and buttons that are fingers.

use super::VrpnPart;
use super::calibration::{need_range, read_range};
use super::fingers::read_fingers;
use super::gestures::{Gestures, read_gestures};
use crate::RigError;
use crate::fields::{Fields, Value};
use std::cell::RefCell;

/// One hand's glove on a VRPN server: which of its channels and buttons are fingers.
///
/// A channel tells how far a finger is bent. A button tells that a finger touches something, and
/// nothing of what: where the thumb and another finger of the hand touch something, they are taken
/// to touch one another, since that is what a hand does that pinches; fingers without the thumb,
/// and a thumb alone, touch what is not known, and are told by their buttons only.
#[derive(Clone, Debug, PartialEq)]
pub struct VrpnGlove {
    /// The sensor that the hand is told of: that of the analogs, or of the buttons.
    pub sensor: u32,
    /// Each finger's channel, the thumb's first; `None` for one that is not measured.
    pub fingers: [Option<VrpnFinger>; 5],
    /// Each finger's button, from 0, the thumb's first; `None` for one that has none.
    pub touching: [Option<u32>; 5],
    /// Whether the fingers' ranges grow by what the server sends.
    pub auto_calibration: bool,
    /// A finger says nothing until its range is so wide, in its channel's own units; 0.01 without
    /// a word in the rig, a hundredth of what most of VRPN's channels can tell.
    pub least_range: f64,
    /// What the fingers mean.
    pub gestures: Gestures,
}

/// A finger's channel, and how it is scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VrpnFinger {
    /// The channel's number, from 0.
    pub channel: usize,
    /// Whether the value is less the further the finger is bent.
    pub inverted: bool,
    /// The lowest and highest value to start from; `None` to start from nothing.
    pub range: Option<[f64; 2]>,
}

/// The highest channel and the highest button that are listened to.
const HIGHEST_CHANNEL: u32 = 31;
const HIGHEST_BUTTON: u32 = 63;

/// Beyond any raw value.
const LIMIT: f64 = 1e9;

/// The glove that `fingers` or `touching` describe; `None` where there is neither.
pub(super) fn read_vrpn_glove(
    fields: &Fields<'_>,
    analogs: &VrpnPart,
    buttons: &VrpnPart,
) -> Result<Option<VrpnGlove>, RigError> {
    let (fingers, touching) = (fields.get("fingers"), fields.get("touching"));
    let sensor = match (&fingers, &touching) {
        (None, None) => return Ok(None),
        (Some(_), Some(value)) if analogs.sensor != buttons.sensor => {
            return Err(value.error(
                &format!(
                    "is of sensor {}, and `fingers` is of sensor {}",
                    buttons.sensor, analogs.sensor
                ),
                "write the same `sensor` in `buttons` and `analogs`: both are one hand's",
            ));
        }
        (Some(_), _) => analogs.sensor,
        (None, Some(_)) => buttons.sensor,
    };
    let auto_calibration = fields.flag("auto_calibration", true)?;
    let read = |fingers: &Value<'_>| read_channels(fingers, auto_calibration);
    let fingers = fingers.map(|fingers| read(&fingers)).transpose()?;
    let touching = touching.map(|buttons| read_buttons(&buttons)).transpose()?;
    Ok(Some(VrpnGlove {
        sensor,
        fingers: fingers.unwrap_or_default(),
        touching: touching.unwrap_or_default(),
        auto_calibration,
        least_range: match fields.get("least_range") {
            Some(value) => value.number(1e-6..=LIMIT, "in the channels' own units")?,
            None => 0.01,
        },
        gestures: read_gestures(fields)?,
    }))
}

fn read_channels(
    value: &Value<'_>,
    auto_calibration: bool,
) -> Result<[Option<VrpnFinger>; 5], RigError> {
    let taken = RefCell::default();
    read_fingers(value, |value| {
        let finger = if value.is_table() {
            let fields = value.fields()?;
            let channel = fields.need("channel", "write the number of the finger's channel")?;
            let finger = VrpnFinger {
                channel: read_number(&channel, HIGHEST_CHANNEL, &taken)? as usize,
                inverted: fields.flag("inverted", false)?,
                range: match fields.get("range") {
                    Some(value) => Some(read_range(&value, -LIMIT..=LIMIT)?),
                    None => None,
                },
            };
            fields.finish()?;
            finger
        } else {
            VrpnFinger {
                channel: read_number(value, HIGHEST_CHANNEL, &taken)? as usize,
                inverted: false,
                range: None,
            }
        };
        need_range(value, finger.range, auto_calibration)?;
        Ok(finger)
    })
}

fn read_buttons(value: &Value<'_>) -> Result<[Option<u32>; 5], RigError> {
    let taken = RefCell::default();
    read_fingers(value, |value| read_number(value, HIGHEST_BUTTON, &taken))
}

/// A number that no other finger has.
fn read_number(
    value: &Value<'_>,
    highest: u32,
    taken: &RefCell<Vec<u32>>,
) -> Result<u32, RigError> {
    let number = value.integer(0..=highest, "")?;
    let mut taken = taken.borrow_mut();
    if taken.contains(&number) {
        return Err(value.error(
            &format!("is {number} a second time"),
            "write each finger's own",
        ));
    }
    taken.push(number);
    Ok(number)
}
