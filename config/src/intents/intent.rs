//! Intents: what people can mean, whatever they mean it with.

/// Something that people can ask the table for, beside looking and reaching, which heads and hands
/// do by being somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Intent {
    /// Fly sideways, right positive.
    Right,
    /// Fly forward.
    Forward,
    /// Fly up; over a table, show more of the world.
    Up,
    /// Turn the heading, clockwise seen from above positive.
    Yaw,
    /// Raise the nose; over a table, raise the glass through the relief.
    Pitch,
    /// Roll the right wing down; over a table, exaggerate the relief.
    Roll,
    /// Do what the hand's mode says: grab, fly or point.
    Act,
    /// Hold the world.
    Grab,
    /// Fly by where the hand goes from where it began.
    Fly,
    /// Point at the ground.
    Point,
    /// Fly faster.
    Faster,
    /// Let the mouse move the head.
    MoveHead,
    /// Let the mouse raise and turn the hand.
    MoveHand,
    /// Take the hand's next mode.
    NextMode,
    /// Show or hide the panel.
    Menu,
    /// Go back to where it began.
    Home,
    /// Cast by the next caster.
    NextCaster,
    /// Show one eye.
    Mono,
    /// Show the eyes side by side.
    SideBySide,
    /// Show the left eye above the right one.
    TopBottom,
    /// Show the eyes in red and cyan.
    Anaglyph,
    /// Let each eye see the other's picture.
    SwapEyes,
    /// Fill the screen, or leave it.
    FullScreen,
    /// Write the picture to a file.
    Screenshot,
    /// End the program.
    Quit,
}

/// How an intent is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntentKind {
    /// By how far something is pushed, from −1 to 1.
    Axis,
    /// For as long as something is held.
    Hold,
    /// Once, when something begins.
    Command,
}

impl Intent {
    /// All of them, in the order in which they are told.
    pub const ALL: [Self; 25] = [
        Self::Forward,
        Self::Right,
        Self::Up,
        Self::Yaw,
        Self::Pitch,
        Self::Roll,
        Self::Faster,
        Self::Act,
        Self::NextMode,
        Self::Grab,
        Self::Fly,
        Self::Point,
        Self::MoveHead,
        Self::MoveHand,
        Self::Home,
        Self::Menu,
        Self::NextCaster,
        Self::Mono,
        Self::SideBySide,
        Self::TopBottom,
        Self::Anaglyph,
        Self::SwapEyes,
        Self::FullScreen,
        Self::Screenshot,
        Self::Quit,
    ];

    /// Its key in a rig's `[intents]`.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Forward => "forward",
            Self::Up => "up",
            Self::Yaw => "yaw",
            Self::Pitch => "pitch",
            Self::Roll => "roll",
            Self::Act => "act",
            Self::Grab => "grab",
            Self::Fly => "fly",
            Self::Point => "point",
            Self::Faster => "faster",
            Self::MoveHead => "move_head",
            Self::MoveHand => "move_hand",
            Self::NextMode => "next_mode",
            Self::Menu => "menu",
            Self::Home => "home",
            Self::NextCaster => "next_caster",
            Self::Mono => "mono",
            Self::SideBySide => "side_by_side",
            Self::TopBottom => "top_bottom",
            Self::Anaglyph => "anaglyph",
            Self::SwapEyes => "swap_eyes",
            Self::FullScreen => "full_screen",
            Self::Screenshot => "screenshot",
            Self::Quit => "quit",
        }
    }

    /// What it does, for people.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Right => "right, left",
            Self::Forward => "forward, back",
            Self::Up => "up, down",
            Self::Yaw => "turn right, left",
            Self::Pitch => "nose up, down",
            Self::Roll => "roll right, left",
            Self::Act => "act: grab, fly or point by the hand's mode",
            Self::Grab => "grab the world",
            Self::Fly => "fly with the hand",
            Self::Point => "point at the ground",
            Self::Faster => "faster",
            Self::MoveHead => "mouse moves the head, wheel raises it",
            Self::MoveHand => "mouse raises and turns the hand",
            Self::NextMode => "next mode of the hand",
            Self::Menu => "show or hide the panel",
            Self::Home => "back to the start",
            Self::NextCaster => "next caster",
            Self::Mono => "one eye",
            Self::SideBySide => "side by side",
            Self::TopBottom => "top and bottom",
            Self::Anaglyph => "anaglyph",
            Self::SwapEyes => "swap the eyes",
            Self::FullScreen => "full screen",
            Self::Screenshot => "screenshot",
            Self::Quit => "quit",
        }
    }

    /// How it is asked for.
    #[must_use]
    pub fn kind(self) -> IntentKind {
        match self {
            Self::Right | Self::Forward | Self::Up | Self::Yaw | Self::Pitch | Self::Roll => {
                IntentKind::Axis
            }
            Self::Act
            | Self::Grab
            | Self::Fly
            | Self::Point
            | Self::Faster
            | Self::MoveHead
            | Self::MoveHand => IntentKind::Hold,
            _ => IntentKind::Command,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_intent_is_there_once_under_its_own_key() {
        let all: BTreeSet<_> = Intent::ALL.into_iter().collect();
        let keys: BTreeSet<_> = Intent::ALL.map(Intent::key).into();
        assert_eq!([all.len(), keys.len()], [Intent::ALL.len(); 2]);
    }
}
