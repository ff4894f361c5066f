//! Tracks: what is remembered of one sensor from one record to the next.

use crate::gate::{Gate, GateLimits, Refusal};
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

/// One sensor's past, of a device whose records are told apart by their raw values `R`.
#[derive(Clone, Debug)]
pub(crate) struct Track<R> {
    gate: Gate,
    raw: Option<R>,
    /// How many records in a row were the same.
    equal: u32,
    newest: Nanos,
}

impl<R> Default for Track<R> {
    fn default() -> Self {
        Self {
            gate: Gate::default(),
            raw: None,
            equal: 0,
            newest: Nanos::default(),
        }
    }
}

impl<R: PartialEq> Track<R> {
    /// Takes note of a record, whether or not it is a pose.
    pub(crate) fn hear(&mut self, raw: R) {
        if self.raw.as_ref() == Some(&raw) {
            self.equal = self.equal.saturating_add(1);
        } else {
            self.equal = 1;
            self.raw = Some(raw);
        }
    }

    /// Whether a record has come since it was made or restarted.
    pub(crate) fn is_heard(&self) -> bool {
        self.raw.is_some()
    }

    /// How many records in a row were the same.
    pub(crate) fn equal(&self) -> u32 {
        self.equal
    }

    /// The time that a pose measured at `measured` is given, after all before it; or why it
    /// may not be let out.
    pub(crate) fn admit(
        &mut self,
        limits: &GateLimits,
        measured: Nanos,
        pose: &Rigid,
    ) -> Result<Nanos, Refusal> {
        let time = measured.max(self.newest + Duration::from_nanos(1));
        self.gate.admit(limits, time, pose)?;
        self.newest = time;
        Ok(time)
    }

    /// Forgets all but the time, which never goes back.
    pub(crate) fn restart(&mut self) {
        *self = Self {
            newest: self.newest,
            ..Self::default()
        };
    }
}
