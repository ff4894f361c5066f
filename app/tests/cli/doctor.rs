//! `sandtable doctor` on any machine, with nothing plugged in too.

use crate::program::Folder;
#[cfg(unix)]
use crate::program::wait_for;
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

#[test]
fn a_rigs_corners_left_for_right_are_doubted() {
    let folder = Folder::new();
    let rig = |[left, right]: [&str; 2]| {
        format!(
            "name = \"lab\"\n[table]\nlower_left = [{left}, -0.5, 0.0]\n\
             lower_right = [{right}, -0.5, 0.0]\nupper_left = [{left}, 0.5, 0.0]\n\
             pixels = [60, 40]\n[head]\n\
             rest = {{ position = [0.0, -0.75, 0.60], axes = [\"+y\", \"+x\", \"-z\"] }}\n\
             eyes = {{ middle = [0.0, 0.0, 0.0], rightwards = [0.0, 1.0, 0.0] }}\n"
        )
    };
    for (corners, status, words) in [
        (["-0.9", "0.9"], "ok", "0.60 m before it"),
        (["0.9", "-0.9"], "missing", "0.60 m behind it"),
    ] {
        folder.write("lab.toml", rig(corners));
        let said = folder.run("doctor --rig lab.toml").done().out;
        assert!(said.contains(&format!("The rig: {status}\n")), "{said}");
        assert!(said.contains(words), "{said}");
        let doubt = "→ The eyes of the head at rest are 0.60 m behind the glass";
        assert_eq!(said.contains(doubt), status != "ok", "{said}");
    }
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
        // A machine that is busy with other things may have it at 30.
        assert!(sensor["jitter_ms"].as_f64().unwrap() < 200.0, "{sensor}");
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

/// A rig with one device, which its file describes by `lines`.
#[cfg(unix)]
fn rig_of(lines: &str) -> String {
    format!(
        "name = 'r'\n[camera]\n[devices.it]\n{lines}\n\
         table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}\n"
    )
}

/// What is told of the devices of such a rig.
#[cfg(unix)]
fn devices_of(folder: &Folder, lines: &str) -> Value {
    folder.write("rig.toml", rig_of(lines));
    let said = folder.run("doctor --json --rig rig.toml").done().out;
    let report: Value = serde_json::from_str(&said).expect("JSON");
    report["devices"].clone()
}

#[cfg(unix)]
#[test]
fn a_device_that_does_not_work_is_never_ok_and_its_cause_is_told() {
    let folder = Folder::new();
    let two = crate::simulate::Simulated::start(&folder, "flock", "--birds 2");
    let controller = crate::simulate::Simulated::start(&folder, "flock", "--birds 1 --erc 1");
    // Somebody is there, and is no Flock.
    let gloves = crate::simulate::Simulated::start(&folder, "pinch", "");
    let flock = |port: &std::path::Path, birds: u32| {
        format!(
            "kind = 'flock-of-birds'\nport = '{}'\nbirds = {birds}\nrange = 72\n\
             hemisphere = 'upper'\nsilence_before = 0.6\nsilence_after = 0.6",
            port.display()
        )
    };
    let port = std::net::UdpSocket::bind("127.0.0.1:0")
        .and_then(|socket| socket.local_addr())
        .expect("a port")
        .port();
    for (lines, cause) in [
        (flock(&two.path, 3), "the Flock on"),
        (flock(&controller.path, 1), "the Flock on"),
        (flock(&gloves.path, 2), "the Flock on"),
        (format!("kind = 'dtrack'\nport = {port}"), "no datagram"),
    ] {
        let devices = devices_of(&folder, &lines);
        assert_eq!(devices["status"], "missing", "{lines}: {devices:#}");
        let advice = devices["advice"][0].as_str().expect("an advice");
        assert!(advice.contains(cause), "{lines}: {devices:#}");
        let problem = devices["found"][0]["problem"].as_str().expect("a problem");
        assert!(advice.contains(problem), "{lines}: {devices:#}");
    }
}

#[cfg(unix)]
#[test]
fn a_vrpn_server_is_told_by_what_it_has() {
    let folder = Folder::new();
    // One that moves: a frozen sensor is silent by VRPN.
    let arguments = "--birds 2 --motion circle --vrpn 127.0.0.1:0";
    let server = crate::simulate::Simulated::start(&folder, "flock", arguments);
    let address = server.path.display();
    let vrpn = |sender: &str, sensors: u32| {
        let lines = format!("kind = 'vrpn'\naddress = '{sender}@{address}'\nsensors = {sensors}");
        devices_of(&folder, &lines)
    };
    // It listens before its birds have started.
    let well = wait_for("a server that is well", || {
        let told = vrpn("flock", 2);
        (told["status"] == "ok").then_some(told)
    });
    assert_eq!(well["found"][0]["problem"], Value::Null);
    // Of a server's other sensors nothing is lost.
    let one = vrpn("flock", 1);
    assert_eq!(one["status"], "ok", "{one:#}");
    assert_eq!(one["found"][0]["lost"], 0);
    assert!(one["found"][0]["of_others"].as_u64() > Some(50), "{one:#}");

    let unknown = vrpn("Tracker0", 1);
    assert_eq!(unknown["status"], "missing", "{unknown:#}");
    let advice = unknown["advice"][0].as_str().expect("an advice");
    assert!(advice.contains("it has: flock, flock/2"), "{unknown:#}");
    // It is there, and tells no poses.
    let silent = vrpn("flock/2", 1);
    assert_eq!(silent["status"], "missing", "{silent:#}");
    let advice = silent["advice"][0].as_str().expect("an advice");
    assert!(advice.contains("no pose came of it/1"), "{silent:#}");
}
