//! What a glove's fingers mean: thresholds and times of gestures.

use crate::RigError;
use crate::fields::Fields;
use std::time::Duration;

/// When a finger counts as closed or open, and how long a gesture must last to count.
#[derive(Clone, Debug, PartialEq)]
pub struct Gestures {
    /// A finger bent further than this is closed: 0 is straight, 1 as far as it goes. Without a
    /// word in the rig, 0.6.
    pub closed_above: f64,
    /// A finger bent less than this is open; between the two it stays what it was. Without a word
    /// in the rig, 0.4.
    pub open_below: f64,
    /// How long a gesture must last before it counts, so that neither a finger on its way nor a
    /// contact that bounces is one. Without a word in the rig, 50 ms.
    pub settle: Duration,
}

impl Default for Gestures {
    fn default() -> Self {
        Self {
            closed_above: 0.6,
            open_below: 0.4,
            settle: Duration::from_millis(50),
        }
    }
}

/// The table `gestures` of a glove, or the defaults where there is none.
pub(super) fn read_gestures(device: &Fields<'_>) -> Result<Gestures, RigError> {
    let Some(value) = device.get("gestures") else {
        return Ok(Gestures::default());
    };
    let fields = value.fields()?;
    let default = Gestures::default();
    let share = |key: &str, default| match fields.get(key) {
        Some(value) => value.number(0.0..=1.0, "of a finger's range"),
        None => Ok(default),
    };
    let gestures = Gestures {
        closed_above: share("closed_above", default.closed_above)?,
        open_below: share("open_below", default.open_below)?,
        settle: fields.seconds("settle", default.settle.as_secs_f64(), 0.0..=2.0)?,
    };
    if gestures.open_below > gestures.closed_above {
        return Err(fields.error(
            "open_below",
            "is more than `closed_above`",
            "write at most as much: a finger is not open and closed at once",
        ));
    }
    fields.finish()?;
    Ok(gestures)
}
