//! Controls: how fast one flies, and how a gamepad's sticks are read.

use crate::fields::{Fields, Value};
use crate::intents::GAMEPAD_PARTS;
use crate::viewing::{Measure, read_measure};
use crate::{Intent, IntentKind, Part, RigError, Source};

/// How fast one flies when every stick is pushed through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// In metres a second; a share is of the ground's longer side a second.
    pub speed: Measure,
    /// In degrees a second.
    pub turn_rate: f64,
}

/// How a gamepad's sticks are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gamepad {
    /// The share of a stick's or a channel's travel around its rest that counts as rest, in
    /// [0, 0.9].
    pub dead_zone: f64,
}

impl Default for Flight {
    fn default() -> Self {
        Self {
            speed: Measure::Share(0.1),
            turn_rate: 60.0,
        }
    }
}

impl Default for Gamepad {
    fn default() -> Self {
        Self { dead_zone: 0.15 }
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

/// What drives axes of flight, in place of the gamepad's default part or of nothing.
pub(crate) type GamepadAxes = Vec<(Intent, Option<Source>)>;

/// The table `gamepad`, and what older rigs say there of single axes: their gamepad's part, or
/// none, in place of the default one.
pub(crate) fn read_gamepad(root: &Fields<'_>) -> Result<(Gamepad, GamepadAxes), RigError> {
    let mut gamepad = Gamepad::default();
    let mut axes = GamepadAxes::new();
    let Some(value) = root.get("gamepad") else {
        return Ok((gamepad, axes));
    };
    let fields = value.fields()?;
    if let Some(value) = fields.get("dead_zone") {
        gamepad.dead_zone = value.number(0.0..=0.9, "of the stick's travel")?;
    }
    let flights = Intent::ALL.into_iter();
    for intent in flights.filter(|intent| intent.kind() == IntentKind::Axis) {
        if let Some(value) = fields.get(intent.key()) {
            axes.push((intent, read_source(&value)?));
        }
    }
    fields.finish()?;
    Ok((gamepad, axes))
}

/// `left-stick-x`, `-left-stick-x` or `none`.
fn read_source(value: &Value<'_>) -> Result<Option<Source>, RigError> {
    let text = value.text("a part of the gamepad")?;
    if text == "none" {
        return Ok(None);
    }
    let (inverted, part) = match text.strip_prefix('-') {
        Some(part) => (true, part),
        None => (false, text),
    };
    let part = Part::Gamepad(value.word(part, &GAMEPAD_PARTS)?);
    Ok(Some(Source { part, inverted }))
}
