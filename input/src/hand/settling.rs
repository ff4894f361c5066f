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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_on_the_way_to_something_else_does_not_lend_it_its_time() {
        let lasting = Duration::from_millis(50);
        let mut settling = Settling::<char>::default();
        let mut at = |ms: u64, seen| settling.update(Nanos(ms * 1_000_000), seen, lasting);
        assert_eq!([at(0, 'a'), at(50, 'a')], ['\0', 'a']);
        assert_eq!([at(60, 'b'), at(100, 'c')], ['a', 'a']);
        assert_eq!([at(120, 'c'), at(149, 'c'), at(150, 'c')], ['a', 'a', 'c']);
    }
}
