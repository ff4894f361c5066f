//! Streams of samples that several tests use.

use glam::{DQuat, DVec3, EulerRot};
use sandtable_pose::{Nanos, Pose, Rigid, Validity};
use std::f64::consts::TAU;

/// A head that sways and turns about all axes: up to 0.4 m/s and 1.3 rad/s.
pub(crate) fn swaying(seconds: f64) -> Rigid {
    let wave = |hertz: f64, phase: f64| (TAU * hertz * seconds + phase).sin();
    Rigid::new(
        DQuat::from_euler(
            EulerRot::ZXY,
            0.5 * wave(0.4, 0.3),
            0.2 * wave(0.3, 1.0) - 0.6,
            0.1 * wave(0.5, 2.0),
        ),
        DVec3::new(
            0.12 * wave(0.5, 0.0),
            0.05 * wave(0.3, 1.0) - 0.9,
            0.03 * wave(0.7, 2.0) + 0.6,
        ),
    )
}

/// Random numbers from 0 to 1, the same for the same seed (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Within `most` of 0 on each axis, evenly.
    pub(crate) fn vector(&mut self, most: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| most * (2.0 * self.unit() - 1.0)))
    }
}

/// Times at a steady rate for so many seconds.
pub(crate) fn steady(hertz: f64, seconds: f64) -> Vec<Nanos> {
    let samples = (hertz * seconds) as u32;
    (0..=samples)
        .map(|i| Nanos::from_seconds(f64::from(i) / hertz))
        .collect()
}

/// Times 1 to 25 ms apart, at random.
pub(crate) fn irregular(seed: u64, seconds: f64) -> Vec<Nanos> {
    let mut random = Random(seed);
    let mut time = 0.0;
    let mut times = Vec::new();
    while time < seconds {
        times.push(Nanos::from_seconds(time));
        time += 0.001 + 0.024 * random.unit();
    }
    times
}

/// A live pose.
pub(crate) fn live(time: Nanos, frame_from_body: Rigid) -> Pose {
    Pose {
        frame_from_body,
        time,
        validity: Validity::Live,
    }
}
