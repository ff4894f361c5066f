//! Seeded noise, as a tracker has it.

use glam::{DQuat, DVec3};
use sandtable_motion::Signal;
use sandtable_pose::Rigid;
use std::f64::consts::TAU;

/// Random numbers; the same seed gives the same ones everywhere.
///
/// The generator is SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Evenly spread from 0 to 1, without 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        // 53 bits fill the significand exactly.
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly spread from `least` to `most`.
    pub(crate) fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.unit()
    }

    /// Normally distributed about 0 with the given deviation (Box and Muller 1958).
    fn normal(&mut self, deviation: f64) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        deviation * radius * (TAU * self.unit()).cos()
    }

    /// A pose as a tracker measures it: off by `metres` and `radians` on each axis.
    pub(crate) fn measured(&mut self, truth: &Rigid, metres: f64, radians: f64) -> Rigid {
        let mut vector = |deviation| {
            DVec3::new(
                self.normal(deviation),
                self.normal(deviation),
                self.normal(deviation),
            )
        };
        let (shift, turn) = (vector(metres), vector(radians));
        let rotation: DQuat = truth.rotation.moved_by(turn);
        Rigid::new(rotation, truth.translation + shift)
    }
}
