//! Frame times, for the panel.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Rates and times are over the last second.
const WINDOW: Duration = Duration::from_secs(1);

/// How often and for how long something was done lately.
#[derive(Clone, Debug, Default)]
pub(super) struct Times(VecDeque<(Instant, Duration)>);

impl Times {
    /// It was finished at `now` and took `time`.
    pub(super) fn add(&mut self, now: Instant, time: Duration) {
        self.0.push_back((now, time));
        self.forget(now);
    }

    /// How many times in the second before `now`.
    pub(super) fn rate(&mut self, now: Instant) -> usize {
        self.forget(now);
        self.0.len()
    }

    /// How long the last one took, in milliseconds.
    pub(super) fn last_ms(&self) -> Option<f64> {
        self.0.back().map(|(_, time)| time.as_secs_f64() * 1e3)
    }

    /// Forgets what is older than a second, but never the last one.
    fn forget(&mut self, now: Instant) {
        while self.0.len() > 1 && now.duration_since(self.0[0].0) > WINDOW {
            self.0.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_of_the_last_second_and_the_last_time_stays() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut times = Times::default();
        assert_eq!((times.rate(start), times.last_ms()), (0, None));
        for frame in 0..40 {
            times.add(at(frame * 50), Duration::from_millis(7));
        }
        assert_eq!(times.rate(at(1950)), 21);
        assert_eq!(times.rate(at(60_000)), 1);
        assert_eq!(times.last_ms(), Some(7.0));
    }
}
