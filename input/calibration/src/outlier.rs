//! The one measurement that disagrees with all the others, found by leaving each out in turn.
//!
//! With item i left out, the sum of squares S falls to Sᵢ. If every coordinate has the same
//! Gaussian noise, Sᵢ/S has the beta distribution with ν/2 and e/2, where an item gives e
//! equations and ν degrees of freedom remain without it: the test for a shift in the mean (Cook
//! and Weisberg 1982), exact for linear models and nearly so for rotations by small
//! angles. The item with the least Sᵢ/S is named where so small a ratio would come up by chance,
//! in any of the items, in less than one set of a hundred ([`FALSE_SHARE`]; for fields in far
//! fewer); then the search goes on without it. At most a quarter of the items is named, so that the majority judges.

use crate::{Item, Items};
use glam::{DMat3, DVec3};
use std::fmt;

/// The usual share of sets with plain noise in which an item is named nevertheless.
pub(crate) const FALSE_SHARE: f64 = 0.01;

/// Below this deviation, in metres, the numbers only round: nothing is named.
const ROUNDING: f64 = 1e-6;

/// Where 1 less an item's leverage is this small, as a determinant, the item alone decides
/// something of the fit, and the others cannot judge it.
const LEAST_FREEDOM: f64 = 1e-6;

/// A measurement that disagrees with the others by more than their noise explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlier {
    /// Which one.
    pub item: Item,
    /// How far it lies from where the others put it, in metres.
    pub deviation: f64,
    /// The share of sets with plain noise in which an item stands out as far, at most 0.01.
    pub chance: f64,
}

impl fmt::Display for Outlier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} lies {:.1} mm from where the others put it; ",
            self.item,
            1e3 * self.deviation
        )?;
        f.write_str(match self.item.of {
            Items::Touches => "touch that mark again, and check its written place",
            Items::Poses => "the tip may have slipped: leave the pose out, or pivot again",
            Items::LeftSightings | Items::RightSightings | Items::Pairs => {
                "sight those marks again, and check their written places"
            }
            Items::FieldSamples => {
                "touch that mark again; where it comes out the same, the field is bent more strongly \
                 there, and more marks around it are needed"
            }
        })
    }
}

/// What the fit becomes without one item.
pub(crate) struct Deleted {
    /// The sum of squares that is left, in square metres.
    pub(crate) sum: f64,
    /// How far the item lies from where the others put it, in metres.
    pub(crate) deviation: f64,
}

impl Deleted {
    /// The same from a linear fit through all, whose sum of squares is `sum`, by the item's
    /// residual and its block of the hat matrix, without fitting anew; none where the others do
    /// not determine the fit. Equations and unknowns may be fewer than three: `hat` maps the
    /// residual's own directions to themselves and all others to zero.
    pub(crate) fn linear(sum: f64, residual: DVec3, hat: &DMat3) -> Option<Self> {
        let left = DMat3::IDENTITY - *hat;
        (left.determinant() >= LEAST_FREEDOM).then(|| {
            let deviation = left.inverse() * residual;
            Self {
                sum: (sum - residual.dot(deviation)).max(0.0),
                deviation: deviation.length(),
            }
        })
    }
}

/// A fit through some of the items, and without each one of these.
pub(crate) struct Deletions {
    /// The sum of squares with all of them, in square metres.
    pub(crate) sum: f64,
    /// Without each, in their order; none where the others do not determine the fit.
    pub(crate) each: Vec<Option<Deleted>>,
}

/// A least-squares problem, as far as the test needs to know it.
pub(crate) struct Problem {
    pub(crate) of: Items,
    /// How many items there are.
    pub(crate) count: usize,
    /// Independent equations of one item: 2 or 3.
    pub(crate) equations: usize,
    /// Unknowns of the fit.
    pub(crate) parameters: usize,
    /// The share of sets with plain noise in which an item may be named nevertheless.
    pub(crate) false_share: f64,
}

impl Problem {
    /// The outliers, the worst first; `delete` gets the indices still in the fit.
    pub(crate) fn outliers(
        &self,
        mut delete: impl FnMut(&[usize]) -> Option<Deletions>,
    ) -> Vec<Outlier> {
        let mut kept: Vec<usize> = (0..self.count).collect();
        let mut outliers = Vec::new();
        while outliers.len() < self.count / 4
            && let Some((position, outlier)) = self.worst(&kept, &mut delete)
        {
            kept.remove(position);
            outliers.push(outlier);
        }
        outliers
    }

    fn worst(
        &self,
        kept: &[usize],
        delete: &mut impl FnMut(&[usize]) -> Option<Deletions>,
    ) -> Option<(usize, Outlier)> {
        let freedom = (self.equations * (kept.len() - 1)).checked_sub(self.parameters)?;
        if freedom == 0 {
            return None;
        }
        let deletions = delete(kept)?;
        let (position, deleted) = deletions
            .each
            .iter()
            .enumerate()
            .filter_map(|(position, deleted)| Some((position, deleted.as_ref()?)))
            .min_by(|(_, a), (_, b)| a.sum.total_cmp(&b.sum))?;
        if deleted.deviation <= ROUNDING {
            return None;
        }
        let ratio = (deleted.sum / deletions.sum).clamp(0.0, 1.0);
        let chance = kept.len() as f64 * beta_share(ratio, freedom, self.equations);
        (chance < self.false_share).then_some((
            position,
            Outlier {
                item: Item {
                    of: self.of,
                    index: kept[position],
                },
                deviation: deleted.deviation,
                chance,
            },
        ))
    }
}

/// The regularised incomplete beta function I_x(ν/2, e/2) for e = 2 or 3.
fn beta_share(x: f64, freedom: usize, equations: usize) -> f64 {
    let a = freedom as f64 / 2.0;
    if equations == 2 {
        return x.powf(a);
    }
    // B(a, 3/2), stepped up from B(1/2, 3/2) = π/2 or B(1, 3/2) = 2/3.
    let (start, mut beta) = if freedom % 2 == 1 {
        (0.5, std::f64::consts::FRAC_PI_2)
    } else {
        (1.0, 2.0 / 3.0)
    };
    let steps = (freedom - 1) / 2;
    for step in 0..steps {
        let at = start + step as f64;
        beta *= at / (at + 1.5);
    }
    // ∫ tᵃ⁻¹ (1 - t)^½ dt from 0 to x, by the binomial series of the root.
    let (mut sum, mut coefficient, mut power) = (0.0, 1.0, 1.0);
    for k in 0..10_000 {
        let k = f64::from(k);
        let term = coefficient * power / (a + k);
        sum += term;
        if term.abs() <= 1e-15 * sum {
            break;
        }
        coefficient *= (k - 0.5) / (k + 1.0);
        power *= x;
    }
    (x.powf(a) * sum / beta).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_agrees_with_tables_of_the_f_distribution() {
        // Upper 1 % points of F with 3 and ν, and with 2 and ν degrees of freedom.
        for (freedom, equations, f) in [
            (2, 3, 99.166),
            (5, 3, 12.060),
            (10, 3, 6.552),
            (30, 3, 4.510),
            (2, 2, 99.000),
            (10, 2, 7.559),
            (30, 2, 5.390),
        ] {
            let x = 1.0 / (1.0 + equations as f64 * f / freedom as f64);
            let share = beta_share(x, freedom, equations);
            assert!(
                (share - 0.01).abs() < 1e-5,
                "F({equations}, {freedom}): {share}"
            );
        }
        assert_eq!(beta_share(0.0, 7, 3), 0.0);
        assert!((beta_share(1.0, 7, 3) - 1.0).abs() < 1e-6);
    }
}
