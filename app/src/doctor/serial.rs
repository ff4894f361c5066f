//! Serial ports, to which the trackers are wired.

use std::path::Path;

use serde_json::{Value, json};
use serialport::{SerialPortInfo, SerialPortType};

use super::access;
use super::finding::{Finding, Item};
use super::remedy::join_group;

pub(super) fn examine() -> Result<Finding, String> {
    let ports = serialport::available_ports().map_err(|error| error.to_string())?;
    let ports: Vec<_> = ports
        .into_iter()
        .map(|port| {
            let node = Path::new(&port.port_name);
            let (granted, group) = (access::is_granted(node), access::group_of(node));
            (port, granted, group)
        })
        .collect();
    Ok(judge(&ports))
}

/// Judges ports, each with whether this user may use it and the group that may.
fn judge(ports: &[(SerialPortInfo, bool, Option<String>)]) -> Finding {
    let mut finding = Finding::default();
    for (port, granted, group) in ports {
        let (kind, usb) = match &port.port_type {
            SerialPortType::UsbPort(usb) => {
                let ids = format!("{:04x}:{:04x}", usb.vid, usb.pid);
                let product = usb.product.as_deref().unwrap_or("adapter");
                (format!("USB {ids} {product}"), json!(ids))
            }
            SerialPortType::PciPort => ("built in".to_owned(), Value::Null),
            SerialPortType::BluetoothPort => ("Bluetooth".to_owned(), Value::Null),
            SerialPortType::Unknown => ("of unknown kind".to_owned(), Value::Null),
        };
        let may = if *granted { "" } else { ", not permitted" };
        finding.found(Item::new(
            &port.port_name,
            format!("{kind}{may}"),
            json!({ "usb": usb, "permitted": granted, "group": group }),
        ));
        if !granted {
            let group = group.as_deref().unwrap_or("dialout");
            finding.advise(format!(
                "To be permitted to use {}: {}.",
                port.port_name,
                join_group(group)
            ));
        }
    }
    if ports.is_empty() {
        finding.advise(
            "There is none; a tracker needs one, and so do PINCH gloves, or a USB adapter, which \
             shows up here once it is plugged in. Without: sandtable simulate flock, or simulate \
             pinch, plays one on a pseudo-terminal."
                .to_owned(),
        );
    }
    finding
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_is_not_permitted_says_which_group_is() {
        let port = |name: &str| SerialPortInfo {
            port_name: name.to_owned(),
            port_type: SerialPortType::PciPort,
        };
        let finding = judge(&[
            (port("/dev/ttyS0"), true, Some("dialout".into())),
            (port("/dev/ttyUSB1"), false, Some("uucp".into())),
        ]);
        assert_eq!(finding.advice.len(), 1);
        assert!(finding.advice[0].contains("/dev/ttyUSB1"));
        assert!(finding.advice[0].contains("usermod -aG uucp"));
        assert_eq!(finding.json()[0]["permitted"], true);
        assert!(judge(&[]).advice[0].contains("simulate flock"));
    }
}
