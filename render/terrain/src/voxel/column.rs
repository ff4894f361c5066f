//! The densities of one column of voxels.

/// The part of a column that is neither wholly below nor wholly above the surface: all levels
/// under `first` have density 255, all past the run have 0.
#[derive(Debug, Default)]
pub(super) struct Run {
    pub(super) first: i32,
    /// Densities from `first` upwards; not rising.
    pub(super) densities: Vec<u8>,
}

impl Run {
    /// A column of binary voxels, without a run.
    pub(super) fn set_binary(&mut self, first_above: i32) {
        self.first = first_above;
        self.densities.clear();
    }

    /// A column with these densities from level `first` upwards.
    pub(super) fn set(&mut self, first: i32, densities: impl Iterator<Item = u8>) {
        self.first = first;
        self.densities.clear();
        for density in densities {
            match density {
                255 => self.first += 1,
                0 => break,
                _ => self.densities.push(density),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_densities_at_both_ends_are_not_stored() {
        let mut run = Run::default();
        run.set(-2, [255, 255, 200, 1, 0, 0].into_iter());
        assert_eq!((run.first, &run.densities[..]), (0, &[200, 1][..]));
        run.set(7, [255, 0].into_iter());
        assert_eq!((run.first, run.densities.len()), (8, 0));
    }
}
