//! The live clock.

use sandtable_pose::Nanos;
use std::time::Instant;

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
}
