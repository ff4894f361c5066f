//! The One-Euro filter: a low-pass whose cutoff rises with speed.

use crate::arrival::{Arrival, Step, Stream};
use crate::settings::{SettingsError, check_gap};
use crate::signal::{Signal, usable_pose};
use glam::{DQuat, DVec3};
use sandtable_pose::{Nanos, Rigid};
use std::f64::consts::TAU;
use std::time::Duration;

/// What a One-Euro filter is tuned by (Casiez, Roussel and Vogel 2012).
///
/// To tune it: set `beta` to 0 and lower `min_cutoff_hz` until a still sensor is calm, then raise
/// `beta` until the lag of a moving one is gone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneEuroSettings {
    /// The cutoff at rest, in hertz; from 0.001 to 1000. Lower is calmer and slower.
    pub min_cutoff_hz: f64,
    /// By how many hertz the cutoff rises for each unit a second of speed: hertz for a metre a
    /// second, or for a radian a second. From 0 to 10000.
    pub beta: f64,
    /// The cutoff of the speed itself, in hertz; from 0.001 to 1000.
    pub derivative_cutoff_hz: f64,
    /// What the speed is taken from.
    pub derivative: Derivative,
}

impl OneEuroSettings {
    /// For the position of a head, in metres, chosen with the table of `docs/filters.md`.
    pub const POSITION: Self = Self {
        min_cutoff_hz: 1.0,
        beta: 80.0,
        derivative_cutoff_hz: 3.0,
        derivative: Derivative::FromFiltered,
    };

    /// For the attitude of a head, in radians, chosen likewise.
    pub const ATTITUDE: Self = Self {
        min_cutoff_hz: 1.0,
        beta: 20.0,
        derivative_cutoff_hz: 3.0,
        derivative: Derivative::FromFiltered,
    };
}

/// Which earlier value the raw sample's speed is measured from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Derivative {
    /// From the last filtered value, as in the paper. It counts the filter's own lag as motion,
    /// and by more the shorter the samples' interval: at 144 Hz the cutoff is higher, and the lag
    /// smaller, than at 50 Hz.
    #[default]
    FromFiltered,
    /// From the last raw value, as in later programs of the paper's authors. It measures the speed
    /// itself, so that the filter does the same at any rate; it needs a larger `beta`.
    FromRaw,
}

/// A One-Euro filter of a number, a position or an attitude (Casiez, Roussel and Vogel 2012).
///
/// The low-pass of cutoff c takes in the share α = 1 / (1 + 1 / (2π c Δt)) of each sample, Δt being
/// the true time since the last one. The cutoff is `min_cutoff_hz` + `beta` · |v|, where v is the
/// sample's difference from the last value (see [`Derivative`]) over Δt, itself low-passed at
/// `derivative_cutoff_hz`. v has one component an axis and |v| is one speed for all of them. An
/// attitude moves by slerp along the shorter way, and its |v| is an angular speed.
///
/// ```
/// use sandtable_motion::{OneEuro, OneEuroSettings};
/// use sandtable_pose::Nanos;
/// use std::time::Duration;
///
/// let mut filter = OneEuro::new(OneEuroSettings::POSITION, Duration::from_millis(100)).unwrap();
/// filter.push(Nanos::from_seconds(0.00), 0.0);
/// filter.push(Nanos::from_seconds(0.01), 0.001);
/// let calm: f64 = filter.value().unwrap();
/// assert!(calm > 0.0 && calm < 0.001);
/// ```
#[derive(Clone, Debug)]
pub struct OneEuro<S: Signal> {
    settings: OneEuroSettings,
    stream: Stream,
    state: Option<State<S>>,
}

#[derive(Clone, Copy, Debug)]
struct State<S: Signal> {
    filtered: S,
    raw: S,
    /// Low-passed, units a second.
    derivative: S::Difference,
}

impl<S: Signal> OneEuro<S> {
    /// A filter that begins anew after no sample for longer than `gap`.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`] names the setting and its range.
    pub fn new(settings: OneEuroSettings, gap: Duration) -> Result<Self, SettingsError> {
        settings.check("")?;
        check_gap(gap)?;
        Ok(Self {
            settings,
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
            (Step::Next(dt), Some(state)) => Some(state.next(&self.settings, dt, sample)),
            (Step::Start | Step::Next(_), _) => Some(State {
                filtered: sample,
                raw: sample,
                derivative: S::Difference::default(),
            }),
        };
        step.into()
    }

    /// The filtered value at the newest sample's time, or `None` before the first.
    pub fn value(&self) -> Option<S> {
        self.state.map(|state| state.filtered)
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.stream.clear();
        self.state = None;
    }
}

impl<S: Signal> State<S> {
    fn next(self, settings: &OneEuroSettings, dt: f64, sample: S) -> Self {
        let before = match settings.derivative {
            Derivative::FromFiltered => self.filtered,
            Derivative::FromRaw => self.raw,
        };
        let rate = sample.difference_from(before) * dt.recip();
        let share = low_pass_share(settings.derivative_cutoff_hz, dt);
        let derivative = self.derivative * (1.0 - share) + rate * share;
        let cutoff = settings.min_cutoff_hz + settings.beta * S::magnitude(derivative);
        let step = sample.difference_from(self.filtered) * low_pass_share(cutoff, dt);
        Self {
            filtered: self.filtered.moved_by(step),
            raw: sample,
            derivative,
        }
    }
}

/// The share of a new sample that a low-pass takes in, 0 to 1.
fn low_pass_share(cutoff_hz: f64, dt: f64) -> f64 {
    1.0 / (1.0 + 1.0 / (TAU * cutoff_hz * dt))
}

/// A One-Euro filter of a pose: of its position and its attitude, each by its own settings.
#[derive(Clone, Debug)]
pub struct PoseOneEuro {
    position: OneEuro<DVec3>,
    attitude: OneEuro<DQuat>,
}

impl PoseOneEuro {
    /// A filter that begins anew after no sample for longer than `gap`.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`] names the setting and its range.
    pub fn new(
        position: OneEuroSettings,
        attitude: OneEuroSettings,
        gap: Duration,
    ) -> Result<Self, SettingsError> {
        position.check("position.")?;
        attitude.check("attitude.")?;
        Ok(Self {
            position: OneEuro::new(position, gap)?,
            attitude: OneEuro::new(attitude, gap)?,
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

    /// The filtered pose at the newest sample's time, or `None` before the first.
    #[must_use]
    pub fn pose(&self) -> Option<Rigid> {
        Some(Rigid::new(self.attitude.value()?, self.position.value()?))
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.position.clear();
        self.attitude.clear();
    }
}
