//! What people mean at one time.

use crate::FlightAxes;
use sandtable_config::Intent;
use sandtable_motion::Estimate;

/// What people mean at one time, whatever they mean it with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntentState {
    /// Where they look from: the head's sensor in the table's frame; `None` while nothing tells.
    pub look: Option<Estimate>,
    /// Where they reach to: the hand's sensor, likewise.
    pub reach: Option<Estimate>,
    /// How they fly.
    pub flight: FlightAxes,
    /// A bit an intent.
    held: u32,
    begun: u32,
}

// Each has a bit of its own.
const _: () = assert!(Intent::ALL.len() <= u32::BITS as usize);

fn bit(intent: Intent) -> u32 {
    1 << intent as u32
}

impl IntentState {
    /// Whether what the intent is asked for by is held.
    #[must_use]
    pub fn holds(&self, intent: Intent) -> bool {
        self.held & bit(intent) != 0
    }

    /// Whether that has begun since the update before.
    #[must_use]
    pub fn begins(&self, intent: Intent) -> bool {
        self.begun & bit(intent) != 0
    }

    /// Whether anything is held or pushed, so that the next moment may differ.
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.held != 0 || self.flight != FlightAxes::default()
    }

    pub(super) fn set_held(&mut self, intent: Intent, held: bool, before: bool) {
        if held {
            self.held |= bit(intent);
            if !before {
                self.begun |= bit(intent);
            }
        }
    }
}
