//! From samples of a distorted field to its correction.
//!
//! Metal and monitors bend a magnetic tracker's field: errors that are constant in place, grow
//! with the distance from the transmitter, and can be looked up (Ghazisaedy and others 1995; Ikits
//! and others 2001, with polynomials). Here a smoothing spline goes through the samples, its
//! smoothness chosen by leaving each sample out in turn, and is then written onto a regular grid.

use crate::decomposition::{outer, symmetric_eigen};
use crate::outlier::Problem;
use crate::smoothing_spline::Basis;
use crate::{CalibrationError, Item, Items, Outlier, Residuals, plausible};
use glam::{DVec3, UVec3};
use sandtable_field::{Correction, fade};
use sandtable_pose::Rigid;

/// Four samples fix the slopes; as many again can disagree with them.
const LEAST: usize = 8;

/// A decomposition of this size takes seconds.
const MOST: usize = 1000;

/// How far marks must spread across the plane that they lie nearest to, relative to their widest
/// spread, for a field to be known above and below it.
const FLAT: f64 = 0.1;

/// A correction helps where left-out samples are off by no more than this share of what they are
/// without it: less could be chance. Fits to plain noise foretell nothing.
const HELPS: f64 = 0.8;

/// It must also take away this much, in metres, RMS: less is what trackers round to.
const LEAST_GAIN: f64 = 5e-4;

/// Real fields are bent more strongly here than there, which the test for outliers does not know:
/// at a corner near a piece of metal samples stood out by chances down to 1e-11, and samples that
/// slipped by 20 mm mostly by less than 1e-14.
const UNMISTAKABLE: f64 = 1e-12;

/// The distance between nodes, in metres, where the volume is small enough.
const SPACING: f64 = 0.1;

/// The most nodes along an axis; wider volumes have wider cells.
const MOST_NODES: f64 = 33.0;

/// Up to this distance from a sample, in metres, the fit is believed in full.
const BELIEVED: f64 = 0.5;

/// Where a sensor was measured in the field, and where it truly was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldSample {
    /// As measured, after the rigid fit: table frame, metres.
    pub measured: DVec3,
    /// As it was: table frame, metres.
    pub truth: DVec3,
}

impl FieldSample {
    /// The sample that a stylus gives with its `tip` (sensor axes, metres) on a `mark` (table
    /// frame, metres), when the rigid fit makes `table_from_sensor` of its pose.
    ///
    /// The field acts where the sensor is, not where the tip is, so the sample lies there: the
    /// mark less the tip's offset. The attitude is taken as measured.
    #[must_use]
    pub fn of_stylus(table_from_sensor: &Rigid, tip: DVec3, mark: DVec3) -> Self {
        Self {
            measured: table_from_sensor.translation,
            truth: mark - table_from_sensor.direction(tip),
        }
    }
}

/// A correction, and what it may be expected to do.
#[derive(Clone, Debug, PartialEq)]
pub struct DistortionFit {
    /// The correction to use.
    pub correction: Correction,
    /// The smoothing weight that was chosen; none where every one foretells samples that it has
    /// not seen worse than leaving the field alone does, so that `correction` changes nothing.
    pub smoothing: Option<f64>,
    /// How far the samples are off without correction.
    pub before: Residuals,
    /// How far they are off with it; little says how well it fits other places.
    pub after: Residuals,
    /// How far each sample is off when all others alone correct it: what to expect at other places
    /// among them.
    pub left_out: Residuals,
    /// Samples that no smooth field explains beside the others, the worst first; `correction` is
    /// still through them too.
    pub outliers: Vec<Outlier>,
}

impl DistortionFit {
    /// Whether the correction is worth using: places that it was not fitted to are off by a fifth
    /// less with it, RMS, and by half a millimetre, at least.
    #[must_use]
    pub fn helps(&self) -> bool {
        let (without, with) = (self.before.rms, self.left_out.rms);
        self.smoothing.is_some() && with <= HELPS * without && with + LEAST_GAIN <= without
    }
}

/// Whether a field can be known in a volume from samples at these marks (table frame, metres).
///
/// # Errors
/// With fewer than 8 marks or more than 1000, with what is not finite or beyond 100 m, and where
/// the marks spread less than a tenth as far across a plane as along it (the ratio of their least
/// to their largest singular value).
pub fn admit_field_marks(marks: &[DVec3]) -> Result<(), CalibrationError> {
    let of = Items::FieldSamples;
    plausible::count(of, marks.len(), LEAST, MOST)?;
    for (index, mark) in marks.iter().enumerate() {
        plausible::place(Item { of, index }, "the mark's place", *mark)?;
    }
    let mean = marks.iter().sum::<DVec3>() / marks.len() as f64;
    let scatter = marks.iter().map(|mark| outer(mark - mean, mark - mean));
    let (spread, _) =
        symmetric_eigen(&scatter.sum()).ok_or(CalibrationError::NoConvergence { of })?;
    // Of marks at one place nothing is left to divide by.
    let ratio = (spread.z.max(0.0) / spread.x.max(f64::MIN_POSITIVE)).sqrt();
    if ratio < FLAT {
        return Err(CalibrationError::MarksInPlane {
            percent: 100.0 * ratio,
            limit_percent: 100.0 * FLAT,
        });
    }
    Ok(())
}

/// Fits a correction to samples: a least-squares fit with a penalty on roughness (Wahba 1990),
/// whose weight is the one of 25 that foretells left-out samples best, sampled on a grid of 0.1 m,
/// or of 32 cells along a side of more than 3.2 m.
///
/// The grid is the box of the measured places. Within 0.5 m of a sample the fit is believed;
/// farther off it fades to nothing over another 0.5 m, as [`Correction`] does beyond the grid.
/// Samples in a plane or a line fix no slope across it, and none is taken. Only places are
/// corrected: marks hold no attitudes, so attitudes are left alone.
///
/// The rigid fit ([`register`](crate::register)) comes first, best from touches near the
/// transmitter, where the field is straight: one through all touches takes a part of the bend for
/// a turn, which the stylus's attitudes then have too. What it leaves over is taken up here.
///
/// # Errors
/// With fewer than 8 samples or more than 1000, and with what is not finite or beyond 100 m.
pub fn fit_distortion(samples: &[FieldSample]) -> Result<DistortionFit, CalibrationError> {
    let of = Items::FieldSamples;
    plausible::count(of, samples.len(), LEAST, MOST)?;
    for (index, sample) in samples.iter().enumerate() {
        let item = Item { of, index };
        plausible::place(item, "the measured position", sample.measured)?;
        plausible::place(item, "the true place", sample.truth)?;
    }
    let sites: Vec<DVec3> = samples.iter().map(|s| s.measured).collect();
    let shifts: Vec<DVec3> = samples.iter().map(|s| s.truth - s.measured).collect();
    let before = Residuals::of(shifts.iter().map(|shift| shift.length()));

    let basis = Basis::new(&sites, &shifts).ok_or(CalibrationError::NoConvergence { of })?;
    let (smoothing, left_out) =
        best_smoothing(&basis).ok_or(CalibrationError::NoConvergence { of })?;
    let outliers = Problem {
        of,
        count: samples.len(),
        equations: 3,
        parameters: basis.parameters(),
        false_share: UNMISTAKABLE,
    }
    .outliers(|kept| {
        let of_kept = |all: &[DVec3]| kept.iter().map(|&index| all[index]).collect::<Vec<_>>();
        let basis = Basis::new(&of_kept(&sites), &of_kept(&shifts))?;
        let (smoothing, _) = best_smoothing(&basis)?;
        Some(basis.deletions(smoothing))
    });
    if left_out.rms >= before.rms {
        return Ok(DistortionFit {
            correction: Correction::identity(),
            smoothing: None,
            after: before.clone(),
            left_out: before.clone(),
            before,
            outliers,
        });
    }
    let spline = basis
        .spline(smoothing)
        .ok_or(CalibrationError::NoConvergence { of })?;
    let correction =
        sampled(&sites, |place| spline.at(place)).ok_or(CalibrationError::NoConvergence { of })?;
    let after = samples
        .iter()
        .map(|s| correction.correct(s.measured).distance(s.truth));
    Ok(DistortionFit {
        smoothing: Some(smoothing),
        before,
        after: Residuals::of(after),
        left_out,
        outliers,
        correction,
    })
}

/// The smoothing weight that foretells left-out samples best, and how far they are off then.
fn best_smoothing(basis: &Basis) -> Option<(f64, Residuals)> {
    basis
        .smoothings()
        .map(|smoothing| {
            let left_out = Residuals::of(basis.left_out(smoothing).into_iter());
            (smoothing, left_out)
        })
        // Of equals the smoother one, which comes later.
        .reduce(|best, next| if next.1.rms <= best.1.rms { next } else { best })
}

/// The field on a grid over the sites' box, given up far from all of them.
fn sampled(sites: &[DVec3], field: impl Fn(DVec3) -> DVec3) -> Option<Correction> {
    let low = sites.iter().copied().reduce(DVec3::min)?;
    let high = sites.iter().copied().reduce(DVec3::max)?;
    let extent = high - low;
    let cells = (extent / SPACING)
        .ceil()
        .min(DVec3::splat(MOST_NODES - 1.0));
    let spacing = DVec3::select(
        cells.cmpgt(DVec3::ZERO),
        (extent / cells.max(DVec3::ONE)).max(DVec3::splat(1e-6)),
        DVec3::splat(SPACING),
    );
    let counts: UVec3 = cells.as_uvec3() + 1;
    let faded = |node: DVec3| {
        let nearest = sites
            .iter()
            .map(|site| site.distance_squared(node))
            .fold(f64::INFINITY, f64::min)
            .sqrt();
        field(node) * fade(nearest - BELIEVED)
    };
    Correction::sampled(low, spacing, counts, faded).ok()
}
