//! How far images are from the truth.

/// The sum of an image's squared errors in 8-bit codes of red, green and blue, and of how many.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Errors {
    squares: f64,
    channels: usize,
}

impl Errors {
    /// Adds what `image` is off from `truth`.
    pub(super) fn add(&mut self, image: &[[u8; 4]], truth: &[[u8; 4]]) {
        for (seen, truth) in image.iter().zip(truth) {
            for (&seen, &truth) in seen[..3].iter().zip(truth) {
                self.squares += (f64::from(seen) - f64::from(truth)).powi(2);
            }
        }
        self.channels += 3 * truth.len();
    }

    /// The peak signal to noise ratio in dB.
    pub(super) fn psnr(&self) -> f64 {
        10.0 * (255.0_f64.powi(2) * self.channels as f64 / self.squares).log10()
    }
}
