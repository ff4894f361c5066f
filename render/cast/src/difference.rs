//! How far one image is from another of the same view.

use crate::Image;

/// What tells a caster's image from the exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The largest difference of depth in cells; infinite where one image has sky and the other
    /// has not.
    pub max_cells: f64,
    /// Pixels whose depth differs by more than a tenth of a cell.
    pub over_tenth_cell: u64,
    /// Pixels whose depth differs by more than half a cell.
    pub over_half_cell: u64,
    /// Pixels whose depth differs by more than a cell.
    pub over_one_cell: u64,
    /// Peak signal-to-noise ratio of the colours in dB; `None` where they are identical.
    pub psnr_db: Option<f64>,
}

impl Difference {
    /// Compares two images of one view, where a cell is `cell_length` metres.
    ///
    /// # Panics
    /// Where the images differ in size.
    #[must_use]
    pub fn between(image: &Image, exact: &Image, cell_length: f64) -> Self {
        assert_eq!(image.view.size, exact.view.size, "images of one view");
        let mut result = Self {
            max_cells: 0.0,
            over_tenth_cell: 0,
            over_half_cell: 0,
            over_one_cell: 0,
            psnr_db: None,
        };
        for (&found, &wanted) in image.depth.iter().zip(&exact.depth) {
            if found != wanted {
                let cells = f64::from((found - wanted).abs()) / cell_length;
                result.max_cells = result.max_cells.max(cells);
                result.over_tenth_cell += u64::from(cells > 0.1);
                result.over_half_cell += u64::from(cells > 0.5);
                result.over_one_cell += u64::from(cells > 1.0);
            }
        }
        let mut squares = 0.0;
        for (found, wanted) in image.colour().iter().zip(exact.colour()) {
            for k in 0..3 {
                squares += (f64::from(found[k]) - f64::from(wanted[k])).powi(2);
            }
        }
        if squares > 0.0 {
            let mean = squares / (3.0 * image.colour().len() as f64);
            result.psnr_db = Some(10.0 * (255.0 * 255.0 / mean).log10());
        }
        result
    }
}
