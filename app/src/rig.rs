//! From the command line's words to a rig.

use crate::exit::usage;
use anyhow::Result;
use sandtable_config::Rig;
use std::collections::BTreeMap;
use std::path::Path;
use time::Date;

/// Whether a rig's name is a file's path and not that of a built-in one.
pub(crate) fn is_file(name: &str) -> bool {
    name.contains(['/', '\\', '.'])
}

/// The rig of that name, or in that file, with its devices' ports replaced as `ports`
/// (`NAME=PORT`) say.
pub(crate) fn open(name: &str, ports: &[String]) -> Result<Rig> {
    let mut rig = if is_file(name) {
        Rig::load(Path::new(name))?
    } else {
        Rig::builtin(name).map_err(usage)?
    };
    for port in ports {
        let (device, path) = port.split_once('=').ok_or_else(|| {
            usage(format!(
                "{port:?} is not NAME=PORT, like flock=/dev/ttyUSB1"
            ))
        })?;
        rig.set_port(device, Path::new(path)).map_err(usage)?;
    }
    // Asked once all are known, as two may change places.
    if let Some(([one, other], port)) = on_one_port(&rig) {
        return Err(usage(format!(
            "`{one}` and `{other}` are both on {port}, and a serial line has one device: \
             give one of them its own port, like --device {other}=/dev/ttyUSB1"
        )));
    }
    Ok(rig)
}

/// Two devices that are on one serial port, and how the second names it; a port may have many names, like
/// `/dev/serial/by-id/…`.
fn on_one_port(rig: &Rig) -> Option<([&str; 2], &str)> {
    let mut ports = BTreeMap::new();
    rig.devices.iter().find_map(|(name, device)| {
        let port = device.port()?;
        let place = Path::new(port);
        let place = place.canonicalize().unwrap_or_else(|_| place.to_owned());
        let other = ports.insert(place, name.as_str())?;
        Some(([other, name.as_str()], port))
    })
}

/// How old a rig's calibration is on the day `today`, in a line; none for a rig without devices.
pub(crate) fn calibration_age(rig: &Rig, today: Date) -> Option<String> {
    if rig.devices.is_empty() {
        return None;
    }
    let age = |measured: Option<Date>| match measured.map(|day| ((today - day).whole_days(), day)) {
        None => "on no known day".to_owned(),
        Some((0, _)) => "today".to_owned(),
        Some((1, _)) => "yesterday".to_owned(),
        Some((days @ 2.., day)) => format!("{days} days ago ({day})"),
        // A clock that was set back.
        Some((_, day)) => format!("on {day}"),
    };
    let mut parts = Vec::new();
    let trackers = rig.devices.iter().filter(|(_, device)| device.has_poses());
    for (name, device) in trackers {
        parts.push(format!("{name} {}", age(device.calibrated())));
        if let Some(correction) = device.correction() {
            parts.push(format!("its field {}", age(Some(correction.calibrated()))));
        }
    }
    if let Some(head) = &rig.head {
        parts.push(format!("eyes {}", age(head.eyes.calibrated)));
    }
    Some(format!("calibrated: {}", parts.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use time::Month;

    #[test]
    fn two_devices_are_not_put_on_one_port() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lab.toml");
        let glove = "[devices.pinch]\nkind = \"pinch\"\nport = \"/dev/ttyS7\"\n";
        let text = format!("{}\n{glove}", Rig::builtin_text("workbench").unwrap());
        std::fs::write(&path, text).unwrap();
        let opened = |ports: &[&str]| {
            let ports: Vec<_> = ports.iter().map(|&port| port.to_owned()).collect();
            open(path.to_str().unwrap(), &ports)
        };
        let error = opened(&["flock=/dev/ttyS7"]).unwrap_err().to_string();
        assert!(
            error.contains("`flock` and `pinch` are both on /dev/ttyS7"),
            "{error}"
        );
        #[cfg(unix)]
        {
            // By another name, too.
            let [port, alias] = ["port", "alias"].map(|name| folder.path().join(name));
            std::fs::write(&port, "").unwrap();
            std::os::unix::fs::symlink(&port, &alias).unwrap();
            let [flock, pinch] = [("flock", &port), ("pinch", &alias)]
                .map(|(name, path)| format!("{name}={}", path.display()));
            let error = opened(&[&flock, &pinch]).unwrap_err().to_string();
            assert!(error.contains("are both on"), "{error}");
        }
        let rig = opened(&["flock=/dev/ttyS7", "pinch=/dev/ttyS3"]).unwrap();
        assert_eq!(rig.devices["flock"].port(), Some("/dev/ttyS7"));
        assert_eq!(rig.devices["pinch"].port(), Some("/dev/ttyS3"));
    }

    #[test]
    fn the_age_of_a_calibration_is_told_in_days() {
        let day = |day| Date::from_calendar_date(2026, Month::November, day).unwrap();
        let workbench = Rig::builtin_text("workbench").unwrap();
        let told = |entry: &str, today| {
            let glove = "[devices.pinch]\nkind = \"pinch\"\nport = \"/dev/ttyS0\"\n";
            let frame = "translation = [0.0, 0.0, -0.30], axes = [\"+y\", \"+x\", \"-z\"] }";
            assert!(workbench.contains(frame));
            let text = format!("{}\n{glove}", workbench.replace(frame, entry));
            calibration_age(&Rig::parse(&text, "w.toml").unwrap(), today).unwrap()
        };
        let measured = "translation = [0.0, 0.0, -0.3], calibrated = 2026-11-09 }";
        for (today, age) in [
            (9, "today"),
            (10, "yesterday"),
            (21, "12 days ago (2026-11-09)"),
            (8, "on 2026-11-09"),
        ] {
            let line = format!("calibrated: flock {age}, eyes on no known day");
            assert_eq!(told(measured, day(today)), line);
        }
        let desktop = Rig::builtin("desktop").unwrap();
        assert_eq!(calibration_age(&desktop, day(1)), None);
    }
}
