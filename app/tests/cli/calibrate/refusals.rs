//! What is refused, before a hand has touched anything where that can be known.

use super::bird::Bird;
use super::talk::Talk;
use super::{MARKS, RIG, TIP, folder, marks, with_tip};
use glam::DVec3;
use std::time::Duration;

#[test]
fn a_sensor_that_falls_silent_is_refused_with_its_reason() {
    let folder = folder();
    let _bird = Bird::start(&folder, "--stall 0.3,100000");
    let mut talk = Talk::start(
        &folder,
        "tracker --rig rig.toml --marks marks.toml --sensor flock/1",
    );
    talk.hear("no stylus tip on flock/1");
    talk.hear("touch \"front left\"");
    // Until a pose is lost.
    std::thread::sleep(Duration::from_millis(1500));
    talk.say("");
    let refused = talk.hear("again: ");
    assert!(refused.contains("flock/1 is not live"), "{refused}");
    talk.hear("touch \"front left\"");
    talk.fails(&["standard input ended", "nothing is written"]);
    assert_eq!(folder.read("rig.toml"), RIG.as_bytes());
}

#[test]
fn a_sensor_that_moves_is_refused_and_asked_again() {
    let folder = folder();
    let mut bird = Bird::start(&folder, "--motion circle");
    let arguments = "check --rig rig.toml --marks marks.toml --sensor flock/1";
    let mut talk = Talk::start(&folder, arguments);
    talk.hear("touch \"front left\"");
    talk.say("");
    let refused = talk.hear("again: ");
    for part in ["flock/1 moved by", "2 mm are allowed", "hold it still"] {
        assert!(refused.contains(part), "no {part:?} in {refused}");
    }
    talk.hear("touch \"front left\"");
    bird.put(DVec3::new(-0.1, 0.2, -0.5), [0.0; 3]);
    talk.measure();
    talk.hear("touch \"front right\"");
    talk.say("q");
    talk.fails(&["ended with q", "nothing is written"]);
}

#[test]
fn a_port_that_is_not_there_is_told_before_anything_is_asked() {
    let folder = folder();
    let refused = folder.run("calibrate check --rig rig.toml --marks marks.toml --sensor flock/1");
    let said = refused.failed(1, &["nothing comes from flock/1", "no-such-port"]);
    assert!(!said.contains("touch \""), "{said}");
}

#[test]
fn what_cannot_end_well_is_refused_before_anything_is_touched() {
    let folder = folder();
    let line: Vec<_> = (0..4)
        .map(|i| {
            (
                "abcd".get(i..=i).unwrap(),
                DVec3::new(0.2 * i as f64, 0.0, 0.0),
            )
        })
        .collect();
    folder.write("line.toml", marks(&line));
    folder.write("two.toml", marks(&MARKS[..2]));
    let torn = marks(&MARKS);
    folder.write("torn.toml", &torn[..torn.len() - 12]);
    folder.write("taken.toml", "mine");
    let tracker = |rest: &str| format!("tracker --sensor flock/1 {rest}");
    for (arguments, code, says) in [
        (
            tracker("--rig rig.toml --marks line.toml"),
            1,
            &["line.toml", "nearly in the line", "well off that line"][..],
        ),
        (
            tracker("--rig rig.toml --marks two.toml"),
            1,
            &["too few", "at least 3"],
        ),
        (
            tracker("--rig rig.toml --marks torn.toml"),
            1,
            &["torn.toml, line 6", "TOML"],
        ),
        (
            tracker("--rig rig.toml --marks none.toml"),
            1,
            &["none.toml", "[marks]"],
        ),
        (
            tracker("--rig workbench --marks marks.toml"),
            2,
            &["built in", "-o"],
        ),
        (
            tracker("--rig rig.toml --marks marks.toml -o taken.toml"),
            1,
            &["taken.toml", "never overwritten"],
        ),
        (
            tracker("--rig rig.toml --marks marks.toml -o /sys/rig.toml"),
            1,
            &["/sys/rig.toml", "writable"],
        ),
        (
            "tracker --rig rig.toml --marks marks.toml".to_owned(),
            2,
            &["--sensor"],
        ),
        (
            "tracker --rig rig.toml --marks marks.toml --sensor flock/2".to_owned(),
            2,
            &["flock/2", "flock/1"],
        ),
        (
            "eyes --rig rig.toml --marks marks.toml --pair post=lamp".to_owned(),
            2,
            &["lamp", "back left"],
        ),
        (
            "eyes --rig rig.toml --marks marks.toml --pair post".to_owned(),
            2,
            &["NEAR=FAR"],
        ),
        (
            "eyes --rig rig.toml --marks marks.toml --pair post=post".to_owned(),
            1,
            &["--pair post=post", "pair 1", "0.000 m apart", "farther"],
        ),
        (
            "eyes --rig rig.toml --marks glass --pair post=lamp".to_owned(),
            2,
            &["on the glass", "no eye", "post", "--marks"],
        ),
        (
            "check --rig rig.toml --marks marks.toml --sensor flock/1 --within 0".to_owned(),
            2,
            &["above 0"],
        ),
        (
            "stylus --rig rig.toml --sensor flock/1 --seconds 0".to_owned(),
            2,
            &["1 to 60"],
        ),
    ] {
        let refused = folder.run(&format!("calibrate {arguments}"));
        refused.failed(code, says);
    }
    assert_eq!(folder.read("rig.toml"), RIG.as_bytes());
    assert_eq!(folder.read("taken.toml"), b"mine");

    let mut permissions = folder.file("rig.toml").metadata().unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(folder.file("rig.toml"), permissions).unwrap();
    let arguments = tracker("--rig rig.toml --marks marks.toml");
    let refused = folder.run(&format!("calibrate {arguments}"));
    refused.failed(1, &["read-only", "-o"]);
    let names = [
        "line.toml",
        "marks.toml",
        "rig.toml",
        "taken.toml",
        "torn.toml",
        "two.toml",
    ];
    assert_eq!(folder.names(), names);
}

#[test]
fn a_full_disk_keeps_the_old_rig_and_prints_what_was_measured() {
    let folder = folder();
    // What it was still fits, and with the measured numbers it does not.
    let old = with_tip() + &"#".repeat(8192 - 10 - with_tip().len()) + "\n";
    folder.write("rig.toml", &old);
    folder.write("marks.toml", marks(&MARKS[..3]));
    let mut bird = Bird::start(&folder, "");
    let mut talk = Talk::start_on_a_full_disk(&folder, "tracker --rig rig.toml --marks marks.toml");
    for (name, place) in &MARKS[..3] {
        talk.hear(&format!("touch \"{name}\""));
        bird.touch(*place, TIP, [0.0, 30.0, 0.0]);
        talk.measure();
    }
    talk.hear("q ends without");
    talk.say("");
    let ended = talk.fails(&["cannot write", "rig.toml", "full"]);
    assert!(ended.out.contains("\n+ table_from_tracker = "), "{ended:?}");
    assert_eq!(folder.read("rig.toml"), old.as_bytes());
    let left: Vec<_> = folder.names();
    assert!(!left.iter().any(|name| name.ends_with(".part")), "{left:?}");
}
