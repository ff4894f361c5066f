//! What a measurement must be before it is counted with: finite, within reach, a rotation.

use crate::{CalibrationError, Item, Items};
use glam::{DQuat, DVec3};
use sandtable_pose::Rigid;

/// The farthest that any place may be from its frame's origin, in metres: more than a magnetic
/// tracker reaches, and little enough for squares of it to stay exact.
pub(crate) const REACH: f64 = 100.0;

/// How far a quaternion's length may be from 1: rounded to four places it still passes.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Whether there are at least `needed` and at most `most` of them.
pub(crate) fn count(
    of: Items,
    found: usize,
    needed: usize,
    most: usize,
) -> Result<(), CalibrationError> {
    if found < needed {
        return Err(CalibrationError::TooFew { of, found, needed });
    }
    if found > most {
        return Err(CalibrationError::TooMany { of, found, most });
    }
    Ok(())
}

/// Whether a place is finite and within [`REACH`].
pub(crate) fn place(item: Item, part: &'static str, at: DVec3) -> Result<(), CalibrationError> {
    if !at.is_finite() {
        return Err(CalibrationError::NotFinite { item, part });
    }
    let farthest = at.abs().max_element();
    if farthest > REACH {
        return Err(CalibrationError::OutOfReach {
            item,
            part,
            metres: farthest,
            limit: REACH,
        });
    }
    Ok(())
}

/// The pose with a rotation of length 1 to the last bit, where it is a pose at all.
pub(crate) fn pose(item: Item, pose: &Rigid) -> Result<Rigid, CalibrationError> {
    place(item, "the position", pose.translation)?;
    let rotation: DQuat = pose.rotation;
    if !rotation.is_finite() {
        return Err(CalibrationError::NotFinite {
            item,
            part: "the attitude",
        });
    }
    let length = rotation.length();
    if (length - 1.0).abs() > UNIT_TOLERANCE {
        return Err(CalibrationError::NoRotation { item, length });
    }
    Ok(Rigid::new(rotation.normalize(), pose.translation))
}
