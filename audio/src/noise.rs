//! Seeded white noise.

/// White noise, evenly spread over −1 to 1; the same seed gives the same noise everywhere.
///
/// The generator is SplitMix64 (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next sample.
    pub(crate) fn sample(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        // 53 bits fill the significand exactly.
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_centred_even_and_without_memory() {
        let mut noise = Noise::new(7);
        let n = 200_000;
        let samples: Vec<f64> = (0..n).map(|_| noise.sample()).collect();
        let mean = |f: &dyn Fn(usize) -> f64| (1..n).map(f).sum::<f64>() / (n - 1) as f64;
        assert!(samples.iter().all(|s| (-1.0..1.0).contains(s)));
        assert!(mean(&|i| samples[i]).abs() < 0.005);
        assert!((mean(&|i| samples[i] * samples[i]) - 1.0 / 3.0).abs() < 0.005);
        assert!(mean(&|i| samples[i] * samples[i - 1]).abs() < 0.005);
    }
}
