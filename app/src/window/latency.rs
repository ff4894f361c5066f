//! Latency: from a tracker's measurement of the head to the frame on the glass that follows it.
//!
//! ```text
//!  measured   read in   taken in   cast begins   cast ends   presented
//!     |---line---|---wait---|-----queue----|----cast----|----glass----|
//! ```
//!
//! Times are arguments: nothing here reads a clock. What each stage holds, and what none of them
//! sees, is in `docs/latency.md`.

use std::collections::VecDeque;
use std::fmt;
use std::time::{Duration, Instant};

/// The stages, in order.
const STAGES: [&str; 5] = ["line", "wait", "queue", "cast", "glass"];

/// Frames that are remembered after they were shown: ten seconds at two hundred a second.
const KEPT: usize = 2048;

/// Frames on their way that are remembered. Four can be: one on the GPU, one cast, one being cast
/// and one that waits for that; where there are more, the casts of the oldest were refused.
const UNDER_WAY: usize = 8;

/// The head's pose that a frame's views follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HeadTimes {
    /// When its tracker measured it, as the device's samples are dated.
    pub(crate) measured: Instant,
    /// When the read ended that brought it.
    pub(crate) read: Instant,
    /// When the session took it in.
    pub(crate) taken_in: Instant,
    /// How far it is predicted beyond `measured`.
    pub(crate) predicted: Duration,
}

/// Follows frames from the head's measurement to the glass.
#[derive(Clone, Debug, Default)]
pub(super) struct Latency {
    /// The oldest first, at most [`UNDER_WAY`].
    under_way: VecDeque<UnderWay>,
    /// The oldest first, at most [`KEPT`].
    shown: VecDeque<Shown>,
    /// Where times are sorted; kept for its memory.
    sorting: Vec<Duration>,
}

#[derive(Clone, Copy, Debug)]
struct UnderWay {
    frame: u64,
    head: HeadTimes,
    /// When its cast began and ended.
    cast: Option<[Instant; 2]>,
}

#[derive(Clone, Copy, Debug)]
struct Shown {
    at: Instant,
    stages: [Duration; STAGES.len()],
    predicted: Duration,
}

/// The latency of the frames shown lately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LatencyTable {
    /// How many there were.
    pub(super) frames: usize,
    /// Each stage.
    pub(super) stages: [Spread; STAGES.len()],
    /// From measurement to glass: of each frame, the sum of its stages.
    pub(super) total: Spread,
    /// How far the head was predicted.
    pub(super) predicted: Spread,
}

/// How long something took, by nearest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Spread {
    /// Half of the frames took no longer.
    pub(super) median: Duration,
    /// 95 in 100 took no longer.
    pub(super) p95: Duration,
}

impl Latency {
    /// The views of `frame` follow `head`, which is `None` where no tracker tells. Its request
    /// replaces that of another frame, which will never be cast. Frame numbers rise.
    pub(super) fn requested(&mut self, frame: u64, head: Option<HeadTimes>, replaced: Option<u64>) {
        self.under_way.retain(|other| Some(other.frame) != replaced);
        let Some(head) = head else {
            return;
        };
        if self.under_way.len() == UNDER_WAY {
            self.under_way.pop_front();
        }
        self.under_way.push_back(UnderWay {
            frame,
            head,
            cast: None,
        });
    }

    /// The images of `frame` are ready for the glass; their cast began at `begun`.
    pub(super) fn cast(&mut self, frame: u64, begun: Instant, cast_time: Duration) {
        let frame = self.under_way.iter_mut().find(|other| other.frame == frame);
        if let Some(frame) = frame {
            frame.cast = Some([begun, begun + cast_time]);
        }
    }

    /// The images of `frame` have been presented at `at`. Only the first time counts, and what was
    /// asked for before it will not be presented any more.
    pub(super) fn presented(&mut self, frame: u64, at: Instant) {
        while let Some(first) = self.under_way.front().filter(|first| first.frame <= frame) {
            if let Some([begun, ended]) = first.cast
                && first.frame == frame
            {
                let HeadTimes {
                    measured,
                    read,
                    taken_in,
                    predicted,
                } = first.head;
                if self.shown.len() == KEPT {
                    self.shown.pop_front();
                }
                self.shown.push_back(Shown {
                    at,
                    stages: stages([measured, read, taken_in, begun, ended, at]),
                    predicted,
                });
            }
            self.under_way.pop_front();
        }
    }

    /// When the newest frame was presented that followed a tracked head.
    pub(super) fn newest(&self) -> Option<Instant> {
        self.shown.back().map(|shown| shown.at)
    }

    /// The latency of the frames presented within `over` before the newest of them, or `None`
    /// before the first.
    pub(super) fn lately(&mut self, over: Duration) -> Option<LatencyTable> {
        let newest = self.newest()?;
        let old = |shown: &Shown| newest.saturating_duration_since(shown.at) > over;
        let first = self.shown.partition_point(old);
        let mut spread = |time_of: &dyn Fn(&Shown) -> Duration| {
            self.sorting.clear();
            self.sorting.extend(self.shown.range(first..).map(time_of));
            self.sorting.sort_unstable();
            Spread::of_sorted(&self.sorting)
        };
        Some(LatencyTable {
            frames: self.shown.len() - first,
            stages: std::array::from_fn(|stage| spread(&|shown| shown.stages[stage])),
            total: spread(&|shown| shown.stages.iter().sum()),
            predicted: spread(&|shown| shown.predicted),
        })
    }
}

/// What lies between the times, one after another. A time before the one that it follows, as of a
/// date that was put off so that a sensor's dates never go back, counts as that one: so no stage is
/// negative, and together they are as long as from the first to the last.
fn stages(times: [Instant; STAGES.len() + 1]) -> [Duration; STAGES.len()] {
    let mut latest = times[0];
    std::array::from_fn(|stage| {
        let from = latest;
        latest = latest.max(times[stage + 1]);
        latest - from
    })
}

impl Spread {
    /// That of times in order; zero where there are none.
    fn of_sorted(times: &[Duration]) -> Self {
        let ranked = |percent: usize| {
            let rank = (times.len() * percent).div_ceil(100);
            times.get(rank.saturating_sub(1)).copied()
        };
        Self {
            median: ranked(50).unwrap_or_default(),
            p95: ranked(95).unwrap_or_default(),
        }
    }
}

/// A time in milliseconds.
pub(super) fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

impl fmt::Display for LatencyTable {
    /// A heading and a line for each stage, the sum and the prediction, without an end of line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let heading = format!("latency in ms, frames: {}", self.frames);
        write!(f, "{heading:<28}{:>9}{:>9}", "median", "95 %")?;
        let stages = STAGES.into_iter().zip(self.stages);
        let sums = [
            ("measurement to glass", self.total),
            ("predicted", self.predicted),
        ];
        for (name, Spread { median, p95 }) in stages.chain(sums) {
            let [median, p95] = [median, p95].map(milliseconds);
            write!(f, "\n{name:<28}{median:>9.1}{p95:>9.1}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// A head measured `start` ms after `zero`, read 2 ms and taken in 5 ms later.
    fn head(zero: Instant, start: u32) -> HeadTimes {
        HeadTimes {
            measured: zero + MS * start,
            read: zero + MS * (start + 2),
            taken_in: zero + MS * (start + 5),
            predicted: MS * 20,
        }
    }

    fn ms(spread: Spread) -> [u128; 2] {
        [spread.median, spread.p95].map(|time| time.as_millis())
    }

    #[test]
    fn each_stage_lies_between_its_two_times_and_all_add_up() {
        let zero = Instant::now();
        let mut latency = Latency::default();
        assert_eq!(latency.lately(MS * 2000), None);
        latency.requested(1, Some(head(zero, 100)), None);
        latency.cast(1, zero + MS * 106, MS * 30);
        assert_eq!(latency.lately(MS * 2000), None);
        latency.presented(1, zero + MS * 153);
        let table = latency.lately(MS * 2000).unwrap();
        assert_eq!(table.frames, 1);
        assert_eq!(table.stages.map(|stage| ms(stage)[0]), [2, 3, 1, 30, 17]);
        assert_eq!(ms(table.total), [53, 53]);
        assert_eq!(ms(table.predicted), [20, 20]);
        let text = table.to_string();
        let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split("  ").collect()).collect();
        assert_eq!(lines.len(), 8);
        let last = |line: &[&str]| line.last().map(|word| word.trim().to_owned());
        assert_eq!(lines[0][0], "latency in ms, frames: 1");
        assert_eq!(lines[4][0], "cast");
        assert_eq!(last(&lines[4]).as_deref(), Some("30.0"));
        assert_eq!(lines[6][0], "measurement to glass");
        assert_eq!(last(&lines[6]).as_deref(), Some("53.0"));
    }

    #[test]
    fn the_same_images_shown_again_count_once() {
        let zero = Instant::now();
        let mut latency = Latency::default();
        latency.requested(1, Some(head(zero, 0)), None);
        latency.cast(1, zero + MS * 6, MS * 10);
        for again in 0..5 {
            latency.presented(1, zero + MS * (20 + again * 16));
            // The images go to the GPU once more, as after it was lost.
            latency.cast(1, zero + MS * 6, MS * 10);
        }
        let table = latency.lately(MS * 2000).unwrap();
        assert_eq!((table.frames, ms(table.total)), (1, [20, 20]));
    }

    #[test]
    fn frames_that_are_replaced_refused_or_overtaken_count_never() {
        let zero = Instant::now();
        let mut latency = Latency::default();
        latency.requested(1, Some(head(zero, 0)), None);
        // While the first is being cast for very long, others come and go.
        latency.requested(2, Some(head(zero, 16)), None);
        for frame in 3..=500 {
            let head = head(zero, 16 * (frame as u32 - 1));
            latency.requested(frame, Some(head), Some(frame - 1));
        }
        latency.cast(1, zero + MS * 5, MS * 8000);
        latency.presented(1, zero + MS * 8010);
        assert_eq!(ms(latency.lately(MS).unwrap().total), [8010, 8010]);
        // Frame 500 is cast, but frame 501 was there before it could be shown.
        latency.requested(501, Some(head(zero, 8016)), None);
        latency.cast(500, zero + MS * 8005, MS);
        latency.cast(501, zero + MS * 8021, MS);
        latency.presented(501, zero + MS * 8036);
        let table = latency.lately(MS * 10_000).unwrap();
        assert_eq!((table.frames, ms(table.total)), (2, [20, 8010]));
        // The casts of these are refused, one after another.
        for frame in 502..600 {
            latency.requested(frame, Some(head(zero, 9000)), None);
        }
        latency.cast(599, zero + MS * 9010, MS);
        latency.presented(599, zero + MS * 9030);
        assert_eq!(latency.lately(MS * 10_000).unwrap().frames, 3);
        // A frame of which nobody told that it was cast is none.
        latency.requested(600, Some(head(zero, 9100)), None);
        latency.presented(600, zero + MS * 9200);
        latency.presented(777, zero + MS * 9300);
        assert_eq!(latency.lately(MS * 10_000).unwrap().frames, 3);
        assert!(latency.under_way.is_empty());
    }

    #[test]
    fn frames_without_a_tracked_head_count_never() {
        let zero = Instant::now();
        let mut latency = Latency::default();
        latency.requested(1, None, None);
        latency.cast(1, zero, MS);
        latency.presented(1, zero + MS * 5);
        assert_eq!(latency.lately(MS * 2000), None);
    }

    #[test]
    fn times_out_of_order_make_no_stage_negative_and_the_sum_holds() {
        let zero = Instant::now();
        let at = |ms: u32| zero + MS * ms;
        assert_eq!(
            stages([at(10), at(8), at(12), at(11), at(30), at(29)]),
            [0, 2, 0, 18, 0].map(|ms| MS * ms)
        );
        assert_eq!(stages([at(9); 6]), [Duration::ZERO; 5]);
        assert_eq!(
            stages([at(9), at(1), at(2), at(3), at(4), at(5)]),
            [Duration::ZERO; 5]
        );
    }

    #[test]
    fn the_table_is_of_the_last_while_and_memory_has_an_end() {
        let zero = Instant::now();
        let mut latency = Latency::default();
        // A hundred frames a second; of a hundred in a row, the casts take 1 to 100 ms.
        for frame in 1..=5000u32 {
            let measured = 10 * frame;
            latency.requested(frame.into(), Some(head(zero, measured)), None);
            let begun = zero + MS * (measured + 5);
            latency.cast(frame.into(), begun, MS * (1 + frame % 100));
            latency.presented(frame.into(), zero + MS * (measured + 200));
        }
        let table = latency.lately(MS * 1990).unwrap();
        assert_eq!(table.frames, 200);
        assert_eq!(ms(table.stages[3]), [50, 95]);
        assert_eq!(ms(table.stages[4]), [144, 189]);
        assert_eq!(ms(table.total), [200, 200]);
        assert_eq!(latency.lately(Duration::ZERO).unwrap().frames, 1);
        assert_eq!(latency.lately(MS * 1_000_000).unwrap().frames, KEPT);
        assert!(latency.shown.capacity() <= 2 * KEPT);
    }
}
