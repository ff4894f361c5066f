//! From samples of a distorted field to its correction.
//!
//! Metal and monitors bend a magnetic tracker's field: errors that are constant in place, grow
//! with the distance from the transmitter, and can be looked up (Ghazisaedy and others 1995; Ikits
//! and others 2001, with polynomials). Here a smoothing spline goes through the samples, its
//! smoothness chosen by leaving each sample out in turn, and is then written onto a regular grid.

use crate::correction::{node_places, smooth_step};
use crate::smoothing_spline::Basis;
use crate::{CalibrationError, Correction, Item, Items, Residuals, plausible};
use glam::{DVec3, UVec3};
use sandtable_pose::Rigid;

/// Four samples fix the slopes; as many again can disagree with them.
const LEAST: usize = 8;

/// A decomposition of this size takes seconds.
const MOST: usize = 1000;

/// The distance between nodes, in metres, where the volume is small enough.
const SPACING: f64 = 0.1;

/// The most nodes along an axis; wider volumes have wider cells.
const MOST_NODES: f64 = 33.0;

/// Up to this distance from a sample, in metres, the fit is believed in full.
const BELIEVED: f64 = 0.5;

/// Beyond that the correction falls to nothing over this distance, in metres.
const FADE: f64 = 0.5;

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
    /// among them. A sample that stands out here was perhaps measured wrongly.
    pub left_out: Residuals,
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
    let (smoothing, left_out) = basis
        .smoothings()
        .map(|smoothing| {
            let left_out = Residuals::of(basis.left_out(smoothing).into_iter());
            (smoothing, left_out)
        })
        // Of equals the smoother one, which comes later.
        .reduce(|best, next| if next.1.rms <= best.1.rms { next } else { best })
        .ok_or(CalibrationError::NoConvergence { of })?;
    if left_out.rms >= before.rms {
        return Ok(DistortionFit {
            correction: Correction::identity(),
            smoothing: None,
            after: before.clone(),
            left_out: before.clone(),
            before,
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
        correction,
    })
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
    let displacements = node_places(low, spacing, counts)
        .map(|node| {
            let nearest = sites
                .iter()
                .map(|site| site.distance_squared(node))
                .fold(f64::INFINITY, f64::min)
                .sqrt();
            field(node) * (1.0 - smooth_step((nearest - BELIEVED) / FADE))
        })
        .collect();
    Correction::new(low, spacing, counts, displacements).ok()
}
