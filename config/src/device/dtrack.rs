//! ART's DTrack: optical trackers that tell their bodies by UDP.

use super::tracking::{Tracking, read_silence, read_tracking};
use crate::RigError;
use crate::fields::Fields;
use std::net::{IpAddr, Ipv4Addr};
use std::time::Duration;

/// A DTrack controller that sends its output to this computer.
#[derive(Clone, Debug, PartialEq)]
pub struct Dtrack {
    /// The UDP port that it sends to.
    pub port: u16,
    /// This computer's address to receive at; unspecified for any that it has.
    pub bind: IpAddr,
    /// The controller's address, where datagrams of others are to be ignored.
    pub from: Option<IpAddr>,
    /// How many standard bodies there are; DTrack's body 0 is sensor 1 here.
    pub bodies: u32,
    /// How many Flysticks there are; they are the sensors behind the bodies.
    pub flysticks: u32,
    /// Silence after which the port is opened anew.
    pub silent_after: Duration,
    /// How its poses are taken.
    pub tracking: Tracking,
}

pub(super) fn read_dtrack(fields: &Fields<'_>) -> Result<Dtrack, RigError> {
    let port = match fields.get("port") {
        Some(value) => value.integer(1..=65_535, "(the UDP port that DTrack sends to)")?,
        None => 5000,
    };
    let address = |key: &str| match fields.get(key) {
        Some(value) => {
            let text = value.text("an IP address, such as \"192.168.0.10\"")?;
            text.parse::<IpAddr>().map(Some).map_err(|_| {
                value.error(
                    &format!("is {text:?}"),
                    "write an IP address, such as \"192.168.0.10\"",
                )
            })
        }
        None => Ok(None),
    };
    let count = |key: &str, default: u32| match fields.get(key) {
        Some(value) => value.integer(0..=64, key),
        None => Ok(default),
    };
    let (bodies, flysticks) = (count("bodies", 1)?, count("flysticks", 0)?);
    if bodies + flysticks == 0 {
        return Err(fields.error(
            "bodies",
            "is 0, and there is no Flystick",
            "write how many bodies DTrack has calibrated, or how many flysticks",
        ));
    }
    Ok(Dtrack {
        port: u16::try_from(port).unwrap_or(u16::MAX),
        bind: address("bind")?.unwrap_or(IpAddr::V4(Ipv4Addr::UNSPECIFIED)),
        from: address("from")?,
        bodies,
        flysticks,
        silent_after: read_silence(fields, 2.0)?,
        tracking: read_tracking(fields)?,
    })
}
