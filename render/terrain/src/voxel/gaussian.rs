//! A 3D Gaussian over the binary voxels of a height field.
//!
//! The kernel is separable and a column of binary voxels is one number, the first level above
//! the surface. So a column's densities are the vertical filter over a single profile: at each
//! level, the horizontal weight of all columns around that are below the surface there. Each
//! column around enters the profile once, whatever its height.
//!
//! All is integers, so that sums do not depend on their order and densities never rise.

use super::column::Run;

/// Weights add up to this along each axis.
const UNIT: u64 = 1 << 16;

/// A Gaussian's weights.
#[derive(Debug)]
pub(super) struct Gaussian {
    radius: usize,
    axis: Vec<u64>,
    /// Products of two axes, row by row.
    plane: Vec<u64>,
}

/// The profile of one column, kept from column to column.
#[derive(Debug, Default)]
pub(super) struct Profile(Vec<u64>);

impl Gaussian {
    /// `sigma` in voxels, above 0; the weights end at `radius`.
    pub(super) fn new(sigma: f64, radius: usize) -> Self {
        let weight = |step: usize| {
            let at = step as f64 - radius as f64;
            (-0.5 * (at / sigma).powi(2)).exp()
        };
        let taps = 2 * radius + 1;
        let total: f64 = (0..taps).map(weight).sum();
        let mut axis: Vec<_> = (0..taps)
            .map(|step| (weight(step) / total * UNIT as f64).round() as u64)
            .collect();
        // What rounding lost or won goes to the middle, so that weights stay symmetric.
        axis[radius] = 0;
        axis[radius] = UNIT - axis.iter().sum::<u64>();
        let plane = axis
            .iter()
            .flat_map(|row| axis.iter().map(move |col| row * col))
            .collect();
        Self {
            radius,
            axis,
            plane,
        }
    }

    /// How many voxels away weights end.
    pub(super) fn radius(&self) -> usize {
        self.radius
    }

    /// Fills a column from the first levels above the surface around it: `rows` of
    /// 2 · radius + 1 columns each, from the south-west.
    pub(super) fn column<'a>(
        &self,
        rows: impl Iterator<Item = &'a [i32]> + Clone,
        profile: &mut Profile,
        run: &mut Run,
    ) {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for &level in rows.clone().flatten() {
            low = low.min(level);
            high = high.max(level);
        }
        // The profile begins two radii under the lowest column and ends two over the highest.
        let relief = (high - low) as usize;
        let Profile(below) = profile;
        below.clear();
        below.resize(relief + 4 * self.radius + 1, 0);
        let weights = self.plane.chunks_exact(self.axis.len());
        for (row, weights) in rows.zip(weights) {
            for (&level, weight) in row.iter().zip(weights) {
                below[2 * self.radius + (level - low) as usize] += weight;
            }
        }
        // From how much ends at a level to how much is below the surface there.
        let mut remaining = UNIT * UNIT;
        for weight in below.iter_mut() {
            remaining -= *weight;
            *weight = remaining;
        }
        let densities = below.windows(self.axis.len()).map(|around| {
            let sum: u64 = around.iter().zip(&self.axis).map(|(a, b)| a * b).sum();
            ((255 * sum + UNIT.pow(3) / 2) / UNIT.pow(3)) as u8
        });
        run.set(low - self.radius as i32, densities);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_symmetric_and_whole() {
        for (sigma, radius) in [(0.01, 1), (0.5, 2), (1.0, 3), (8.0, 20)] {
            let Gaussian { axis, plane, .. } = Gaussian::new(sigma, radius);
            assert_eq!(axis.iter().sum::<u64>(), UNIT);
            assert_eq!(plane.iter().sum::<u64>(), UNIT * UNIT);
            assert!(axis.iter().eq(axis.iter().rev()));
            assert!(axis[..=radius].is_sorted());
        }
    }

    #[test]
    fn level_ground_fades_as_the_gaussian_does() {
        let gaussian = Gaussian::new(1.0, 3);
        let mut run = Run::default();
        let rows = [[5; 7]; 7];
        gaussian.column(
            rows.iter().map(|row| &row[..]),
            &mut Profile::default(),
            &mut run,
        );
        // Level 5 is the first above. The normal density at whole numbers is 0.3991, 0.2420,
        // 0.0540 and 0.0044 once it is cut off at 3: sums of its tail remain.
        for (level, share) in [(5, 0.3005), (6, 0.0584), (7, 0.0044)] {
            let above = f64::from(run.densities[(level - run.first) as usize]);
            let below = f64::from(run.densities[(9 - level - run.first) as usize]);
            assert!((above - 255.0 * share).abs() < 0.6, "{above} at {level}");
            assert_eq!(above + below, 255.0);
        }
    }
}
