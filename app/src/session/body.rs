//! A head or a hand: tracked, or at rest where the mouse may move it.

use glam::{DQuat, DVec3};
use sandtable_config::SensorName;
use sandtable_input::Estimate;
use sandtable_pose::{Rigid, Validity};

/// A head or a hand in the table's frame.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    sensor: Option<SensorName>,
    table_from_body: Rigid,
    /// How far the tracked pose may be trusted; `None` while nothing has ever tracked it.
    validity: Option<Validity>,
}

impl Default for Body {
    /// A body that nothing tracks, at the table's origin.
    fn default() -> Self {
        Self {
            sensor: None,
            table_from_body: Rigid::IDENTITY,
            validity: None,
        }
    }
}

/// How far from the table's origin the mouse may move a body, in metres.
const REACH: f64 = 3.0;

impl Body {
    /// A body that rests at `rest` until its sensor says otherwise.
    pub(crate) fn new(sensor: Option<SensorName>, rest: Rigid) -> Self {
        Self {
            sensor,
            table_from_body: rest,
            validity: None,
        }
    }

    /// Takes in what its sensor tells. A lost pose leaves the body where it last was: nothing snaps
    /// back to its rest.
    pub(crate) fn follow(&mut self, told: Option<Estimate>) {
        if let Some(pose) = told.map(|told| told.pose) {
            self.table_from_body = pose.frame_from_body;
            self.validity = Some(pose.validity);
        }
    }

    /// Where it is.
    pub(crate) fn table_from_body(&self) -> Rigid {
        self.table_from_body
    }

    /// Whether a sensor moves it now, so that the mouse must not.
    pub(crate) fn is_tracked(&self) -> bool {
        matches!(self.validity, Some(Validity::Live | Validity::Held))
    }

    /// Moves it by `by` table metres, unless it is tracked.
    pub(crate) fn push(&mut self, by: DVec3) {
        if !self.is_tracked() && by.is_finite() {
            let to = self.table_from_body.translation + by;
            self.table_from_body.translation = to.clamp_length_max(REACH);
        }
    }

    /// Turns it about the table's vertical, counter-clockwise seen from above, unless it is tracked.
    pub(crate) fn turn(&mut self, radians: f64) {
        if !self.is_tracked() && radians.is_finite() {
            let turned = DQuat::from_rotation_z(radians) * self.table_from_body.rotation;
            self.table_from_body.rotation = turned.normalize();
        }
    }

    /// Puts it at `to` in table metres, unless it is tracked.
    pub(crate) fn place(&mut self, to: DVec3) {
        self.push(to - self.table_from_body.translation);
    }

    /// Puts it where it was recorded, unless it is tracked.
    pub(crate) fn rest_at(&mut self, table_from_body: Rigid) {
        if !self.is_tracked() {
            self.table_from_body = table_from_body;
        }
    }

    /// How it is, for the panel: "flock/1 live", "at rest".
    pub(crate) fn state(&self) -> (String, bool) {
        let Some(sensor) = &self.sensor else {
            return ("untracked; the mouse moves it".into(), true);
        };
        match self.validity {
            None => (
                format!("{sensor} has said nothing yet; the mouse moves it"),
                false,
            ),
            Some(Validity::Live) => (format!("{sensor} live"), true),
            Some(Validity::Held) => (format!("{sensor} held"), false),
            Some(Validity::Lost) => (format!("{sensor} lost; the mouse moves it"), false),
        }
    }
}
