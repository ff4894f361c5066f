//! `sandtable doctor` on any machine, with nothing plugged in too.

use crate::program::Folder;
use serde_json::Value;

#[test]
fn people_get_every_section() {
    let said = Folder::new().run("doctor").done().out;
    for section in [
        "GPUs",
        "Displays",
        "Serial ports",
        "HID devices",
        "Gamepads",
        "Sound outputs",
        "Programs",
    ] {
        let line = said.lines().find(|line| line.starts_with(section));
        let line = line.unwrap_or_else(|| panic!("no {section} in\n{said}"));
        let status = line.rsplit(": ").next().unwrap();
        assert!(["ok", "missing", "failed"].contains(&status), "{line}");
    }
    // There is no display in a test, and that is said with what to do.
    assert!(
        said.contains("Displays: missing") && said.contains("→"),
        "{said}"
    );
}

#[test]
fn programs_get_the_same_as_json() {
    let said = Folder::new().run("doctor --json").done().out;
    let report: Value = serde_json::from_str(&said).unwrap();
    for key in [
        "gpus",
        "displays",
        "serial_ports",
        "hid_devices",
        "gamepads",
        "sound_outputs",
        "programs",
    ] {
        let section = &report[key];
        assert!(section["status"].is_string(), "{key}: {section}");
        assert!(section["found"].is_array(), "{key}: {section}");
        assert!(section["advice"].is_array(), "{key}: {section}");
    }
    assert_eq!(report["displays"]["status"], "missing");
    assert_ne!(report["displays"]["advice"], serde_json::json!([]));
}

#[cfg(unix)]
#[test]
fn a_rigs_devices_are_listened_to() {
    let folder = Folder::new();
    let flock = crate::simulate::Simulated::start(&folder, "flock", "--damage-every 20");
    let said = folder.run(&format!(
        "doctor --json --rig workbench --device flock={}",
        flock.path.display()
    ));
    let report: Value = serde_json::from_str(&said.done().out).unwrap();
    let flock = &report["devices"]["found"][0];
    assert_eq!(flock["name"], "flock");
    assert_eq!(flock["condition"], "streaming");
    for sensor in flock["sensors"].as_array().unwrap() {
        let rate = sensor["rate_hz"].as_f64().unwrap();
        assert!((80.0..110.0).contains(&rate), "{sensor}");
        assert!(sensor["jitter_ms"].as_f64().unwrap() < 20.0, "{sensor}");
    }
    assert!(flock["lost"].as_u64().unwrap() > 5, "{flock}");
    assert!(
        report["devices"]["advice"][0]
            .as_str()
            .unwrap()
            .contains("cable")
    );

    // One that is not there is named with its remedy.
    let said = folder.run("doctor --rig workbench --device flock=/dev/there-is-none");
    let said = said.done().out;
    assert!(
        said.contains("flock: waiting") && said.contains("plug the device in"),
        "{said}"
    );
}
