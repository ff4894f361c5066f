//! What of a photograph's 16-bit values is shown: cameras use a part of their range only.

use super::Pixel;

/// Shares of all samples that may be clipped at each end.
const CLIPPED: f64 = 0.002;

/// Counts of a photograph's 16-bit values.
pub(super) struct Counts(Vec<u64>);

impl Counts {
    pub(super) fn new() -> Self {
        Self(vec![0; 1 << 16])
    }

    pub(super) fn add(&mut self, value: u16) {
        self.0[usize::from(value)] += 1;
    }

    /// The range that holds nearly all values; all of it where there are none.
    pub(super) fn stretch(&self) -> Stretch {
        if self.0.iter().all(|&count| count == 0) {
            return Stretch {
                low: 0,
                high: u16::MAX,
            };
        }
        let clipped = (self.0.iter().sum::<u64>() as f64 * CLIPPED) as u64;
        // One value below the highest at least, so that the range is never empty.
        let low = value_beyond(self.0.iter().enumerate(), clipped).min(u16::MAX - 1);
        let high = value_beyond(self.0.iter().enumerate().rev(), clipped);
        Stretch {
            low,
            high: high.max(low + 1),
        }
    }
}

/// The first value with more than `skipped` samples up to it.
fn value_beyond<'a>(mut counts: impl Iterator<Item = (usize, &'a u64)>, skipped: u64) -> u16 {
    let mut seen = 0;
    let found = counts.find(|(_, count)| {
        seen += **count;
        seen > skipped
    });
    found.map_or(0, |(value, _)| value as u16)
}

/// The lowest and the highest 16-bit value that are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stretch {
    low: u16,
    high: u16,
}

impl Stretch {
    /// A value of the file, as a part of 255.
    pub(super) fn shown(self, value: f32) -> f32 {
        (value - f32::from(self.low)) * 255.0 / f32::from(self.high - self.low)
    }

    /// What the user should know.
    pub(super) fn note(self) -> String {
        format!(
            "the photograph's 16-bit values from {} to {} are shown as 0 to 255",
            self.low, self.high
        )
    }
}

/// A covered pixel of these colours, as parts of 255.
pub(super) fn covered(colours: [f32; 3]) -> Pixel {
    let [red, green, blue] = colours.map(|colour| (colour + 0.5).clamp(0.0, 255.0) as u8);
    [red, green, blue, 255]
}
