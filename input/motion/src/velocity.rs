//! Velocities: how fast a body moves and turns, by least squares over a short window.

use crate::arrival::{Arrival, Step, Stream};
use crate::settings::{SettingsError, check_gap, check_window};
use crate::signal::{Signal, usable_pose};
use glam::DVec3;
use sandtable_pose::{Nanos, Rigid};
use std::collections::VecDeque;
use std::time::Duration;

/// How fast a body moves and turns, in the frame that its poses are given in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity {
    /// Metres a second, of the body's origin.
    pub linear: DVec3,
    /// Radians a second about each of the frame's axes: a direction to turn about, by the right
    /// hand, and a speed as its length.
    pub angular: DVec3,
}

impl Velocity {
    /// The pose that one becomes in so many seconds, when both parts of the velocity stay as they
    /// are.
    #[must_use]
    pub fn carry(&self, frame_from_body: &Rigid, seconds: f64) -> Rigid {
        Rigid::new(
            frame_from_body.rotation.moved_by(self.angular * seconds),
            frame_from_body.translation.moved_by(self.linear * seconds),
        )
    }
}

/// The window that [`VelocityWindow`] is used with unless a setting says otherwise: six samples at
/// 100 Hz.
pub const VELOCITY_WINDOW: Duration = Duration::from_millis(50);

/// The samples of a pose's last moments, and the velocity that fits them best.
///
/// The velocity is the slope of the line with the least sum of squares through positions, and
/// through the rotation vectors that lead from the newest attitude to each, over their true times.
/// It is that of the window's middle, so half a window old. Within the window the body must turn by
/// less than half a turn.
///
/// The window holds what is not older than its length, but three samples at least, so that a slow
/// sensor has a velocity too, and [`VelocityWindow::CAPACITY`] at most. It never reaches over a
/// gap.
#[derive(Clone, Debug)]
pub struct VelocityWindow {
    window: Duration,
    stream: Stream,
    /// Oldest first; never grows beyond what it was made with.
    samples: VecDeque<(Nanos, Rigid)>,
}

/// Fewer samples make no velocity: noise in two of them is as good as a motion.
const LEAST: usize = 3;

impl VelocityWindow {
    /// The most samples held; at more than 5000 a second the usual window is shorter than asked.
    pub const CAPACITY: usize = 256;

    /// A window of so much time, which begins anew after no sample for longer than `gap`.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`] names the setting and its range.
    pub fn new(window: Duration, gap: Duration) -> Result<Self, SettingsError> {
        check_window(window)?;
        check_gap(gap)?;
        Ok(Self {
            window,
            stream: Stream::new(gap),
            samples: VecDeque::with_capacity(Self::CAPACITY),
        })
    }

    /// Takes in the pose measured at `time`; one that is refused changes nothing.
    pub fn push(&mut self, time: Nanos, frame_from_body: &Rigid) -> Arrival {
        let Some(pose) = usable_pose(frame_from_body) else {
            return Arrival::Unusable;
        };
        let step = self.stream.step(time);
        match step {
            Step::Stale => return Arrival::Stale,
            Step::Start => self.samples.clear(),
            Step::Next(_) => {
                while self.samples.len() >= LEAST && self.front_may_go(time) {
                    self.samples.pop_front();
                }
            }
        }
        self.samples.push_back((time, pose));
        step.into()
    }

    fn front_may_go(&self, now: Nanos) -> bool {
        self.samples.len() == Self::CAPACITY
            || self
                .samples
                .front()
                .is_some_and(|(time, _)| now.since(*time) > self.window)
    }

    /// The velocity, or `None` until three samples span half the window.
    #[must_use]
    pub fn velocity(&self) -> Option<Velocity> {
        let (newest, pose) = self.samples.back()?;
        let (oldest, _) = self.samples.front()?;
        if self.samples.len() < LEAST || newest.since(*oldest) < self.window / 2 {
            return None;
        }
        // From the newest sample, where differences of times and places lose no digits.
        let offsets = || {
            self.samples.iter().map(|(time, at)| {
                (
                    -newest.since(*time).as_secs_f64(),
                    at.translation.difference_from(pose.translation),
                    at.rotation.difference_from(pose.rotation),
                )
            })
        };
        let mean_time = offsets().map(|(t, ..)| t).sum::<f64>() / self.samples.len() as f64;
        let mut spread = 0.0;
        let mut sum = Velocity::default();
        for (t, way, turn) in offsets() {
            // Weights sum to zero, so that the means of way and turn drop out.
            let weight = t - mean_time;
            spread += weight * weight;
            sum.linear += way * weight;
            sum.angular += turn * weight;
        }
        Some(Velocity {
            linear: sum.linear / spread,
            angular: sum.angular / spread,
        })
    }

    /// Forgets all samples.
    pub fn clear(&mut self) {
        self.stream.clear();
        self.samples.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_window_never_holds_more_than_it_was_made_with() {
        let length = Duration::from_millis(100);
        let mut window = VelocityWindow::new(length, length).unwrap();
        let room = window.samples.capacity();
        let velocity = DVec3::new(0.2, 0.0, -0.1);
        for i in 0..10_000 {
            // First a thousand samples a second, then ten thousand, so that time runs out first
            // and room later.
            let microseconds = if i < 1000 {
                1000 * i
            } else {
                900_000 + 100 * i
            };
            let time = Nanos(1000 * microseconds);
            let place = velocity * time.seconds();
            window.push(time, &Rigid::new(DQuat::IDENTITY, place));
            assert_eq!(window.samples.capacity(), room);
            let most = if i < 1000 {
                101
            } else {
                VelocityWindow::CAPACITY
            };
            assert!(window.samples.len() <= most);
        }
        assert_eq!(window.samples.len(), VelocityWindow::CAPACITY);
    }
}
