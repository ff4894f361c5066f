//! VRPN servers: trackers, buttons and analogs that others put on the network.

use super::VrpnGlove;
use super::tracking::{Tracking, read_silence, read_tracking};
use super::vrpn_glove::read_vrpn_glove;
use crate::RigError;
use crate::fields::{Fields, Value};
use std::fmt;
use std::time::Duration;

/// A device of a VRPN server: a tracker, and the buttons and analogs that belong to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Vrpn {
    /// The tracker and its server.
    pub address: VrpnAddress,
    /// How many sensors the tracker has, from 1; the server's sensor 0 is sensor 1 here.
    pub sensors: u32,
    /// Where the buttons come from, and whose they are.
    pub buttons: VrpnPart,
    /// Where the analogs, joysticks among them, come from, and whose they are.
    pub analogs: VrpnPart,
    /// Which channels and buttons are the fingers of a glove, where it is one.
    pub glove: Option<Box<VrpnGlove>>,
    /// Silence, pings unanswered, after which the server is connected to anew.
    pub silent_after: Duration,
    /// How its poses are taken.
    pub tracking: Tracking,
}

/// `Tracker0@host:3883`: a device's name on a server, and the server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VrpnAddress {
    /// The device's name, which VRPN calls its sender.
    pub sender: String,
    /// The server's name, or its IP address.
    pub host: String,
    /// The server's TCP port.
    pub port: u16,
}

/// The port that VRPN servers listen at.
pub const VRPN_PORT: u16 = 3883;

/// VRPN keeps names in 100 bytes, of which the last is a zero.
const LONGEST_NAME: usize = 99;

/// A sender on the same server, and the sensor here that its buttons or analogs belong to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VrpnPart {
    /// The sender's name.
    pub sender: String,
    /// The sensor's number, from 1.
    pub sensor: u32,
}

impl Vrpn {
    /// Takes the device at another address in place of its own; buttons and analogs that came from
    /// the same sender come from the new one.
    pub(crate) fn move_to(&mut self, address: VrpnAddress) {
        for part in [&mut self.buttons, &mut self.analogs] {
            if part.sender == self.address.sender {
                part.sender.clone_from(&address.sender);
            }
        }
        self.address = address;
    }
}

impl fmt::Display for VrpnAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { sender, host, port } = self;
        if host.contains(':') {
            write!(f, "{sender}@[{host}]:{port}")
        } else {
            write!(f, "{sender}@{host}:{port}")
        }
    }
}

pub(super) fn read_vrpn(fields: &Fields<'_>) -> Result<Vrpn, RigError> {
    let address = read_address(&fields.need(
        "address",
        "write the device and its server, as \"Tracker0@lab-pc\" or \"Tracker0@10.0.0.5:3883\"",
    )?)?;
    let sensors = match fields.get("sensors") {
        Some(value) => value.integer(1..=64, "sensors")?,
        None => 1,
    };
    let part = |key: &str| match fields.get(key) {
        Some(value) => read_part(&value, &address.sender, sensors),
        None => Ok(VrpnPart {
            sender: address.sender.clone(),
            sensor: 1,
        }),
    };
    let (buttons, analogs) = (part("buttons")?, part("analogs")?);
    Ok(Vrpn {
        sensors,
        glove: read_vrpn_glove(fields, &analogs, &buttons)?.map(Box::new),
        buttons,
        analogs,
        silent_after: read_silence(fields, 3.0)?,
        tracking: read_tracking(fields)?,
        address,
    })
}

fn read_part(value: &Value<'_>, tracker: &str, sensors: u32) -> Result<VrpnPart, RigError> {
    let fields = value.fields()?;
    let sender = match fields.get("sender") {
        Some(value) => {
            let sender = value.text("a device's name on the server, such as \"Wand0\"")?;
            if let Some(remedy) = name_remedy(sender) {
                return Err(value.error(&format!("is {sender:?}"), remedy));
            }
            sender.to_owned()
        }
        None => tracker.to_owned(),
    };
    let sensor = match fields.get("sensor") {
        Some(value) => value.integer(1..=sensors, "(a sensor of this device)")?,
        None => 1,
    };
    fields.finish()?;
    Ok(VrpnPart { sender, sensor })
}

fn read_address(value: &Value<'_>) -> Result<VrpnAddress, RigError> {
    let text = value.text("the device and its server, as \"Tracker0@lab-pc\"")?;
    VrpnAddress::parse(text).map_err(|remedy| value.error(&format!("is {text:?}"), remedy))
}

impl VrpnAddress {
    /// The address that `text` is, or what would be right.
    pub(crate) fn parse(text: &str) -> Result<Self, &'static str> {
        let Some((sender, place)) = text.split_once('@') else {
            return Err("write the device's name, @ and its server, as \"Tracker0@lab-pc\"");
        };
        if let Some(remedy) = name_remedy(sender) {
            return Err(remedy);
        }
        // VRPN's own way to say that no UDP is wanted.
        let place = place.strip_prefix("tcp://").unwrap_or(place);
        let (host, port) = match place.strip_prefix('[').and_then(|v6| v6.split_once(']')) {
            Some((host, rest)) => (
                host,
                rest.strip_prefix(':').or(rest.is_empty().then_some("")),
            ),
            None => match place.split_once(':') {
                Some((host, port)) => (host, Some(port)),
                None => (place, Some("")),
            },
        };
        let v6 = place.starts_with('[');
        let plain = !host.is_empty()
            && host.len() <= 253
            && !host.starts_with('-')
            && host.bytes().all(|b| {
                b.is_ascii_alphanumeric() || b"-._".contains(&b) || (v6 && b"%:".contains(&b))
            });
        if !plain {
            return Err(
                "write the server's name or IP address behind the @, as \"Tracker0@lab-pc\" or \
                 \"Tracker0@[::1]\"",
            );
        }
        let port = match port {
            Some("") if !place.ends_with(':') => Some(VRPN_PORT),
            Some(port) => port.parse().ok().filter(|&port| port != 0),
            None => None,
        };
        let Some(port) = port else {
            return Err(
                "write a port from 1 to 65535 behind the colon, as \"Tracker0@lab-pc:3883\"",
            );
        };
        Ok(VrpnAddress {
            sender: sender.to_owned(),
            host: host.to_owned(),
            port,
        })
    }
}

/// What is wrong with a device's name on a server.
fn name_remedy(name: &str) -> Option<&'static str> {
    if name.is_empty() || name.len() > LONGEST_NAME {
        return Some("write the device's name on its server, of 1 to 99 bytes, as \"Tracker0\"");
    }
    if name.chars().any(|c| c.is_control() || c == '@') {
        return Some("write the device's name on its server without control characters and @");
    }
    None
}
