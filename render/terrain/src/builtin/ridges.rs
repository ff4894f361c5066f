//! Mountains out of noise that look as if water had run over them.
//!
//! Ridged multifractal over warped ground (Musgrave), whose finer octaves are damped where the
//! coarser ones are steep, so that crests stay sharp, flanks become smooth and valleys fill.

use super::noise::noise;

/// Length of the broadest mountains, metres.
const RANGE_LENGTH: f64 = 14_000.0;
const OCTAVES: u32 = 9;
/// Each octave is turned against the one before, so that no lattice shows.
const TURN: (f64, f64) = (0.8, 0.6);

/// One world of mountains.
pub(super) struct Ridges {
    seed: u32,
}

impl Ridges {
    pub(super) fn new(seed: u64) -> Self {
        let mixed = (seed ^ (seed >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        Self {
            seed: (mixed >> 32) as u32,
        }
    }

    /// Height in metres at a place in metres.
    pub(super) fn height(&self, x: f64, y: f64) -> f32 {
        let layer = |index: u32| self.seed.wrapping_add(index.wrapping_mul(0x632b_e5ab));
        // Warp: ranges bend, spurs wander.
        let (wx, wy) = (x / 11_000.0, y / 11_000.0);
        let warp = [
            noise(wx, wy, layer(100)).value + 0.4 * noise(wx * 2.7, wy * 2.7, layer(101)).value,
            noise(wx, wy, layer(102)).value + 0.4 * noise(wx * 2.7, wy * 2.7, layer(103)).value,
        ];
        let (px, py) = (
            x + 2_200.0 * f64::from(warp[0]),
            y + 2_200.0 * f64::from(warp[1]),
        );
        // Where there are high ranges and where plains.
        let land = noise(x / 38_000.0, y / 38_000.0, layer(104)).value;
        let uplift = (0.62 + 0.6 * land).clamp(0.12, 1.15);

        let (mut fx, mut fy) = (px / RANGE_LENGTH, py / RANGE_LENGTH);
        let mut amplitude = 1.0_f32;
        let mut sum = 0.0_f32;
        let mut slope = [0.0_f32; 2];
        let mut weight = 1.0_f32;
        for octave in 0..OCTAVES {
            let n = noise(fx, fy, layer(octave));
            let crest = 1.0 - n.value.abs();
            let ridge = crest * crest;
            let towards = -2.0 * crest * n.value.signum();
            let gain = amplitude * weight;
            slope[0] += gain * towards * n.slope[0];
            slope[1] += gain * towards * n.slope[1];
            let damped = 1.0 + 0.35 * (slope[0] * slope[0] + slope[1] * slope[1]);
            sum += gain * ridge / damped;
            weight = (ridge * 1.6).clamp(0.0, 1.0);
            amplitude *= 0.5;
            (fx, fy) = (
                2.03 * (TURN.0 * fx - TURN.1 * fy) + 17.3,
                2.03 * (TURN.1 * fx + TURN.0 * fy) - 9.1,
            );
        }
        250.0 + 2_300.0 * uplift * sum
    }
}
