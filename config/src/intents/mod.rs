//! Intents: what people mean by keys, buttons, sticks, gestures and touches, `[intents]`.
//!
//! ```text
//! act = ["default", "pinch/2 grab", "flock/2 button 0"]
//! yaw = ["gamepad right-stick-x", "key Right", "-key Left"]
//! ```

mod intent;
mod source;

pub use intent::{Intent, IntentKind};
pub(crate) use source::GAMEPAD_PARTS;
pub use source::{GamepadPart, Gesture, MouseButton, Part, Source, Touch};

use crate::fields::{Fields, Value, nearest};
use crate::{Device, RigError, SensorName};
use source::{GESTURES, MOUSE_BUTTONS, TOUCHES};
use std::collections::BTreeMap;

/// By what each intent is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Intents(BTreeMap<Intent, Vec<Source>>);

impl Intents {
    /// The sources of an intent: of axes the sum counts, of others any one of them.
    #[must_use]
    pub fn sources(&self, intent: Intent) -> &[Source] {
        self.0.get(&intent).map_or(&[], Vec::as_slice)
    }

    /// Every intent that has sources, and these, in the order of [`Intent::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Intent, &[Source])> {
        let all = Intent::ALL.into_iter();
        all.map(|intent| (intent, self.sources(intent)))
            .filter(|(_, sources)| !sources.is_empty())
    }
}

impl Default for Intents {
    /// Those of keyboard, mouse and gamepad without a word in the rig.
    fn default() -> Self {
        let sources = |intent| (intent, default_sources(intent));
        Self(Intent::ALL.into_iter().map(sources).collect())
    }
}

/// What an intent is asked for by without a word in the rig.
fn default_words(intent: Intent) -> &'static [&'static str] {
    match intent {
        Intent::Right => &["key D", "-key A", "gamepad left-stick-x"],
        Intent::Forward => &["key W", "-key S", "gamepad left-stick-y"],
        Intent::Up => &["key R", "-key F", "gamepad triggers"],
        Intent::Yaw => &["key Right", "-key Left", "gamepad right-stick-x"],
        Intent::Pitch => &["key Up", "-key Down", "gamepad right-stick-y"],
        Intent::Roll => &["key E", "-key Q", "gamepad shoulders"],
        Intent::Act => &["mouse left", "key Space", "gamepad south"],
        Intent::Grab => &["key G"],
        Intent::Fly => &["key V"],
        Intent::Point => &["key P", "gamepad west"],
        Intent::Faster => &["key ShiftLeft", "key ShiftRight", "gamepad left-stick"],
        Intent::MoveHead => &["mouse right", "key H"],
        Intent::MoveHand => &["mouse middle", "key T"],
        Intent::NextMode => &["key M", "gamepad north"],
        Intent::Menu => &["key F1", "key Tab", "gamepad start"],
        Intent::Home => &["key Home", "gamepad select"],
        Intent::NextCaster => &["key C"],
        Intent::Mono => &["key 1", "key Numpad1"],
        Intent::SideBySide => &["key 2", "key Numpad2"],
        Intent::TopBottom => &["key 3", "key Numpad3"],
        Intent::Anaglyph => &["key 4", "key Numpad4"],
        Intent::SwapEyes => &["key X"],
        Intent::FullScreen => &["key F11"],
        Intent::Screenshot => &["key F12"],
        Intent::Quit => &["key Esc"],
    }
}

fn default_sources(intent: Intent) -> Vec<Source> {
    let words = default_words(intent).iter();
    words.filter_map(|words| builtin_source(words)).collect()
}

/// A source that needs no device of the rig.
fn builtin_source(words: &str) -> Option<Source> {
    let (inverted, words) = unsigned(words);
    let (device, part) = words.split_once(' ')?;
    let part = match device {
        "key" => Part::Key(source::key(part)?),
        "mouse" => Part::Mouse(meaning(&MOUSE_BUTTONS, part)?),
        "gamepad" => Part::Gamepad(meaning(&GAMEPAD_PARTS, part)?),
        _ => return None,
    };
    Some(Source { part, inverted })
}

fn unsigned(words: &str) -> (bool, &str) {
    match words.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, words),
    }
}

fn meaning<T: Copy>(words: &[(&str, T)], word: &str) -> Option<T> {
    let found = words.iter().find(|(known, _)| *known == word);
    found.map(|(_, meaning)| *meaning)
}

/// The table `intents`; `gamepad` is what `[gamepad]` says of single axes, as older rigs do.
pub(crate) fn read_intents(
    root: &Fields<'_>,
    devices: &BTreeMap<String, Device>,
    gamepad: &[(Intent, Option<Source>)],
) -> Result<Intents, RigError> {
    let mut intents = Intents::default();
    for (intent, source) in gamepad {
        let sources = intents.0.entry(*intent).or_default();
        sources.retain(|source| !matches!(source.part, Part::Gamepad(_)));
        sources.extend(source.clone());
    }
    let Some(value) = root.get("intents") else {
        return Ok(intents);
    };
    let fields = value.fields()?;
    for intent in Intent::ALL {
        if let Some(value) = fields.get(intent.key()) {
            if gamepad.iter().any(|(named, _)| *named == intent) {
                return Err(value.error(
                    &format!("is there beside `gamepad.{}`", intent.key()),
                    "write the gamepad's part here, as \"gamepad left-stick-x\", and leave the \
                     other one out",
                ));
            }
            intents
                .0
                .insert(intent, read_sources(&value, intent, devices)?);
        }
    }
    fields.finish()?;
    Ok(intents)
}

fn read_sources(
    value: &Value<'_>,
    intent: Intent,
    devices: &BTreeMap<String, Device>,
) -> Result<Vec<Source>, RigError> {
    let mut sources = Vec::new();
    for value in value.elements("an array of sources such as \"key Space\"")? {
        let words = value.text("a source such as \"key Space\"")?;
        if words == "default" {
            sources.extend(default_sources(intent));
            continue;
        }
        let (inverted, unsigned) = unsigned(words);
        if inverted && intent.kind() != IntentKind::Axis {
            return Err(value.error(
                &format!("is {words:?}"),
                "leave out the minus: only of an axis does it turn the sign",
            ));
        }
        let part = read_part(&value, unsigned, devices)?;
        let source = Source { part, inverted };
        if sources.contains(&source) {
            return Err(value.error(&format!("is {words:?} a second time"), "leave one out"));
        }
        sources.push(source);
    }
    Ok(sources)
}

fn read_part(
    value: &Value<'_>,
    words: &str,
    devices: &BTreeMap<String, Device>,
) -> Result<Part, RigError> {
    let wrong = |remedy: &str| Err(value.error(&format!("is {words:?}"), remedy));
    let Some((device, part)) = words.split_once(' ') else {
        return wrong(
            "write a device and its part, as \"key Space\", \"mouse left\", \"gamepad south\", \
             \"pinch/2 grab\" or \"flock/2 button 0\"",
        );
    };
    match device {
        "key" => source::key(part).map(Part::Key).map_or_else(
            || {
                wrong(
                    "write a letter, a digit, Left, Right, Up or Down, or a key's code as in \
                     \"key Space\", \"key F5\" or \"key Numpad7\"",
                )
            },
            Ok,
        ),
        "mouse" => value.word(part, &MOUSE_BUTTONS).map(Part::Mouse),
        "gamepad" => value.word(part, &GAMEPAD_PARTS).map(Part::Gamepad),
        sensor => {
            let (sensor, device) = read_sensor(value, sensor, devices)?;
            read_sensors_part(value, sensor, device, part)
        }
    }
}

fn read_sensor<'d>(
    value: &Value<'_>,
    text: &str,
    devices: &'d BTreeMap<String, Device>,
) -> Result<(SensorName, &'d Device), RigError> {
    let wrong = |remedy: &str| value.error(&format!("names {text:?}"), remedy);
    let (name, number) = text.split_once('/').unwrap_or((text, ""));
    let Some(device) = devices.get(name) else {
        let known = ["key", "mouse", "gamepad"].into_iter();
        let known: Vec<&str> = known.chain(devices.keys().map(String::as_str)).collect();
        return Err(wrong(&match nearest(name, &known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there is no such device; there are {}", known.join(", ")),
        }));
    };
    let number = number
        .parse()
        .ok()
        .filter(|n| (1..=device.sensors()).contains(n));
    match number {
        Some(number) => {
            let device_name = name.to_owned();
            let sensor = SensorName {
                device: device_name,
                number,
            };
            Ok((sensor, device))
        }
        None => Err(wrong(&match device.sensors() {
            1 => format!("write {name}/1: it has one sensor"),
            sensors => format!("write {name}/1 to {name}/{sensors}"),
        })),
    }
}

fn read_sensors_part(
    value: &Value<'_>,
    sensor: SensorName,
    device: &Device,
    part: &str,
) -> Result<Part, RigError> {
    let number = |text: &str, most: u32| {
        let number = text.parse().ok().filter(|number| *number < most);
        number.ok_or_else(|| {
            let remedy = format!("write a number from 0 to {}", most - 1);
            value.error(&format!("names {part:?}"), &remedy)
        })
    };
    match part.split_once(' ') {
        Some(("button", text)) => {
            let number = number(text, 64)?;
            if !value.is_recorded()
                && let Some(remedy) = device.lack_of_buttons()
            {
                let problem = format!("names {part:?} of `{}`, which has none", sensor.device);
                return Err(value.error(&problem, remedy));
            }
            return Ok(Part::Button { sensor, number });
        }
        Some(("channel", text)) => {
            let number = number(text, 32)?;
            if !value.is_recorded()
                && let Some(remedy) = device.lack_of_channels()
            {
                let problem = format!("names {part:?} of `{}`, which has none", sensor.device);
                return Err(value.error(&problem, remedy));
            }
            return Ok(Part::Channel { sensor, number });
        }
        _ => {}
    }
    let gesture = meaning(&GESTURES, part);
    let touch = meaning(&TOUCHES, part);
    if device.gestures().is_none() && (gesture.is_some() || touch.is_some()) {
        return Err(value.error(
            &format!("names {part:?} of `{}`, which is no glove", sensor.device),
            "write a glove's hand, or a button as \"flock/2 button 0\"",
        ));
    }
    match (gesture, touch) {
        (Some(gesture), _) => Ok(Part::Gesture { sensor, gesture }),
        (_, Some(touch)) => Ok(Part::Touch { sensor, touch }),
        _ => {
            let gestures = GESTURES.iter().map(|(word, _)| *word);
            let known: Vec<&str> = gestures
                .chain(TOUCHES.iter().map(|(word, _)| *word))
                .collect();
            let others = "button N or channel N";
            Err(value.error(
                &format!("names {part:?}"),
                &match nearest(part, &known) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("write {others}, or of a glove {}", known.join(", ")),
                },
            ))
        }
    }
}
