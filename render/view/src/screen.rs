//! Screens: a flat window's three corners.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A window as the eye sees it: a parallelogram by three of its corners, in metres.
///
/// The frame (table or world) is its owner's. On the table it is a rectangle; mapped to the world
/// by a [`Placement`](crate::Placement) with vertical exaggeration, it may become a parallelogram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screen {
    /// The lower left corner of the picture.
    pub lower_left: DVec3,
    /// The lower right corner of the picture.
    pub lower_right: DVec3,
    /// The upper left corner of the picture.
    pub upper_left: DVec3,
}

impl Screen {
    /// A horizontal glass of `width` (x) by `depth` (y) metres, centred on the table's origin.
    #[must_use]
    pub fn horizontal(width: f64, depth: f64) -> Self {
        let (x, y) = (0.5 * width, 0.5 * depth);
        Self {
            lower_left: DVec3::new(-x, -y, 0.0),
            lower_right: DVec3::new(x, -y, 0.0),
            upper_left: DVec3::new(-x, y, 0.0),
        }
    }

    /// The upper right corner.
    #[must_use]
    pub fn upper_right(&self) -> DVec3 {
        self.lower_right + self.upper_left - self.lower_left
    }

    /// The middle of the window.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.lower_right + self.upper_left)
    }

    /// From the lower left to the lower right corner.
    #[must_use]
    pub fn across(&self) -> DVec3 {
        self.lower_right - self.lower_left
    }

    /// From the lower left to the upper left corner.
    #[must_use]
    pub fn upwards(&self) -> DVec3 {
        self.upper_left - self.lower_left
    }

    /// The unit normal on the side from which the corners run as named (towards the user), or
    /// `None` where the corners lie in a line.
    #[must_use]
    pub fn normal(&self) -> Option<DVec3> {
        self.across().cross(self.upwards()).try_normalize()
    }

    /// The screen with every corner mapped by `map`.
    #[must_use]
    pub fn map(&self, map: impl Fn(DVec3) -> DVec3) -> Self {
        Self {
            lower_left: map(self.lower_left),
            lower_right: map(self.lower_right),
            upper_left: map(self.upper_left),
        }
    }
}
