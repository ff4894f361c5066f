//! Keys: which are held, and what each does.

use sandtable_input::FlightAxes;
use sandtable_stage::StereoMode;
use std::collections::HashSet;
use winit::keyboard::KeyCode;

/// How many times as fast Shift makes a flight.
const BOOST: f64 = 5.0;

/// What the keys do, for the panel: keys, then meaning.
pub(super) const HELP: [(&str, &str); 16] = [
    ("W S", "forward, back"),
    ("A D", "left, right"),
    ("R F", "up, down"),
    ("Left Right", "turn left, right"),
    ("Up Down", "nose up, down"),
    ("Q E", "roll left, right"),
    ("Shift", "faster"),
    ("mouse", "drag turns, wheel changes the speed"),
    ("Home", "back to the start"),
    ("1 2 3 4", "mono, side by side, top-bottom, anaglyph"),
    ("X", "swap the eyes"),
    ("C", "next caster"),
    ("F1 Tab", "hide or show the panel"),
    ("F11", "full screen"),
    ("F12", "screenshot"),
    ("Esc", "quit"),
];

/// What a key does once, when it goes down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    Quit,
    TogglePanel,
    FullScreen,
    Screenshot,
    Home,
    SwapEyes,
    Stereo(StereoMode),
    NextCaster,
}

impl Command {
    /// The command of `key`, if it has one.
    pub(super) fn of(key: KeyCode) -> Option<Self> {
        Some(match key {
            KeyCode::Escape => Self::Quit,
            KeyCode::F1 | KeyCode::Tab => Self::TogglePanel,
            KeyCode::F11 => Self::FullScreen,
            KeyCode::F12 => Self::Screenshot,
            KeyCode::Home => Self::Home,
            KeyCode::KeyX => Self::SwapEyes,
            KeyCode::KeyC => Self::NextCaster,
            KeyCode::Digit1 | KeyCode::Numpad1 => Self::Stereo(StereoMode::Mono),
            KeyCode::Digit2 | KeyCode::Numpad2 => Self::Stereo(StereoMode::SideBySide),
            KeyCode::Digit3 | KeyCode::Numpad3 => Self::Stereo(StereoMode::TopBottom),
            KeyCode::Digit4 | KeyCode::Numpad4 => Self::Stereo(StereoMode::Anaglyph),
            _ => return None,
        })
    }

    /// Whether it works even while a text field of the panel has the keyboard.
    pub(super) fn above_panel(self) -> bool {
        matches!(
            self,
            Self::TogglePanel | Self::FullScreen | Self::Screenshot
        )
    }
}

/// The keys that are down. Keys are places on the keyboard, whatever is printed on them.
#[derive(Clone, Debug, Default)]
pub(super) struct HeldKeys {
    down: HashSet<KeyCode>,
    /// Pressed since the last frame, so that a short tap counts for one.
    tapped: HashSet<KeyCode>,
}

impl HeldKeys {
    pub(super) fn press(&mut self, key: KeyCode) {
        self.down.insert(key);
        self.tapped.insert(key);
    }

    pub(super) fn release(&mut self, key: KeyCode) {
        self.down.remove(&key);
    }

    /// Forgets all keys, as when the window loses the keyboard: releases are not reported then.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// A frame was driven by what they ask for.
    pub(super) fn used(&mut self) {
        self.tapped.clear();
    }

    fn contains(&self, key: KeyCode) -> bool {
        self.down.contains(&key) || self.tapped.contains(&key)
    }

    /// The flight that they ask for.
    pub(super) fn axes(&self) -> FlightAxes {
        use KeyCode::*;
        let axis = |more, less| {
            f64::from(u8::from(self.contains(more))) - f64::from(u8::from(self.contains(less)))
        };
        FlightAxes {
            right: axis(KeyD, KeyA),
            forward: axis(KeyW, KeyS),
            up: axis(KeyR, KeyF),
            yaw: axis(ArrowRight, ArrowLeft),
            pitch: axis(ArrowUp, ArrowDown),
            roll: axis(KeyE, KeyQ),
        }
    }

    /// How many times as fast as usual.
    pub(super) fn boost(&self) -> f64 {
        let shift = [KeyCode::ShiftLeft, KeyCode::ShiftRight];
        if shift.iter().any(|key| self.contains(*key)) {
            BOOST
        } else {
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_keys_are_axes_and_opposites_cancel() {
        let mut held = HeldKeys::default();
        for key in [
            KeyCode::KeyW,
            KeyCode::KeyE,
            KeyCode::ArrowLeft,
            KeyCode::ShiftRight,
        ] {
            held.press(key);
            held.press(key);
        }
        let expected = FlightAxes {
            forward: 1.0,
            roll: 1.0,
            yaw: -1.0,
            ..Default::default()
        };
        assert_eq!((held.axes(), held.boost()), (expected, BOOST));
        held.press(KeyCode::KeyS);
        held.press(KeyCode::KeyQ);
        held.release(KeyCode::ArrowLeft);
        held.used();
        assert_eq!(held.axes(), FlightAxes::default());
        held.clear();
        assert_eq!(held.boost(), 1.0);
    }

    #[test]
    fn a_tap_between_two_frames_drives_one_of_them() {
        let mut held = HeldKeys::default();
        held.press(KeyCode::KeyR);
        held.release(KeyCode::KeyR);
        assert_eq!(held.axes().up, 1.0);
        held.used();
        assert_eq!(held.axes().up, 0.0);
    }

    #[test]
    fn flight_keys_are_no_commands() {
        use KeyCode::*;
        for key in [
            KeyW, KeyS, KeyA, KeyD, KeyR, KeyF, KeyQ, KeyE, ArrowUp, ArrowDown, ArrowLeft,
            ArrowRight, ShiftLeft,
        ] {
            assert_eq!(Command::of(key), None);
        }
    }

    #[test]
    fn every_stereo_mode_has_its_key() {
        let keys = [
            KeyCode::Digit1,
            KeyCode::Digit2,
            KeyCode::Digit3,
            KeyCode::Digit4,
        ];
        for (key, mode) in keys.into_iter().zip(StereoMode::ALL) {
            assert_eq!(Command::of(key), Some(Command::Stereo(mode)));
        }
    }
}
