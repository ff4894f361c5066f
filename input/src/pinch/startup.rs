//! Start-up: what is sent to the box in which order, and what it should answer.
//!
//! A plain table, so that it can be read and tested without a port. A command is two bytes, and a
//! host that comes late does not know which of them the box awaits; so it begins with single bytes
//! that end no command, until the box says that it does not understand.

use sandtable_config::{Pinch, Side};
use std::fmt;

/// One step of a start-up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// What it does, for logs and errors.
    pub what: &'static str,
    /// What is sent.
    pub command: Command,
    /// What the box should answer; `None` where any answer will do.
    pub wanted: Option<Answer>,
    /// Whether a box that answers otherwise cannot be used.
    pub required: bool,
}

/// What is sent to the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// This byte alone, again and again until the box answers.
    UntilAnswered(u8),
    /// Two bytes with a pause between them.
    Pair([u8; 2]),
}

/// What the box answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// `?`: there is no such command.
    Unknown,
    /// A number.
    Number(u32),
    /// Whether there is a glove for a hand.
    Glove {
        /// The hand.
        side: Side,
        /// Whether its glove is plugged in.
        present: bool,
    },
    /// Something else.
    Other,
}

impl Answer {
    /// What a text of the box means.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let glove = |side| Self::Glove {
            side,
            present: !text.contains("NO GLOVE"),
        };
        match text.as_bytes() {
            b"?" => Self::Unknown,
            [b'L', ..] => glove(Side::Left),
            [b'R', ..] => glove(Side::Right),
            _ => text.parse().map_or(Self::Other, Self::Number),
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => write!(f, "\"?\""),
            Self::Number(number) => write!(f, "\"{number}\""),
            Self::Glove { .. } => write!(f, "with what gloves there are"),
            Self::Other => write!(f, "with a text that is not known"),
        }
    }
}

/// The steps that take a rig's box from whatever it was doing to sending contacts.
#[must_use]
pub fn startup(pinch: &Pinch) -> Vec<Step> {
    let step = |what, command, wanted, required| Step {
        what,
        command,
        wanted,
        required,
    };
    let pair = |command: &[u8; 2]| Command::Pair(*command);
    vec![
        step(
            "to get into step",
            Command::UntilAnswered(b'*'),
            Some(Answer::Unknown),
            true,
        ),
        step(
            "to tell the time between messages, or not to",
            pair(&timestamps(pinch)),
            Some(Answer::Number(pinch.timestamps.into())),
            true,
        ),
        // Two of four known hosts do without.
        step(
            "to speak version 1",
            pair(b"V1"),
            Some(Answer::Number(1)),
            false,
        ),
        // The stream takes the number told right before the gloves for the tick's.
        step("for its timer's unit", pair(b"CT"), None, false),
        step("for the left glove", pair(b"CL"), None, false),
        step("for the right glove", pair(b"CR"), None, false),
    ]
}

/// The command that turns timestamps on or off. It changes nothing when it is sent again.
pub(super) fn timestamps(pinch: &Pinch) -> [u8; 2] {
    if pinch.timestamps { *b"T1" } else { *b"T0" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_config::{Device, Rig};

    fn sent(settings: &str) -> Vec<Step> {
        let text = format!(
            "name = 'p'\n[camera]\n[devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n{settings}"
        );
        let rig = Rig::parse(&text, "p").unwrap();
        let Device::Pinch(pinch) = &rig.devices["pinch"] else {
            panic!("it is a PINCH glove");
        };
        startup(pinch)
    }

    #[test]
    fn the_table_is_that_of_the_known_hosts() {
        let steps = sent("");
        assert_eq!(steps[0].command, Command::UntilAnswered(b'*'));
        let commands: Vec<_> = steps[1..].iter().map(|step| step.command).collect();
        let expected = [b"T0", b"V1", b"CT", b"CL", b"CR"].map(|pair| Command::Pair(*pair));
        assert_eq!(commands, expected);
        assert_eq!(steps[1].wanted, Some(Answer::Number(0)));
        let timed = sent("timestamps = true");
        assert_eq!(timed[1].command, Command::Pair(*b"T1"));
        assert_eq!(timed[1].wanted, Some(Answer::Number(1)));
        assert!(timed[1].required);
    }

    #[test]
    fn answers_are_what_they_say() {
        let glove = |side, present| Answer::Glove { side, present };
        for (text, answer) in [
            ("?", Answer::Unknown),
            ("0", Answer::Number(0)),
            ("1000", Answer::Number(1000)),
            ("L NO GLOVE", glove(Side::Left, false)),
            ("R NO GLOVE", glove(Side::Right, false)),
            ("LEFT", glove(Side::Left, true)),
            ("R", glove(Side::Right, true)),
            ("V1.0 (c) 1995", Answer::Other),
            ("99999999999", Answer::Other),
            ("", Answer::Other),
        ] {
            assert_eq!(Answer::of(text), answer, "{text:?}");
        }
    }
}
