//! A smooth vector field through scattered noisy samples.
//!
//! f(x) = Σ wᵢ φ(|x - xᵢ|) + affine, with weights orthogonal to all affine functions, minimises
//! Σ |yᵢ - f(xᵢ)|² + λ times its roughness: the polyharmonic smoothing spline (Duchon 1977, Wahba
//! 1990). With the weights written in a basis Z of what is orthogonal to the affine functions, and
//! Zᵀ K Z = V D Vᵀ, any λ costs little more than a product: w = Z V (D + λ)⁻¹ Vᵀ Zᵀ y. The same
//! factors give what each sample misses by when it is left out, without fitting anew: the residual
//! divided by 1 less the leverage (Wahba 1990).

use crate::decomposition::{outer, symmetric_eigen};
use crate::outlier::{Deleted, Deletions};
use glam::DVec3;
use nalgebra::{DMatrix, SymmetricEigen};

/// Directions in which samples spread less than this, relative to the widest, have no slope.
const FLAT: f64 = 1e-3;

/// Samples within this distance of their mean, in metres, are at one place.
const ONE_PLACE: f64 = 1e-6;

/// Where 1 less a sample's leverage is this small, the others cannot judge it.
const LEAST_FREEDOM: f64 = 1e-6;

/// Smoothing weights tried, relative to the largest eigenvalue: half a decade from one to the next.
const LEAST_EXPONENT: i32 = -18;
const MOST_EXPONENT: i32 = 6;

/// What all smoothing weights share.
pub(crate) struct Basis {
    sites: Vec<DVec3>,
    centre: DVec3,
    /// The radius of the samples, which makes the numbers near 1.
    scale: f64,
    /// The directions that have a slope, in scaled coordinates.
    slopes: Vec<DVec3>,
    values: DMatrix<f64>,
    kernel: DMatrix<f64>,
    affine: DMatrix<f64>,
    /// `Z V`, a column an eigenvalue, and the eigenvalues.
    vectors: DMatrix<f64>,
    eigenvalues: Vec<f64>,
    /// `Vᵀ Zᵀ y`.
    projected: DMatrix<f64>,
}

/// A fitted field.
pub(crate) struct Spline<'a> {
    basis: &'a Basis,
    weights: DMatrix<f64>,
    affine: DMatrix<f64>,
}

/// The radial function. The cube of the distance has continuous curvature at the samples, where
/// the distance itself has a tip, and meets smooth fields more closely between them.
fn phi(r: f64) -> f64 {
    r * r * r
}

impl Basis {
    /// None where the decomposition does not converge.
    pub(crate) fn new(sites: &[DVec3], values: &[DVec3]) -> Option<Self> {
        let count = sites.len();
        let centre = sites.iter().sum::<DVec3>() / count as f64;
        let radius = sites.iter().map(|s| s.distance(centre)).fold(0.0, f64::max);
        let is_one_place = radius < ONE_PLACE;
        let scale = if is_one_place { 1.0 } else { radius };
        let sites: Vec<DVec3> = sites.iter().map(|s| (s - centre) / scale).collect();
        let scatter = sites.iter().map(|s| outer(*s, *s)).sum();
        let (spread, axes) = symmetric_eigen(&scatter)?;
        let slopes: Vec<DVec3> = (0..3)
            .filter(|&k| !is_one_place && spread[k] > FLAT * FLAT * spread.x)
            .map(|k| axes.col(k))
            .collect();

        let values = DMatrix::from_fn(count, 3, |i, k| values[i][k]);
        let kernel = DMatrix::from_fn(count, count, |i, j| phi(sites[i].distance(sites[j])));
        let affine = DMatrix::from_fn(count, 1 + slopes.len(), |i, k| match k {
            0 => 1.0,
            k => slopes[k - 1].dot(sites[i]),
        });
        let mut full = DMatrix::identity(count, count);
        affine.clone().qr().q_tr_mul(&mut full);
        let orthogonal = full
            .rows(affine.ncols(), count - affine.ncols())
            .transpose();
        let inner = orthogonal.tr_mul(&(&kernel * &orthogonal));
        let eigen = SymmetricEigen::try_new(inner, f64::EPSILON, 1000 * count)?;
        let vectors = orthogonal * eigen.eigenvectors;
        Some(Self {
            projected: vectors.tr_mul(&values),
            // Rounding may make the least of them negative.
            eigenvalues: eigen.eigenvalues.iter().map(|e| e.max(0.0)).collect(),
            vectors,
            values,
            kernel,
            affine,
            slopes,
            sites,
            centre,
            scale,
        })
    }

    /// The smoothing weights that are worth trying, the least first.
    pub(crate) fn smoothings(&self) -> impl Iterator<Item = f64> {
        let largest = self.eigenvalues.iter().copied().fold(0.0, f64::max);
        let largest = if largest > 0.0 { largest } else { 1.0 };
        (LEAST_EXPONENT..=MOST_EXPONENT).map(move |k| largest * 10_f64.powf(0.5 * f64::from(k)))
    }

    /// The distance of each sample from the field that all others give, in metres; infinite for a
    /// sample that alone decides something.
    pub(crate) fn left_out(&self, smoothing: f64) -> Vec<f64> {
        (0..self.sites.len())
            .map(|i| {
                let (residual, freedom) = self.residual(i, smoothing);
                if freedom > f64::EPSILON {
                    residual.length() / freedom
                } else {
                    f64::INFINITY
                }
            })
            .collect()
    }

    /// What a sample misses the field by, and 1 less its leverage.
    fn residual(&self, sample: usize, smoothing: f64) -> (DVec3, f64) {
        let (mut residual, mut freedom) = (DVec3::ZERO, 0.0);
        for (k, eigenvalue) in self.eigenvalues.iter().enumerate() {
            let kept = smoothing / (eigenvalue + smoothing) * self.vectors[(sample, k)];
            freedom += kept * self.vectors[(sample, k)];
            for c in 0..3 {
                residual[c] += kept * self.projected[(k, c)];
            }
        }
        (residual, freedom)
    }

    /// What is minimised, with all samples and without each.
    ///
    /// Read as the posterior mean of a Gaussian process the field has 12 unknowns or fewer, its
    /// affine part, and what is minimised is the sum of squares of the rest's independent noise and
    /// prior, each over its variance (Wahba 1990): the sum that the test for outliers asks for.
    pub(crate) fn deletions(&self, smoothing: f64) -> Deletions {
        let sum = (0..self.eigenvalues.len())
            .map(|k| {
                let squares = (0..3).map(|c| self.projected[(k, c)].powi(2)).sum::<f64>();
                smoothing / (self.eigenvalues[k] + smoothing) * squares
            })
            .sum::<f64>();
        let each = (0..self.sites.len()).map(|i| {
            let (residual, freedom) = self.residual(i, smoothing);
            (freedom > LEAST_FREEDOM).then(|| Deleted {
                sum: (sum - residual.length_squared() / freedom).max(0.0),
                deviation: residual.length() / freedom,
            })
        });
        Deletions {
            each: each.collect(),
            sum,
        }
    }

    /// The unknowns that no prior knows anything of: the affine part's.
    pub(crate) fn parameters(&self) -> usize {
        3 * self.affine.ncols()
    }

    /// The field with this smoothing weight; none where rounding leaves no slopes to solve for.
    pub(crate) fn spline(&self, smoothing: f64) -> Option<Spline<'_>> {
        let mut damped = self.projected.clone();
        for (mut row, eigenvalue) in damped.row_iter_mut().zip(&self.eigenvalues) {
            row /= eigenvalue + smoothing;
        }
        let weights = &self.vectors * damped;
        let rest = &self.values - &self.kernel * &weights - &weights * smoothing;
        let qr = self.affine.clone().qr();
        let affine = qr.r().solve_upper_triangular(&qr.q().tr_mul(&rest))?;
        Some(Spline {
            basis: self,
            weights,
            affine,
        })
    }
}

impl Spline<'_> {
    /// The field at a place.
    pub(crate) fn at(&self, place: DVec3) -> DVec3 {
        let Basis {
            sites,
            centre,
            scale,
            slopes,
            ..
        } = self.basis;
        let place = (place - centre) / *scale;
        let row = |m: &DMatrix<f64>, i: usize| DVec3::new(m[(i, 0)], m[(i, 1)], m[(i, 2)]);
        let affine = slopes
            .iter()
            .enumerate()
            .map(|(k, slope)| row(&self.affine, k + 1) * slope.dot(place));
        let radial = sites
            .iter()
            .enumerate()
            .map(|(i, site)| row(&self.weights, i) * phi(site.distance(place)));
        row(&self.affine, 0) + affine.sum::<DVec3>() + radial.sum::<DVec3>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places that fill a box unevenly, and a field that is bent and not affine.
    fn samples() -> (Vec<DVec3>, Vec<DVec3>) {
        let part = |k: usize, step: f64| (k as f64 * step).fract();
        let sites: Vec<_> = (1..=40)
            .map(|k| {
                DVec3::new(
                    part(k, 0.8192),
                    0.6 * part(k, 0.6710),
                    0.3 * part(k, 0.5497),
                )
            })
            .collect();
        let values = sites.iter().map(|&site| field(site)).collect();
        (sites, values)
    }

    fn field(p: DVec3) -> DVec3 {
        DVec3::new(p.x * p.y - 0.2 * p.z, p.x * p.x, 0.3 + p.y * p.z)
    }

    #[test]
    fn left_out_is_what_a_fit_through_the_others_misses_by() {
        let (sites, values) = samples();
        let all = Basis::new(&sites, &values).unwrap();
        for smoothing in [1e-6, 1e-3, 1.0] {
            let left_out = all.left_out(smoothing);
            for out in [0, 7, 39] {
                let (mut sites, mut values) = (sites.clone(), values.clone());
                let (site, value) = (sites.remove(out), values.remove(out));
                let others = Basis::new(&sites, &values).unwrap();
                // The weight is relative to the scale's cube, which the sample left out may set.
                let smoothing = smoothing * (all.scale / others.scale).powi(3);
                let missed = others.spline(smoothing).unwrap().at(site).distance(value);
                assert!((missed - left_out[out]).abs() < 1e-9, "{missed}");
            }
        }
    }

    #[test]
    fn affine_fields_are_met_exactly_and_bent_ones_closely() {
        let (sites, values) = samples();
        let affine = |p: DVec3| DVec3::new(1.0 + p.x, p.y - 2.0 * p.z, 3.0 * p.x + p.y);
        let exact: Vec<_> = sites.iter().map(|&site| affine(site)).collect();
        let basis = Basis::new(&sites, &exact).unwrap();
        let place = DVec3::new(0.45, 0.25, 0.1);
        let most = basis.smoothings().last().unwrap();
        assert!(
            basis
                .spline(most)
                .unwrap()
                .at(place)
                .distance(affine(place))
                < 1e-12
        );

        let basis = Basis::new(&sites, &values).unwrap();
        let least = basis.smoothings().next().unwrap();
        let spline = basis.spline(least).unwrap();
        for (site, value) in sites.iter().zip(&values) {
            assert!(spline.at(*site).distance(*value) < 1e-6);
        }
        // With the distance in place of its cube it would be off by three times as much.
        let off: f64 = (1..=20)
            .map(|k| {
                let place = DVec3::splat(0.2) + 0.01 * f64::from(k) * DVec3::new(2.0, 1.0, -0.5);
                spline.at(place).distance_squared(field(place))
            })
            .sum();
        assert!((off / 20.0).sqrt() < 3e-3);
    }
}
