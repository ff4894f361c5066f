//! Where a stylus has its tip, from poses that pivot on one spot.
//!
//! The tip p in the sensor's axes and the spot c do not move, so Rᵢ p + tᵢ = c for every pose: a
//! linear problem of six unknowns. The spot is eliminated by centring, which leaves the normal
//! equations Σ R̃ᵢᵀ R̃ᵢ p = -Σ R̃ᵢᵀ t̃ᵢ with R̃ᵢ and t̃ᵢ the differences from the means.

use crate::decomposition::{symmetric_eigen, trace};
use crate::outlier::{Deleted, Deletions, FALSE_SHARE, Problem};
use crate::{CalibrationError, Item, Items, Outlier, Residuals, plausible};
use glam::{DMat3, DVec3};
use sandtable_pose::Rigid;

/// Nine equations for the tip, the spot and three that can disagree, and one pose over.
const LEAST: usize = 4;

/// Over a minute of a fast tracker; a pair of poses at a time is compared.
const MOST: usize = 10_000;

/// The least of the largest angle between two attitudes, in radians.
const SPREAD_LIMIT: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// The least RMS angle by which the stylus's steadiest axis moves, in radians.
const AXIS_LIMIT: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// Where the tip is, and how well the poses agree on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pivot {
    /// The tip in the sensor's own axes, in metres.
    pub tip: DVec3,
    /// The spot that the tip stood on, in the frame of the poses, in metres.
    pub spot: DVec3,
    /// The standard error of `tip`, as a length in metres.
    pub standard_error: f64,
    /// The largest angle between two attitudes, in radians.
    pub spread: f64,
    /// How far each pose puts the tip from `spot`, in metres.
    pub residuals: Residuals,
    /// Poses that disagree with all others; they are counted in, as every pose is.
    pub outliers: Vec<Outlier>,
}

/// Finds the tip of a stylus from poses `frame_from_sensor` while the tip stands on one spot; the
/// frame may be the tracker's or the table's.
///
/// Outliers are named by leaving each pose out in turn ([`Outlier`]).
///
/// # Errors
/// With fewer than 4 poses or more than 10 000; with what is not finite, beyond 100 m or no
/// rotation; where no two attitudes differ by 40 degrees; and where some axis of the stylus moved
/// by less than 4 degrees RMS, as it does when the stylus only tips to and fro: the tip's place
/// along that axis is then open.
pub fn pivot(frame_from_sensor: &[Rigid]) -> Result<Pivot, CalibrationError> {
    let of = Items::Poses;
    plausible::count(of, frame_from_sensor.len(), LEAST, MOST)?;
    let poses = frame_from_sensor
        .iter()
        .enumerate()
        .map(|(index, pose)| plausible::pose(Item { of, index }, pose))
        .collect::<Result<Vec<_>, _>>()?;

    let spread = spread(&poses);
    if spread < SPREAD_LIMIT {
        return Err(CalibrationError::NarrowPivot {
            degrees: spread.to_degrees(),
            limit_degrees: SPREAD_LIMIT.to_degrees(),
        });
    }
    let all: Vec<usize> = (0..poses.len()).collect();
    let fit = Fit::through(&poses, &all);
    let (eigenvalues, _) =
        symmetric_eigen(&fit.normal).ok_or(CalibrationError::NoConvergence { of })?;
    let steadiest = (eigenvalues.z / poses.len() as f64)
        .clamp(0.0, 1.0)
        .sqrt()
        .asin();
    if steadiest < AXIS_LIMIT {
        return Err(CalibrationError::OneAxis {
            degrees: steadiest.to_degrees(),
            limit_degrees: AXIS_LIMIT.to_degrees(),
        });
    }

    let outliers = Problem {
        of,
        count: poses.len(),
        equations: 3,
        parameters: 6,
        false_share: FALSE_SHARE,
    }
    .outliers(|kept| Some(Fit::through(&poses, kept).delete_each(&poses, kept)));
    let residuals = Residuals::of(poses.iter().map(|pose| fit.residual(pose).length()));
    let variance = residuals.sum_of_squares() / (3 * poses.len() - 6) as f64;
    Ok(Pivot {
        tip: fit.tip,
        spot: fit.spot,
        standard_error: (variance * trace(&fit.inverse)).sqrt(),
        spread,
        residuals,
        outliers,
    })
}

/// The largest angle between two attitudes, in radians.
fn spread(poses: &[Rigid]) -> f64 {
    let mut least = 1.0_f64;
    for (second, pose) in poses.iter().enumerate() {
        for earlier in &poses[..second] {
            // q and -q are the same attitude.
            least = least.min(pose.rotation.dot(earlier.rotation).abs());
        }
    }
    2.0 * least.acos()
}

struct Fit {
    tip: DVec3,
    spot: DVec3,
    mean_rotation: DMat3,
    count: f64,
    normal: DMat3,
    inverse: DMat3,
}

impl Fit {
    /// The fit through the poses `kept`; where they do not determine it, numbers that are not
    /// finite or are far off.
    fn through(poses: &[Rigid], kept: &[usize]) -> Self {
        let kept = || kept.iter().map(|&index| &poses[index]);
        let count = kept().count() as f64;
        let mut mean_rotation = DMat3::ZERO;
        let mut mean_position = DVec3::ZERO;
        for pose in kept() {
            mean_rotation += DMat3::from_quat(pose.rotation);
            mean_position += pose.translation;
        }
        mean_rotation *= 1.0 / count;
        mean_position /= count;
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for pose in kept() {
            let turned = (DMat3::from_quat(pose.rotation) - mean_rotation).transpose();
            normal += turned * turned.transpose();
            right -= turned * (pose.translation - mean_position);
        }
        let inverse = normal.inverse();
        let tip = inverse * right;
        Self {
            tip,
            spot: mean_rotation * tip + mean_position,
            mean_rotation,
            count,
            normal,
            inverse,
        }
    }

    fn residual(&self, pose: &Rigid) -> DVec3 {
        pose.point(self.tip) - self.spot
    }

    fn delete_each(&self, poses: &[Rigid], kept: &[usize]) -> Deletions {
        let residuals = || kept.iter().map(|&index| self.residual(&poses[index]));
        let sum = residuals().map(DVec3::length_squared).sum();
        let each = kept.iter().zip(residuals()).map(|(&index, residual)| {
            let turned = DMat3::from_quat(poses[index].rotation) - self.mean_rotation;
            let hat =
                DMat3::IDENTITY * (1.0 / self.count) + turned * self.inverse * turned.transpose();
            Deleted::linear(sum, residual, &hat)
        });
        Deletions {
            sum,
            each: each.collect(),
        }
    }
}
