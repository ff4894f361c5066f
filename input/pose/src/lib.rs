//! Poses: where a head, a hand or a sensor is, when that was measured, and how far to trust it.
//!
//! Right-handed, metres, unit quaternions. A transform is named `target_from_source`: it takes
//! coordinates in `source` and gives the same point's coordinates in `target`, so that in a
//! product the neighbours must match (`table_from_head = table_from_tracker * tracker_from_head`).
//!
//! ```
//! use glam::{DQuat, DVec3};
//! use sandtable_pose::Rigid;
//!
//! let table_from_tracker = Rigid::new(DQuat::IDENTITY, DVec3::new(0.0, 0.0, 1.0));
//! let tracker_from_sensor = Rigid::new(DQuat::IDENTITY, DVec3::new(0.5, 0.0, 0.0));
//! let table_from_sensor = table_from_tracker * tracker_from_sensor;
//! assert_eq!(table_from_sensor.point(DVec3::ZERO), DVec3::new(0.5, 0.0, 1.0));
//! ```

mod nanos;
mod rigid;

pub use nanos::Nanos;
pub use rigid::Rigid;

use serde::{Deserialize, Serialize};

/// How far a pose may be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Validity {
    /// Measured, and recent.
    Live,
    /// The last live pose, shown on while its sensor is silent for a moment.
    Held,
    /// The sensor has been silent, or frozen, for too long: the pose says only where it was.
    Lost,
}

/// A rigid body's pose in the frame that its owner names, at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// `frame_from_body`: rotation, and the body's position in metres.
    pub frame_from_body: Rigid,
    /// When it was measured.
    pub time: Nanos,
    /// How far it may be trusted.
    pub validity: Validity,
}
