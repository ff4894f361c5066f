//! Sources: the parts of devices by which people ask for something.

use crate::SensorName;
use keyboard_types::Code;
use std::fmt;

/// A part of a device, and whether its sign is turned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The part.
    pub part: Part,
    /// Whether it asks for the opposite; of axes only.
    pub inverted: bool,
}

/// A part of a device that is pushed, pressed or held. What is down counts 1 and what is not 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// A key: a place on the keyboard, whatever is printed on it.
    Key(Code),
    /// A button of the mouse.
    Mouse(MouseButton),
    /// A part of a gamepad.
    Gamepad(GamepadPart),
    /// A button of a sensor.
    Button {
        /// The sensor.
        sensor: SensorName,
        /// The button, from 0.
        number: u32,
    },
    /// A channel of a sensor, such as a joystick's axis: its value from −1 to 1.
    Channel {
        /// The sensor.
        sensor: SensorName,
        /// The channel, from 0.
        number: u32,
    },
    /// A gesture of a gloved hand.
    Gesture {
        /// The glove's hand.
        sensor: SensorName,
        /// The gesture.
        gesture: Gesture,
    },
    /// A touch of a gloved hand's fingertips.
    Touch {
        /// The glove's hand.
        sensor: SensorName,
        /// What touches what.
        touch: Touch,
    },
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MouseButton {
    /// The main one.
    Left,
    /// The other one.
    Right,
    /// The wheel.
    Middle,
}

/// What a gloved hand means by its fingers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gesture {
    /// The hand is open.
    Open,
    /// The index finger points.
    Point,
    /// Thumb and index finger hold something.
    Pinch,
    /// The whole hand holds something.
    Grab,
}

/// Which fingertips touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// The thumb and a finger of the same hand: 1 is the index finger, 4 the little one.
    Thumb(usize),
    /// Any finger and one of the other hand.
    OtherHand,
}

/// A part of a gamepad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GamepadPart {
    /// The left stick, right positive.
    LeftStickX,
    /// The left stick, away positive.
    LeftStickY,
    /// The right stick, right positive.
    RightStickX,
    /// The right stick, away positive.
    RightStickY,
    /// The right trigger less the left one.
    Triggers,
    /// The right shoulder button less the left one.
    Shoulders,
    /// The direction pad, right positive.
    DPadX,
    /// The direction pad, up positive.
    DPadY,
    /// The left trigger alone.
    LeftTrigger,
    /// The right trigger alone.
    RightTrigger,
    /// The left shoulder button alone.
    LeftShoulder,
    /// The right shoulder button alone.
    RightShoulder,
    /// The lowest of the four buttons.
    South,
    /// The rightmost of the four buttons.
    East,
    /// The uppermost of the four buttons.
    North,
    /// The leftmost of the four buttons.
    West,
    /// The left stick, pressed.
    LeftStick,
    /// The right stick, pressed.
    RightStick,
    /// The button left of the middle.
    Select,
    /// The button right of the middle.
    Start,
}

pub(super) const MOUSE_BUTTONS: [(&str, MouseButton); 3] = [
    ("left", MouseButton::Left),
    ("right", MouseButton::Right),
    ("middle", MouseButton::Middle),
];

pub(super) const GESTURES: [(&str, Gesture); 4] = [
    ("open", Gesture::Open),
    ("point", Gesture::Point),
    ("pinch", Gesture::Pinch),
    ("grab", Gesture::Grab),
];

pub(super) const TOUCHES: [(&str, Touch); 5] = [
    ("thumb-index", Touch::Thumb(1)),
    ("thumb-middle", Touch::Thumb(2)),
    ("thumb-ring", Touch::Thumb(3)),
    ("thumb-little", Touch::Thumb(4)),
    ("other-hand", Touch::OtherHand),
];

pub(crate) const GAMEPAD_PARTS: [(&str, GamepadPart); 20] = [
    ("left-stick-x", GamepadPart::LeftStickX),
    ("left-stick-y", GamepadPart::LeftStickY),
    ("right-stick-x", GamepadPart::RightStickX),
    ("right-stick-y", GamepadPart::RightStickY),
    ("triggers", GamepadPart::Triggers),
    ("shoulders", GamepadPart::Shoulders),
    ("d-pad-x", GamepadPart::DPadX),
    ("d-pad-y", GamepadPart::DPadY),
    ("left-trigger", GamepadPart::LeftTrigger),
    ("right-trigger", GamepadPart::RightTrigger),
    ("left-shoulder", GamepadPart::LeftShoulder),
    ("right-shoulder", GamepadPart::RightShoulder),
    ("south", GamepadPart::South),
    ("east", GamepadPart::East),
    ("north", GamepadPart::North),
    ("west", GamepadPart::West),
    ("left-stick", GamepadPart::LeftStick),
    ("right-stick", GamepadPart::RightStick),
    ("select", GamepadPart::Select),
    ("start", GamepadPart::Start),
];

/// The word for `meaning` among `words`.
fn word<T: PartialEq + Copy>(words: &[(&'static str, T)], meaning: T) -> &'static str {
    let found = words.iter().find(|(_, known)| *known == meaning);
    found.map_or("?", |(word, _)| word)
}

/// The key that people call `name`: a letter, a digit, an arrow, or its code in the W3C's UI Events.
pub(super) fn key(name: &str) -> Option<Code> {
    let code = match name {
        "Left" | "Right" | "Up" | "Down" => format!("Arrow{name}"),
        "Esc" => "Escape".to_owned(),
        _ => match name.as_bytes() {
            [letter] if letter.is_ascii_alphabetic() => {
                format!("Key{}", letter.to_ascii_uppercase() as char)
            }
            [digit] if digit.is_ascii_digit() => format!("Digit{name}"),
            _ => name.to_owned(),
        },
    };
    code.parse().ok()
}

/// The shortest name that [`key`] knows a key by.
fn key_name(code: Code) -> String {
    let name = code.to_string();
    let short = |prefix| name.strip_prefix(prefix).filter(|rest| !rest.is_empty());
    let short = short("Key").or(short("Digit")).or(short("Arrow"));
    short.map_or_else(|| name.clone(), str::to_owned)
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.inverted {
            f.write_str("-")?;
        }
        match &self.part {
            Part::Key(code) => write!(f, "key {}", key_name(*code)),
            Part::Mouse(button) => write!(f, "mouse {}", word(&MOUSE_BUTTONS, *button)),
            Part::Gamepad(part) => write!(f, "gamepad {}", word(&GAMEPAD_PARTS, *part)),
            Part::Button { sensor, number } => write!(f, "{sensor} button {number}"),
            Part::Channel { sensor, number } => write!(f, "{sensor} channel {number}"),
            Part::Gesture { sensor, gesture } => {
                write!(f, "{sensor} {}", word(&GESTURES, *gesture))
            }
            Part::Touch { sensor, touch } => write!(f, "{sensor} {}", word(&TOUCHES, *touch)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_short_names_and_their_codes() {
        for (name, code, short) in [
            ("w", Code::KeyW, "W"),
            ("KeyW", Code::KeyW, "W"),
            ("7", Code::Digit7, "7"),
            ("Left", Code::ArrowLeft, "Left"),
            ("Esc", Code::Escape, "Escape"),
            ("F12", Code::F12, "F12"),
            ("Space", Code::Space, "Space"),
            ("ShiftLeft", Code::ShiftLeft, "ShiftLeft"),
        ] {
            assert_eq!(key(name), Some(code), "{name}");
            assert_eq!(key_name(code), short);
            assert_eq!(key(short), Some(code));
        }
        for none in ["", "ctrl+x", "Ä", "Keyw", "Arrow"] {
            assert_eq!(key(none), None, "{none}");
        }
    }
}
