//! From the tracker's frame to the table's, by touching marks of known place.
//!
//! Both sets of points are centred; the rotation comes from the singular value decomposition of
//! the sum of their products (Kabsch 1976), with the determinant's sign put right (Umeyama 1991),
//! which is what makes it a rotation where the points lie in a plane or are noisy.

use crate::decomposition::{Svd, outer, svd, symmetric_eigen};
use crate::outlier::{Deleted, Deletions, FALSE_SHARE, Problem};
use crate::{CalibrationError, Item, Items, Outlier, Residuals, plausible};
use glam::{DMat3, DQuat, DVec3};
use sandtable_pose::Rigid;
use std::fmt;

/// Three points fix a rotation.
const LEAST: usize = 3;

/// More than anybody touches.
const MOST: usize = 1000;

/// Marks nearer to one another than this, in metres, are one mark.
const SAME_PLACE: f64 = 1e-3;

/// The least spread across the line that fits best, relative to that along it.
const LINE_LIMIT: f64 = 0.05;

/// A fit is far better than another where its RMS is this many times smaller.
const FAR_BETTER: f64 = 3.0;

/// No hand touches better than this, in metres: below it no fit is called worse.
const TOUCH: f64 = 1e-3;

/// Of so many touches that fit worst, each two are tried in each other's place.
const MOST_EXCHANGED: usize = 30;

/// A scale farther from 1 than this is reported.
const SCALE_LIMIT: f64 = 0.01;

/// A scale is reported only where it is this many standard errors from 1.
const SCALE_ERRORS: f64 = 3.0;

/// A mark touched with the stylus tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The tip as the tracker has it: tracker frame, metres.
    pub measured: DVec3,
    /// The mark's known place: table frame, metres.
    pub marked: DVec3,
}

/// Where the tracker stands at the table, and how well the touches agree on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Registration {
    /// Takes the tracker's coordinates to the table's. Every touch is counted in, a named outlier
    /// too: whoever believes the finding leaves that touch out and registers again.
    pub table_from_tracker: Rigid,
    /// The distance of each touch from its mark after the fit, in metres.
    pub residuals: Residuals,
    /// Marked metres for one measured metre as the touches that are no outliers fit best: only a
    /// check, not part of `table_from_tracker`. 1 where the tracker is set up rightly.
    pub scale: f64,
    /// What whoever touched the marks should know.
    pub findings: Vec<Finding>,
}

/// Something about a registration that its numbers alone do not say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// One touch disagrees with all others.
    Outlier(Outlier),
    /// Two marks were touched in each other's place: then all fit far better.
    Exchanged {
        /// The two touches.
        touches: [Item; 2],
        /// Two others that fit about as well exchanged, as where marks lie in a plane, alike on both sides.
        or: Option<[Item; 2]>,
        /// RMS distance of the best rotation with a shift and a scale, in metres, as they were touched.
        touched: f64,
        /// The same with `touches` exchanged.
        exchanged: f64,
    },
    /// The tracker's lengths are over 1 % off, and by more than the noise explains.
    WrongScale {
        /// Marked metres for one measured metre.
        factor: f64,
        /// The factor's standard error.
        standard_error: f64,
    },
    /// A mirror image fits about as well as a rotation, since the points lie nearly in a plane or
    /// fit badly at all: had the tracker left-handed axes, nothing would show it.
    HandednessUnknown {
        /// RMS distance of the best rotation with a shift and a scale, in metres.
        rotated: f64,
        /// The same of the best mirror image, in metres.
        mirrored: f64,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outlier(outlier) => outlier.fmt(f),
            Self::Exchanged {
                touches: [first, second],
                or,
                touched,
                exchanged,
            } => {
                write!(f, "{first} and {second}")?;
                if let Some([first, second]) = or {
                    write!(f, ", or {first} and {second},")?;
                }
                write!(
                    f,
                    " seem to be touched in each other's place: exchanged, all points fit to {:.1} mm RMS instead of {:.1}; touch both again",
                    1e3 * exchanged,
                    1e3 * touched
                )
            }
            Self::WrongScale {
                factor,
                standard_error,
            } => {
                write!(
                    f,
                    "the marks lie {factor:.3} (± {standard_error:.3}) times as far apart as the tracker measures; "
                )?;
                // The ranges are 36, 72 and 144 in: a wrong one is off by 2 or by 4.
                match [4.0, 2.0, 0.5, 0.25]
                    .into_iter()
                    .find(|ratio| (factor / ratio - 1.0).abs() < 0.1)
                {
                    Some(ratio) => write!(
                        f,
                        "the range set is wrong: take the one of 36, 72 and 144 in that is {ratio} times it"
                    ),
                    None => f.write_str(
                        "see that the range set (36, 72 or 144 in) is the tracker's own, and that the marks' places are in metres",
                    ),
                }
            }
            Self::HandednessUnknown { rotated, mirrored } => write!(
                f,
                "a mirror image ({:.1} mm RMS) and a rotation ({:.1} mm RMS) fit the points too much alike to see left-handed axes; touch a mark well above the others",
                1e3 * mirrored,
                1e3 * rotated
            ),
        }
    }
}

/// Finds `table_from_tracker` from touched marks, by least squares (Kabsch 1976, Umeyama 1991).
///
/// Three touches are the least, 6 to 12 through the volume are better; with noise of σ a
/// coordinate, n of them put their centroid right to σ √(3/n). An outlier is named by leaving each
/// touch out in turn ([`Outlier`]): of sets with equal Gaussian noise and no outlier about 1 in
/// 100 has a point named. Two outliers that agree with one another can hide; the residuals
/// still show them. Two marks that were touched in each other's place are told by exchanging each
/// two of those that fit worst; what else is found holds with those two exchanged.
///
/// # Errors
/// With fewer than 3 touches or more than 1000; with coordinates that are not finite or beyond
/// 100 m; with two marks within 1 mm or two measurements that are the same to the last bit; where
/// the marks or the measured positions spread less than 5 % as far across a line as along it (the
/// ratio of their second to their first singular value); and where a mirror image fits at least 3
/// times better than any rotation, which is at least 1 mm off.
pub fn register(touches: &[Touch]) -> Result<Registration, CalibrationError> {
    admit(touches)?;
    let no_convergence = CalibrationError::NoConvergence { of: Items::Touches };
    let moments = Moments::of(touches);
    let fit = moments.fit().ok_or(no_convergence.clone())?;
    let mut findings = Vec::new();
    let mut believed = touches.to_vec();
    if let Some((finding, [first, second])) = fit.exchanged(touches, &moments) {
        findings.push(finding);
        believed[first].measured = touches[second].measured;
        believed[second].measured = touches[first].measured;
    }
    let moments = Moments::of(&believed);
    let believed_fit = moments.fit().ok_or(no_convergence.clone())?;
    believed_fit.refuse_mirror()?;

    let outliers = Problem {
        of: Items::Touches,
        count: believed.len(),
        equations: 3,
        // Rotation, shift and scale: a wrong range must not make the outermost point an outlier.
        parameters: 7,
        false_share: FALSE_SHARE,
    }
    .outliers(|kept| delete_each(&believed, &moments, kept));
    let kept = moments.without(outliers.iter().map(|o| &believed[o.item.index]));
    let kept_fit = kept.fit().ok_or(no_convergence)?;
    kept_fit.refuse_mirror()?;

    let table_from_tracker = fit.table_from_tracker();
    let distance = |touch: &Touch| {
        table_from_tracker
            .point(touch.measured)
            .distance(touch.marked)
    };
    findings.extend(outliers.into_iter().map(Finding::Outlier));
    findings.extend(kept_fit.scale_finding());
    findings.extend(kept_fit.handedness_finding());
    Ok(Registration {
        table_from_tracker,
        residuals: Residuals::of(touches.iter().map(distance)),
        scale: kept_fit.scale,
        findings,
    })
}

fn item(index: usize) -> Item {
    Item {
        of: Items::Touches,
        index,
    }
}

fn admit(touches: &[Touch]) -> Result<(), CalibrationError> {
    plausible::count(Items::Touches, touches.len(), LEAST, MOST)?;
    for (index, touch) in touches.iter().enumerate() {
        plausible::place(item(index), "the measured position", touch.measured)?;
        plausible::place(item(index), "the mark's place", touch.marked)?;
    }
    for (second, touch) in touches.iter().enumerate() {
        for (first, earlier) in touches[..second].iter().enumerate() {
            let apart = touch.marked.distance(earlier.marked);
            if apart < SAME_PLACE {
                return Err(CalibrationError::SameMark {
                    first: item(first),
                    second: item(second),
                    millimetres: 1e3 * apart,
                });
            }
            if touch.measured == earlier.measured {
                return Err(CalibrationError::SameMeasurement {
                    first: item(first),
                    second: item(second),
                });
            }
        }
    }
    if let Some((first, second, ratio)) = line(touches, |touch| touch.marked)? {
        return Err(CalibrationError::MarksInLine {
            first: item(first),
            second: item(second),
            percent: 100.0 * ratio,
            limit_percent: 100.0 * LINE_LIMIT,
        });
    }
    if let Some((first, second, ratio)) = line(touches, |touch| touch.measured)? {
        return Err(CalibrationError::MeasurementsInLine {
            first: item(first),
            second: item(second),
            percent: 100.0 * ratio,
            limit_percent: 100.0 * LINE_LIMIT,
        });
    }
    Ok(())
}

/// The two points farthest apart and the spread across their line, where that is too little.
fn line(
    touches: &[Touch],
    place: impl Fn(&Touch) -> DVec3,
) -> Result<Option<(usize, usize, f64)>, CalibrationError> {
    let places: Vec<_> = touches.iter().map(place).collect();
    let mean = places.iter().sum::<DVec3>() / places.len() as f64;
    let scatter = places
        .iter()
        .fold(DMat3::ZERO, |sum, p| sum + outer(p - mean, p - mean));
    let (spread, _) =
        symmetric_eigen(&scatter).ok_or(CalibrationError::NoConvergence { of: Items::Touches })?;
    let ratio = (spread.y.max(0.0) / spread.x).sqrt();
    if ratio >= LINE_LIMIT {
        return Ok(None);
    }
    let (mut ends, mut longest) = ((0, 1), 0.0);
    for (second, p) in places.iter().enumerate() {
        for (first, q) in places[..second].iter().enumerate() {
            let length = p.distance(*q);
            if length > longest {
                (ends, longest) = ((first, second), length);
            }
        }
    }
    Ok(Some((ends.0, ends.1, ratio)))
}

/// The fit through the touches `kept`, and without each one of them.
fn delete_each(touches: &[Touch], all: &Moments, kept: &[usize]) -> Option<Deletions> {
    let mut is_kept = vec![false; touches.len()];
    kept.iter().for_each(|&index| is_kept[index] = true);
    let dropped = touches.iter().zip(&is_kept).filter(|(_, kept)| !**kept);
    let moments = all.without(dropped.map(|(touch, _)| touch));
    let each = kept.iter().map(|&index| {
        let touch = &touches[index];
        let fit = moments.without([touch]).fit()?;
        // Points in a line leave a turn open, and so where the point left out should be.
        (fit.cross_spread >= LINE_LIMIT).then(|| Deleted {
            sum: fit.rotated,
            deviation: fit.scaled(touch.measured).distance(touch.marked),
        })
    });
    Some(Deletions {
        sum: moments.fit()?.rotated,
        each: each.collect(),
    })
}

/// Sums over touches, about fixed origins near their means so that little cancels.
#[derive(Clone, Copy, Debug)]
struct Moments {
    origins: (DVec3, DVec3),
    count: f64,
    measured: DVec3,
    marked: DVec3,
    measured_squares: f64,
    marked_squares: f64,
    /// `Σ marked * measuredᵀ`.
    products: DMat3,
}

impl Moments {
    fn of(touches: &[Touch]) -> Self {
        let count = touches.len() as f64;
        let mut moments = Self {
            origins: (
                touches.iter().map(|t| t.measured).sum::<DVec3>() / count,
                touches.iter().map(|t| t.marked).sum::<DVec3>() / count,
            ),
            count: 0.0,
            measured: DVec3::ZERO,
            marked: DVec3::ZERO,
            measured_squares: 0.0,
            marked_squares: 0.0,
            products: DMat3::ZERO,
        };
        for touch in touches {
            moments.add(touch, 1.0);
        }
        moments
    }

    fn without<'a>(mut self, touches: impl IntoIterator<Item = &'a Touch>) -> Self {
        for touch in touches {
            self.add(touch, -1.0);
        }
        self
    }

    fn add(&mut self, touch: &Touch, times: f64) {
        let measured = touch.measured - self.origins.0;
        let marked = touch.marked - self.origins.1;
        self.count += times;
        self.measured += times * measured;
        self.marked += times * marked;
        self.measured_squares += times * measured.length_squared();
        self.marked_squares += times * marked.length_squared();
        self.products += outer(times * marked, measured);
    }

    /// None only where the decomposition does not converge.
    fn fit(&self) -> Option<Fit> {
        let measured_mean = self.measured / self.count;
        let marked_mean = self.marked / self.count;
        let measured_squares = self.measured_squares - self.count * measured_mean.length_squared();
        let marked_squares = self.marked_squares - self.count * marked_mean.length_squared();
        let decomposed = svd(&(self.products - outer(self.marked, measured_mean)))?;
        let values = decomposed.values;
        let (rotation, sign) = proper_rotation(&decomposed);
        // What is left of the marks' squares after the best similarity of either handedness.
        let (with, against) = (
            values.x + values.y + sign * values.z,
            values.x + values.y - sign * values.z,
        );
        let left =
            |explained: f64| (marked_squares - explained * explained / measured_squares).max(0.0);
        Some(Fit {
            rotation,
            measured_mean: measured_mean + self.origins.0,
            marked_mean: marked_mean + self.origins.1,
            count: self.count,
            measured_squares,
            scale: with / measured_squares,
            rotated: left(with),
            mirrored: left(against),
            cross_spread: (values.y / values.x).sqrt(),
        })
    }
}

/// The rotation nearest to `u * vᵀ`, and the sign of that product's determinant: where it is
/// negative, the direction of the least singular value is turned over (Umeyama 1991).
fn proper_rotation(Svd { u, v, .. }: &Svd) -> (DQuat, f64) {
    let sign = (u.determinant() * v.determinant()).signum();
    let rotation = *u * DMat3::from_diagonal(DVec3::new(1.0, 1.0, sign)) * v.transpose();
    (DQuat::from_mat3(&rotation).normalize(), sign)
}

#[derive(Clone, Copy, Debug)]
struct Fit {
    rotation: DQuat,
    measured_mean: DVec3,
    marked_mean: DVec3,
    count: f64,
    measured_squares: f64,
    scale: f64,
    /// The sums of squares left by the best similarity and by the best mirror image.
    rotated: f64,
    mirrored: f64,
    /// The points' spread across the line that fits them best, relative to that along it.
    cross_spread: f64,
}

impl Fit {
    fn table_from_tracker(&self) -> Rigid {
        Rigid::new(
            self.rotation,
            self.marked_mean - self.rotation * self.measured_mean,
        )
    }

    /// A point's place in the table with the best scale.
    fn scaled(&self, measured: DVec3) -> DVec3 {
        self.marked_mean + self.scale * (self.rotation * (measured - self.measured_mean))
    }

    /// RMS distances of the best similarity and of the best mirror image, in metres.
    fn both_rms(&self) -> (f64, f64) {
        (
            (self.rotated / self.count).sqrt(),
            (self.mirrored / self.count).sqrt(),
        )
    }

    /// Two touches that fit far better in each other's place, and what to say of them.
    fn exchanged(&self, touches: &[Touch], all: &Moments) -> Option<(Finding, [usize; 2])> {
        let (touched, _) = self.both_rms();
        if touched <= TOUCH {
            return None;
        }
        let off = |k: &usize| {
            self.scaled(touches[*k].measured)
                .distance(touches[*k].marked)
        };
        let mut worst: Vec<_> = (0..touches.len()).collect();
        worst.sort_by(|a, b| off(b).total_cmp(&off(a)));
        worst.truncate(MOST_EXCHANGED);
        let pairs = (1..worst.len()).flat_map(|k| (0..k).map(move |j| (j, k)));
        let mut tried: Vec<_> = pairs
            .filter_map(|(j, k)| {
                let mut pair = [worst[j], worst[k]];
                pair.sort_unstable();
                let [a, b] = pair.map(|k| touches[k]);
                let mut exchanged = all.without([&a, &b]);
                for (measured, marked) in [(a.measured, b.marked), (b.measured, a.marked)] {
                    exchanged.add(&Touch { measured, marked }, 1.0);
                }
                Some((exchanged.fit()?.both_rms().0, pair))
            })
            .collect();
        tried.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let &(exchanged, pair) = tried.first()?;
        let or = tried.get(1).filter(|(other, _)| {
            // As well as a hand touches, or nearly as well as the first.
            *other < (2.0 * exchanged).max(TOUCH)
        });
        let finding = Finding::Exchanged {
            touches: pair.map(item),
            or: or.map(|(_, pair)| pair.map(item)),
            touched,
            exchanged,
        };
        (touched > FAR_BETTER * exchanged).then_some((finding, pair))
    }

    fn refuse_mirror(&self) -> Result<(), CalibrationError> {
        let (rotated, mirrored) = self.both_rms();
        if rotated > TOUCH && rotated > FAR_BETTER * mirrored {
            return Err(CalibrationError::Mirrored {
                rotated_mm: 1e3 * rotated,
                mirrored_mm: 1e3 * mirrored,
            });
        }
        Ok(())
    }

    fn handedness_finding(&self) -> Option<Finding> {
        let (rotated, mirrored) = self.both_rms();
        let told = mirrored > TOUCH && mirrored > FAR_BETTER * rotated;
        (!told).then_some(Finding::HandednessUnknown { rotated, mirrored })
    }

    fn scale_finding(&self) -> Option<Finding> {
        let freedom = 3.0 * self.count - 7.0;
        let standard_error = (self.rotated / freedom / self.measured_squares).sqrt();
        let off = (self.scale - 1.0).abs();
        (off > SCALE_LIMIT && off > SCALE_ERRORS * standard_error).then_some(Finding::WrongScale {
            factor: self.scale,
            standard_error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worked example of three points in a plane: their singular values are .169551, .082814
    /// and 0, so a decomposition may turn the third direction either way.
    #[test]
    fn either_sign_of_the_raw_determinant_gives_the_rotation() {
        let rotation = DQuat::from_xyzw(0.11547, -0.34641, 0.46188, 0.80829).normalize();
        let inches = [[12.0, 3.0, -5.0], [20.0, -8.0, 4.0], [30.0, 0.5, -14.0]];
        let touches = inches.map(|inches| {
            let measured = 0.0254 * DVec3::from_array(inches);
            Touch {
                measured,
                marked: rotation * measured + DVec3::new(0.2, -0.4, 0.9),
            }
        });
        let moments = Moments::of(&touches);
        let mut signs = Vec::new();
        for turn in [1.0, -1.0] {
            let mut decomposed = svd(&moments.products).unwrap();
            assert!(
                decomposed
                    .values
                    .abs_diff_eq(DVec3::new(0.169551, 0.082814, 0.0), 1e-6)
            );
            decomposed.u.z_axis *= turn;
            let (found, sign) = proper_rotation(&decomposed);
            let matrix = DMat3::from_quat(found);
            assert!((matrix.determinant() - 1.0).abs() < 1e-12);
            assert!(matrix.abs_diff_eq(DMat3::from_quat(rotation), 1e-9));
            signs.push(sign);
        }
        signs.sort_by(f64::total_cmp);
        assert_eq!(signs, [-1.0, 1.0]);
    }
}
