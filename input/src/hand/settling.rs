//! Settling: what counts only once it has lasted.

use sandtable_pose::Nanos;
use std::time::Duration;

/// Something seen over time, which counts once it has lasted and until something else has, so that
/// neither a finger on its way nor a contact that bounces does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Settling<T> {
    settled: T,
    /// What was seen last, if it is not what has settled, and since when.
    rising: Option<(T, Nanos)>,
}

impl<T: Copy + PartialEq> Settling<T> {
    /// Takes what is seen at `time`; gives what counts now, where it takes `lasting` to.
    pub(crate) fn update(&mut self, time: Nanos, seen: T, lasting: Duration) -> T {
        let since = match self.rising {
            _ if seen == self.settled => {
                self.rising = None;
                return self.settled;
            }
            Some((rising, since)) if rising == seen => since,
            _ => time,
        };
        self.rising = Some((seen, since));
        if time.since(since) >= lasting {
            self.settled = seen;
            self.rising = None;
        }
        self.settled
    }
}
