//! The latency of the frames shown, told on standard error at intervals and at the end.

use super::latency::LatencyTable;
use super::shell::Shell;
use std::io::Write;
use std::time::{Duration, Instant};

/// From one report to the next, and what each is about.
const INTERVAL: Duration = Duration::from_secs(5);

impl Shell<'_> {
    /// Tells the latency where that was asked for and is due.
    pub(super) fn report_latency(&mut self, now: Instant) {
        if !self.options.latency || now.duration_since(self.latency_reported) < INTERVAL {
            return;
        }
        let is_news = self.latency.newest() > Some(self.latency_reported);
        tell(self.latency.lately(INTERVAL).filter(|_| is_news));
        self.latency_reported = now;
    }

    /// Tells the latency of the last frames at the end, where it was asked for.
    pub(super) fn report_last_latency(&mut self) {
        if self.options.latency {
            tell(self.latency.lately(INTERVAL));
        }
    }
}

fn tell(table: Option<LatencyTable>) {
    let told = table.map_or_else(
        || "latency: no new picture for a tracked head has been shown".to_owned(),
        |table| table.to_string(),
    );
    // Where nobody reads it any more, the window goes on.
    let _ = writeln!(std::io::stderr(), "{told}");
}
