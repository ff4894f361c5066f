//! Prediction: where a body will be when a frame is on the glass.

use crate::double_exponential::PoseDoubleExponential;
use crate::settings::{Prediction, SettingsError};
use crate::velocity::Velocity;
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

/// The furthest that a pose is predicted unless a setting says otherwise. Noise grows with the
/// time ahead, and a head that stops is overshot by it.
pub const HORIZON: Duration = Duration::from_millis(50);

/// How far ahead of a pose measured at `sample` a frame shown at `display` lies: never before it,
/// and never further than `limit`.
#[must_use]
pub fn time_ahead(sample: Nanos, display: Nanos, limit: Duration) -> Duration {
    display.since(sample).min(limit)
}

/// One sensor's way of prediction, and the state that it needs.
///
/// It knows of times ahead only: whether to predict at all, from how old a pose and to which time
/// is decided in [`TrackerFilter`](crate::TrackerFilter).
#[derive(Clone, Debug)]
pub struct Predictor {
    limit: Duration,
    method: Method,
}

#[derive(Clone, Debug)]
enum Method {
    Off,
    ConstantVelocity,
    DoubleExponential(Box<PoseDoubleExponential>),
}

impl Predictor {
    /// A predictor that begins anew after no sample for longer than `gap`.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`] names the setting and its range.
    pub fn new(settings: Prediction, gap: Duration) -> Result<Self, SettingsError> {
        settings.check("")?;
        let (limit, method) = match settings {
            Prediction::Off => (Duration::ZERO, Method::Off),
            Prediction::ConstantVelocity { horizon } => (horizon, Method::ConstantVelocity),
            Prediction::DoubleExponential {
                position,
                attitude,
                horizon,
            } => (
                horizon,
                Method::DoubleExponential(Box::new(PoseDoubleExponential::new(
                    position, attitude, gap,
                )?)),
            ),
        };
        Ok(Self { limit, method })
    }

    /// Takes in the pose measured at `time`, smoothed or not.
    pub fn push(&mut self, time: Nanos, frame_from_body: &Rigid) {
        if let Method::DoubleExponential(filter) = &mut self.method {
            filter.push(time, frame_from_body);
        }
    }

    /// The newest pose, measured at `sample`, carried to the time `display`, and how far that was.
    ///
    /// `velocity` is the body's, where it is known; at a constant velocity nothing is predicted
    /// without it.
    #[must_use]
    pub fn predict(
        &self,
        sample: Nanos,
        frame_from_body: &Rigid,
        velocity: Option<Velocity>,
        display: Nanos,
    ) -> (Rigid, Duration) {
        let ahead = time_ahead(sample, display, self.limit);
        let seconds = ahead.as_secs_f64();
        let predicted = match &self.method {
            Method::Off => None,
            Method::ConstantVelocity => {
                velocity.map(|velocity| velocity.carry(frame_from_body, seconds))
            }
            Method::DoubleExponential(filter) => filter.pose_after(seconds),
        };
        predicted.map_or((*frame_from_body, Duration::ZERO), |pose| (pose, ahead))
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        if let Method::DoubleExponential(filter) = &mut self.method {
            filter.clear();
        }
    }
}
