//! Devices: what is plugged in where, and how it sits in the table's frame. One file a kind.

mod flock;
mod port;

pub use flock::{
    Addressing, Confirm, Flock, FlockMode, Hemisphere, QuaternionSign, Range, RecordFormat,
};
pub(crate) use port::port_remedy;

use crate::RigError;
use crate::fields::Value;
use flock::read_flock;

/// A device of the rig.
#[derive(Clone, Debug, PartialEq)]
pub enum Device {
    /// An Ascension Flock of Birds on a serial line.
    Flock(Flock),
}

/// The kinds, as they are written.
#[derive(Clone, Copy)]
enum Kind {
    Flock,
}

impl Device {
    /// How many sensors it has.
    #[must_use]
    pub fn sensors(&self) -> u32 {
        match self {
            Self::Flock(flock) => flock.birds,
        }
    }

    /// The path of the serial port that it is on, where it is on one.
    pub(crate) fn port_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Flock(flock) => Some(&mut flock.port),
        }
    }
}

pub(crate) fn read_device(value: &Value<'_>) -> Result<Device, RigError> {
    let fields = value.fields()?;
    let kind = fields
        .need("kind", "write kind = \"flock-of-birds\"")?
        .choice(&[("flock-of-birds", Kind::Flock)])?;
    let device = match kind {
        Kind::Flock => Device::Flock(read_flock(&fields)?),
    };
    fields.finish()?;
    Ok(device)
}
