//! Gamepads, as gilrs sees them.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::access;
use super::finding::{Finding, Item};
use super::remedy::join_group;

pub(super) fn examine() -> Result<Finding, String> {
    let gilrs = match gilrs::Gilrs::new() {
        Ok(gilrs) => gilrs,
        Err(gilrs::Error::NotImplemented(_)) => {
            return Err("gamepads are not supported on this system".to_owned());
        }
        Err(error) => return Err(error.to_string()),
    };
    let pads = gilrs.gamepads().map(|(_, pad)| {
        let mapped = pad.mapping_source() != gilrs::MappingSource::None;
        (pad.name().to_owned(), mapped)
    });
    Ok(judge(&pads.collect::<Vec<_>>(), &refused()))
}

/// The joysticks that the kernel knows but this user may not use.
fn refused() -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir("/dev/input") else {
        return Vec::new();
    };
    entries
        .flatten()
        .filter(|entry| entry.file_name().as_encoded_bytes().starts_with(b"js"))
        .map(|entry| entry.path())
        .filter(|node| !access::is_granted(node))
        .collect()
}

/// Judges pads, each with whether its buttons are known by name, and refused joysticks.
fn judge(pads: &[(String, bool)], refused: &[PathBuf]) -> Finding {
    let mut finding = Finding::default();
    for (name, mapped) in pads {
        let detail = if *mapped { "" } else { "unknown layout" };
        finding.found(Item::new(name, detail, json!({ "mapped": mapped })));
        if !mapped {
            finding.advise(format!(
                "The layout of {name} is not known: set SDL_GAMECONTROLLERCONFIG to its mapping, \
                 as `sdl2-jstest` or Steam write it."
            ));
        }
    }
    for node in refused {
        let group = access::group_of(node);
        finding.advise(format!(
            "To be permitted to use {}: {}; one who sits at the machine itself needs no group.",
            node.display(),
            join_group(group.as_deref().unwrap_or("input"))
        ));
    }
    if pads.is_empty() && refused.is_empty() {
        let udev = Path::new("/run/udev/control");
        finding.advise(if cfg!(target_os = "linux") && !udev.exists() {
            "There is none, and no udev to tell of one: in a container, share /run/udev and \
             /dev/input with it. Keyboard and mouse fly too."
                .to_owned()
        } else {
            "There is none; one shows up here once it is plugged in. Keyboard and mouse fly too."
                .to_owned()
        });
    }
    finding
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pads_that_are_unknown_or_refused_get_their_remedy() {
        let pads = [("Pad".to_owned(), true), ("Stick".to_owned(), false)];
        assert!(judge(&pads[..1], &[]).advice.is_empty());
        assert!(judge(&pads, &[]).advice[0].contains("SDL_GAMECONTROLLERCONFIG"));
        let refused = judge(&[], &["/dev/input/js0".into()]);
        assert!(refused.advice[0].contains("usermod -aG input"));
        assert_eq!(judge(&[], &[]).advice.len(), 1);
    }
}
