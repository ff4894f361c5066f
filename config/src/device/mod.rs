//! Devices: what is plugged in where, and how it sits in the table's frame. One file a kind.

mod axis_map;
mod dtrack;
mod flock;
mod port;
mod tracking;
mod vrpn;

pub use axis_map::AxisMap;
pub use dtrack::Dtrack;
pub use flock::{
    Addressing, Confirm, Flock, FlockMode, Hemisphere, QuaternionSign, Range, RecordFormat,
};
pub(crate) use port::port_remedy;
pub use tracking::Tracking;
pub use vrpn::{VRPN_PORT, Vrpn, VrpnAddress, VrpnPart};

use crate::fields::Value;
use crate::{FieldCorrection, RigError};
use dtrack::read_dtrack;
use flock::read_flock;
use sandtable_pose::Rigid;
use time::Date;
use vrpn::read_vrpn;

/// A device of the rig.
#[derive(Clone, Debug, PartialEq)]
pub enum Device {
    /// An Ascension Flock of Birds on a serial line.
    Flock(Flock),
    /// A device of a VRPN server, by TCP.
    Vrpn(Vrpn),
    /// An ART DTrack controller, by UDP.
    Dtrack(Dtrack),
}

/// The kinds, as they are written.
#[derive(Clone, Copy)]
enum Kind {
    Flock,
    Vrpn,
    Dtrack,
}

impl Device {
    /// How many sensors it has.
    #[must_use]
    pub fn sensors(&self) -> u32 {
        match self {
            Self::Flock(flock) => flock.birds,
            Self::Vrpn(vrpn) => vrpn.sensors,
            Self::Dtrack(dtrack) => dtrack.bodies + dtrack.flysticks,
        }
    }

    /// From the tracker's frame to the table's, where it is a tracker.
    pub fn table_from_tracker_mut(&mut self) -> Option<&mut Rigid> {
        match self {
            Self::Flock(flock) => Some(&mut flock.table_from_tracker),
            Self::Vrpn(vrpn) => Some(&mut vrpn.tracking.table_from_tracker),
            Self::Dtrack(dtrack) => Some(&mut dtrack.tracking.table_from_tracker),
        }
    }

    /// The day on which its frame was measured, where that is known.
    #[must_use]
    pub fn calibrated(&self) -> Option<Date> {
        match self {
            Self::Flock(flock) => flock.calibrated,
            Self::Vrpn(vrpn) => vrpn.tracking.calibrated,
            Self::Dtrack(dtrack) => dtrack.tracking.calibrated,
        }
    }

    /// How its field is bent, where that was measured.
    #[must_use]
    pub fn correction(&self) -> Option<&FieldCorrection> {
        match self {
            Self::Flock(flock) => flock.correction.as_ref(),
            Self::Vrpn(vrpn) => vrpn.tracking.correction.as_ref(),
            Self::Dtrack(dtrack) => dtrack.tracking.correction.as_ref(),
        }
    }

    /// Lets its poses come as its field bends them, for whoever measures the field.
    pub fn leave_field_bent(&mut self) {
        match self {
            Self::Flock(flock) => flock.correction = None,
            Self::Vrpn(vrpn) => vrpn.tracking.correction = None,
            Self::Dtrack(dtrack) => dtrack.tracking.correction = None,
        }
    }

    /// The path of the serial port that it is on, where it is on one.
    pub(crate) fn port_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Flock(flock) => Some(&mut flock.port),
            Self::Vrpn(_) | Self::Dtrack(_) => None,
        }
    }
}

pub(crate) fn read_device(value: &Value<'_>) -> Result<Device, RigError> {
    let fields = value.fields()?;
    let kind = fields
        .need(
            "kind",
            "write what it is: \"flock-of-birds\", \"vrpn\" or \"dtrack\"",
        )?
        .choice(&[
            ("flock-of-birds", Kind::Flock),
            ("vrpn", Kind::Vrpn),
            ("dtrack", Kind::Dtrack),
        ])?;
    let device = match kind {
        Kind::Flock => Device::Flock(read_flock(&fields)?),
        Kind::Vrpn => Device::Vrpn(read_vrpn(&fields)?),
        Kind::Dtrack => Device::Dtrack(read_dtrack(&fields)?),
    };
    fields.finish()?;
    Ok(device)
}
