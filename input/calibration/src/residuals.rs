//! How far the measurements lie from a fit.

/// The distance of each measurement from what the fit makes of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Residuals {
    /// One distance a measurement, in their order, in metres.
    pub each: Vec<f64>,
    /// Their root mean square, in metres.
    pub rms: f64,
    /// The index, from 0, of the largest; of the first where several are.
    pub worst: usize,
}

impl Residuals {
    pub(crate) fn of(each: impl Iterator<Item = f64>) -> Self {
        let each: Vec<f64> = each.collect();
        let mean = each.iter().map(|r| r * r).sum::<f64>() / each.len() as f64;
        let worst = (0..each.len())
            .rev()
            .max_by(|&a, &b| each[a].total_cmp(&each[b]))
            .unwrap_or(0);
        Self {
            rms: mean.sqrt(),
            worst,
            each,
        }
    }

    /// The sum of squares, in square metres.
    pub(crate) fn sum_of_squares(&self) -> f64 {
        self.each.iter().map(|r| r * r).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_of_equals_is_the_first() {
        let residuals = Residuals::of([1.0, 3.0, 3.0, 2.0].into_iter());
        assert_eq!(residuals.worst, 1);
        assert_eq!(residuals.rms, 23.0_f64.sqrt() / 2.0);
    }
}
