//! Gamepads: what is pushed, and how far.

use gilrs::{Axis, Button, GamepadId, Gilrs};
use sandtable_config::GamepadPart;

/// What is pushed on a gamepad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GamepadState {
    /// The left stick: right and away positive, each from −1 to 1.
    pub left_stick: [f64; 2],
    /// The right stick, likewise.
    pub right_stick: [f64; 2],
    /// The left and the right trigger, from 0 to 1.
    pub triggers: [f64; 2],
    /// The left and the right shoulder button.
    pub shoulders: [bool; 2],
    /// The direction pad: right and up positive, −1, 0 or 1.
    pub d_pad: [f64; 2],
    /// The lowest, the rightmost, the uppermost and the leftmost of the four buttons.
    pub buttons: [bool; 4],
    /// The left and the right stick, pressed.
    pub sticks: [bool; 2],
    /// The buttons left and right of the middle.
    pub select_start: [bool; 2],
}

impl GamepadState {
    /// How far a part is pushed, from −1 to 1, with `dead` of its travel taken out around its
    /// rest. What is no number is not pushed.
    #[must_use]
    pub fn value(&self, part: GamepadPart, dead: f64) -> f64 {
        let pushed = |trigger: f64| beyond_dead_zone(trigger, dead).max(0.0);
        let pressed = |button: bool| f64::from(u8::from(button));
        match part {
            GamepadPart::LeftStickX => round_dead_zone(self.left_stick, dead)[0],
            GamepadPart::LeftStickY => round_dead_zone(self.left_stick, dead)[1],
            GamepadPart::RightStickX => round_dead_zone(self.right_stick, dead)[0],
            GamepadPart::RightStickY => round_dead_zone(self.right_stick, dead)[1],
            GamepadPart::Triggers => pushed(self.triggers[1]) - pushed(self.triggers[0]),
            GamepadPart::LeftTrigger => pushed(self.triggers[0]),
            GamepadPart::RightTrigger => pushed(self.triggers[1]),
            GamepadPart::Shoulders => pressed(self.shoulders[1]) - pressed(self.shoulders[0]),
            GamepadPart::LeftShoulder => pressed(self.shoulders[0]),
            GamepadPart::RightShoulder => pressed(self.shoulders[1]),
            GamepadPart::DPadX => finite(self.d_pad[0]),
            GamepadPart::DPadY => finite(self.d_pad[1]),
            GamepadPart::South => pressed(self.buttons[0]),
            GamepadPart::East => pressed(self.buttons[1]),
            GamepadPart::North => pressed(self.buttons[2]),
            GamepadPart::West => pressed(self.buttons[3]),
            GamepadPart::LeftStick => pressed(self.sticks[0]),
            GamepadPart::RightStick => pressed(self.sticks[1]),
            GamepadPart::Select => pressed(self.select_start[0]),
            GamepadPart::Start => pressed(self.select_start[1]),
        }
    }
}

/// A stick's place with a round dead zone taken out: rest is 0 whatever the direction, and what is
/// outside begins at 0 and still reaches 1.
fn round_dead_zone([x, y]: [f64; 2], dead: f64) -> [f64; 2] {
    let (x, y) = (finite(x), finite(y));
    let length = x.hypot(y);
    if length <= dead {
        return [0.0, 0.0];
    }
    let wanted = ((length - dead) / (1.0 - dead)).min(1.0);
    [x * wanted / length, y * wanted / length]
}

/// A value with a dead zone taken out on both sides of 0.
pub(crate) fn beyond_dead_zone(value: f64, dead: f64) -> f64 {
    let value = finite(value);
    ((value.abs() - dead) / (1.0 - dead))
        .clamp(0.0, 1.0)
        .copysign(value)
}

fn finite(value: f64) -> f64 {
    if value.is_finite() {
        value.clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

/// The gamepads that are plugged in, now or later.
#[derive(Debug)]
pub struct Gamepads {
    gilrs: Gilrs,
    /// The one that was touched last.
    active: Option<GamepadId>,
}

/// There are no gamepads to be had on this system.
#[derive(Debug, thiserror::Error)]
#[error("gamepads cannot be used ({0}); keyboard and mouse fly as well")]
pub struct GamepadError(String);

impl Gamepads {
    /// Begins to listen to gamepads; there need not be one yet.
    ///
    /// # Errors
    /// Where the system has no support for them.
    pub fn open() -> Result<Self, GamepadError> {
        match Gilrs::new() {
            Ok(gilrs) => Ok(Self {
                gilrs,
                active: None,
            }),
            Err(error) => Err(GamepadError(error.to_string())),
        }
    }

    /// What is pushed now on the gamepad touched last, or `None` where none is plugged in.
    pub fn poll(&mut self) -> Option<GamepadState> {
        while let Some(event) = self.gilrs.next_event() {
            self.active = Some(event.id);
        }
        let active = self.active.and_then(|id| self.gilrs.connected_gamepad(id));
        let pad = active.or_else(|| self.gilrs.gamepads().next().map(|(_, pad)| pad))?;
        let axis = |axis| f64::from(pad.value(axis));
        let trigger = |button| {
            pad.button_data(button)
                .map_or(0.0, |data| f64::from(data.value()))
        };
        let both = |less, more| {
            let down = |button| f64::from(u8::from(pad.is_pressed(button)));
            down(more) - down(less)
        };
        Some(GamepadState {
            left_stick: [axis(Axis::LeftStickX), axis(Axis::LeftStickY)],
            right_stick: [axis(Axis::RightStickX), axis(Axis::RightStickY)],
            triggers: [
                trigger(Button::LeftTrigger2),
                trigger(Button::RightTrigger2),
            ],
            shoulders: [
                pad.is_pressed(Button::LeftTrigger),
                pad.is_pressed(Button::RightTrigger),
            ],
            d_pad: [
                both(Button::DPadLeft, Button::DPadRight),
                both(Button::DPadDown, Button::DPadUp),
            ],
            buttons: [Button::South, Button::East, Button::North, Button::West]
                .map(|button| pad.is_pressed(button)),
            sticks: [Button::LeftThumb, Button::RightThumb].map(|button| pad.is_pressed(button)),
            select_start: [Button::Select, Button::Start].map(|button| pad.is_pressed(button)),
        })
    }

    /// The names of the gamepads that are plugged in.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let pads = self.gilrs.gamepads();
        pads.map(|(_, pad)| pad.name().to_owned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use GamepadPart::*;

    const DEAD: f64 = 0.15;

    fn left(x: f64, y: f64) -> [f64; 2] {
        let state = GamepadState {
            left_stick: [x, y],
            ..GamepadState::default()
        };
        [LeftStickX, LeftStickY].map(|part| state.value(part, DEAD))
    }

    #[test]
    fn each_part_has_its_own_value() {
        let state = GamepadState {
            left_stick: [1.0, 0.0],
            right_stick: [0.0, -1.0],
            triggers: [1.0, 0.0],
            shoulders: [false, true],
            d_pad: [-1.0, 1.0],
            buttons: [true, false, true, false],
            sticks: [true, false],
            select_start: [false, true],
        };
        for (part, value) in [
            (LeftStickX, 1.0),
            (LeftStickY, 0.0),
            (RightStickX, 0.0),
            (RightStickY, -1.0),
            (Triggers, -1.0),
            (LeftTrigger, 1.0),
            (RightTrigger, 0.0),
            (Shoulders, 1.0),
            (LeftShoulder, 0.0),
            (RightShoulder, 1.0),
            (DPadX, -1.0),
            (DPadY, 1.0),
            (South, 1.0),
            (East, 0.0),
            (North, 1.0),
            (West, 0.0),
            (LeftStick, 1.0),
            (RightStick, 0.0),
            (Select, 0.0),
            (Start, 1.0),
        ] {
            assert_eq!(state.value(part, DEAD), value, "{part:?}");
            assert_eq!(GamepadState::default().value(part, DEAD), 0.0, "{part:?}");
        }
    }

    #[test]
    fn rest_is_rest_in_every_direction() {
        for angle in 0..360 {
            let (y, x) = f64::from(angle).to_radians().sin_cos();
            assert_eq!(left(0.149 * x, 0.149 * y), [0.0; 2]);
        }
    }

    #[test]
    fn the_dead_zones_edge_is_zero_and_the_sticks_end_is_one() {
        let just_out = left(DEAD + 1e-9, 0.0)[0];
        assert!(just_out > 0.0 && just_out < 1e-6);
        assert_eq!(left(1.0, 0.0)[0], 1.0);
        // A stick pushed into its corner is no faster than one pushed straight.
        let [x, y] = left(1.0, 1.0);
        assert!((x.hypot(y) - 1.0).abs() < 1e-12);
        // More is more.
        let pushed: Vec<f64> = (0..=100)
            .map(|i| left(f64::from(i) * 0.01, 0.0)[0])
            .collect();
        assert!(pushed.is_sorted());
        let channel = |value| beyond_dead_zone(value, DEAD);
        assert_eq!(
            [channel(-1.0), channel(-0.15), channel(0.15)],
            [-1.0, 0.0, 0.0]
        );
        assert!((channel(-0.575) + 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_gamepad_that_sends_no_numbers_asks_nothing() {
        assert_eq!(left(f64::NAN, f64::INFINITY), [0.0; 2]);
        assert_eq!(beyond_dead_zone(f64::NAN, DEAD), 0.0);
    }
}
