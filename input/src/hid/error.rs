//! What may be wrong with a HID device.

use super::choice::Found;

/// Why a HID device cannot be had just now.
#[derive(Debug, thiserror::Error)]
pub enum HidError {
    /// The system does not tell which devices there are.
    #[error("cannot list HID devices ({problem}); `sandtable doctor` shows what the system lacks")]
    NoList {
        /// What the system says.
        problem: String,
    },
    /// It is not plugged in.
    #[error(
        "no {what} is plugged in{others}; plug it in, or correct the rig: `sandtable doctor` lists what is"
    )]
    NotFound {
        /// What was looked for, with its ids.
        what: String,
        /// What of the same maker is plugged in instead, if anything.
        others: String,
    },
    /// It could be one or another.
    #[error(
        "{count} devices may be the {what}: {list}; write `serial_number` or `path` of one in the rig"
    )]
    Several {
        /// What was looked for, with its ids.
        what: String,
        /// How many there are.
        count: usize,
        /// Each one's path and serial number.
        list: String,
    },
    /// The user may not open it.
    #[error(
        "{path} may not be opened by you; write this line to /etc/udev/rules.d/70-sandtable.rules: \
         {rule}, then run `sudo udevadm control --reload && sudo udevadm trigger` and plug it in \
         anew"
    )]
    Denied {
        /// The device's path.
        path: String,
        /// The rule that permits it.
        rule: String,
    },
    /// It cannot be opened for another reason.
    #[error("cannot open {path} ({problem}); end other programs that use it, or plug it in anew")]
    Open {
        /// The device's path.
        path: String,
        /// What the system says.
        problem: String,
    },
    /// It was open and is gone.
    #[error("{path} is gone ({problem}); plug the device in again")]
    Gone {
        /// The device's path.
        path: String,
        /// What the system says.
        problem: String,
    },
    /// It sends nothing.
    #[error(
        "{path} has been silent for {seconds} s; check that the glove is on, or write a longer \
         `silent_after` in the rig"
    )]
    Silent {
        /// The device's path.
        path: String,
        /// For how long.
        seconds: f64,
    },
    /// It sends reports that are none.
    #[error(
        "{path} sends reports of {length} bytes that are not those of the {what}; check what the \
         rig says of them"
    )]
    NotUnderstood {
        /// The device's path.
        path: String,
        /// What it should be.
        what: String,
        /// How long the newest one is.
        length: usize,
    },
}

/// The rule by which udev lets whoever sits at the machine open a HID device with these ids.
#[must_use]
pub fn udev_rule(vendor: u16, product: u16) -> String {
    format!(
        "KERNEL==\"hidraw*\", ATTRS{{idVendor}}==\"{vendor:04x}\", \
         ATTRS{{idProduct}}==\"{product:04x}\", TAG+=\"uaccess\""
    )
}

impl HidError {
    /// Why `found` could not be opened.
    pub(super) fn opening(found: &Found, denied: bool, problem: String) -> Self {
        let path = found.path.clone();
        if denied {
            let rule = udev_rule(found.vendor, found.product);
            Self::Denied { path, rule }
        } else {
            Self::Open { path, problem }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_may_not_be_opened_comes_with_its_rule() {
        let found = Found {
            path: "/dev/hidraw3".into(),
            vendor: 0x5D70,
            product: 0x0010,
            ..Found::default()
        };
        let denied = HidError::opening(&found, true, "EACCES".into()).to_string();
        let rule = "KERNEL==\"hidraw*\", ATTRS{idVendor}==\"5d70\", ATTRS{idProduct}==\"0010\", \
                    TAG+=\"uaccess\"";
        assert!(
            denied.contains(rule) && denied.contains("/dev/hidraw3"),
            "{denied}"
        );
        let other = HidError::opening(&found, false, "EBUSY".into()).to_string();
        assert!(
            other.contains("EBUSY") && !other.contains("udev"),
            "{other}"
        );
    }
}
