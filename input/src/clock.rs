//! The live clock.

use sandtable_pose::Nanos;
use std::time::{Duration, Instant};

/// A session's monotonic clock, counting from its own start.
///
/// Only live sessions have one. Everything else takes the time as a value, so that replay may
/// bring its own.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
}

impl Clock {
    /// A clock that starts now.
    #[must_use]
    pub fn start() -> Self {
        Self {
            start: Instant::now(),
        }
    }

    /// The time since the start.
    #[must_use]
    pub fn now(&self) -> Nanos {
        Nanos(u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX))
    }

    /// When this clock says `time`, on the system's monotonic clock.
    #[must_use]
    pub fn instant(&self, time: Nanos) -> Instant {
        self.start + Duration::from_nanos(time.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_and_its_instant_are_the_same_moment() {
        let clock = Clock::start();
        let before = Instant::now();
        let now = clock.now();
        let after = Instant::now();
        let instant = clock.instant(now);
        assert!(before <= instant && instant <= after);
        let later = clock.instant(now + Duration::from_millis(7));
        assert_eq!(later - instant, Duration::from_millis(7));
    }
}
