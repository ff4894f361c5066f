//! Gamepads: what is pushed how far, and what that asks of the flight.

use crate::FlightAxes;
use gilrs::{Axis, Button, GamepadId, Gilrs};
use sandtable_config::{GamepadAxis, GamepadMapping, GamepadSource};

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
}

/// What the sticks ask of the flight. A state without numbers asks nothing.
#[must_use]
pub fn map_gamepad(state: &GamepadState, mapping: &GamepadMapping) -> FlightAxes {
    let dead = mapping.dead_zone;
    let [left_x, left_y] = round_dead_zone(state.left_stick, dead);
    let [right_x, right_y] = round_dead_zone(state.right_stick, dead);
    let [left_trigger, right_trigger] = state.triggers.map(|t| straight_dead_zone(t, dead));
    let [left_shoulder, right_shoulder] = state.shoulders.map(|down| f64::from(u8::from(down)));
    let [d_pad_x, d_pad_y] = state.d_pad.map(finite);
    let value = |source: Option<GamepadSource>| {
        let Some(GamepadSource { axis, inverted }) = source else {
            return 0.0;
        };
        let value = match axis {
            GamepadAxis::LeftStickX => left_x,
            GamepadAxis::LeftStickY => left_y,
            GamepadAxis::RightStickX => right_x,
            GamepadAxis::RightStickY => right_y,
            GamepadAxis::Triggers => right_trigger - left_trigger,
            GamepadAxis::Shoulders => right_shoulder - left_shoulder,
            GamepadAxis::DPadX => d_pad_x,
            GamepadAxis::DPadY => d_pad_y,
        };
        if inverted { -value } else { value }
    };
    let axes = mapping.axes;
    FlightAxes {
        right: value(axes.right),
        forward: value(axes.forward),
        up: value(axes.up),
        yaw: value(axes.yaw),
        pitch: value(axes.pitch),
        roll: value(axes.roll),
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

fn straight_dead_zone(value: f64, dead: f64) -> f64 {
    ((finite(value) - dead) / (1.0 - dead)).clamp(0.0, 1.0)
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

    fn left(x: f64, y: f64) -> FlightAxes {
        let state = GamepadState {
            left_stick: [x, y],
            ..GamepadState::default()
        };
        map_gamepad(&state, &GamepadMapping::default())
    }

    #[test]
    fn each_part_asks_for_its_own_axis() {
        let state = GamepadState {
            left_stick: [1.0, 0.0],
            right_stick: [0.0, -1.0],
            triggers: [0.0, 1.0],
            shoulders: [true, false],
            d_pad: [0.0, 0.0],
        };
        let axes = map_gamepad(&state, &GamepadMapping::default());
        assert_eq!((axes.right, axes.forward), (1.0, 0.0));
        assert_eq!((axes.yaw, axes.pitch), (0.0, -1.0));
        assert_eq!((axes.up, axes.roll), (1.0, -1.0));
    }

    #[test]
    fn rest_is_rest_in_every_direction() {
        for angle in 0..360 {
            let (y, x) = f64::from(angle).to_radians().sin_cos();
            assert_eq!(left(0.149 * x, 0.149 * y), FlightAxes::default());
        }
        assert_eq!(
            map_gamepad(&GamepadState::default(), &GamepadMapping::default()),
            FlightAxes::default()
        );
    }

    #[test]
    fn the_dead_zones_edge_is_zero_and_the_sticks_end_is_one() {
        let just_out = left(0.15 + 1e-9, 0.0).right;
        assert!(just_out > 0.0 && just_out < 1e-6);
        assert_eq!(left(1.0, 0.0).right, 1.0);
        // A stick pushed into its corner is no faster than one pushed straight.
        let corner = left(1.0, 1.0);
        assert!((corner.right.hypot(corner.forward) - 1.0).abs() < 1e-12);
        // More is more.
        let pushed: Vec<f64> = (0..=100)
            .map(|i| left(f64::from(i) * 0.01, 0.0).right)
            .collect();
        assert!(pushed.is_sorted());
    }

    #[test]
    fn signs_turn_and_parts_can_be_left_out() {
        let rig = "name = 'g'\n[camera]\n[gamepad]\nforward = '-left-stick-y'\nright = 'none'\n";
        let mapping = sandtable_config::Rig::parse(rig, "g").unwrap().gamepad;
        let state = GamepadState {
            left_stick: [0.6, 0.6],
            ..GamepadState::default()
        };
        let axes = map_gamepad(&state, &mapping);
        assert!(axes.forward < -0.5 && axes.right == 0.0);
    }

    #[test]
    fn a_gamepad_that_sends_no_numbers_asks_nothing() {
        assert_eq!(left(f64::NAN, f64::INFINITY), FlightAxes::default());
    }
}
