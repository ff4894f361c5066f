//! The gate: jumps that no head or hand makes are not let out.
//!
//! A serial line's bytes carry no checksum, and a tracker that mistakes one body for another says so
//! to nobody: what is wrong shows only by what it says. A pose passes when the
//! sensor could have come there from the last pose that passed. Once that one is too old to say
//! anything, two records in a row must agree: the first alone could be the altered one.

use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

/// What a sensor can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GateLimits {
    /// Metres a second.
    pub(crate) max_speed: f64,
    /// Radians a second.
    pub(crate) max_turn: f64,
    /// The least time between two records: bytes read at once may have been sent apart.
    pub(crate) period: Duration,
    /// How long a pose that passed vouches for the next.
    pub(crate) memory: Duration,
}

/// Why a pose is not let out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// No sensor comes there so fast.
    Jump,
    /// It is the first after a silence, and no other has agreed yet.
    Alone,
}

/// One sensor's gate.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gate {
    passed: Option<(Nanos, Rigid)>,
    refused: Option<(Nanos, Rigid)>,
}

impl Gate {
    /// Whether `pose`, measured at `time`, may be let out; else why not.
    pub(crate) fn admit(
        &mut self,
        limits: &GateLimits,
        time: Nanos,
        pose: &Rigid,
    ) -> Result<(), Refusal> {
        let remembered = |(then, _): &(Nanos, Rigid)| time.since(*then) <= limits.memory;
        // A new place is believed only after the old one is forgotten, so that it shows as lost.
        let reference = self.passed.filter(remembered);
        let verdict = match reference.or(self.refused.filter(remembered)) {
            Some((then, from)) if limits.reachable(&from, pose, time.since(then)) => Ok(()),
            Some(_) => Err(Refusal::Jump),
            None => Err(Refusal::Alone),
        };
        if verdict.is_ok() {
            self.passed = Some((time, *pose));
            self.refused = None;
        } else {
            self.refused = Some((time, *pose));
        }
        verdict
    }
}

impl GateLimits {
    fn reachable(&self, from: &Rigid, to: &Rigid, elapsed: Duration) -> bool {
        let seconds = elapsed.max(self.period).as_secs_f64();
        let way = (to.translation - from.translation).length();
        // q and −q are the same attitude.
        let turn = 2.0 * from.rotation.dot(to.rotation).abs().min(1.0).acos();
        way <= self.max_speed * seconds && turn <= self.max_turn * seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    const LIMITS: GateLimits = GateLimits {
        max_speed: 5.0,
        max_turn: 17.0,
        period: Duration::from_millis(10),
        memory: Duration::from_millis(250),
    };

    const JUMP: Result<(), Refusal> = Err(Refusal::Jump);
    const ALONE: Result<(), Refusal> = Err(Refusal::Alone);

    fn at(x: f64) -> Rigid {
        Rigid::new(DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0))
    }

    fn ms(ms: u64) -> Nanos {
        Nanos(ms * 1_000_000)
    }

    #[test]
    fn two_agreeing_records_open_it_and_motion_keeps_it_open() {
        let mut gate = Gate::default();
        assert_eq!(gate.admit(&LIMITS, ms(0), &at(0.0)), ALONE);
        for step in 1..100 {
            // 2 m/s.
            assert_eq!(
                gate.admit(&LIMITS, ms(10 * step), &at(0.02 * step as f64)),
                Ok(())
            );
        }
    }

    #[test]
    fn a_jump_is_refused_and_does_not_hide_what_follows() {
        let mut gate = Gate::default();
        assert_eq!(gate.admit(&LIMITS, ms(0), &at(0.0)), ALONE);
        assert_eq!(gate.admit(&LIMITS, ms(10), &at(0.0)), Ok(()));
        assert_eq!(gate.admit(&LIMITS, ms(20), &at(0.4)), JUMP);
        assert_eq!(gate.admit(&LIMITS, ms(30), &at(0.0)), Ok(()));
    }

    #[test]
    fn a_flip_to_the_mirrored_place_is_believed_only_after_it_was_lost() {
        let mut gate = Gate::default();
        assert_eq!(gate.admit(&LIMITS, ms(0), &at(0.9)), ALONE);
        assert_eq!(gate.admit(&LIMITS, ms(10), &at(0.9)), Ok(()));
        for time in (20..=260).step_by(10) {
            assert_eq!(gate.admit(&LIMITS, ms(time), &at(-0.9)), JUMP);
        }
        assert_eq!(gate.admit(&LIMITS, ms(270), &at(-0.9)), Ok(()));
    }

    #[test]
    fn a_turn_beyond_the_limit_is_refused_whatever_the_quaternions_sign() {
        let mut gate = Gate::default();
        let turned = |angle: f64| Rigid::new(DQuat::from_rotation_z(angle), DVec3::ZERO);
        assert_eq!(gate.admit(&LIMITS, ms(0), &turned(0.0)), ALONE);
        assert_eq!(gate.admit(&LIMITS, ms(10), &turned(0.1)), Ok(()));
        assert_eq!(gate.admit(&LIMITS, ms(20), &turned(0.5)), JUMP);
        let same = Rigid::new(-turned(0.15).rotation, DVec3::ZERO);
        assert_eq!(gate.admit(&LIMITS, ms(30), &same), Ok(()));
    }

    #[test]
    fn after_a_silence_one_record_alone_is_not_believed() {
        let mut gate = Gate::default();
        assert_eq!(gate.admit(&LIMITS, ms(0), &at(0.0)), ALONE);
        assert_eq!(gate.admit(&LIMITS, ms(10), &at(0.0)), Ok(()));
        assert_eq!(gate.admit(&LIMITS, ms(1010), &at(0.3)), ALONE);
        assert_eq!(gate.admit(&LIMITS, ms(1020), &at(0.3)), Ok(()));
    }

    #[test]
    fn two_records_after_a_silence_that_do_not_agree_are_a_jump() {
        let mut gate = Gate::default();
        assert_eq!(gate.admit(&LIMITS, ms(0), &at(0.0)), ALONE);
        assert_eq!(gate.admit(&LIMITS, ms(10), &at(0.9)), JUMP);
        assert_eq!(gate.admit(&LIMITS, ms(20), &at(0.9)), Ok(()));
    }
}
