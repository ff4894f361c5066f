//! Why measurements cannot be turned into a calibration.

use crate::{Item, Items};

/// Why there is no result. Each text names the measurements, counted from 1, and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// Fewer than the unknowns ask for.
    #[error("{found} {of} are too few; give at least {needed}")]
    TooFew {
        /// What there are too few of.
        of: Items,
        /// How many there are.
        found: usize,
        /// The least that is needed.
        needed: usize,
    },
    /// More than any person measures; a fit through them would only take long.
    #[error("{found} {of} are more than the {most} that are read; give every other one, or fewer")]
    TooMany {
        /// What there are too many of.
        of: Items,
        /// How many there are.
        found: usize,
        /// The most that is read.
        most: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("{item}: {part} is not finite; leave it out, or measure it again")]
    NotFinite {
        /// Which one.
        item: Item,
        /// What of it.
        part: &'static str,
    },
    /// A coordinate lies where no tracker reaches.
    #[error(
        "{item}: {part} has a coordinate of {metres:.1}, where {limit:.0} m is the most; give it in metres, not in millimetres or inches"
    )]
    OutOfReach {
        /// Which one.
        item: Item,
        /// What of it.
        part: &'static str,
        /// The largest coordinate.
        metres: f64,
        /// The most that is allowed.
        limit: f64,
    },
    /// A quaternion does not have length 1.
    #[error(
        "{item}: the attitude is a quaternion of length {length:.4}, which is no rotation; leave it out, or measure it again"
    )]
    NoRotation {
        /// Which one.
        item: Item,
        /// The quaternion's length.
        length: f64,
    },
    /// Two marks are the same place.
    #[error(
        "{first} and {second} were touched on marks at the same place ({millimetres:.2} mm apart); give each mark its own place, and touch each once"
    )]
    SameMark {
        /// The earlier one.
        first: Item,
        /// The later one.
        second: Item,
        /// The distance between the marks.
        millimetres: f64,
    },
    /// The tracker gave one position twice, to the last bit.
    #[error(
        "{first} and {second} were measured at exactly the same position, though their marks lie apart: the tracker stood still; see that it runs, and touch both again"
    )]
    SameMeasurement {
        /// The earlier one.
        first: Item,
        /// The later one.
        second: Item,
    },
    /// The marks do not fix the turn about the line that they lie in.
    #[error(
        "the marks lie nearly in the line through {first} and {second}: they spread {percent:.2} % as far across it as along it, where at least {limit_percent:.0} % are needed; touch a mark well off that line"
    )]
    MarksInLine {
        /// An end of the line.
        first: Item,
        /// Its other end.
        second: Item,
        /// The spread across the line in per cent of that along it.
        percent: f64,
        /// The least that is accepted.
        limit_percent: f64,
    },
    /// The marks fix no field above and below the plane that they lie in.
    #[error(
        "the marks lie nearly in a plane: they spread {percent:.1} % as far across it as along it, where at least {limit_percent:.0} % are needed, and above and below it nothing would be known; raise some of them, on posts or blocks, to where hands and heads move"
    )]
    MarksInPlane {
        /// The spread across the plane in per cent of the widest along it.
        percent: f64,
        /// The least that is accepted.
        limit_percent: f64,
    },
    /// The marks are not in a line, but their measured positions are.
    #[error(
        "the positions measured lie nearly in the line through {first} and {second} ({percent:.2} % across it, at least {limit_percent:.0} % are needed), though the marks do not: the tracker loses an axis; see its axis map and its hemisphere, and touch the marks again"
    )]
    MeasurementsInLine {
        /// An end of the line.
        first: Item,
        /// Its other end.
        second: Item,
        /// The spread across the line in per cent of that along it.
        percent: f64,
        /// The least that is accepted.
        limit_percent: f64,
    },
    /// A mirror explains the touches, and no rotation does.
    #[error(
        "the touched points fit a mirror image to {mirrored_mm:.1} mm RMS, but a rotation only to {rotated_mm:.1} mm: the tracker's axes are left-handed, or it keeps to the wrong hemisphere; turn the sign of one axis in its axis map, or set its hemisphere, and touch the marks again"
    )]
    Mirrored {
        /// RMS distance of the best rotation with a shift and a scale.
        rotated_mm: f64,
        /// The same of the best mirror image.
        mirrored_mm: f64,
    },
    /// The stylus was not tilted far enough.
    #[error(
        "the attitudes of the pivoting stylus differ by at most {degrees:.1} degrees, where {limit_degrees:.0} are needed; tilt it farther, to all sides"
    )]
    NarrowPivot {
        /// The largest angle between two of them.
        degrees: f64,
        /// The least that is accepted.
        limit_degrees: f64,
    },
    /// The stylus was turned about one axis only, along which the tip is not determined.
    #[error(
        "the pivoting stylus was turned about one axis only: that axis itself moved by {degrees:.1} degrees RMS, where {limit_degrees:.0} are needed; tilt it to all sides, not to and fro"
    )]
    OneAxis {
        /// How far the steadiest axis of the stylus moved.
        degrees: f64,
        /// The least that is accepted.
        limit_degrees: f64,
    },
    /// A near and a far mark are too close to one another to give a direction.
    #[error(
        "{item}: the near and the far mark are {metres:.3} m apart, where {limit} m are needed; take marks farther from one another"
    )]
    MarksTooClose {
        /// Which one.
        item: Item,
        /// The distance between the marks.
        metres: f64,
        /// The least that is accepted.
        limit: f64,
    },
    /// The lines of sight do not cross clearly enough to fix a distance.
    #[error(
        "the {of} look along nearly parallel lines: {degrees:.1} degrees RMS about their mean, where {limit_degrees:.0} are needed; turn the head farther to the left, right, up and down between sightings"
    )]
    ParallelSight {
        /// Which eye's.
        of: Items,
        /// The lines' angle to their mean direction.
        degrees: f64,
        /// The least that is accepted.
        limit_degrees: f64,
    },
    /// The eye would not look over the near mark at the far one.
    #[error(
        "{item}: the eye comes out beyond its near mark, on the far mark's side; exchange its near and far mark, or leave it out"
    )]
    BeyondMark {
        /// Which one.
        item: Item,
    },
    /// The eyes are not as far apart as people's.
    #[error(
        "the eyes come out {millimetres:.1} mm apart, where {least_mm:.0} to {most_mm:.0} mm are possible; sight again, one eye closed, and see that no sighting was given to the wrong eye"
    )]
    Interpupillary {
        /// The distance found.
        millimetres: f64,
        /// The least that is accepted.
        least_mm: f64,
        /// The most that is accepted.
        most_mm: f64,
    },
    /// The left eye comes out to the right of the right eye.
    #[error(
        "the left eye comes out to the right of the right eye, as seen by the viewer; exchange the left and the right eye's sightings"
    )]
    EyesExchanged,
    /// The decomposition that the fit needs does not converge.
    #[error("the fit through these {of} does not converge; measure them again")]
    NoConvergence {
        /// What was to be fitted.
        of: Items,
    },
}
