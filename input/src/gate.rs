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

/// One sensor's gate.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gate {
    passed: Option<(Nanos, Rigid)>,
    refused: Option<(Nanos, Rigid)>,
}

impl Gate {
    /// Whether `pose`, measured at `time`, may be let out.
    pub(crate) fn admits(&mut self, limits: &GateLimits, time: Nanos, pose: &Rigid) -> bool {
        let fresh = self
            .passed
            .filter(|(then, _)| time.since(*then) <= limits.memory);
        // A new place is believed only after the old one is forgotten, so that it shows as lost.
        let reference = fresh.or(self.refused);
        let plausible = reference.is_some_and(|(then, from)| {
            time.since(then) <= limits.memory && limits.reachable(&from, pose, time.since(then))
        });
        if plausible {
            self.passed = Some((time, *pose));
            self.refused = None;
        } else {
            self.refused = Some((time, *pose));
        }
        plausible
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

    fn at(x: f64) -> Rigid {
        Rigid::new(DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0))
    }

    fn ms(ms: u64) -> Nanos {
        Nanos(ms * 1_000_000)
    }

    #[test]
    fn two_agreeing_records_open_it_and_motion_keeps_it_open() {
        let mut gate = Gate::default();
        assert!(!gate.admits(&LIMITS, ms(0), &at(0.0)));
        for step in 1..100 {
            // 2 m/s.
            assert!(gate.admits(&LIMITS, ms(10 * step), &at(0.02 * step as f64)));
        }
    }

    #[test]
    fn a_jump_is_refused_and_does_not_hide_what_follows() {
        let mut gate = Gate::default();
        gate.admits(&LIMITS, ms(0), &at(0.0));
        assert!(gate.admits(&LIMITS, ms(10), &at(0.0)));
        assert!(!gate.admits(&LIMITS, ms(20), &at(0.4)));
        assert!(gate.admits(&LIMITS, ms(30), &at(0.0)));
    }

    #[test]
    fn a_flip_to_the_mirrored_place_is_believed_only_after_it_was_lost() {
        let mut gate = Gate::default();
        gate.admits(&LIMITS, ms(0), &at(0.9));
        assert!(gate.admits(&LIMITS, ms(10), &at(0.9)));
        for time in (20..=260).step_by(10) {
            assert!(!gate.admits(&LIMITS, ms(time), &at(-0.9)));
        }
        assert!(gate.admits(&LIMITS, ms(270), &at(-0.9)));
    }

    #[test]
    fn a_turn_beyond_the_limit_is_refused_whatever_the_quaternions_sign() {
        let mut gate = Gate::default();
        let turned = |angle: f64| Rigid::new(DQuat::from_rotation_z(angle), DVec3::ZERO);
        gate.admits(&LIMITS, ms(0), &turned(0.0));
        assert!(gate.admits(&LIMITS, ms(10), &turned(0.1)));
        assert!(!gate.admits(&LIMITS, ms(20), &turned(0.5)));
        let same = Rigid::new(-turned(0.15).rotation, DVec3::ZERO);
        assert!(gate.admits(&LIMITS, ms(30), &same));
    }

    #[test]
    fn after_a_silence_one_record_alone_is_not_believed() {
        let mut gate = Gate::default();
        gate.admits(&LIMITS, ms(0), &at(0.0));
        assert!(gate.admits(&LIMITS, ms(10), &at(0.0)));
        assert!(!gate.admits(&LIMITS, ms(1010), &at(0.3)));
        assert!(gate.admits(&LIMITS, ms(1020), &at(0.3)));
    }
}
