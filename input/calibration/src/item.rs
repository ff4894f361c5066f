//! What is measured by the handful, and how a message names one of it.

use std::fmt;

/// A kind of measurement that a calibration takes several of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Items {
    /// Marks touched with the stylus ([`Touch`](crate::Touch)).
    Touches,
    /// Poses of a stylus that pivots on one spot.
    Poses,
    /// Sightings with the left eye ([`Sighting`](crate::Sighting)).
    LeftSightings,
    /// Sightings with the right eye.
    RightSightings,
    /// Pairs of a near and a far mark that are to be sighted over.
    Pairs,
    /// Samples of the distorted field ([`FieldSample`](crate::FieldSample)).
    FieldSamples,
}

impl fmt::Display for Items {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Touches => "touched points",
            Self::Poses => "poses",
            Self::LeftSightings => "sightings of the left eye",
            Self::RightSightings => "sightings of the right eye",
            Self::Pairs => "pairs of marks",
            Self::FieldSamples => "samples of the field",
        })
    }
}

/// One measurement among several; its text counts from 1, as people do: "point 3".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Item {
    /// What it is one of.
    pub of: Items,
    /// Its index in the slice that was given, from 0.
    pub index: usize,
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = self.index + 1;
        match self.of {
            Items::Touches => write!(f, "point {number}"),
            Items::Poses => write!(f, "pose {number}"),
            Items::LeftSightings => write!(f, "sighting {number} of the left eye"),
            Items::RightSightings => write!(f, "sighting {number} of the right eye"),
            Items::Pairs => write!(f, "pair {number}"),
            Items::FieldSamples => write!(f, "sample {number}"),
        }
    }
}
