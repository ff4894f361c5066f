//! The system's HID devices: listed, opened and read.

use super::choice::Found;
use super::error::HidError;
use hidapi::{HidApi, HidDevice};
use std::ffi::CString;
use std::io::ErrorKind;

/// Where HID devices are plugged in.
pub(crate) trait HidBus {
    /// Those that are plugged in now, each once.
    fn list(&mut self) -> Result<Vec<Found>, HidError>;

    /// Opens one of them.
    fn open(&mut self, found: &Found) -> Result<Box<dyn HidReports>, HidError>;
}

/// An open device's reports.
pub(crate) trait HidReports {
    /// Reads one report, waiting a little; none is 0 bytes.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, HidError>;
}

/// How long one read waits, and so how long a stop may take, in milliseconds.
const READ_TIMEOUT_MS: i32 = 50;

/// The system's own.
#[derive(Default)]
pub(crate) struct SystemBus {
    api: Option<HidApi>,
}

impl SystemBus {
    /// The system's interface, with the devices that are plugged in now.
    fn api(&mut self) -> Result<&HidApi, HidError> {
        let no_list = |error: hidapi::HidError| HidError::NoList {
            problem: error.to_string(),
        };
        match &mut self.api {
            Some(api) => api.refresh_devices().map_err(no_list)?,
            None => self.api = Some(HidApi::new().map_err(no_list)?),
        }
        self.api.as_ref().ok_or(HidError::NoList {
            problem: "it has no HID interface".to_owned(),
        })
    }
}

impl HidBus for SystemBus {
    fn list(&mut self) -> Result<Vec<Found>, HidError> {
        let mut found: Vec<Found> = Vec::new();
        for device in self.api()?.device_list() {
            let path = device.path().to_string_lossy().into_owned();
            // A device is listed once for each of its usages.
            if found.iter().all(|found| found.path != path) {
                found.push(Found {
                    path,
                    vendor: device.vendor_id(),
                    product: device.product_id(),
                    serial_number: device.serial_number().map(str::to_owned),
                });
            }
        }
        Ok(found)
    }

    fn open(&mut self, found: &Found) -> Result<Box<dyn HidReports>, HidError> {
        let opened = match CString::new(found.path.as_str()) {
            Ok(path) => self.api()?.open_path(&path),
            Err(_) => Err(hidapi::HidError::HidApiErrorEmpty),
        };
        match opened {
            Ok(device) => Ok(Box::new(SystemReports {
                path: found.path.clone(),
                device,
            })),
            Err(error) => Err(HidError::opening(
                found,
                is_denied(&found.path),
                error.to_string(),
            )),
        }
    }
}

/// Whether the user may not open a device, which the interface tells in words only.
fn is_denied(path: &str) -> bool {
    // Elsewhere a path is no file's.
    cfg!(target_os = "linux")
        && std::fs::OpenOptions::new()
            .read(true)
            .write(true)
            .open(path)
            .is_err_and(|error| error.kind() == ErrorKind::PermissionDenied)
}

struct SystemReports {
    path: String,
    device: HidDevice,
}

impl HidReports for SystemReports {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, HidError> {
        match self.device.read_timeout(buffer, READ_TIMEOUT_MS) {
            Ok(count) => Ok(count),
            Err(hidapi::HidError::IoError { error }) if error.kind() == ErrorKind::Interrupted => {
                Ok(0)
            }
            Err(error) => Err(HidError::Gone {
                path: self.path.clone(),
                problem: error.to_string(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_lists_each_device_once() {
        // On a machine without any, that is none; with or without, it is no error, and twice.
        let mut bus = SystemBus::default();
        for _ in 0..2 {
            let mut paths: Vec<_> = bus.list().unwrap().into_iter().map(|f| f.path).collect();
            let all = paths.len();
            paths.sort();
            paths.dedup();
            assert_eq!(paths.len(), all);
        }
    }

    #[test]
    fn what_is_no_hid_device_is_refused_by_name() {
        let found = Found {
            path: "/dev/null".into(),
            ..Found::default()
        };
        let Err(error) = SystemBus::default().open(&found) else {
            panic!("/dev/null is no HID device");
        };
        assert!(matches!(error, HidError::Open { .. }), "{error}");
        assert!(error.to_string().contains("/dev/null"), "{error}");
        let missing = Found {
            path: "/dev/hidraw\0".into(),
            ..Found::default()
        };
        assert!(SystemBus::default().open(&missing).is_err());
    }
}
