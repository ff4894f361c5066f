//! A finger with one bend sensor, as the rig describes it.

use super::SensorCalibration;
use crate::Flexion;

/// A finger whose both joints one sensor measures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BentFinger {
    inverted: bool,
    calibration: SensorCalibration,
}

/// The fingers, as the rig writes them.
const NAMES: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

impl BentFinger {
    /// A finger whose raw value is less the further it is bent, if it is `inverted`.
    pub(crate) fn new(inverted: bool, calibration: SensorCalibration) -> Self {
        Self {
            inverted,
            calibration,
        }
    }

    /// How far it is bent; `None` while its range is too narrow.
    pub(crate) fn flexion(&mut self, raw: f64) -> Option<Flexion> {
        let scaled = self.calibration.scaled(raw)?;
        let bent = if self.inverted { 1.0 - scaled } else { scaled };
        Some(Flexion::of_one_sensor(bent))
    }

    /// Forgets the range that it has learnt.
    pub(crate) fn reset(&mut self) {
        self.calibration.reset();
    }

    /// The ranges of a hand's fingers, the thumb first, in words; `None` where none is known.
    pub(crate) fn ranges(fingers: [Option<&Self>; 5]) -> Option<String> {
        let ranges = fingers.iter().zip(NAMES).filter_map(|(finger, name)| {
            let [lowest, highest] = finger.as_ref()?.calibration.range()?;
            Some(format!("{name} range = [{lowest}, {highest}]"))
        });
        let ranges: Vec<String> = ranges.collect();
        (!ranges.is_empty()).then(|| ranges.join(", "))
    }
}
