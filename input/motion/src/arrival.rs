//! Arrival: how a sample's time stands to the one before it.

use sandtable_pose::Nanos;
use std::time::Duration;

/// What a filter did with a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// The first one, or the first after a gap: the filter began anew from it.
    Started,
    /// It was taken as the next of its stream.
    Continued,
    /// Refused: not later than the one before, which a filter cannot go back behind.
    Stale,
    /// Refused: not finite, larger than [`LARGEST`](crate::LARGEST), or no rotation.
    Unusable,
    /// A pose that is not live: it is shown as it is, and the next live one begins anew.
    Interrupted,
}

/// The times of one stream's samples, and the gap that ends it.
#[derive(Clone, Debug)]
pub(crate) struct Stream {
    gap: Duration,
    newest: Option<Nanos>,
}

/// How a time continues a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// There is none before it, or one too old.
    Start,
    /// It is later by so many seconds, more than zero.
    Next(f64),
    /// It is not later.
    Stale,
}

impl Stream {
    pub(crate) fn new(gap: Duration) -> Self {
        Self { gap, newest: None }
    }

    /// Steps on to `time`, unless it is stale.
    pub(crate) fn step(&mut self, time: Nanos) -> Step {
        let step = match self.newest {
            None => Step::Start,
            Some(newest) if time <= newest => return Step::Stale,
            Some(newest) if time.since(newest) > self.gap => Step::Start,
            Some(newest) => Step::Next(time.since(newest).as_secs_f64()),
        };
        self.newest = Some(time);
        step
    }

    /// Forgets the times: the next one starts the stream, whatever it is.
    pub(crate) fn clear(&mut self) {
        self.newest = None;
    }
}

impl From<Step> for Arrival {
    fn from(step: Step) -> Self {
        match step {
            Step::Start => Self::Started,
            Step::Next(_) => Self::Continued,
            Step::Stale => Self::Stale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_ends_at_a_gap_and_never_goes_back() {
        let ms = |ms: u64| Nanos(ms * 1_000_000);
        let mut stream = Stream::new(Duration::from_millis(100));
        assert_eq!(stream.step(ms(50)), Step::Start);
        assert_eq!(stream.step(ms(60)), Step::Next(0.01));
        assert_eq!(stream.step(ms(60)), Step::Stale);
        assert_eq!(stream.step(ms(40)), Step::Stale);
        assert_eq!(stream.step(ms(160)), Step::Next(0.1));
        assert_eq!(stream.step(ms(261)), Step::Start);
        stream.clear();
        assert_eq!(stream.step(ms(10)), Step::Start);
    }
}
