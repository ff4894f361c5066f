//! Glides: values that follow their targets without a click.

/// A value that follows its target, sample by sample, with neither a step nor a kink.
///
/// Two one-pole low-passes in a row: after a jump of the target, value and slope are continuous.
/// One pole alone would leave a kink that is heard as a faint tick.
#[derive(Clone, Debug)]
pub(crate) struct Glide {
    share: f64,
    target: f64,
    first: f64,
    value: f64,
}

/// Nearer than this to its target a glide has arrived: −120 dB, far below the loudest click allowed.
const ARRIVED: f64 = 1e-6;

impl Glide {
    /// A glide at rest at zero; `time_constant` in seconds, `sample_rate` in hertz.
    pub(crate) fn new(time_constant: f64, sample_rate: f64) -> Self {
        Self {
            share: 1.0 - (-1.0 / (time_constant * sample_rate)).exp(),
            target: 0.0,
            first: 0.0,
            value: 0.0,
        }
    }

    /// Sets the value to glide to; one that is not finite is ignored.
    pub(crate) fn set_target(&mut self, target: f64) {
        if target.is_finite() {
            self.target = target;
        }
    }

    /// The value one sample later.
    pub(crate) fn advance(&mut self) -> f64 {
        let near = |a: f64| (self.target - a).abs() < ARRIVED;
        if near(self.first) && near(self.value) {
            // Exactly there: silence is zero and costs no denormal numbers.
            (self.first, self.value) = (self.target, self.target);
        } else {
            self.first += self.share * (self.target - self.first);
            self.value += self.share * (self.first - self.value);
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_leaves_neither_step_nor_kink_and_arrives() {
        let mut glide = Glide::new(0.01, 48_000.0);
        let (mut value, mut slope) = (0.0, 0.0);
        glide.set_target(1.0);
        for _ in 0..48_000 {
            let next = glide.advance();
            assert!(next >= value, "no overshoot");
            assert!((next - value).abs() < 1e-3);
            assert!((next - value - slope).abs() < 1e-5);
            (value, slope) = (next, next - value);
        }
        assert_eq!(value, 1.0);
    }

    #[test]
    fn targets_that_are_no_numbers_are_ignored() {
        let mut glide = Glide::new(0.01, 48_000.0);
        glide.set_target(0.5);
        glide.set_target(f64::NAN);
        glide.set_target(f64::INFINITY);
        assert_eq!((0..48_000).map(|_| glide.advance()).last(), Some(0.5));
    }
}
