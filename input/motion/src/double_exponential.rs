//! Double exponential smoothing: a level and a slope, from which to extrapolate.
//!
//! A sample x is smoothed once into s₁ and that into s₂, each by the share α of what is new. Behind
//! a ramp that has gone on for long s₁ lies by a lag of (1 − α) / α samples and s₂ by twice that,
//! which gives the ramp's slope and value; k samples ahead it is LaViola's
//! (2 + αk / (1 − α)) s₁ − (1 + αk / (1 − α)) s₂.
//!
//! For samples at any times the share is made of the time Δt that passed: α = Δt / (τ + Δt). Then
//! the lag is the time constant τ at any rate, and it is at any spacing: a ramp's lag goes from L₁
//! to (1 − α)(L₁ + Δt), which is τ where L₁ is τ, whatever Δt is; and that of s₂ goes from L₂ to
//! (1 − α)(L₂ + Δt) + ατ, which is 2τ where L₂ is 2τ. So the slope is (s₁ − s₂) / τ, and the value
//! a time h ahead s₁ + (τ + h) · slope, which is LaViola's at steady intervals, sample by sample.
//! With α = 1 − exp(−Δt / τ), which is usual too, the lag would be τ − Δt/2 and vary with the rate.
//!
//! A filter begins with s₁ = s₂ = x, as LaViola's does: as if the body had been at rest before.

use crate::arrival::{Arrival, Step, Stream};
use crate::settings::{SettingsError, check_gap, check_time_constant};
use crate::signal::{Signal, usable_pose};
use crate::velocity::Velocity;
use glam::{DQuat, DVec3};
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

/// Double exponential smoothing and prediction of a number, a position or an attitude (LaViola
/// 2003), for samples at any times.
///
/// LaViola smooths an attitude as four numbers, and makes a unit quaternion of the result. Here its
/// smoothed values are attitudes, moved by shares of rotation vectors. A turn about one axis at a
/// steady speed is then predicted exactly, where four numbers lead along a chord; no sum can come
/// out as zero; and the slope is an angular velocity. What it needs is that s₁ lies less than half
/// a turn behind the sample, and s₂ behind s₁: with τ = 0.1 s, speeds below 30 rad/s.
///
/// ```
/// use sandtable_motion::{DoubleExponential, time_constant};
/// use sandtable_pose::Nanos;
/// use std::time::Duration;
///
/// // LaViola's α = 0.5 at 100 Hz, three steps ahead.
/// let tau = time_constant(0.5, Duration::from_millis(10));
/// let mut filter = DoubleExponential::new(tau, Duration::from_millis(100)).unwrap();
/// filter.push(Nanos(0), 0.0);
/// filter.push(Nanos(10_000_000), 1.0);
/// let ahead: f64 = filter.value_after(0.03).unwrap();
/// assert!((ahead - 1.5).abs() < 1e-6);
/// ```
#[derive(Clone, Debug)]
pub struct DoubleExponential<S: Signal> {
    time_constant: f64,
    stream: Stream,
    state: Option<State<S>>,
}

#[derive(Clone, Copy, Debug)]
struct State<S: Signal> {
    once: S,
    twice: S,
    /// Units a second.
    slope: S::Difference,
}

impl<S: Signal> DoubleExponential<S> {
    /// A filter whose once smoothed value lags by `time_constant`, and which begins anew after no
    /// sample for longer than `gap`.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`] names the setting and its range.
    pub fn new(time_constant: Duration, gap: Duration) -> Result<Self, SettingsError> {
        check_time_constant("time_constant", time_constant)?;
        check_gap(gap)?;
        Ok(Self {
            time_constant: time_constant.as_secs_f64(),
            stream: Stream::new(gap),
            state: None,
        })
    }

    /// Takes in the sample measured at `time`; one that is refused changes nothing.
    pub fn push(&mut self, time: Nanos, sample: S) -> Arrival {
        let Some(sample) = sample.usable() else {
            return Arrival::Unusable;
        };
        let step = self.stream.step(time);
        self.state = match (step, self.state) {
            (Step::Stale, state) => state,
            (Step::Next(dt), Some(state)) => Some(state.next(self.time_constant, dt, sample)),
            (Step::Start | Step::Next(_), _) => Some(State {
                once: sample,
                twice: sample,
                slope: S::Difference::default(),
            }),
        };
        step.into()
    }

    /// The value a finite number of `seconds` after the newest sample, or `None` before the first:
    /// at 0 the smoothed value, later a prediction.
    #[must_use]
    pub fn value_after(&self, seconds: f64) -> Option<S> {
        let state = self.state?;
        let from_once = self.time_constant + seconds;
        Some(state.once.moved_by(state.slope * from_once))
    }

    /// The slope at the newest sample, in units a second, or `None` before the first.
    #[must_use]
    pub fn slope(&self) -> Option<S::Difference> {
        self.state.map(|state| state.slope)
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.stream.clear();
        self.state = None;
    }
}

impl<S: Signal> State<S> {
    fn next(self, time_constant: f64, dt: f64, sample: S) -> Self {
        let share = dt / (time_constant + dt);
        let once = self
            .once
            .moved_by(sample.difference_from(self.once) * share);
        let ahead = once.difference_from(self.twice);
        Self {
            once,
            twice: self.twice.moved_by(ahead * share),
            // The new s₁ − s₂ is what is left of it, its share τ / (τ + Δt), and is divided by τ.
            slope: ahead * (time_constant + dt).recip(),
        }
    }
}

/// The time constant τ = Δt (1 − α) / α with which samples `interval` apart are taken in by the
/// share `alpha`, as LaViola and others give it. It is zero, which no filter takes, where `alpha` is
/// not between 0 and 1.
#[must_use]
pub fn time_constant(alpha: f64, interval: Duration) -> Duration {
    let seconds = interval.as_secs_f64() * (1.0 - alpha) / alpha;
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::ZERO)
}

/// Double exponential smoothing and prediction of a pose: of its position and its attitude, each
/// with its own time constant.
#[derive(Clone, Debug)]
pub struct PoseDoubleExponential {
    position: DoubleExponential<DVec3>,
    attitude: DoubleExponential<DQuat>,
}

impl PoseDoubleExponential {
    /// A filter whose once smoothed values lag by the two time constants, and which begins anew
    /// after no sample for longer than `gap`.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`] names the setting and its range.
    pub fn new(
        position: Duration,
        attitude: Duration,
        gap: Duration,
    ) -> Result<Self, SettingsError> {
        check_time_constant("position", position)?;
        check_time_constant("attitude", attitude)?;
        Ok(Self {
            position: DoubleExponential::new(position, gap)?,
            attitude: DoubleExponential::new(attitude, gap)?,
        })
    }

    /// Takes in the pose measured at `time`; one that is refused changes nothing.
    pub fn push(&mut self, time: Nanos, frame_from_body: &Rigid) -> Arrival {
        let Some(pose) = usable_pose(frame_from_body) else {
            return Arrival::Unusable;
        };
        self.position.push(time, pose.translation);
        self.attitude.push(time, pose.rotation)
    }

    /// The pose a finite number of `seconds` after the newest sample, or `None` before the first:
    /// at 0 the smoothed pose, later a prediction.
    #[must_use]
    pub fn pose_after(&self, seconds: f64) -> Option<Rigid> {
        Some(Rigid::new(
            self.attitude.value_after(seconds)?,
            self.position.value_after(seconds)?,
        ))
    }

    /// The velocity at the newest sample, or `None` before the first.
    #[must_use]
    pub fn velocity(&self) -> Option<Velocity> {
        Some(Velocity {
            linear: self.position.slope()?,
            angular: self.attitude.slope()?,
        })
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.position.clear();
        self.attitude.clear();
    }
}
