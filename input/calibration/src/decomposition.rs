//! Singular values and eigenvalues of 3 x 3 matrices.

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};

/// Far more iterations than a 3 x 3 matrix of finite numbers takes.
const MOST_ITERATIONS: usize = 1000;

/// `m = u * diag(values) * vᵀ`, values falling; `u` and `v` are orthogonal, of either handedness.
pub(crate) struct Svd {
    pub(crate) u: DMat3,
    pub(crate) values: DVec3,
    pub(crate) v: DMat3,
}

/// The singular value decomposition, or none where it does not converge.
pub(crate) fn svd(m: &DMat3) -> Option<Svd> {
    let svd = to_nalgebra(m).try_svd(true, true, f64::EPSILON, MOST_ITERATIONS)?;
    Some(Svd {
        u: from_nalgebra(&svd.u?),
        values: DVec3::from_slice(svd.singular_values.as_slice()),
        v: from_nalgebra(&svd.v_t?.transpose()),
    })
}

/// A symmetric matrix's eigenvalues, falling, and unit eigenvectors as columns in the same order;
/// none where they do not converge.
pub(crate) fn symmetric_eigen(m: &DMat3) -> Option<(DVec3, DMat3)> {
    let eigen = SymmetricEigen::try_new(to_nalgebra(m), f64::EPSILON, MOST_ITERATIONS)?;
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let vectors = from_nalgebra(&eigen.eigenvectors);
    Some((
        DVec3::from_array(order.map(|k| eigen.eigenvalues[k])),
        DMat3::from_cols(
            vectors.col(order[0]),
            vectors.col(order[1]),
            vectors.col(order[2]),
        ),
    ))
}

/// `a * bᵀ`.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The sum of the diagonal.
pub(crate) fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

fn to_nalgebra(m: &DMat3) -> Matrix3<f64> {
    Matrix3::from_column_slice(&m.to_cols_array())
}

fn from_nalgebra(m: &Matrix3<f64>) -> DMat3 {
    DMat3::from_cols_slice(m.as_slice())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_multiply_to_the_matrix_and_values_fall() {
        let m = DMat3::from_cols_array(&[1.0, -2.0, 0.5, 0.25, 3.0, -1.0, 2.0, 0.1, 0.7]);
        let Svd { u, values, v } = svd(&m).unwrap();
        let again = u * DMat3::from_diagonal(values) * v.transpose();
        assert!(again.abs_diff_eq(m, 1e-12));
        assert!(values.x >= values.y && values.y >= values.z && values.z >= 0.0);

        let symmetric = m * m.transpose();
        let (values, vectors) = symmetric_eigen(&symmetric).unwrap();
        let again = vectors * DMat3::from_diagonal(values) * vectors.transpose();
        assert!(again.abs_diff_eq(symmetric, 1e-12));
        assert!(values.x >= values.y && values.y >= values.z);
    }

    #[test]
    fn a_matrix_of_rank_one_has_orthogonal_factors_too() {
        let m = outer(DVec3::new(1.0, 2.0, 3.0), DVec3::new(-1.0, 0.5, 2.0));
        let Svd { u, values, v } = svd(&m).unwrap();
        for factor in [u, v] {
            assert!((factor * factor.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        }
        assert!(values.y < 1e-12 * values.x);
    }
}
