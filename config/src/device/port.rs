//! Serial ports as rig files name them.

use crate::RigError;
use crate::fields::Fields;

/// The field `port`: the path of a serial port.
pub(super) fn read_port(fields: &Fields<'_>) -> Result<String, RigError> {
    let value = fields.need("port", "write the serial port's path, as \"/dev/ttyUSB0\"")?;
    let port = value.text("the serial port's path")?;
    match port_remedy(port) {
        Some(remedy) => Err(value.error(&format!("is {port:?}"), remedy)),
        None => Ok(port.to_owned()),
    }
}

/// Checks that a port is the path of a terminal, never a command or an address.
pub(crate) fn port_remedy(port: &str) -> Option<&'static str> {
    let com = port
        .strip_prefix("COM")
        .is_some_and(|n| !n.is_empty() && n.len() <= 3 && n.bytes().all(|b| b.is_ascii_digit()));
    if com {
        return None;
    }
    if !port.starts_with('/') || port.len() < 2 || port.ends_with('/') {
        return Some("write its absolute path, as \"/dev/ttyUSB0\" (or \"COM3\")");
    }
    if port.len() > 1024
        || port
            .chars()
            .any(|c| c.is_control() || "|;&$<>`\"'*?".contains(c))
    {
        return Some("write the path of a serial port only: commands and patterns are never run");
    }
    None
}
