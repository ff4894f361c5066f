//! Voices: what the source sounds like, before distance and direction.

use std::f64::consts::TAU;

/// Amplitude of a voice at its loudest: with the strongest wind it still stays in full scale.
const LOUDEST: f64 = 0.5;
/// A beacon's stroke sets in over this time, in seconds: sudden to the ear, yet without a click.
const ONSET_S: f64 = 0.003;
/// A struck bar's partials: frequency ratio and share of the amplitude.
const PARTIALS: [(f64, f64); 3] = [(1.0, 0.6), (2.756, 0.25), (5.404, 0.15)];

/// What the source sounds like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Voice {
    /// A steady sine: for measuring, and for finding which loudspeaker is which.
    Tone {
        /// Hertz.
        frequency: f64,
    },
    /// A chime struck again and again: its onsets and overtones are easier to place than a tone.
    Beacon {
        /// Of the lowest partial, hertz.
        frequency: f64,
        /// From stroke to stroke, seconds.
        period: f64,
    },
}

impl Default for Voice {
    /// A beacon at 440 Hz, struck every 1.5 s.
    fn default() -> Self {
        Self::Beacon {
            frequency: 440.0,
            period: 1.5,
        }
    }
}

/// A voice being played.
#[derive(Clone, Debug)]
pub(crate) struct Speaker {
    voice: Voice,
    sample_rate: f64,
    /// Each partial's phase, in turns.
    phases: [f64; PARTIALS.len()],
    /// Since the last stroke, seconds.
    since_stroke: f64,
}

impl Speaker {
    pub(crate) fn new(voice: Voice, sample_rate: f64) -> Self {
        Self {
            voice,
            sample_rate,
            phases: [0.0; PARTIALS.len()],
            since_stroke: 0.0,
        }
    }

    /// The next sample, within [`LOUDEST`].
    pub(crate) fn sample(&mut self) -> f64 {
        match self.voice {
            Voice::Tone { frequency } => LOUDEST * self.partial(0, frequency),
            Voice::Beacon { frequency, period } => {
                let sum: f64 = (0..PARTIALS.len())
                    .map(|i| PARTIALS[i].1 * self.partial(i, frequency * PARTIALS[i].0))
                    .sum();
                LOUDEST * self.stroke(period) * sum
            }
        }
    }

    /// One partial's next sample; silent where the sample rate cannot hold it.
    fn partial(&mut self, index: usize, frequency: f64) -> f64 {
        if !(0.0..0.45 * self.sample_rate).contains(&frequency) {
            return 0.0;
        }
        let phase = &mut self.phases[index];
        let sample = (*phase * TAU).sin();
        *phase = (*phase + frequency / self.sample_rate).fract();
        sample
    }

    /// A stroke's envelope: starts and ends at zero without a kink.
    fn stroke(&mut self, period: f64) -> f64 {
        let t = self.since_stroke;
        let left = (1.0 - t / period).max(0.0);
        self.since_stroke += 1.0 / self.sample_rate;
        if self.since_stroke >= period {
            self.since_stroke = 0.0;
        }
        let onset = 1.0 - (-t / ONSET_S).exp();
        onset * onset * (-5.0 * t / period).exp() * left * left
    }
}
