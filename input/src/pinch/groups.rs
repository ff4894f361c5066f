//! Contact groups: which fingers are joined to which, on one hand or across both.

use crate::{Contacts, Fingers};

/// The most groups that there can be: ten fingers, two a group at least.
pub const GROUPS: usize = 5;

/// The groups of fingers that are joined, the newest first. A finger is in one of them at most,
/// and each has two fingers at least; whoever is in none touches nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContactGroups {
    /// Each group's fingers of the left and of the right hand.
    groups: [[Fingers; 2]; GROUPS],
    count: usize,
}

impl ContactGroups {
    /// Groups of left and right fingers, or `None` where they are none: a finger alone, one in two
    /// groups, what is no finger, or too many.
    #[must_use]
    pub fn new(groups: &[[Fingers; 2]]) -> Option<Self> {
        let mut whole = Self::default();
        for &group in groups {
            whole.add(group)?;
        }
        Some(whole)
    }

    /// The groups that make the left and the right hand's contacts, or `None` where none do: a
    /// finger that touches one that does not touch it. Which was the newest is not told by them.
    #[must_use]
    pub fn of_contacts(hands: &[Contacts; 2]) -> Option<Self> {
        let mut groups = Self::default();
        for (hand, contacts) in hands.iter().enumerate() {
            for finger in 0..5 {
                let this = Fingers::number(finger);
                let (own, other) = (contacts.own[finger], contacts.other[finger]);
                let known = groups.joined()[hand].contains(this);
                if known || own.with(other).is_empty() {
                    continue;
                }
                let own = own.with(this);
                groups.add(if hand == 0 {
                    [own, other]
                } else {
                    [other, own]
                })?;
            }
        }
        (groups.contacts() == *hands).then_some(groups)
    }

    /// What is left of them where one hand, or both, have no glove: `present` tells of the left
    /// and the right one.
    #[must_use]
    pub fn of_gloves(&self, present: [bool; 2]) -> Self {
        let mut left = Self::default();
        for group in self.as_slice() {
            let mut worn = *group;
            for (fingers, present) in worn.iter_mut().zip(present) {
                if !present {
                    *fingers = Fingers::default();
                }
            }
            // One finger alone is no group, and is left out.
            let _ = left.add(worn);
        }
        left
    }

    /// Adds the next older group, or gives `None` where that would be none.
    pub(super) fn add(&mut self, [left, right]: [Fingers; 2]) -> Option<()> {
        let [joined_left, joined_right] = self.joined();
        let fingers = Fingers::ALL.contains(left.with(right));
        let alone = left.count() + right.count() < 2;
        let twice = !left.only(joined_left).is_empty() || !right.only(joined_right).is_empty();
        if !fingers || alone || twice {
            return None;
        }
        *self.groups.get_mut(self.count)? = [left, right];
        self.count += 1;
        Some(())
    }

    /// The groups' left and right fingers, the newest group first.
    #[must_use]
    pub fn as_slice(&self) -> &[[Fingers; 2]] {
        &self.groups[..self.count]
    }

    /// The fingers of the left and of the right hand that are in any group.
    #[must_use]
    pub fn joined(&self) -> [Fingers; 2] {
        let none = [Fingers::default(); 2];
        self.as_slice()
            .iter()
            .fold(none, |[l, r], &[left, right]| [l.with(left), r.with(right)])
    }

    /// What touches what on the left and on the right hand.
    #[must_use]
    pub fn contacts(&self) -> [Contacts; 2] {
        let mut hands = [Contacts::default(); 2];
        for group in self.as_slice() {
            for (hand, contacts) in hands.iter_mut().enumerate() {
                let (own, other) = (group[hand], group[1 - hand]);
                for finger in 0..5 {
                    let this = Fingers::number(finger);
                    if own.contains(this) {
                        contacts.own[finger] = own.without(this);
                        contacts.other[finger] = other;
                    }
                }
            }
        }
        hands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Fingers = Fingers(0);

    #[test]
    fn each_finger_of_a_group_touches_all_others_of_it() {
        let thumb_index = Fingers::THUMB.with(Fingers::INDEX);
        let groups = ContactGroups::new(&[
            [thumb_index, Fingers::INDEX],
            [NONE, Fingers::RING.with(Fingers::LITTLE)],
        ]);
        let [left, right] = groups.unwrap().contacts();
        assert_eq!(left.own, [Fingers::INDEX, Fingers::THUMB, NONE, NONE, NONE]);
        assert_eq!(
            left.other,
            [Fingers::INDEX, Fingers::INDEX, NONE, NONE, NONE]
        );
        assert_eq!(
            right.own,
            [NONE, NONE, NONE, Fingers::LITTLE, Fingers::RING]
        );
        assert_eq!(right.other, [NONE, thumb_index, NONE, NONE, NONE]);
        assert_eq!(
            ContactGroups::default().contacts(),
            [Contacts::default(); 2]
        );
    }

    #[test]
    fn contacts_are_made_of_groups_again() {
        let thumb_index = Fingers::THUMB.with(Fingers::INDEX);
        let groups = ContactGroups::new(&[
            [thumb_index, Fingers::INDEX],
            [Fingers::LITTLE, Fingers::RING.with(Fingers::LITTLE)],
        ])
        .unwrap();
        let contacts = groups.contacts();
        assert_eq!(ContactGroups::of_contacts(&contacts), Some(groups));
        let right = ContactGroups::new(&[[NONE, thumb_index]]).unwrap();
        assert_eq!(ContactGroups::of_contacts(&right.contacts()), Some(right));
        // The left thumb touches an index finger that knows nothing of it.
        let mut one_sided = [Contacts::default(); 2];
        one_sided[0].own[0] = Fingers::INDEX;
        assert_eq!(ContactGroups::of_contacts(&one_sided), None);
    }

    #[test]
    fn a_hand_without_a_glove_touches_nothing() {
        let thumb_index = Fingers::THUMB.with(Fingers::INDEX);
        let groups = ContactGroups::new(&[
            [thumb_index, Fingers::INDEX],
            [Fingers::LITTLE, Fingers::LITTLE],
        ])
        .unwrap();
        assert_eq!(groups.of_gloves([true; 2]), groups);
        let left = groups.of_gloves([true, false]);
        assert_eq!(left.as_slice(), [[thumb_index, NONE]]);
        assert!(groups.of_gloves([false, true]).as_slice().is_empty());
    }

    #[test]
    fn what_are_no_groups_is_refused() {
        let pair = Fingers::THUMB.with(Fingers::INDEX);
        assert_eq!(ContactGroups::new(&[[Fingers::THUMB, NONE]]), None);
        assert_eq!(ContactGroups::new(&[[NONE, NONE]]), None);
        assert_eq!(ContactGroups::new(&[[pair, NONE], [pair, NONE]]), None);
        assert_eq!(ContactGroups::new(&[[Fingers(0b10_0001), NONE]]), None);
        assert!(ContactGroups::new(&[[pair, NONE], [NONE, pair]]).is_some());
        // Five of them are the ten fingers.
        let five: Vec<_> = (0..5).map(|finger| [Fingers::number(finger); 2]).collect();
        let groups = ContactGroups::new(&five).unwrap();
        assert_eq!(groups.joined(), [Fingers::ALL; 2]);
        assert_eq!(groups.as_slice(), five);
    }
}
