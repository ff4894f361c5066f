//! Devices: what is plugged in where, and how it sits in the table's frame. One file a kind.

mod axis_map;
mod calibration;
mod data_glove;
mod dtrack;
mod fingers;
mod flock;
mod gestures;
mod hid;
mod hid_glove;
mod pinch;
mod port;
mod tracking;
mod vrpn;
mod vrpn_glove;

pub use axis_map::AxisMap;
pub use data_glove::DataGlove;
pub use dtrack::Dtrack;
pub use flock::{
    Addressing, Confirm, Flock, FlockMode, Hemisphere, QuaternionSign, Range, RecordFormat,
};
pub use gestures::Gestures;
pub use hid::{ByteOrder, HidAddress, Side};
pub use hid_glove::{HidBit, HidField, HidFinger, HidGlove};
pub use pinch::Pinch;
pub(crate) use port::port_remedy;
pub use tracking::Tracking;
pub use vrpn::{VRPN_PORT, Vrpn, VrpnAddress, VrpnPart};
pub use vrpn_glove::{VrpnFinger, VrpnGlove};

use crate::fields::Value;
use crate::{FieldCorrection, RigError};
use data_glove::read_data_glove;
use dtrack::read_dtrack;
use flock::read_flock;
use hid_glove::read_hid_glove;
use pinch::read_pinch;
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
    /// Fakespace PINCH gloves on a serial line.
    Pinch(Pinch),
    /// A 5DT Data Glove Ultra over USB.
    DataGlove(DataGlove),
    /// Any glove that is a HID device, by the rig's own description of its reports.
    HidGlove(Box<HidGlove>),
}

/// The kinds, as they are written.
#[derive(Clone, Copy)]
enum Kind {
    Flock,
    Vrpn,
    Dtrack,
    Pinch,
    DataGlove,
    HidGlove,
}

impl Device {
    /// How many sensors it has. Of PINCH gloves, 1 is the left and 2 the right one.
    #[must_use]
    pub fn sensors(&self) -> u32 {
        match self {
            Self::Flock(flock) => flock.birds,
            Self::Vrpn(vrpn) => vrpn.sensors,
            Self::Dtrack(dtrack) => dtrack.bodies + dtrack.flysticks,
            Self::Pinch(_) => 2,
            Self::DataGlove(_) | Self::HidGlove(_) => 1,
        }
    }

    /// What its fingers mean, where it is a glove.
    #[must_use]
    pub fn gestures(&self) -> Option<&Gestures> {
        match self {
            Self::Flock(_) | Self::Dtrack(_) => None,
            Self::Vrpn(vrpn) => vrpn.glove.as_ref().map(|glove| &glove.gestures),
            Self::Pinch(pinch) => Some(&pinch.gestures),
            Self::DataGlove(glove) => Some(&glove.gestures),
            Self::HidGlove(glove) => Some(&glove.gestures),
        }
    }

    /// Whether its sensors tell where they are.
    #[must_use]
    pub fn has_poses(&self) -> bool {
        match self {
            Self::Flock(_) | Self::Vrpn(_) | Self::Dtrack(_) => true,
            Self::Pinch(_) | Self::DataGlove(_) | Self::HidGlove(_) => false,
        }
    }

    /// Why its sensors have no buttons, with the remedy; `None` where they may have some.
    pub(crate) fn lack_of_buttons(&self) -> Option<&'static str> {
        match self {
            Self::Flock(flock) if !flock.buttons => Some(
                "write `buttons = true` at the Flock if its birds have any: its records bring \
                 none without",
            ),
            Self::Dtrack(dtrack) if dtrack.flysticks == 0 => {
                Some("write how many `flysticks` there are: bodies have no buttons")
            }
            Self::Pinch(_) | Self::DataGlove(_) => {
                Some("write a gesture, such as \"grab\": this glove has no buttons")
            }
            Self::HidGlove(glove) if glove.buttons.is_empty() => {
                Some("write `buttons` at the glove, or a gesture, such as \"grab\"")
            }
            _ => None,
        }
    }

    /// Why its sensors have no channels, with the remedy; `None` where they may have some.
    pub(crate) fn lack_of_channels(&self) -> Option<&'static str> {
        match self {
            Self::Vrpn(_) => None,
            Self::Dtrack(dtrack) if dtrack.flysticks > 0 => None,
            Self::Dtrack(_) => {
                Some("write how many `flysticks` there are: bodies have no channels")
            }
            Self::Flock(_) | Self::Pinch(_) | Self::DataGlove(_) | Self::HidGlove(_) => Some(
                "take a gamepad's stick, or a channel of a VRPN server or a Flystick: this device \
                 has none",
            ),
        }
    }

    /// From the tracker's frame to the table's, where it is a tracker.
    pub fn table_from_tracker_mut(&mut self) -> Option<&mut Rigid> {
        match self {
            Self::Flock(flock) => Some(&mut flock.table_from_tracker),
            Self::Vrpn(vrpn) => Some(&mut vrpn.tracking.table_from_tracker),
            Self::Dtrack(dtrack) => Some(&mut dtrack.tracking.table_from_tracker),
            Self::Pinch(_) | Self::DataGlove(_) | Self::HidGlove(_) => None,
        }
    }

    /// The day on which its frame was measured, where that is known.
    #[must_use]
    pub fn calibrated(&self) -> Option<Date> {
        match self {
            Self::Flock(flock) => flock.calibrated,
            Self::Vrpn(vrpn) => vrpn.tracking.calibrated,
            Self::Dtrack(dtrack) => dtrack.tracking.calibrated,
            Self::Pinch(_) | Self::DataGlove(_) | Self::HidGlove(_) => None,
        }
    }

    /// How its field is bent, where that was measured.
    #[must_use]
    pub fn correction(&self) -> Option<&FieldCorrection> {
        match self {
            Self::Flock(flock) => flock.correction.as_ref(),
            Self::Vrpn(vrpn) => vrpn.tracking.correction.as_ref(),
            Self::Dtrack(dtrack) => dtrack.tracking.correction.as_ref(),
            Self::Pinch(_) | Self::DataGlove(_) | Self::HidGlove(_) => None,
        }
    }

    /// Lets its poses come as its field bends them, for whoever measures the field.
    pub fn leave_field_bent(&mut self) {
        match self {
            Self::Flock(flock) => flock.correction = None,
            Self::Vrpn(vrpn) => vrpn.tracking.correction = None,
            Self::Dtrack(dtrack) => dtrack.tracking.correction = None,
            Self::Pinch(_) | Self::DataGlove(_) | Self::HidGlove(_) => {}
        }
    }

    /// The path of the serial port that it is on, where it is on one.
    pub fn port(&self) -> Option<&str> {
        match self {
            Self::Flock(flock) => Some(&flock.port),
            Self::Pinch(pinch) => Some(&pinch.port),
            Self::Vrpn(_) | Self::Dtrack(_) | Self::DataGlove(_) | Self::HidGlove(_) => None,
        }
    }

    /// The same, to be changed.
    pub(crate) fn port_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Flock(flock) => Some(&mut flock.port),
            Self::Pinch(pinch) => Some(&mut pinch.port),
            Self::Vrpn(_) | Self::Dtrack(_) | Self::DataGlove(_) | Self::HidGlove(_) => None,
        }
    }
}

pub(crate) fn read_device(value: &Value<'_>) -> Result<Device, RigError> {
    let fields = value.fields()?;
    let kind = fields
        .need(
            "kind",
            "write what it is: \"flock-of-birds\", \"vrpn\", \"dtrack\", \"pinch\", \"data-glove\" or \
             \"hid-glove\"",
        )?
        .choice(&[
            ("flock-of-birds", Kind::Flock),
            ("vrpn", Kind::Vrpn),
            ("dtrack", Kind::Dtrack),
            ("pinch", Kind::Pinch),
            ("data-glove", Kind::DataGlove),
            ("hid-glove", Kind::HidGlove),
        ])?;
    let device = match kind {
        Kind::Flock => Device::Flock(read_flock(&fields)?),
        Kind::Vrpn => Device::Vrpn(read_vrpn(&fields)?),
        Kind::Dtrack => Device::Dtrack(read_dtrack(&fields)?),
        Kind::Pinch => Device::Pinch(read_pinch(&fields)?),
        Kind::DataGlove => Device::DataGlove(read_data_glove(&fields)?),
        Kind::HidGlove => Device::HidGlove(Box::new(read_hid_glove(&fields)?)),
    };
    fields.finish()?;
    Ok(device)
}
