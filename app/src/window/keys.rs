//! The keyboard: which keys are down.

use sandtable_config::KeyCode;
use std::collections::HashSet;
use winit::keyboard::KeyCode as WinitKey;

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

    /// The keys that are down, or were since the last call.
    pub(super) fn take(&mut self) -> HashSet<KeyCode> {
        let mut keys = std::mem::take(&mut self.tapped);
        keys.extend(&self.down);
        keys
    }
}

/// The key's name in the W3C's UI Events, by which rigs call it; `None` for one that has none.
pub(super) fn code(key: WinitKey) -> Option<KeyCode> {
    match key {
        WinitKey::SuperLeft => Some(KeyCode::MetaLeft),
        WinitKey::SuperRight => Some(KeyCode::MetaRight),
        // The window system's names are the W3C's for all others.
        key => format!("{key:?}").parse().ok(),
    }
}

/// Whether a key types nothing, so that it may be meant for the window even while a text field of
/// the panel has the keyboard.
pub(super) fn types_nothing(key: KeyCode) -> bool {
    let name = key.to_string();
    let number = name.strip_prefix('F').and_then(|n| n.parse::<u8>().ok());
    key == KeyCode::Tab || number.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tap_between_two_frames_drives_one_of_them() {
        let mut held = HeldKeys::default();
        held.press(KeyCode::KeyW);
        held.press(KeyCode::KeyR);
        held.release(KeyCode::KeyR);
        assert_eq!(held.take(), [KeyCode::KeyW, KeyCode::KeyR].into());
        assert_eq!(held.take(), [KeyCode::KeyW].into());
        held.clear();
        assert!(held.take().is_empty());
    }

    #[test]
    fn the_window_systems_keys_are_those_of_rigs() {
        use WinitKey as W;
        for (key, expected) in [
            (W::KeyW, KeyCode::KeyW),
            (W::Digit1, KeyCode::Digit1),
            (W::Numpad4, KeyCode::Numpad4),
            (W::ArrowLeft, KeyCode::ArrowLeft),
            (W::ShiftLeft, KeyCode::ShiftLeft),
            (W::Space, KeyCode::Space),
            (W::Escape, KeyCode::Escape),
            (W::Tab, KeyCode::Tab),
            (W::Home, KeyCode::Home),
            (W::F12, KeyCode::F12),
            (W::SuperLeft, KeyCode::MetaLeft),
            (W::NumpadAdd, KeyCode::NumpadAdd),
            (W::IntlBackslash, KeyCode::IntlBackslash),
        ] {
            assert_eq!(code(key), Some(expected), "{key:?}");
        }
    }

    #[test]
    fn every_key_of_the_default_intents_is_one_that_windows_tell() {
        use sandtable_config::{Intents, Part};
        let windows = [
            WinitKey::KeyA,
            WinitKey::KeyC,
            WinitKey::KeyD,
            WinitKey::KeyE,
            WinitKey::KeyF,
            WinitKey::KeyG,
            WinitKey::KeyH,
            WinitKey::KeyM,
            WinitKey::KeyP,
            WinitKey::KeyQ,
            WinitKey::KeyR,
            WinitKey::KeyS,
            WinitKey::KeyT,
            WinitKey::KeyV,
            WinitKey::KeyW,
            WinitKey::KeyX,
            WinitKey::Space,
            WinitKey::Tab,
            WinitKey::Home,
            WinitKey::Escape,
            WinitKey::ArrowUp,
            WinitKey::ArrowDown,
            WinitKey::ArrowLeft,
            WinitKey::ArrowRight,
            WinitKey::ShiftLeft,
            WinitKey::ShiftRight,
            WinitKey::F1,
            WinitKey::F11,
            WinitKey::F12,
            WinitKey::Digit1,
            WinitKey::Digit2,
            WinitKey::Digit3,
            WinitKey::Digit4,
            WinitKey::Numpad1,
            WinitKey::Numpad2,
            WinitKey::Numpad3,
            WinitKey::Numpad4,
        ]
        .map(|key| code(key).unwrap());
        let intents = Intents::default();
        for source in intents.iter().flat_map(|(_, sources)| sources) {
            if let Part::Key(key) = source.part {
                assert!(windows.contains(&key), "{source}");
            }
        }
    }

    #[test]
    fn function_keys_type_nothing_and_letters_do() {
        for key in [KeyCode::F1, KeyCode::F12, KeyCode::Tab] {
            assert!(types_nothing(key), "{key}");
        }
        for key in [
            KeyCode::KeyF,
            KeyCode::Digit1,
            KeyCode::Escape,
            KeyCode::Space,
        ] {
            assert!(!types_nothing(key), "{key}");
        }
    }
}
