//! Reproducible noise.

use glam::{DQuat, DVec3};

/// Random numbers by splitmix64 (Steele and others 2014).
pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn seeded(seed: u64) -> Self {
        // Mixed, so that neighbouring seeds do not give the same numbers one later.
        Self(mixed(seed ^ 0x5851_F42D_4C95_7F2D))
    }

    /// Even over 0 to 1.
    pub(crate) fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        (mixed(self.0) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Even over a box.
    pub(crate) fn within(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        let share = DVec3::new(self.share(), self.share(), self.share());
        low + (high - low) * share
    }

    /// Gaussian with mean 0 and this standard deviation (Box and Muller 1958).
    pub(crate) fn gaussian(&mut self, deviation: f64) -> f64 {
        let radius = (-2.0 * (1.0 - self.share()).ln()).sqrt();
        deviation * radius * (std::f64::consts::TAU * self.share()).cos()
    }

    /// Gaussian on every axis.
    pub(crate) fn vector(&mut self, deviation: f64) -> DVec3 {
        DVec3::new(
            self.gaussian(deviation),
            self.gaussian(deviation),
            self.gaussian(deviation),
        )
    }

    /// A direction, even over the sphere.
    pub(crate) fn direction(&mut self) -> DVec3 {
        self.vector(1.0).normalize_or(DVec3::X)
    }

    /// An attitude, even over all.
    pub(crate) fn attitude(&mut self) -> DQuat {
        let (v, w) = (self.vector(1.0), self.gaussian(1.0));
        DQuat::from_xyzw(v.x, v.y, v.z, w).normalize()
    }

    /// A small turn with this standard deviation about every axis, in radians.
    pub(crate) fn turn(&mut self, deviation: f64) -> DQuat {
        DQuat::from_scaled_axis(self.vector(deviation))
    }
}

fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
