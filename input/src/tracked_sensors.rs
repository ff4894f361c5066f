//! The sensors of a tracker on the network: from poses as they are told to samples.

use crate::gate::GateLimits;
use crate::track::Track;
use crate::{PoseSample, StreamCounts};
use glam::{DQuat, DVec3};
use sandtable_config::Tracking;
use sandtable_pose::{Nanos, Rigid};

/// How far the length of a quaternion, or of a rotation's column, may be from 1.
pub(crate) const NORM_TOLERANCE: f64 = 0.01;

/// A tracker's sensors, whose records are told apart by their raw values `R`.
#[derive(Clone, Debug)]
pub(crate) struct TrackedSensors<R> {
    tracking: Tracking,
    limits: GateLimits,
    tracks: Vec<Track<R>>,
}

impl<R: Clone + PartialEq> TrackedSensors<R> {
    pub(crate) fn new(tracking: &Tracking, sensors: u32) -> Self {
        Self {
            limits: GateLimits {
                max_speed: tracking.max_speed,
                max_turn: tracking.max_turn.to_radians(),
                period: tracking.period(),
                memory: tracking.lost_after,
            },
            tracks: vec![Track::default(); sensors as usize],
            tracking: tracking.clone(),
        }
    }

    /// The sample of a pose that came at `arrival` for the sensor with `index`, from 0; `None`
    /// where it is none, or where it may not be let out.
    pub(crate) fn sample(
        &mut self,
        index: usize,
        raw: R,
        told: Option<Rigid>,
        arrival: Nanos,
        counts: &mut StreamCounts,
    ) -> Option<PoseSample> {
        let Some(track) = self.tracks.get_mut(index) else {
            counts.foreign_records += 1;
            return None;
        };
        track.hear(raw);
        let Some(told) = told else {
            counts.implausible += 1;
            return None;
        };
        // Judged as it was told: a correction must not decide which records are believed.
        let time = match track.admit(&self.limits, arrival, &told) {
            Ok(time) => time,
            Err(refusal) => {
                counts.refuse(refusal);
                return None;
            }
        };
        counts.samples += 1;
        let frozen_after = self.tracking.frozen_after;
        Some(PoseSample {
            sensor: u32::try_from(index + 1).unwrap_or(u32::MAX),
            time,
            table_from_sensor: self.tracking.table_from_sensor(&told),
            frozen: frozen_after.is_some_and(|after| track.equal() >= after),
        })
    }

    pub(crate) fn restart(&mut self) {
        for track in &mut self.tracks {
            track.restart();
        }
    }
}

/// A pose, or `None` where the numbers are none: not finite, or no unit quaternion.
pub(crate) fn plausible(position: DVec3, rotation: DQuat) -> Option<Rigid> {
    let length = rotation.length();
    // NaN fails both.
    let unit = (length - 1.0).abs() <= NORM_TOLERANCE;
    (unit && position.is_finite()).then(|| Rigid::new(rotation * length.recip(), position))
}
