//! Waiting for what other threads do.
#![allow(dead_code, reason = "some tests wait in their own way, for as long")]

use std::time::{Duration, Instant};

/// A device that is tried again every half second, on a slow machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// Waits until `found` gives something; fails by name where it never does.
pub(crate) fn wait_for<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
