//! Controls: how fast one flies, and what the gamepad's sticks mean.

use crate::RigError;
use crate::fields::{Fields, Value};
use crate::viewing::{Measure, read_measure};

/// How fast one flies when every stick is pushed through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// In metres a second; a share is of the ground's longer side a second.
    pub speed: Measure,
    /// In degrees a second.
    pub turn_rate: f64,
}

/// A part of a gamepad that gives a number from −1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GamepadAxis {
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
}

/// What drives one axis of flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GamepadSource {
    /// The part of the gamepad.
    pub axis: GamepadAxis,
    /// Whether its sign is turned.
    pub inverted: bool,
}

/// What drives each axis of flight; none where nothing does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GamepadAxes {
    /// Sideways.
    pub right: Option<GamepadSource>,
    /// Forward.
    pub forward: Option<GamepadSource>,
    /// Up.
    pub up: Option<GamepadSource>,
    /// The heading, clockwise seen from above.
    pub yaw: Option<GamepadSource>,
    /// Nose up.
    pub pitch: Option<GamepadSource>,
    /// Right wing down.
    pub roll: Option<GamepadSource>,
}

/// How a gamepad flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GamepadMapping {
    /// The share of a stick's travel around its rest that counts as rest, in [0, 0.9].
    pub dead_zone: f64,
    /// What drives each axis of flight.
    pub axes: GamepadAxes,
}

impl Default for Flight {
    fn default() -> Self {
        Self {
            speed: Measure::Share(0.1),
            turn_rate: 60.0,
        }
    }
}

impl Default for GamepadMapping {
    fn default() -> Self {
        let plain = |axis| {
            Some(GamepadSource {
                axis,
                inverted: false,
            })
        };
        Self {
            dead_zone: 0.15,
            axes: GamepadAxes {
                right: plain(GamepadAxis::LeftStickX),
                forward: plain(GamepadAxis::LeftStickY),
                up: plain(GamepadAxis::Triggers),
                yaw: plain(GamepadAxis::RightStickX),
                pitch: plain(GamepadAxis::RightStickY),
                roll: plain(GamepadAxis::Shoulders),
            },
        }
    }
}

pub(crate) fn read_flight(root: &Fields<'_>) -> Result<Flight, RigError> {
    let mut flight = Flight::default();
    if let Some(value) = root.get("flight") {
        let fields = value.fields()?;
        if let Some(value) = fields.get("speed") {
            flight.speed = read_measure(&value, 1e-3..=1e6, 1e-6..=10.0)?;
        }
        if let Some(value) = fields.get("turn_rate") {
            flight.turn_rate = value.number(1.0..=720.0, "degrees a second")?;
        }
        fields.finish()?;
    }
    Ok(flight)
}

pub(crate) fn read_gamepad(root: &Fields<'_>) -> Result<GamepadMapping, RigError> {
    let mut mapping = GamepadMapping::default();
    let Some(value) = root.get("gamepad") else {
        return Ok(mapping);
    };
    let fields = value.fields()?;
    if let Some(value) = fields.get("dead_zone") {
        mapping.dead_zone = value.number(0.0..=0.9, "of the stick's travel")?;
    }
    for (key, source) in [
        ("right", &mut mapping.axes.right),
        ("forward", &mut mapping.axes.forward),
        ("up", &mut mapping.axes.up),
        ("yaw", &mut mapping.axes.yaw),
        ("pitch", &mut mapping.axes.pitch),
        ("roll", &mut mapping.axes.roll),
    ] {
        if let Some(value) = fields.get(key) {
            *source = read_source(&value)?;
        }
    }
    fields.finish()?;
    Ok(mapping)
}

/// `left-stick-x`, `-left-stick-x` or `none`.
fn read_source(value: &Value<'_>) -> Result<Option<GamepadSource>, RigError> {
    const AXES: [(&str, GamepadAxis); 8] = [
        ("left-stick-x", GamepadAxis::LeftStickX),
        ("left-stick-y", GamepadAxis::LeftStickY),
        ("right-stick-x", GamepadAxis::RightStickX),
        ("right-stick-y", GamepadAxis::RightStickY),
        ("triggers", GamepadAxis::Triggers),
        ("shoulders", GamepadAxis::Shoulders),
        ("d-pad-x", GamepadAxis::DPadX),
        ("d-pad-y", GamepadAxis::DPadY),
    ];
    let text = value.text("a part of the gamepad")?;
    if text == "none" {
        return Ok(None);
    }
    if let Some(part) = text.strip_prefix('-')
        && let Some((_, axis)) = AXES.iter().find(|(name, _)| *name == part)
    {
        return Ok(Some(GamepadSource {
            axis: *axis,
            inverted: true,
        }));
    }
    Ok(Some(GamepadSource {
        axis: value.choice(&AXES)?,
        inverted: false,
    }))
}
