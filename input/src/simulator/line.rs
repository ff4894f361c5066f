//! The line of a simulated device: bytes wait for it, and it carries them at its own speed.

use std::collections::VecDeque;
use std::time::Duration;

/// A serial line towards the host.
#[derive(Clone, Debug)]
pub(crate) struct SimulatedLine {
    byte_time: Duration,
    waiting: VecDeque<u8>,
    /// When the last byte was through.
    free: Duration,
}

impl SimulatedLine {
    /// A line of so many bits a second.
    pub(crate) fn new(baud: u32) -> Self {
        Self {
            // A start bit, eight bits, a stop bit.
            byte_time: Duration::from_secs_f64(10.0 / f64::from(baud.max(1))),
            waiting: VecDeque::new(),
            free: Duration::ZERO,
        }
    }

    /// Lets bytes wait for the line from `now` on.
    pub(crate) fn queue(&mut self, bytes: &[u8], now: Duration) {
        if self.waiting.is_empty() {
            self.free = self.free.max(now);
        }
        self.waiting.extend(bytes);
    }

    /// Gives `out` the bytes that are through by `now`.
    pub(crate) fn carry(&mut self, now: Duration, out: &mut Vec<u8>) {
        while self.free + self.byte_time <= now {
            let Some(byte) = self.waiting.pop_front() else {
                break;
            };
            self.free += self.byte_time;
            out.push(byte);
        }
    }

    /// When the next byte is through, if one waits.
    pub(crate) fn next(&self) -> Option<Duration> {
        (!self.waiting.is_empty()).then(|| self.free + self.byte_time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_one_by_one_at_the_lines_speed() {
        let ms = Duration::from_millis;
        let mut line = SimulatedLine::new(10_000);
        assert_eq!(line.next(), None);
        line.queue(&[1, 2, 3], ms(100));
        assert_eq!(line.next(), Some(ms(101)));
        let carried = |line: &mut SimulatedLine, now| {
            let mut out = Vec::new();
            line.carry(now, &mut out);
            out
        };
        assert!(carried(&mut line, ms(100)).is_empty());
        assert_eq!(carried(&mut line, ms(102)), [1, 2]);
        // What is queued while it is busy waits for the rest.
        line.queue(&[4], ms(102));
        assert_eq!(line.next(), Some(ms(103)));
        assert_eq!(carried(&mut line, ms(500)), [3, 4]);
        line.queue(&[5], ms(500));
        assert_eq!(line.next(), Some(ms(501)));
    }
}
