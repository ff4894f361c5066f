//! HID devices, as which data gloves present themselves.

use std::path::PathBuf;

use sandtable_input::udev_rule;
use serde_json::json;

use super::access;
use super::finding::{Finding, Item};

pub(super) fn examine() -> Result<Finding, String> {
    let api = hidapi::HidApi::new().map_err(|error| error.to_string())?;
    let mut devices: Vec<_> = api
        .device_list()
        .map(|device| {
            let node = PathBuf::from(device.path().to_string_lossy().into_owned());
            let name = [device.manufacturer_string(), device.product_string()]
                .into_iter()
                .flatten()
                .filter(|part| !part.is_empty())
                .collect::<Vec<_>>()
                .join(" ");
            Device {
                // Only on Linux is the path a node to which permission can be asked.
                permitted: !cfg!(target_os = "linux") || access::is_granted(&node),
                node,
                name,
                ids: [device.vendor_id(), device.product_id()],
            }
        })
        .collect();
    // A device is listed once for each of its usages.
    devices.sort();
    devices.dedup();
    Ok(judge(&devices))
}

#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Device {
    node: PathBuf,
    name: String,
    /// Vendor and product.
    ids: [u16; 2],
    permitted: bool,
}

fn judge(devices: &[Device]) -> Finding {
    let mut finding = Finding::default();
    for device in devices {
        let [vendor, product] = device.ids.map(|id| format!("{id:04x}"));
        let may = if device.permitted {
            ""
        } else {
            ", not permitted"
        };
        let name = match device.name.as_str() {
            "" => "unnamed",
            name => name,
        };
        finding.found(Item::new(
            name,
            format!("{vendor}:{product} at {}{may}", device.node.display()),
            json!({
                "vendor": vendor,
                "product": product,
                "path": device.node,
                "permitted": device.permitted,
            }),
        ));
        // Mice and keyboards are HID devices too, and nobody should be given those.
        if !device.permitted {
            finding.advise(format!(
                "If {name} is a glove, permit it: write this line to \
                 /etc/udev/rules.d/70-sandtable.rules\n\
                 {}\n\
                 then: sudo udevadm control --reload && sudo udevadm trigger, and plug it in anew.",
                udev_rule(device.ids[0], device.ids[1])
            ));
        }
    }
    if devices.is_empty() {
        finding.advise(
            "There is none; a data glove shows up here once it is plugged in. The mouse serves as \
             a hand until then, and sandtable simulate glove plays one by VRPN."
                .to_owned(),
        );
    }
    finding
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_glove_that_is_not_permitted_gets_its_udev_rule() {
        let device = |name: &str, permitted| Device {
            node: "/dev/hidraw3".into(),
            name: name.into(),
            ids: [0x5d70, 0x000b],
            permitted,
        };
        let finding = judge(&[device("Glove", false), device("Mouse", true)]);
        assert_eq!(finding.advice.len(), 1);
        let rule = "KERNEL==\"hidraw*\", ATTRS{idVendor}==\"5d70\", ATTRS{idProduct}==\"000b\", \
                    TAG+=\"uaccess\"";
        assert!(finding.advice[0].lines().any(|line| line == rule));
        assert_eq!(finding.json()[1]["name"], "Mouse");
        assert!(judge(&[]).advice[0].contains("plugged in"));
    }
}
