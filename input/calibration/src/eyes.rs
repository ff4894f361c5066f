//! Where the eyes sit on a head, from sightings over two marks.
//!
//! With one eye closed the viewer brings a near and a far mark into line. The open eye then lies
//! on the line through both, beyond the near one. Seen from the head sensor these lines change
//! with every turn of the head, while the eye stays: it is the point nearest to all lines.

use crate::decomposition::{outer, symmetric_eigen, trace};
use crate::outlier::{Deleted, Deletions, FALSE_SHARE, Problem};
use crate::{CalibrationError, Item, Items, Outlier, Residuals, plausible};
use glam::{DMat3, DVec3};
use sandtable_pose::Rigid;
use serde::{Deserialize, Serialize};

/// Two lines cross or miss; the third can disagree.
const LEAST: usize = 3;

/// More than anybody sights.
const MOST: usize = 1000;

/// The least distance between a near and its far mark, in metres.
const MARKS_APART: f64 = 0.1;

/// The least RMS angle between the lines and their mean direction, in radians.
const SIGHT_LIMIT: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// The distances between people's eyes, in metres, with some room.
const INTERPUPILLARY: std::ops::RangeInclusive<f64> = 0.045..=0.080;

/// A mean of [`seen_rightwards`] below this says that left and right are exchanged; nearer to 0 it
/// says nothing.
const EXCHANGED: f64 = -0.1;

/// One eye brings two marks into line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The head sensor's pose while the marks are in line: table frame, metres.
    pub table_from_sensor: Rigid,
    /// The mark nearer to the viewer: table frame, metres.
    pub near: DVec3,
    /// The mark farther from the viewer: table frame, metres.
    pub far: DVec3,
}

/// Whose sightings they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The viewer's left eye.
    Left,
    /// The viewer's right eye.
    Right,
}

/// One eye's place, and how well the sightings agree on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Eye {
    /// The eye in the head sensor's own axes, in metres.
    pub position: DVec3,
    /// The covariance of `position`, in square metres, as the residuals tell it.
    pub covariance: DMat3,
    /// The RMS angle between the lines of sight and their mean direction in the sensor's axes, in
    /// radians: the wider, the better is the eye's distance along them known.
    pub spread: f64,
    /// The distance of each line of sight from the eye, in metres.
    pub residuals: Residuals,
    /// Sightings that disagree with all others; they are counted in, as every sighting is.
    pub outliers: Vec<Outlier>,
}

/// Where the eyes sit, in the head sensor's own axes and metres: what a rig calls `eyes`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Eyes {
    /// The middle between the eyes.
    pub middle: DVec3,
    /// The unit vector from the left eye to the right eye.
    pub rightwards: DVec3,
    /// The distance between the eyes.
    pub interpupillary: f64,
}

/// Both eyes, and what they were found from.
#[derive(Clone, Debug, PartialEq)]
pub struct LocatedEyes {
    /// What the rig needs.
    pub eyes: Eyes,
    /// The standard error of the distance between the eyes, in metres.
    pub interpupillary_error: f64,
    /// The left eye alone.
    pub left: Eye,
    /// The right eye alone.
    pub right: Eye,
}

/// Whether pairs of a near and a far mark, in table metres, can be sighted over: asked before
/// anybody does.
///
/// # Errors
/// With what is not finite or beyond 100 m, and with a near and a far mark within 0.1 m of one
/// another.
pub fn admit_pairs(pairs: &[[DVec3; 2]]) -> Result<(), CalibrationError> {
    let of = Items::Pairs;
    for (index, &[near, far]) in pairs.iter().enumerate() {
        apart(Item { of, index }, near, far)?;
    }
    Ok(())
}

/// Finds both eyes from sightings with either.
///
/// # Errors
/// Whatever [`locate_eye`] refuses; where the eyes come out less than 45 or more than 80 mm apart;
/// and where the left one comes out to the right, with the table's z axis as up.
pub fn locate_eyes(
    left_sightings: &[Sighting],
    right_sightings: &[Sighting],
) -> Result<LocatedEyes, CalibrationError> {
    let left = locate_eye(Side::Left, left_sightings)?;
    let right = locate_eye(Side::Right, right_sightings)?;
    let across = right.position - left.position;
    let interpupillary = across.length();
    if !INTERPUPILLARY.contains(&interpupillary) {
        return Err(CalibrationError::Interpupillary {
            millimetres: 1e3 * interpupillary,
            least_mm: 1e3 * INTERPUPILLARY.start(),
            most_mm: 1e3 * INTERPUPILLARY.end(),
        });
    }
    let rightwards = across / interpupillary;
    let both = left_sightings.iter().chain(right_sightings);
    let seen: f64 = both.map(|s| seen_rightwards(s, rightwards)).sum();
    if seen / ((left_sightings.len() + right_sightings.len()) as f64) < EXCHANGED {
        return Err(CalibrationError::EyesExchanged);
    }
    let covariance = left.covariance + right.covariance;
    Ok(LocatedEyes {
        eyes: Eyes {
            middle: 0.5 * (left.position + right.position),
            rightwards,
            interpupillary,
        },
        interpupillary_error: rightwards.dot(covariance * rightwards).sqrt(),
        left,
        right,
    })
}

/// Finds one eye in the head sensor's axes: the point nearest to all lines of sight, by least
/// squares of the distances.
///
/// Outliers are named by leaving each sighting out in turn ([`Outlier`]).
///
/// # Errors
/// With fewer than 3 sightings or more than 1000; with what is not finite, beyond 100 m or no
/// rotation; with a near and a far mark within 0.1 m of one another; where the lines lie within 5
/// degrees RMS of their mean direction, seen from the sensor; and where the eye comes out on the
/// far side of a near mark.
pub fn locate_eye(side: Side, sightings: &[Sighting]) -> Result<Eye, CalibrationError> {
    let of = match side {
        Side::Left => Items::LeftSightings,
        Side::Right => Items::RightSightings,
    };
    plausible::count(of, sightings.len(), LEAST, MOST)?;
    let lines = sightings
        .iter()
        .enumerate()
        .map(|(index, sighting)| Line::of(Item { of, index }, sighting))
        .collect::<Result<Vec<_>, _>>()?;

    let all: Vec<usize> = (0..lines.len()).collect();
    let fit = Fit::through(&lines, &all);
    let (eigenvalues, _) =
        symmetric_eigen(&fit.normal).ok_or(CalibrationError::NoConvergence { of })?;
    let spread = (eigenvalues.z / lines.len() as f64)
        .clamp(0.0, 1.0)
        .sqrt()
        .asin();
    if spread < SIGHT_LIMIT {
        return Err(CalibrationError::ParallelSight {
            of,
            degrees: spread.to_degrees(),
            limit_degrees: SIGHT_LIMIT.to_degrees(),
        });
    }
    if let Some(index) = lines
        .iter()
        .position(|line| (fit.eye - line.near).dot(line.towards_eye) <= 0.0)
    {
        return Err(CalibrationError::BeyondMark {
            item: Item { of, index },
        });
    }

    let outliers = Problem {
        of,
        count: lines.len(),
        equations: 2,
        parameters: 3,
        false_share: FALSE_SHARE,
    }
    .outliers(|kept| Some(Fit::through(&lines, kept).delete_each(&lines, kept)));
    let residuals = Residuals::of(lines.iter().map(|line| line.offset(fit.eye).length()));
    let variance = residuals.sum_of_squares() / (2 * lines.len() - 3) as f64;
    Ok(Eye {
        position: fit.eye,
        covariance: fit.inverse * variance,
        spread,
        residuals,
        outliers,
    })
}

impl Eye {
    /// The standard error of the position, as a length in metres.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        trace(&self.covariance).sqrt()
    }
}

/// How far `rightwards`, in the sensor's axes, points to the right of the line of sight, from -1
/// to 1; near 0 where the viewer looks straight down and left or right cannot be told.
fn seen_rightwards(sighting: &Sighting, rightwards: DVec3) -> f64 {
    let ahead = (sighting.far - sighting.near).normalize_or_zero();
    let right = ahead.cross(DVec3::Z);
    right.dot(sighting.table_from_sensor.direction(rightwards))
}

/// The unit vector from the far to the near mark, which are far enough from one another.
fn apart(item: Item, near: DVec3, far: DVec3) -> Result<DVec3, CalibrationError> {
    plausible::place(item, "the near mark's place", near)?;
    plausible::place(item, "the far mark's place", far)?;
    let metres = near.distance(far);
    if metres < MARKS_APART {
        return Err(CalibrationError::MarksTooClose {
            item,
            metres,
            limit: MARKS_APART,
        });
    }
    Ok((near - far) / metres)
}

/// A line of sight in the sensor's axes.
struct Line {
    near: DVec3,
    /// The unit vector from the far to the near mark.
    towards_eye: DVec3,
}

impl Line {
    fn of(item: Item, sighting: &Sighting) -> Result<Self, CalibrationError> {
        let towards_eye = apart(item, sighting.near, sighting.far)?;
        let sensor_from_table = plausible::pose(item, &sighting.table_from_sensor)?.inverse();
        Ok(Self {
            near: sensor_from_table.point(sighting.near),
            towards_eye: sensor_from_table.direction(towards_eye),
        })
    }

    /// Takes the part of a vector across the line.
    fn across(&self) -> DMat3 {
        DMat3::IDENTITY - outer(self.towards_eye, self.towards_eye)
    }

    /// From the line to `point`, at right angles to the line.
    fn offset(&self, point: DVec3) -> DVec3 {
        (point - self.near).reject_from_normalized(self.towards_eye)
    }
}

struct Fit {
    eye: DVec3,
    normal: DMat3,
    inverse: DMat3,
}

impl Fit {
    /// The fit through the lines `kept`; where they are parallel, numbers that are not finite or
    /// are far off.
    fn through(lines: &[Line], kept: &[usize]) -> Self {
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for line in kept.iter().map(|&index| &lines[index]) {
            let across = line.across();
            normal += across;
            right += across * line.near;
        }
        let inverse = normal.inverse();
        Self {
            eye: inverse * right,
            normal,
            inverse,
        }
    }

    fn delete_each(&self, lines: &[Line], kept: &[usize]) -> Deletions {
        let kept = || kept.iter().map(|&index| &lines[index]);
        let sum = kept().map(|l| l.offset(self.eye).length_squared()).sum();
        let each = kept().map(|line| {
            let hat = line.across() * self.inverse * line.across();
            Deleted::linear(sum, line.offset(self.eye), &hat)
        });
        Deletions {
            sum,
            each: each.collect(),
        }
    }
}
