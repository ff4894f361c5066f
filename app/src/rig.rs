//! From the command line's words to a rig.

use crate::exit::usage;
use anyhow::Result;
use sandtable_config::Rig;
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
    Ok(rig)
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
    let mut parts: Vec<String> = rig
        .devices
        .iter()
        .filter(|(_, device)| device.has_poses())
        .map(|(name, device)| format!("{name} {}", age(device.calibrated())))
        .collect();
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
