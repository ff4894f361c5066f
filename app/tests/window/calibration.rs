//! The calibration guided in the window: marks shown on the glass are touched by a simulated bird.

use crate::hands::held_at;
use crate::session::{Session, wait_for};
use glam::{DVec2, DVec3};
use image::RgbaImage;
use sandtable_config::{Device, Rig};
use sandtable_input::flock::{Motion, Simulator, SimulatorSettings};
use std::time::Duration;

/// The middle of the cross that shows a mark, as shares of the picture from its upper left, where
/// one is shown.
fn cross(image: &RgbaImage) -> Option<DVec2> {
    let yellow = |pixel: &image::Rgba<u8>| {
        let [r, g, b, _] = pixel.0;
        r > 240 && g > 240 && b < 20
    };
    let arms = image.enumerate_pixels().filter(|(.., pixel)| yellow(pixel));
    let (mut sum, mut count) = (DVec2::ZERO, 0);
    for (x, y, _) in arms {
        sum += DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        count += 1;
    }
    let size = DVec2::new(f64::from(image.width()), f64::from(image.height()));
    (count > 100).then(|| sum / f64::from(count) / size)
}

/// Says that the mark at `at` is touched, until it is taken and the next one's cross shows; gives
/// that. On a loaded machine the bird may still seem to move, and the touch is asked for again.
fn after_touch(session: &Session, at: DVec2) -> DVec2 {
    wait_for("the next cross", || {
        std::thread::sleep(Duration::from_millis(300));
        session.key("space");
        (0..20).find_map(|_| {
            std::thread::sleep(Duration::from_millis(100));
            let image = session.shoot_until("a picture", |_| true);
            // While a touch is measured, no mark is asked for.
            cross(&image).filter(|next| next.distance(at) > 0.05)
        })
    })
}

#[test]
fn the_tracker_is_calibrated_by_touching_crosses_on_the_glass() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rig_file = folder.path().join("lab.toml");
    let right = "translation = [0.0, 0.0, -0.30]";
    let text = Rig::builtin_text("workbench").expect("built in");
    // Somebody has moved the transmitter, and nobody has measured it since.
    let moved = text.replace(right, "translation = [0.05, -0.03, -0.33]");
    assert_ne!(moved, text);
    std::fs::write(&rig_file, &moved).expect("it can be written");
    let flock = Simulator::start(
        SimulatorSettings {
            motions: vec![Motion::Still, held_at(DVec3::new(0.0, 0.0, 0.2), 0.0)],
            ..SimulatorSettings::default()
        },
        None,
    )
    .expect("a pseudo-terminal");
    let device = format!("flock={}", flock.path().display());
    let Some(session) = Session::open(&[
        "builtin:jacksboro",
        "--rig",
        rig_file.to_str().expect("a plain path"),
        "--device",
        &device,
        "--stereo",
        "mono",
        "--mute",
        "--calibrate",
        "tracker",
    ]) else {
        return;
    };
    let first = session.shoot_until("a cross", |image| cross(image).is_some());
    let mut at = cross(&first).expect("it was there");
    for number in 1..=6 {
        // The window shows the glass, of 1.80 by 1.10 m about the table's origin.
        let place = DVec3::new(1.80 * at.x - 0.90, 0.55 - 1.10 * at.y, 0.0);
        flock.set_motion(2, held_at(place, 10.0 * f64::from(number)));
        if number < 6 {
            at = after_touch(&session, at);
        }
    }
    // The last touch, and then what came out of them.
    let measured = wait_for("the rig's new frame", || {
        std::thread::sleep(Duration::from_millis(1000));
        session.key("space");
        let rig = Rig::load(&rig_file).ok()?;
        let Device::Flock(flock) = &rig.devices["flock"] else {
            panic!("it is a Flock");
        };
        flock.calibrated.map(|_| flock.table_from_tracker)
    });
    let off = measured.translation - DVec3::new(0.0, 0.0, -0.30);
    // A pixel of the cross is 1.4 mm.
    assert!(off.length() < 2e-3, "{off} off");
    let axes = Rig::builtin("workbench").expect("built in");
    let Device::Flock(workbench) = &axes.devices["flock"] else {
        panic!("it is a Flock");
    };
    let turned = measured
        .rotation
        .angle_between(workbench.table_from_tracker.rotation);
    assert!(turned < 0.004, "{turned} rad off");
    // The old rig is kept, and the program goes on.
    let kept = std::fs::read_dir(folder.path()).expect("it is there");
    let kept = kept.filter_map(Result::ok);
    let kept = kept.filter(|entry| entry.file_name().to_string_lossy().contains(".bak-"));
    assert_eq!(kept.count(), 1);
    session.close();
    flock.stop();
}
