//! A tracker's filter: what stands between one sensor's samples and the pose that is shown.

use crate::arrival::Arrival;
use crate::double_exponential::PoseDoubleExponential;
use crate::one_euro::PoseOneEuro;
use crate::prediction::Predictor;
use crate::settings::{FilterSettings, SettingsError, Smoothing};
use crate::signal::usable_pose;
use crate::velocity::{Velocity, VelocityWindow};
use sandtable_pose::{Nanos, Pose, Rigid, Validity};
use std::time::Duration;

/// One sensor's smoothing, velocity and prediction.
///
/// Samples go in as they come, and the pose for any display time comes out. Nothing is allocated
/// after [`TrackerFilter::new`].
#[derive(Clone, Debug)]
pub struct TrackerFilter {
    settings: FilterSettings,
    smoother: Smoother,
    window: VelocityWindow,
    predictor: Predictor,
    /// As it was pushed, but for its place and attitude, which are smoothed.
    newest: Option<Pose>,
}

#[derive(Clone, Debug)]
enum Smoother {
    Off,
    OneEuro(Box<PoseOneEuro>),
    DoubleExponential(Box<PoseDoubleExponential>),
}

/// Where a body is, or will be, and what is known of its motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The pose, smoothed and predicted as the settings say. Its time is that of the newest
    /// sample; it is valid for `predicted` later.
    pub pose: Pose,
    /// How fast the body moves and turns, where that is known: not while its pose is held or lost.
    pub velocity: Option<Velocity>,
    /// How old the newest sample is.
    pub age: Duration,
    /// How far the pose is predicted; zero where it is not.
    pub predicted: Duration,
}

impl TrackerFilter {
    /// A filter that has had no sample yet.
    ///
    /// # Errors
    /// The first setting that cannot be meant.
    pub fn new(settings: FilterSettings) -> Result<Self, SettingsError> {
        settings.check()?;
        let gap = settings.gap;
        let smoother = match settings.smoothing {
            Smoothing::Off => Smoother::Off,
            Smoothing::OneEuro { position, attitude } => {
                Smoother::OneEuro(Box::new(PoseOneEuro::new(position, attitude, gap)?))
            }
            Smoothing::DoubleExponential { position, attitude } => Smoother::DoubleExponential(
                Box::new(PoseDoubleExponential::new(position, attitude, gap)?),
            ),
        };
        Ok(Self {
            settings,
            smoother,
            window: VelocityWindow::new(settings.velocity_window, gap)?,
            predictor: Predictor::new(settings.prediction, gap)?,
            newest: None,
        })
    }

    /// Takes in a sample: a pose with its time, and live unless the device itself says otherwise.
    ///
    /// One that is refused changes nothing. One that is not live is shown as it is, and the next
    /// live one begins anew.
    pub fn push(&mut self, sample: &Pose) -> Arrival {
        if usable_pose(&sample.frame_from_body).is_none() {
            return Arrival::Unusable;
        }
        if self.newest.is_some_and(|newest| sample.time <= newest.time) {
            return Arrival::Stale;
        }
        if sample.validity != Validity::Live {
            self.clear();
            self.newest = Some(*sample);
            return Arrival::Interrupted;
        }
        let continued = self.newest.is_some_and(|newest| {
            newest.validity == Validity::Live && sample.time.since(newest.time) <= self.settings.gap
        });
        let smoothed = self.smoother.push(sample.time, &sample.frame_from_body);
        // The velocity of smoothed poses lags by no more than they do, and trembles far less.
        self.window.push(sample.time, &smoothed);
        self.predictor.push(sample.time, &smoothed);
        self.newest = Some(Pose {
            frame_from_body: smoothed,
            ..*sample
        });
        if continued {
            Arrival::Continued
        } else {
            Arrival::Started
        }
    }

    /// The pose for a frame that is made at `now` and shown at `display`, or `None` before the
    /// first sample.
    ///
    /// Only a pose that is live at `now`, and that no gap has ended, is predicted; one that is held
    /// or lost stays where it was. A display time before the newest sample gives that sample.
    #[must_use]
    pub fn pose_at(&self, now: Nanos, display: Nanos) -> Option<Estimate> {
        let pose = self.newest?;
        let age = now.since(pose.time);
        let validity = self.validity(&pose, age);
        let mut estimate = Estimate {
            pose: Pose { validity, ..pose },
            velocity: None,
            age,
            predicted: Duration::ZERO,
        };
        if validity == Validity::Live && age <= self.settings.gap {
            estimate.velocity = self.window.velocity();
            (estimate.pose.frame_from_body, estimate.predicted) = self.predictor.predict(
                pose.time,
                &pose.frame_from_body,
                estimate.velocity,
                display,
            );
        }
        Some(estimate)
    }

    fn validity(&self, pose: &Pose, age: Duration) -> Validity {
        if pose.validity == Validity::Lost || age > self.settings.lost_after {
            Validity::Lost
        } else if pose.validity == Validity::Held || age > self.settings.held_after {
            Validity::Held
        } else {
            Validity::Live
        }
    }

    /// Forgets all samples, as before a recording is played anew.
    pub fn clear(&mut self) {
        self.smoother.clear();
        self.window.clear();
        self.predictor.clear();
        self.newest = None;
    }
}

impl Smoother {
    /// Takes in a usable pose, later than the last, and gives it back smoothed.
    fn push(&mut self, time: Nanos, raw: &Rigid) -> Rigid {
        let smoothed = match self {
            Self::Off => None,
            Self::OneEuro(filter) => {
                filter.push(time, raw);
                filter.pose()
            }
            Self::DoubleExponential(filter) => {
                filter.push(time, raw);
                filter.pose_after(0.0)
            }
        };
        smoothed.unwrap_or(*raw)
    }

    fn clear(&mut self) {
        match self {
            Self::Off => {}
            Self::OneEuro(filter) => filter.clear(),
            Self::DoubleExponential(filter) => filter.clear(),
        }
    }
}
