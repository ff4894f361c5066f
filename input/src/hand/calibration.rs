//! Calibration: from a bend sensor's raw values to how far a finger is bent.

/// One sensor's range of raw values, which may grow by what the sensor tells.
///
/// Ranges differ by glove, hand and day and are a small part of what a sensor could tell; so the
/// user opens and closes the hand a few times, and the lowest and highest values are the ends of
/// the scale. Until then the sensor says nothing, as noise would fill it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorCalibration {
    range: Option<[f64; 2]>,
    grows: bool,
    least: f64,
}

impl SensorCalibration {
    /// A sensor that starts from `range`, or from nothing, and says something where its range is
    /// `least` raw values wide. One whose range does not grow and that has none never does.
    #[must_use]
    pub fn new(range: Option<[f64; 2]>, grows: bool, least: f64) -> Self {
        Self {
            range,
            grows,
            least,
        }
    }

    /// Where the raw value is in the range, from 0, the lowest, to 1; beyond it, its end. `None`
    /// while the range is too narrow.
    pub fn scaled(&mut self, raw: f64) -> Option<f64> {
        if self.grows && raw.is_finite() {
            let [lowest, highest] = self.range.unwrap_or([raw, raw]);
            self.range = Some([lowest.min(raw), highest.max(raw)]);
        }
        let [lowest, highest] = self.range?;
        let width = highest - lowest;
        // A width of 0 has no scale, whatever the least one is.
        (width > 0.0 && width >= self.least).then(|| ((raw - lowest) / width).clamp(0.0, 1.0))
    }

    /// The lowest and the highest raw value, if there were any.
    #[must_use]
    pub fn range(&self) -> Option<[f64; 2]> {
        self.range
    }

    /// Forgets its range, so that it learns it anew; one that does not grow keeps it.
    pub fn reset(&mut self) {
        if self.grows {
            self.range = None;
        }
    }

    /// The ranges of `sensors` as an array of a rig file, or `None` where one has none.
    pub(crate) fn in_the_rigs_words(sensors: &[Self]) -> Option<String> {
        let pair = |sensor: &Self| {
            let [lowest, highest] = sensor.range?;
            (lowest < highest).then(|| format!("[{lowest}, {highest}]"))
        };
        let pairs: Option<Vec<String>> = sensors.iter().map(pair).collect();
        Some(format!("[{}]", pairs?.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_range_grows_by_what_comes_and_is_a_scale_once_it_is_wide_enough() {
        let mut sensor = SensorCalibration::new(None, true, 41.0);
        assert_eq!(sensor.scaled(1000.0), None);
        assert_eq!(sensor.scaled(1040.0), None);
        assert_eq!(sensor.scaled(1041.0), Some(1.0));
        assert_eq!(sensor.scaled(1020.5), Some(0.5));
        assert_eq!(sensor.scaled(918.0), Some(0.0));
        assert_eq!(sensor.range(), Some([918.0, 1041.0]));
        sensor.reset();
        assert_eq!(sensor.scaled(1000.0), None);
    }

    #[test]
    fn a_range_of_the_rig_is_a_scale_from_the_start() {
        let rig = Some([400.0, 3600.0]);
        let mut grows = SensorCalibration::new(rig, true, 41.0);
        assert_eq!(grows.scaled(3000.0), Some(0.8125));
        assert_eq!(grows.scaled(4000.0), Some(1.0));
        assert_eq!(grows.range(), Some([400.0, 4000.0]));
        let mut fixed = SensorCalibration::new(rig, false, 41.0);
        assert_eq!(fixed.scaled(4000.0), Some(1.0));
        assert_eq!(fixed.scaled(0.0), Some(0.0));
        fixed.reset();
        assert_eq!(fixed.range(), rig);
        let both = [fixed, SensorCalibration::new(Some([1.5, 2.0]), true, 0.0)];
        let text = SensorCalibration::in_the_rigs_words(&both);
        assert_eq!(text.as_deref(), Some("[[400, 3600], [1.5, 2]]"));
        let unknown = SensorCalibration::new(None, true, 0.0);
        assert_eq!(
            SensorCalibration::in_the_rigs_words(&[fixed, unknown]),
            None
        );
    }

    proptest! {
        #[test]
        fn a_scaled_value_is_from_0_to_1(
            raw in prop::collection::vec(prop_oneof![any::<f64>(), 0.0..4096.0], 0..50),
            least in 0.0..100.0,
        ) {
            let mut sensor = SensorCalibration::new(None, true, least);
            for raw in raw.into_iter().filter(|raw| raw.is_finite()) {
                if let Some(scaled) = sensor.scaled(raw) {
                    prop_assert!((0.0..=1.0).contains(&scaled), "{scaled}");
                }
            }
        }
    }
}
