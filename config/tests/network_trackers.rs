//! Trackers on the network: what a rig file may say of VRPN servers and DTrack.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use glam::{DQuat, DVec3};
use sandtable_config::{Device, Dtrack, Rig, RigError, Vrpn};
use sandtable_pose::Rigid;
use std::net::{IpAddr, Ipv4Addr};
use std::path::Path;
use std::time::Duration;

const TABLE: &str = "table_from_tracker = { translation = [0.0, 0.0, 0.0] }";

/// A rig with one device of these lines.
fn rig(lines: &str) -> Result<Rig, RigError> {
    let head = "name = 'lab'\ncamera = { horizontal_fov = 60.0 }\n[devices.t]\n";
    Rig::parse(&format!("{head}{lines}\n"), "lab.toml")
}

fn vrpn(lines: &str) -> Vrpn {
    match rig(lines).unwrap().devices.remove("t") {
        Some(Device::Vrpn(vrpn)) => vrpn,
        other => panic!("{other:?}"),
    }
}

fn dtrack(lines: &str) -> Dtrack {
    match rig(lines).unwrap().devices.remove("t") {
        Some(Device::Dtrack(dtrack)) => dtrack,
        other => panic!("{other:?}"),
    }
}

fn error(lines: &str) -> String {
    rig(lines).unwrap_err().to_string()
}

#[test]
fn a_servers_address_may_come_from_the_command_line() {
    let text = "name = 'lab'\n[camera]\n[devices.wand]\nkind = 'vrpn'\n\
                address = 'Tracker0@lab-pc'\nbuttons = { sender = 'Button0' }\n\
                table_from_tracker = { translation = [0.0, 0.0, 0.0] }\n";
    let mut rig = Rig::parse(text, "lab.toml").unwrap();
    rig.set_port("wand", Path::new("Wand0@[::1]:4000")).unwrap();
    let Device::Vrpn(wand) = &rig.devices["wand"] else {
        panic!("it is of a VRPN server");
    };
    assert_eq!(wand.address.to_string(), "Wand0@[::1]:4000");
    // What has its own sender keeps it; what came from the tracker's comes from the new one.
    assert_eq!(
        [&wand.buttons.sender, &wand.analogs.sender],
        ["Button0", "Wand0"]
    );
    let before = rig.clone();
    let error = rig.set_port("wand", Path::new("/dev/ttyS0")).unwrap_err();
    assert!(error.to_string().contains("Tracker0@lab-pc"), "{error}");
    assert_eq!(rig, before);
}

#[test]
fn a_vrpn_device_needs_little_and_takes_defaults() {
    let vrpn = vrpn(&format!(
        "kind = 'vrpn'\naddress = 'Tracker0@lab-pc'\n{TABLE}"
    ));
    assert_eq!(vrpn.address.to_string(), "Tracker0@lab-pc:3883");
    assert_eq!(vrpn.sensors, 1);
    for part in [&vrpn.buttons, &vrpn.analogs] {
        assert_eq!((part.sender.as_str(), part.sensor), ("Tracker0", 1));
    }
    assert_eq!(vrpn.silent_after, Duration::from_secs(3));
    let tracking = &vrpn.tracking;
    assert_eq!(tracking.rate, 60.0);
    assert_eq!(tracking.held_after, Duration::from_millis(30));
    assert_eq!(tracking.lost_after, Duration::from_millis(250));
    assert_eq!((tracking.max_speed, tracking.max_turn), (5.0, 1000.0));
    assert_eq!(tracking.frozen_after, Some(100));
    let pose = Rigid::new(DQuat::from_rotation_x(0.4), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(tracking.table_from_sensor(&pose), pose);
}

#[test]
fn a_vrpn_device_is_what_its_lines_say() {
    let vrpn = vrpn(
        "kind = 'vrpn'\naddress = 'DTrack@10.0.0.5:4500'\nsensors = 3\n\
         buttons = { sender = 'Wand 0', sensor = 2 }\nanalogs = { sensor = 3 }\n\
         silent_after = 5.5\nrate = 120.0\nheld_after_ms = 40.0\nlost_after_ms = 500.0\n\
         max_speed = 8.0\nmax_turn = 2000.0\nfrozen_after = 0\naxes = ['x', 'z', '-y']\n\
         table_from_tracker = { translation = [0.0, 0.0, 0.5], angles = [90.0, 0.0, 0.0] }",
    );
    assert_eq!(
        (vrpn.address.host.as_str(), vrpn.address.port),
        ("10.0.0.5", 4500)
    );
    assert_eq!(
        (vrpn.buttons.sender.as_str(), vrpn.buttons.sensor),
        ("Wand 0", 2)
    );
    assert_eq!(
        (vrpn.analogs.sender.as_str(), vrpn.analogs.sensor),
        ("DTrack", 3)
    );
    assert_eq!(vrpn.silent_after, Duration::from_millis(5500));
    assert_eq!(vrpn.tracking.frozen_after, None);
    assert_eq!(vrpn.tracking.period(), Duration::from_secs_f64(1.0 / 120.0));
    // y up becomes z up, then the frame is turned and lifted.
    let pose = Rigid::new(DQuat::IDENTITY, DVec3::new(1.0, 2.0, 3.0));
    let table = vrpn.tracking.table_from_sensor(&pose);
    assert!((table.translation - DVec3::new(3.0, 1.0, 2.5)).length() < 1e-12);
    let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    assert!(table.rotation.angle_between(quarter) < 1e-7);
}

#[test]
fn addresses_may_be_written_in_every_usual_way() {
    for (written, host, port) in [
        ("T@h", "h", 3883),
        ("T@h:1", "h", 1),
        ("T@tcp://h.lab.example:65535", "h.lab.example", 65_535),
        ("T@[::1]", "::1", 3883),
        ("T@[fe80::1%eth0]:99", "fe80::1%eth0", 99),
    ] {
        let vrpn = vrpn(&format!("kind = 'vrpn'\naddress = '{written}'\n{TABLE}"));
        assert_eq!(
            (vrpn.address.host.as_str(), vrpn.address.port),
            (host, port)
        );
        assert_eq!(vrpn.address.sender, "T");
    }
}

#[test]
fn a_dtrack_device_needs_little_and_takes_defaults() {
    let plain = dtrack(&format!("kind = 'dtrack'\n{TABLE}"));
    assert_eq!((plain.port, plain.bodies, plain.flysticks), (5000, 1, 0));
    assert_eq!(
        (plain.bind, plain.from),
        (IpAddr::V4(Ipv4Addr::UNSPECIFIED), None)
    );
    let full = dtrack(&format!(
        "kind = 'dtrack'\nport = 5001\nbind = '127.0.0.1'\nfrom = '10.0.0.9'\nbodies = 2\n\
         flysticks = 1\n{TABLE}"
    ));
    assert_eq!((full.port, full.bodies, full.flysticks), (5001, 2, 1));
    assert_eq!(full.from, Some(IpAddr::V4(Ipv4Addr::new(10, 0, 0, 9))));
    assert_eq!(Device::Dtrack(full).sensors(), 3);
}

#[test]
fn each_error_names_line_key_and_remedy() {
    let vrpn = |line: &str| error(&format!("kind = 'vrpn'\n{line}\n{TABLE}"));
    let dtrack = |line: &str| error(&format!("kind = 'dtrack'\n{line}\n{TABLE}"));
    let at = "address = 'T@h'\n";
    for (said, needles) in [
        (vrpn(""), ["address", "Tracker0@lab-pc"]),
        (vrpn("address = 'Tracker0'"), ["line 5", "@ and its server"]),
        (
            vrpn("address = '@h'"),
            ["devices.t.address", "1 to 99 bytes"],
        ),
        (
            vrpn("address = 'T@'"),
            ["devices.t.address", "behind the @"],
        ),
        (vrpn("address = 'T@h:'"), ["\"T@h:\"", "1 to 65535"]),
        (vrpn("address = 'T@h:0'"), ["\"T@h:0\"", "1 to 65535"]),
        (vrpn("address = 'T@h:70000'"), ["70000", "1 to 65535"]),
        (vrpn("address = 'T@[::1]x'"), ["::1", "1 to 65535"]),
        (vrpn("address = 'T@::1'"), ["::1", "Tracker0@[::1]"]),
        (
            vrpn("address = 'T@h;reboot'"),
            ["h;reboot", "name or IP address"],
        ),
        (vrpn("address = 'T@a@b'"), ["T@a@b", "name or IP address"]),
        (
            vrpn("adress = 'T@h'"),
            ["devices.t.adress", "did you mean `address`?"],
        ),
        (
            vrpn(&format!("{at}sensors = 0")),
            ["devices.t.sensors", "from 1 to 64"],
        ),
        (
            vrpn(&format!("{at}buttons = {{ sensor = 2 }}")),
            ["devices.t.buttons.sensor", "from 1 to 1"],
        ),
        (
            vrpn(&format!("{at}buttons = {{ sender = '' }}")),
            ["devices.t.buttons.sender", "1 to 99 bytes"],
        ),
        (
            vrpn(&format!("{at}held_after_ms = 300")),
            ["lost_after_ms", "held before it is lost"],
        ),
        (
            vrpn(&format!("{at}axes = ['x', 'y', 'y']")),
            ["devices.t.axes", "one axis twice"],
        ),
        (
            vrpn(&format!("{at}rate = 0")),
            ["devices.t.rate", "from 1 to 2000"],
        ),
        (dtrack("port = 0"), ["devices.t.port", "from 1 to 65535"]),
        (
            dtrack("from = 'artserver'"),
            ["\"artserver\"", "192.168.0.10"],
        ),
        (dtrack("bodies = 0"), ["devices.t.bodies", "no Flystick"]),
        (dtrack("body = 2"), ["devices.t.body", "is unknown"]),
        (
            error("kind = 'vrpm'"),
            ["devices.t.kind", "did you mean \"vrpn\"?"],
        ),
        (
            error("kind = 'dtrack'"),
            ["table_from_tracker", "is missing"],
        ),
    ] {
        for needle in needles {
            assert!(said.contains(needle), "{needle:?} is not in {said:?}");
        }
        assert!(said.starts_with("lab.toml, line "), "{said}");
    }
}

#[test]
fn a_mirror_is_no_place_for_a_tracker_but_may_be_its_convention() {
    let mirror = "['x', 'y', '-z']";
    let said = error(&format!(
        "kind = 'dtrack'\ntable_from_tracker = {{ translation = [0, 0, 0], axes = {mirror} }}"
    ));
    assert!(said.contains("is a mirror"), "{said}");
    let left_handed = dtrack(&format!("kind = 'dtrack'\naxes = {mirror}\n{TABLE}"));
    let pose = Rigid::new(DQuat::IDENTITY, DVec3::ONE);
    let table = left_handed.tracking.table_from_sensor(&pose);
    assert_eq!(table.translation, DVec3::new(1.0, 1.0, -1.0));
}

#[test]
fn a_tracker_on_the_network_has_no_serial_port() {
    let mut rig = rig(&format!("kind = 'dtrack'\n{TABLE}")).unwrap();
    let error = rig.set_port("t", Path::new("/dev/ttyUSB0")).unwrap_err();
    assert!(error.to_string().contains("no serial port"), "{error}");
}
