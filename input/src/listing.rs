//! What is plugged in, for people who look for what is missing. Nothing is opened.

use crate::access::access_problem;
use crate::gamepad::Gamepads;
use serialport::SerialPortType;
use std::path::Path;

/// A device that the system knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundDevice {
    /// Its path, as a rig would name it, or its name where it has no path.
    pub path: String,
    /// What it says it is.
    pub description: String,
    /// Why it could not be used, and what helps.
    pub problem: Option<String>,
}

/// The system cannot say what is plugged in.
#[derive(Debug, thiserror::Error)]
#[error("cannot list {kind} ({problem})")]
pub struct ListError {
    /// What was to be listed.
    pub kind: &'static str,
    /// What the system says.
    pub problem: String,
}

/// The serial ports.
///
/// # Errors
/// Where the system cannot list them.
pub fn list_serial_ports() -> Result<Vec<FoundDevice>, ListError> {
    let ports = serialport::available_ports().map_err(|error| ListError {
        kind: "serial ports",
        problem: error.to_string(),
    })?;
    let mut found: Vec<FoundDevice> = ports
        .into_iter()
        .map(|port| FoundDevice {
            problem: access_problem(Path::new(&port.port_name)),
            description: match port.port_type {
                SerialPortType::UsbPort(usb) => {
                    let product = usb.product.unwrap_or_else(|| "USB serial port".to_owned());
                    format!("{product} ({:04x}:{:04x})", usb.vid, usb.pid)
                }
                SerialPortType::PciPort => "serial port on the PCI bus".to_owned(),
                SerialPortType::BluetoothPort => "serial port over Bluetooth".to_owned(),
                SerialPortType::Unknown => "serial port".to_owned(),
            },
            path: port.port_name,
        })
        .collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// The HID devices: gloves, mice, keyboards and more.
///
/// # Errors
/// Where the system cannot list them.
pub fn list_hid_devices() -> Result<Vec<FoundDevice>, ListError> {
    let hid = hidapi::HidApi::new().map_err(|error| ListError {
        kind: "HID devices",
        problem: error.to_string(),
    })?;
    let mut found: Vec<FoundDevice> = hid
        .device_list()
        .map(|device| {
            let path = device.path().to_string_lossy().into_owned();
            let product = device.product_string().unwrap_or("HID device");
            FoundDevice {
                problem: access_problem(Path::new(&path)),
                description: format!(
                    "{product} ({:04x}:{:04x})",
                    device.vendor_id(),
                    device.product_id()
                ),
                path,
            }
        })
        .collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    // One device shows once for each of its uses.
    found.dedup();
    Ok(found)
}

/// The gamepads, those among them that may not be read included.
///
/// # Errors
/// Where the system cannot list them.
pub fn list_gamepads() -> Result<Vec<FoundDevice>, ListError> {
    let gamepads = Gamepads::open().map_err(|error| ListError {
        kind: "gamepads",
        problem: error.to_string(),
    })?;
    let mut found: Vec<FoundDevice> = gamepads
        .names()
        .into_iter()
        .map(|name| FoundDevice {
            path: name,
            description: "gamepad".to_owned(),
            problem: None,
        })
        .collect();
    found.extend(unreadable_joysticks());
    Ok(found)
}

/// Joysticks that the kernel knows and this process may not read, so that nobody sees them.
fn unreadable_joysticks() -> Vec<FoundDevice> {
    let Ok(folder) = std::fs::read_dir("/dev/input") else {
        return Vec::new();
    };
    let mut found: Vec<FoundDevice> = folder
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with("js"))
        .filter_map(|entry| {
            let path = entry.path();
            access_problem(&path).map(|problem| FoundDevice {
                path: path.display().to_string(),
                description: "joystick or gamepad".to_owned(),
                problem: Some(problem),
            })
        })
        .collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_list_comes_without_a_device() {
        for list in [list_serial_ports(), list_hid_devices()] {
            for device in list.unwrap() {
                assert!(!device.path.is_empty() && !device.description.is_empty());
            }
        }
        // Where there is no support for gamepads at all, that is what it says.
        match list_gamepads() {
            Ok(_) => {}
            Err(error) => assert!(error.to_string().starts_with("cannot list gamepads")),
        }
    }
}
