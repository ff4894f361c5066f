//! The fingers of a glove, as rig files name them.

use crate::RigError;
use crate::fields::Value;

/// The fingers, as they are written, the thumb first.
const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

/// What `read` makes of each finger in a table, the thumb first; at least one must be there.
pub(super) fn read_fingers<T: Copy>(
    value: &Value<'_>,
    read: impl Fn(&Value<'_>) -> Result<T, RigError>,
) -> Result<[Option<T>; 5], RigError> {
    let fields = value.fields()?;
    let mut fingers = [None; 5];
    for (finger, name) in fingers.iter_mut().zip(FINGERS) {
        *finger = fields.get(name).map(|value| read(&value)).transpose()?;
    }
    fields.finish()?;
    if fingers.iter().all(Option::is_none) {
        return Err(value.error("is empty", "write at least one finger"));
    }
    Ok(fingers)
}
