//! Eyes: from a tracked head to two eye points.

use crate::{Placement, Screen, View};
use glam::DVec3;
use sandtable_pose::Rigid;
use serde::{Deserialize, Serialize};

/// What belongs to the left and to the right eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StereoPair<T> {
    /// The left eye's.
    pub left: T,
    /// The right eye's.
    pub right: T,
}

impl<T> StereoPair<T> {
    /// Left, then right.
    pub fn into_array(self) -> [T; 2] {
        [self.left, self.right]
    }

    /// The pair with left and right exchanged.
    #[must_use]
    pub fn swapped(self) -> Self {
        Self {
            left: self.right,
            right: self.left,
        }
    }

    /// Applies `f` to both.
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> StereoPair<U> {
        StereoPair {
            left: f(self.left),
            right: f(self.right),
        }
    }
}

/// Eye points in metres, in the frame that the owner names.
pub type Eyes = StereoPair<DVec3>;

/// Where the eyes sit on a tracked head, in the head sensor's own axes and metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EyesInHead {
    /// The middle between the eyes.
    pub middle: DVec3,
    /// The unit vector from the left eye to the right eye.
    pub rightwards: DVec3,
    /// The distance between the eyes.
    pub interpupillary: f64,
}

impl EyesInHead {
    /// The eyes in head axes.
    #[must_use]
    pub fn eyes(&self) -> Eyes {
        let half = 0.5 * self.interpupillary * self.rightwards;
        StereoPair {
            left: self.middle - half,
            right: self.middle + half,
        }
    }

    /// The eyes of a head at `table_from_head`, in table metres.
    ///
    /// The head's attitude moves the eye points and nothing else: a fixed screen's picture depends
    /// on where the eyes are, never on where they look.
    #[must_use]
    pub fn on_table(&self, table_from_head: &Rigid) -> Eyes {
        self.eyes().map(|eye| table_from_head.point(eye))
    }
}

impl StereoPair<View> {
    /// The two views of a screen on the table, mapped into the world by `placement`.
    ///
    /// `eyes` and `screen` are in table metres; `size` is in pixels.
    #[must_use]
    pub fn on_table(eyes: Eyes, screen: &Screen, placement: &Placement, size: [u32; 2]) -> Self {
        let window = screen.map(|corner| placement.world_from_table(corner));
        eyes.map(|eye| View {
            eye: placement.world_from_table(eye),
            window,
            size,
        })
    }
}
