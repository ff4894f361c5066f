//! The choice: which of the devices that are plugged in is the one that the rig means.
//!
//! Where several fit, none is taken: which one the system lists first changes, and a glove would
//! be taken for the other hand's.

use super::error::HidError;
use sandtable_config::HidAddress;

/// What the rig means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Wanted {
    /// What people call it.
    pub(crate) what: String,
    pub(crate) vendor: u16,
    /// Any of these.
    pub(crate) products: Vec<u16>,
    pub(crate) address: HidAddress,
}

/// A device that is plugged in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) path: String,
    pub(crate) vendor: u16,
    pub(crate) product: u16,
    pub(crate) serial_number: Option<String>,
}

impl Wanted {
    fn fits(&self, found: &Found) -> bool {
        let HidAddress {
            serial_number,
            path,
        } = &self.address;
        let serial = serial_number.is_none() || *serial_number == found.serial_number;
        let path = path.as_ref().is_none_or(|path| *path == found.path);
        // No id stands for any: 0 is a real one.
        found.vendor == self.vendor && self.products.contains(&found.product) && serial && path
    }

    fn described(&self) -> String {
        let ids = self.products.iter();
        let ids: Vec<String> = ids.map(|id| shown_ids(self.vendor, *id)).collect();
        let mut text = format!("{} ({})", self.what, ids.join(", "));
        if let Some(serial) = &self.address.serial_number {
            text += &format!(" with the serial number {serial:?}");
        }
        if let Some(path) = &self.address.path {
            text += &format!(" at {path}");
        }
        text
    }
}

fn shown_ids(vendor: u16, product: u16) -> String {
    format!("{vendor:04x}:{product:04x}")
}

/// The one device that is meant.
pub(crate) fn choose<'a>(wanted: &Wanted, found: &'a [Found]) -> Result<&'a Found, HidError> {
    let fitting: Vec<&Found> = found.iter().filter(|found| wanted.fits(found)).collect();
    match fitting[..] {
        [one] => Ok(one),
        [] => Err(HidError::NotFound {
            what: wanted.described(),
            others: others(wanted, found),
        }),
        _ => Err(HidError::Several {
            what: wanted.described(),
            count: fitting.len(),
            list: listed(&fitting),
        }),
    }
}

fn others(wanted: &Wanted, found: &[Found]) -> String {
    let of_its_maker = found.iter().filter(|found| found.vendor == wanted.vendor);
    match of_its_maker.collect::<Vec<_>>()[..] {
        [] => String::new(),
        ref others => format!("; of its maker there is {}", listed(others)),
    }
}

fn listed(devices: &[&Found]) -> String {
    let shown = |found: &&Found| {
        let serial = match &found.serial_number {
            Some(serial) if !serial.is_empty() => format!(", serial number {serial:?}"),
            _ => String::new(),
        };
        let ids = shown_ids(found.vendor, found.product);
        format!("{ids} at {}{serial}", found.path)
    };
    let shown: Vec<String> = devices.iter().map(shown).collect();
    shown.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(serial_number: Option<&str>, path: Option<&str>) -> Wanted {
        Wanted {
            what: "right glove".into(),
            vendor: 0x5D70,
            products: vec![0x0000, 0x0002],
            address: HidAddress {
                serial_number: serial_number.map(str::to_owned),
                path: path.map(str::to_owned),
            },
        }
    }

    fn found(path: &str, product: u16, serial_number: &str) -> Found {
        Found {
            path: path.into(),
            vendor: 0x5D70,
            product,
            serial_number: Some(serial_number.into()),
        }
    }

    #[test]
    fn the_one_with_the_ids_is_taken_and_0_is_an_id() {
        let mouse = Found {
            path: "/dev/hidraw0".into(),
            vendor: 0x046D,
            ..Found::default()
        };
        let left = found("/dev/hidraw1", 0x0001, "");
        let right = found("/dev/hidraw2", 0x0000, "");
        let all = [mouse.clone(), left.clone(), right.clone()];
        assert_eq!(choose(&wanted(None, None), &all).unwrap(), &right);
        let error = choose(&wanted(None, None), &[mouse, left]).unwrap_err();
        let error = error.to_string();
        for needle in [
            "5d70:0000, 5d70:0002",
            "there is 5d70:0001 at /dev/hidraw1",
            "doctor",
        ] {
            assert!(error.contains(needle), "{error}");
        }
        assert!(!error.contains("046d"), "{error}");
    }

    #[test]
    fn of_several_none_is_taken_until_the_rig_says_which() {
        let all = [
            found("/dev/hidraw1", 0, "A7"),
            found("/dev/hidraw2", 2, "B9"),
        ];
        let error = choose(&wanted(None, None), &all).unwrap_err().to_string();
        for needle in [
            "2 devices",
            "/dev/hidraw1, serial number \"A7\"",
            "`serial_number`",
        ] {
            assert!(error.contains(needle), "{error}");
        }
        assert_eq!(choose(&wanted(Some("B9"), None), &all).unwrap(), &all[1]);
        let first = wanted(None, Some("/dev/hidraw1"));
        assert_eq!(choose(&first, &all).unwrap(), &all[0]);
        let neither = choose(&wanted(Some("B9"), Some("/dev/hidraw1")), &all);
        let error = neither.unwrap_err().to_string();
        assert!(error.contains("\"B9\" at /dev/hidraw1"), "{error}");
    }
}
