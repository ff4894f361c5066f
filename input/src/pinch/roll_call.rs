//! The roll call: whether a box that says nothing is still there.
//!
//! A box is silent while nothing changes, so a silence proves nothing. It is asked something that
//! changes nothing, byte by byte and without waiting; whoever does not answer is missing.

use std::time::Duration;

/// When to send what, on a clock that is handed in.
#[derive(Clone, Debug)]
pub(super) struct RollCall {
    command: [u8; 2],
    every: Option<Duration>,
    byte_pause: Duration,
    answer_within: Duration,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// Heard of last at this time.
    Heard(Duration),
    /// The command's first byte was sent at this time.
    Half(Duration),
    /// The whole command was sent at this time.
    Asked(Duration),
}

impl RollCall {
    /// A roll call that begins at `now`; without `every` there is none.
    pub(super) fn new(
        command: [u8; 2],
        every: Option<Duration>,
        byte_pause: Duration,
        answer_within: Duration,
        now: Duration,
    ) -> Self {
        Self {
            command,
            every,
            byte_pause,
            answer_within,
            state: State::Heard(now),
        }
    }

    /// The box has sent a whole message.
    pub(super) fn heard(&mut self, now: Duration) {
        // A command that is half sent has to be ended all the same.
        if !matches!(self.state, State::Half(_)) {
            self.state = State::Heard(now);
        }
    }

    /// The byte that is to be sent now, if one is.
    pub(super) fn byte_to_send(&mut self, now: Duration) -> Option<u8> {
        let [first, second] = self.command;
        match self.state {
            State::Heard(last) if self.every.is_some_and(|every| now >= last + every) => {
                self.state = State::Half(now);
                Some(first)
            }
            State::Half(since) if now >= since + self.byte_pause => {
                self.state = State::Asked(now);
                Some(second)
            }
            State::Heard(_) | State::Half(_) | State::Asked(_) => None,
        }
    }

    /// Whether the box did not answer in time.
    pub(super) fn is_missing(&self, now: Duration) -> bool {
        matches!(self.state, State::Asked(since) if now >= since + self.answer_within)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    fn roll_call(every: Option<Duration>) -> RollCall {
        RollCall::new(*b"T0", every, ms(250), ms(1000), ms(0))
    }

    #[test]
    fn whoever_answers_is_asked_again_later() {
        let mut call = roll_call(Some(ms(5000)));
        assert_eq!(call.byte_to_send(ms(4999)), None);
        // Contacts say as much as an answer would.
        call.heard(ms(3000));
        assert_eq!(call.byte_to_send(ms(7999)), None);
        assert_eq!(call.byte_to_send(ms(8000)), Some(b'T'));
        // Contacts amid the command do not leave it half sent.
        call.heard(ms(8100));
        assert_eq!(call.byte_to_send(ms(8249)), None);
        assert_eq!(call.byte_to_send(ms(8250)), Some(b'0'));
        assert_eq!(call.byte_to_send(ms(8300)), None);
        assert!(!call.is_missing(ms(9249)));
        call.heard(ms(8280));
        assert!(!call.is_missing(ms(9250)));
        assert_eq!(call.byte_to_send(ms(13_280)), Some(b'T'));
    }

    #[test]
    fn whoever_does_not_answer_is_missing() {
        let mut call = roll_call(Some(ms(5000)));
        call.byte_to_send(ms(5000));
        call.byte_to_send(ms(5250));
        assert!(!call.is_missing(ms(6249)));
        assert!(call.is_missing(ms(6250)));
    }

    #[test]
    fn where_there_is_none_nothing_is_sent_and_nobody_is_missing() {
        let mut call = roll_call(None);
        assert_eq!(call.byte_to_send(ms(100_000_000)), None);
        assert!(!call.is_missing(ms(100_000_000)));
    }
}
