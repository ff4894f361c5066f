//! The correction of a distorted field: displacements on a regular grid.

use glam::{DVec3, UVec3};
use serde::{Deserialize, Serialize};

/// Beyond the grid the correction falls to nothing over this distance, in metres.
const FADE: f64 = 0.5;

/// The most nodes along an axis, and with it the most in all.
const MOST_NODES: u32 = 64;

/// What to add to a measured place to have the true one: a displacement at each node of a regular
/// grid, trilinear between (the look-up table of Ghazisaedy and others 1995).
///
/// Beyond the grid the displacement of the nearest place on its border holds on and fades
/// smoothly to nothing over 0.5 m: there it is a guess, and the guess is given up step by step.
/// Only places are corrected; attitudes stay as the tracker gives them.
///
/// It is written as plain numbers: `{ origin, spacing, counts, displacements }`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Numbers", into = "Numbers")]
pub struct Correction {
    origin: DVec3,
    spacing: DVec3,
    counts: UVec3,
    /// x runs fastest, then y.
    displacements: Vec<DVec3>,
    /// The far corner's grid coordinates, and nodes a metre; 0 along an axis with one node.
    last: DVec3,
    per_metre: DVec3,
}

/// Why numbers are no correction.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CorrectionError {
    /// An axis has no nodes or too many.
    #[error(
        "a correction has {counts} nodes along its axes, where each has 1 to {MOST_NODES}; calibrate anew"
    )]
    Counts {
        /// Nodes along x, y and z.
        counts: UVec3,
    },
    /// There is not one displacement a node.
    #[error(
        "a correction has {found} displacements, where {needed} nodes need one each; calibrate anew"
    )]
    Displacements {
        /// How many there are.
        found: usize,
        /// How many there should be.
        needed: usize,
    },
    /// The spacing is not positive, or a number is not finite.
    #[error("a correction's {part} must be {must}; calibrate anew")]
    Numbers {
        /// What of it.
        part: &'static str,
        /// What it must be.
        must: &'static str,
    },
}

impl Correction {
    /// A correction from its displacements in metres at `origin + spacing * (i, j, k)`, table
    /// frame and metres, with i running fastest, then j.
    ///
    /// # Errors
    /// With no node or more than 64 along an axis, with another number of displacements than of
    /// nodes, with a spacing that is not positive, and with what is not finite.
    pub fn new(
        origin: DVec3,
        spacing: DVec3,
        counts: UVec3,
        displacements: Vec<DVec3>,
    ) -> Result<Self, CorrectionError> {
        if counts.min_element() == 0 || counts.max_element() > MOST_NODES {
            return Err(CorrectionError::Counts { counts });
        }
        let needed = counts.element_product() as usize;
        if displacements.len() != needed {
            return Err(CorrectionError::Displacements {
                found: displacements.len(),
                needed,
            });
        }
        let must = |part, must| Err(CorrectionError::Numbers { part, must });
        if !origin.is_finite() {
            return must("origin", "finite");
        }
        if !spacing.is_finite() || spacing.min_element() < 1e-6 {
            return must("spacing", "finite and at least a micrometre");
        }
        if !displacements.iter().all(|d| d.is_finite()) {
            return must("displacements", "finite");
        }
        Ok(Self {
            origin,
            spacing,
            counts,
            displacements,
            last: (counts - 1).as_dvec3(),
            per_metre: spacing.recip(),
        })
    }

    /// The correction whose displacement at each node is what `field` says of its place: table
    /// frame, metres.
    ///
    /// # Errors
    /// As [`Correction::new`].
    pub fn sampled(
        origin: DVec3,
        spacing: DVec3,
        counts: UVec3,
        field: impl Fn(DVec3) -> DVec3,
    ) -> Result<Self, CorrectionError> {
        // Before anything is made for more nodes than there may be.
        if counts.max_element() > MOST_NODES {
            return Err(CorrectionError::Counts { counts });
        }
        let displacements = node_places(origin, spacing, counts).map(field).collect();
        Self::new(origin, spacing, counts, displacements)
    }

    /// The correction that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            origin: DVec3::ZERO,
            spacing: DVec3::ONE,
            counts: UVec3::ONE,
            displacements: vec![DVec3::ZERO],
            last: DVec3::ZERO,
            per_metre: DVec3::ONE,
        }
    }

    /// The true place of what was measured at `measured`: table frame, metres. What is not finite
    /// stays so. Neither allocates nor loops.
    #[must_use]
    pub fn correct(&self, measured: DVec3) -> DVec3 {
        measured + self.displacement(measured)
    }

    /// What [`Correction::correct`] adds, in metres.
    #[must_use]
    pub fn displacement(&self, measured: DVec3) -> DVec3 {
        let at = (measured - self.origin) * self.per_metre;
        let inside = at.clamp(DVec3::ZERO, self.last);
        let beyond = ((at - inside) * self.spacing).length();
        self.trilinear(inside) * fade(beyond)
    }

    /// The first node's place: table frame, metres.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// From one node to the next along each axis, in metres.
    #[must_use]
    pub fn spacing(&self) -> DVec3 {
        self.spacing
    }

    /// How many nodes there are along each axis.
    #[must_use]
    pub fn counts(&self) -> UVec3 {
        self.counts
    }

    /// The nodes' places, in the displacements' order: table frame, metres.
    pub fn nodes(&self) -> impl Iterator<Item = DVec3> + '_ {
        node_places(self.origin, self.spacing, self.counts)
    }

    /// The displacements at the nodes, in metres.
    #[must_use]
    pub fn displacements(&self) -> &[DVec3] {
        &self.displacements
    }

    fn trilinear(&self, inside: DVec3) -> DVec3 {
        // The last node belongs to the cell before it, if there is one.
        let low = inside.floor().min((self.last - 1.0).max(DVec3::ZERO));
        let part = inside - low;
        let low = low.as_uvec3();
        let high = (low + 1).min(self.counts - 1);
        let node = |x: u32, y: u32, z: u32| {
            self.displacements[((z * self.counts.y + y) * self.counts.x + x) as usize]
        };
        let along_x = |y, z| node(low.x, y, z).lerp(node(high.x, y, z), part.x);
        let along_y = |z| along_x(low.y, z).lerp(along_x(high.y, z), part.y);
        along_y(low.z).lerp(along_y(high.z), part.z)
    }
}

/// The places of a grid's nodes, x running fastest.
fn node_places(origin: DVec3, spacing: DVec3, counts: UVec3) -> impl Iterator<Item = DVec3> {
    (0..counts.z).flat_map(move |z| {
        (0..counts.y).flat_map(move |y| {
            (0..counts.x).map(move |x| origin + spacing * UVec3::new(x, y, z).as_dvec3())
        })
    })
}

/// The share of a correction that is left `beyond` metres from where it is known: 1 at 0, nothing
/// from 0.5 m on, with level ends.
#[must_use]
pub fn fade(beyond: f64) -> f64 {
    let t = (beyond / FADE).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

#[derive(Serialize, Deserialize)]
#[serde(rename = "Correction", deny_unknown_fields)]
struct Numbers {
    origin: DVec3,
    spacing: DVec3,
    counts: UVec3,
    displacements: Vec<DVec3>,
}

impl TryFrom<Numbers> for Correction {
    type Error = CorrectionError;

    fn try_from(numbers: Numbers) -> Result<Self, CorrectionError> {
        Self::new(
            numbers.origin,
            numbers.spacing,
            numbers.counts,
            numbers.displacements,
        )
    }
}

impl From<Correction> for Numbers {
    fn from(correction: Correction) -> Self {
        Self {
            origin: correction.origin,
            spacing: correction.spacing,
            counts: correction.counts,
            displacements: correction.displacements,
        }
    }
}
