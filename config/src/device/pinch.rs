//! Fakespace's PINCH gloves.

use super::gestures::{Gestures, read_gestures};
use super::port::read_port;
use crate::RigError;
use crate::fields::Fields;
use std::time::Duration;

/// Fakespace PINCH gloves: which fingertips of two hands touch which. A box on a serial line sends
/// each change, and nothing else.
///
/// The defaults are what the box's known hosts agree on. Where they differ, the key says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Pinch {
    /// The serial port's path.
    pub port: String,
    /// Bits a second; 9600 without a word in the rig, as all known hosts have it.
    pub baud: u32,
    /// Whether the box is to tell the time between its messages. Off without a word in the rig:
    /// most hosts never ask for it.
    pub timestamps: bool,
    /// The pause between the two bytes of a command. Known hosts leave 0, 1 and 250 ms; 250 ms
    /// without a word in the rig.
    pub byte_pause: Duration,
    /// How long an answer of the box may take; 1 s without a word in the rig.
    pub answer_within: Duration,
    /// How long fingers are still believed after a message was damaged: what they do is unknown
    /// until the next change. 250 ms without a word in the rig.
    pub release_after: Duration,
    /// How often the box is asked whether it is there, as it is silent while nothing changes;
    /// `None` for never. 10 s without a word in the rig. No known host asks.
    pub ask_every: Option<Duration>,
    /// Whether the gloves have contacts in the palms. Their coding is not known: their bits are
    /// then passed over, where they otherwise are damage.
    pub palms: bool,
    /// What the fingers mean.
    pub gestures: Gestures,
}

pub(super) fn read_pinch(fields: &Fields<'_>) -> Result<Pinch, RigError> {
    let ask_every = fields.seconds("ask_every", 10.0, 0.0..=3600.0)?;
    Ok(Pinch {
        port: read_port(fields)?,
        baud: match fields.get("baud") {
            Some(value) => value.one_of(
                &[1200, 2400, 4800, 9600, 19200, 38400, 57600, 115_200],
                "as the box is set, mostly 9600",
            )?,
            None => 9600,
        },
        timestamps: fields.flag("timestamps", false)?,
        byte_pause: fields.seconds("byte_pause", 0.25, 0.0..=2.0)?,
        answer_within: fields.seconds("answer_within", 1.0, 0.05..=30.0)?,
        release_after: fields.seconds("release_after", 0.25, 0.05..=10.0)?,
        ask_every: (!ask_every.is_zero()).then_some(ask_every),
        palms: fields.flag("palms", false)?,
        gestures: read_gestures(fields)?,
    })
}
