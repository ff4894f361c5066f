//! Motions: what simulated fingers do, as pure functions of the motion's time.

use crate::pinch::ContactGroups;
use crate::simulator::mixed;
use crate::{Fingers, Replay, Sample};
use sandtable_config::Device;
use sandtable_pose::Nanos;
use std::time::Duration;

/// What the fingers of two hands touch, and when that changes.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Nothing, and it stays so.
    Open,
    /// These states in turn, each for so long, and again from the first one.
    Repeat(Vec<(Duration, ContactGroups)>),
    /// By turns something and nothing, one thing or another by the seed.
    Seeded(u64),
}

const NONE: Fingers = Fingers(0);
const PINCH: Fingers = Fingers(0b00011);
const GRAB: Fingers = Fingers(0b00111);

/// What a seeded motion chooses from: pinches and grabs of either hand and of both, other fingers,
/// and hands that touch one another.
const PLAYED: [&[[Fingers; 2]]; 10] = [
    &[[PINCH, NONE]],
    &[[NONE, PINCH]],
    &[[GRAB, NONE]],
    &[[NONE, GRAB]],
    &[[NONE, PINCH], [PINCH, NONE]],
    &[[Fingers(0b10001), NONE]],
    &[[NONE, Fingers(0b01001)]],
    &[[Fingers::THUMB, Fingers::THUMB]],
    &[[PINCH, Fingers::INDEX]],
    &[[Fingers::ALL, Fingers::ALL]],
];

/// From one change of a seeded motion to the next, but for a jitter of half of that.
const PLAYED_EVERY: Duration = Duration::from_millis(600);

/// The least time that the end of a recording lasts.
const SHORTEST_END: Duration = Duration::from_secs(1);

impl Motion {
    /// The names that [`Motion::named`] knows.
    pub const NAMES: [&'static str; 4] = ["open", "pinch", "grab", "play"];

    /// A motion by its name, or `None` where it is not one of [`Motion::NAMES`].
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let by_turns = |right| {
            let second = Duration::from_secs(1);
            let groups = ContactGroups::new(&[[NONE, right]])?;
            Some(Self::Repeat(vec![
                (second, groups),
                (second, ContactGroups::default()),
            ]))
        };
        match name {
            "open" => Some(Self::Open),
            "pinch" => by_turns(PINCH),
            "grab" => by_turns(GRAB),
            "play" => Some(Self::Seeded(0)),
            _ => None,
        }
    }

    /// What the PINCH gloves of a recording touched, from their first message to the recording's
    /// end, and again; `None` where the device is none, or told nothing. Hands that were let go
    /// touch nothing.
    #[must_use]
    pub fn recorded(replay: &Replay, device: &str) -> Option<Self> {
        let Device::Pinch(_) = replay.rig().devices.get(device)? else {
            return None;
        };
        // The left hand's sample comes first, the right one's is of the same time.
        let mut left = None;
        let mut changes: Vec<(Nanos, ContactGroups)> = Vec::new();
        for sample in replay.samples(device) {
            let Sample::Hand(hand) = sample else {
                continue;
            };
            let contacts = hand.hand.contacts.unwrap_or_default();
            if hand.sensor == 1 {
                left = Some(contacts);
            } else if let Some(left) = left.take() {
                changes.push((hand.time, ContactGroups::of_contacts(&[left, contacts])?));
            }
        }
        let (last, _) = *changes.last()?;
        // The end may be the last change itself, which must show for a while.
        let end = replay.end().max(last + SHORTEST_END);
        let ends = changes.iter().skip(1).map(|(time, _)| *time).chain([end]);
        let lasting = changes.iter().zip(ends);
        let state =
            |(&(begun, groups), end): (&(Nanos, ContactGroups), Nanos)| (end.since(begun), groups);
        Some(Self::Repeat(lasting.map(state).collect()))
    }

    /// When the change with this number, from 0, comes after the motion's begin, and what the
    /// fingers touch from then on; `None` where there is none.
    #[must_use]
    pub fn change(&self, number: u64) -> Option<(Duration, ContactGroups)> {
        match self {
            Self::Open => None,
            Self::Repeat(states) => {
                let index = usize::try_from(number.checked_rem(states.len() as u64)?).ok()?;
                let round = u32::try_from(number / states.len() as u64).ok()?;
                let lasting = |states: &[(Duration, ContactGroups)]| -> Duration {
                    states.iter().map(|(lasting, _)| *lasting).sum()
                };
                let whole = lasting(states);
                // A round that takes no time would be followed by others without end.
                if whole.is_zero() && round > 0 {
                    return None;
                }
                let begun = whole.checked_mul(round)?;
                let begun = begun.checked_add(lasting(&states[..index]))?;
                Some((begun, states[index].1))
            }
            Self::Seeded(seed) => {
                let random = mixed(seed.wrapping_add(number.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
                let jitter = PLAYED_EVERY / 2 * (random >> 32 & 0xFF) as u32 / 0xFF;
                let time = PLAYED_EVERY.checked_mul(u32::try_from(number).ok()?)? + jitter;
                let played = PLAYED[(random % PLAYED.len() as u64) as usize];
                let groups = if number.is_multiple_of(2) {
                    played
                } else {
                    &[]
                };
                Some((time, ContactGroups::new(groups)?))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_motion() {
        for name in Motion::NAMES {
            assert!(Motion::named(name).is_some());
        }
        assert_eq!(Motion::named("dance"), None);
    }

    #[test]
    fn states_repeat_in_turn() {
        let motion = Motion::named("grab").unwrap();
        let times: Vec<_> = (0..5)
            .map(|number| motion.change(number).unwrap().0.as_secs())
            .collect();
        assert_eq!(times, [0, 1, 2, 3, 4]);
        assert_eq!(motion.change(4).unwrap().1, motion.change(0).unwrap().1);
        assert_eq!(motion.change(3).unwrap().1, ContactGroups::default());
        assert_eq!(Motion::Repeat(Vec::new()).change(0), None);
        let hasty = Motion::Repeat(vec![(Duration::ZERO, ContactGroups::default())]);
        assert_eq!([0, 1].map(|n| hasty.change(n).is_some()), [true, false]);
        assert_eq!(Motion::Open.change(0), None);
    }

    #[test]
    fn a_seeded_motion_is_its_seeds_own_and_plays_everything() {
        let changes = |seed| -> Vec<_> {
            (0..400)
                .map(|number| Motion::Seeded(seed).change(number).unwrap())
                .collect()
        };
        assert_eq!(changes(1), changes(1));
        assert_ne!(changes(1), changes(2));
        let changes = changes(7);
        assert!(changes.is_sorted_by_key(|(time, _)| *time));
        for played in PLAYED {
            let groups = ContactGroups::new(played).unwrap();
            assert!(changes.iter().any(|(_, played)| *played == groups));
        }
        assert!(
            changes[1..]
                .iter()
                .step_by(2)
                .all(|(_, g)| g.as_slice().is_empty())
        );
    }
}
