//! Intents: what a rig's sources mean, and what is wrong with one that means nothing.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use sandtable_config::{
    GamepadPart, Gesture, Intent, IntentKind, Intents, KeyCode, Part, Rig, SensorName, Source,
    Touch,
};

const DEVICES: &str = "name = 'i'\n[camera]\n\
    [devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n\
    [devices.wand]\nkind = 'vrpn'\naddress = 'Wand0@lab'\nsensors = 2\n\
    table_from_tracker = { translation = [0.0, 0.0, 0.0] }\n";

/// Trackers without buttons and channels.
const TRACKERS: &str = "[devices.flock]\nkind = 'flock-of-birds'\nport = '/dev/ttyS1'\n\
    birds = 2\nrange = 72\nhemisphere = 'upper'\n\
    table_from_tracker = { translation = [0.0, 0.0, 0.0] }\n\
    [devices.art]\nkind = 'dtrack'\n\
    table_from_tracker = { translation = [0.0, 0.0, 0.0] }\n";

fn rig(rest: &str) -> Rig {
    Rig::parse(&format!("{DEVICES}{rest}"), "i.toml").unwrap()
}

fn words(intents: &Intents, intent: Intent) -> Vec<String> {
    let sources = intents.sources(intent).iter();
    sources.map(ToString::to_string).collect()
}

#[test]
fn every_kind_of_source_is_read_and_written_alike() {
    let written = [
        "key W",
        "-key Space",
        "mouse middle",
        "-gamepad right-stick-y",
        "gamepad south",
        "wand/2 button 63",
        "-wand/1 channel 31",
        "pinch/1 point",
        "pinch/2 thumb-ring",
        "-pinch/1 other-hand",
    ];
    let rig = rig(&format!("[intents]\nyaw = {written:?}\n"));
    assert_eq!(words(&rig.intents, Intent::Yaw), written);
    let glove = |number| SensorName {
        device: "pinch".into(),
        number,
    };
    let sources = rig.intents.sources(Intent::Yaw);
    let part = |index: usize| &sources[index].part;
    assert_eq!(part(0), &Part::Key(KeyCode::KeyW));
    assert!(sources[1].inverted && !sources[0].inverted);
    assert_eq!(part(4), &Part::Gamepad(GamepadPart::South));
    let (sensor, gesture) = (glove(1), Gesture::Point);
    assert_eq!(part(7), &Part::Gesture { sensor, gesture });
    let (sensor, touch) = (glove(2), Touch::Thumb(3));
    assert_eq!(part(8), &Part::Touch { sensor, touch });
}

#[test]
fn what_is_not_written_stands_as_it_would_without_a_word() {
    let rig = rig("[intents]\nact = ['default', 'pinch/2 pinch']\nquit = []\n");
    let act = ["mouse left", "key Space", "gamepad south", "pinch/2 pinch"];
    assert_eq!(words(&rig.intents, Intent::Act), act);
    assert_eq!(rig.intents.sources(Intent::Quit), []);
    let told: Vec<_> = rig.intents.iter().map(|(intent, _)| intent).collect();
    assert_eq!(told.len(), Intent::ALL.len() - 1);
    let plain = Intents::default();
    for intent in Intent::ALL {
        assert!(!plain.sources(intent).is_empty(), "{intent:?}");
        if ![Intent::Act, Intent::Quit].contains(&intent) {
            assert_eq!(rig.intents.sources(intent), plain.sources(intent));
        }
        // Only an axis has an opposite.
        let inverted = plain.sources(intent).iter().any(|source| source.inverted);
        assert!(!inverted || intent.kind() == IntentKind::Axis, "{intent:?}");
    }
}

#[test]
fn no_two_intents_share_a_default_source() {
    let plain = Intents::default();
    let all: Vec<&Source> = plain.iter().flat_map(|(_, sources)| sources).collect();
    for (index, source) in all.iter().enumerate() {
        assert!(!all[..index].contains(source), "{source}");
    }
}

#[test]
fn a_gamepads_axes_of_older_rigs_are_understood() {
    let rig = rig("[gamepad]\nforward = '-right-stick-y'\nroll = 'none'\n");
    let forward = ["key W", "-key S", "-gamepad right-stick-y"];
    assert_eq!(words(&rig.intents, Intent::Forward), forward);
    assert_eq!(words(&rig.intents, Intent::Roll), ["key E", "-key Q"]);
    let both = "[gamepad]\nyaw = 'triggers'\n[intents]\nyaw = ['key Y']\n";
    let error = Rig::parse(&format!("{DEVICES}{both}"), "i.toml").unwrap_err();
    let error = error.to_string();
    assert!(error.contains("`gamepad.yaw`"), "{error}");
}

#[test]
fn an_error_names_what_is_wrong_and_what_is_right() {
    let cases: &[(&str, &[&str])] = &[
        ("grabb = []", &["intents.grabb", "did you mean `grab`?"]),
        ("act = 'key Space'", &["intents.act", "an array"]),
        ("act = [3]", &["intents.act[0]", "key Space"]),
        (
            "act = ['Space']",
            &["intents.act[0]", "a device and its part"],
        ),
        ("act = ['key Spaec']", &["a letter, a digit"]),
        ("act = ['mouse lefft']", &["did you mean \"left\"?"]),
        ("act = ['gamepad noth']", &["did you mean \"north\"?"]),
        ("act = ['pinhc/1 grab']", &["did you mean `pinch`?"]),
        (
            "act = ['glove/1 grab']",
            &["key, mouse, gamepad, art, flock, pinch, wand"],
        ),
        ("act = ['pinch/3 grab']", &["pinch/1 to pinch/2"]),
        ("act = ['pinch grab']", &["pinch/1 to pinch/2"]),
        ("act = ['pinch/1 grap']", &["did you mean `grab`?"]),
        ("act = ['pinch/1 wave']", &["thumb-index", "other-hand"]),
        ("act = ['wand/1 grab']", &["`wand`, which is no glove"]),
        ("act = ['wand/1 button 64']", &["from 0 to 63"]),
        ("act = ['wand/1 channel 32']", &["from 0 to 31"]),
        ("act = ['wand/1 button -1']", &["from 0 to 63"]),
        (
            "act = ['flock/2 button 0']",
            &[
                "intents.act[0]",
                "`flock`, which has none",
                "`buttons = true`",
            ],
        ),
        (
            "yaw = ['flock/2 channel 0']",
            &["intents.yaw[0]", "`flock`, which has none", "gamepad"],
        ),
        (
            "act = ['pinch/2 button 0']",
            &["`pinch`, which has none", "a gesture"],
        ),
        ("act = ['art/1 button 0']", &["`flysticks`"]),
        ("yaw = ['art/1 channel 0']", &["`flysticks`"]),
        ("act = ['-key Space']", &["leave out the minus"]),
        (
            "act = ['key g', 'key G']",
            &["intents.act[1]", "a second time"],
        ),
    ];
    for (line, needles) in cases {
        let text = format!("{DEVICES}{TRACKERS}[intents]\n{line}\n");
        let error = Rig::parse(&text, "i.toml").unwrap_err().to_string();
        let number = 1 + text.lines().position(|l| l == *line).unwrap();
        let place = format!("i.toml, line {number}: `intents.");
        assert!(error.starts_with(&place), "{line}: {error}");
        for needle in *needles {
            assert!(error.contains(needle), "{line}: {error}");
        }
    }
}
