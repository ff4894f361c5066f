//! What goes before a repetition that is timed.

use anyhow::Result;
use std::time::{Duration, Instant};

/// Threads that slept are slower at first: by half in their first millisecond, and still by a tenth in the next.
const LENGTH: Duration = Duration::from_millis(20);

/// Repeats for a while, at least once, what is to be timed then.
pub(crate) fn warm_up(mut repeat: impl FnMut() -> Result<()>) -> Result<()> {
    let begin = Instant::now();
    loop {
        repeat()?;
        if begin.elapsed() >= LENGTH {
            return Ok(());
        }
    }
}
