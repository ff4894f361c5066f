//! What a caster fills: colour and depth of one view.

use crate::CastError;
use glam::DVec3;
use sandtable_terrain::use_huge_pages;
use sandtable_view::{Screen, View};

/// Colour and depth, row by row from the top, and the view that they were cast for.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The view that was cast.
    pub view: View,
    /// Red, green, blue and 255 in the order of memory, as words so that threads can fill them.
    colour: Vec<u32>,
    /// Metres in the world from the eye along the pixel's ray; +∞ for sky.
    pub depth: Vec<f32>,
}

impl Default for Image {
    /// An image without pixels, to be filled later.
    fn default() -> Self {
        let nowhere = Screen {
            lower_left: DVec3::ZERO,
            lower_right: DVec3::ZERO,
            upper_left: DVec3::ZERO,
        };
        Self {
            view: View {
                eye: DVec3::ZERO,
                window: nowhere,
                size: [0, 0],
            },
            colour: Vec::new(),
            depth: Vec::new(),
        }
    }
}

impl Image {
    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.view.size[0]
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.view.size[1]
    }

    /// The world point seen in pixel (i, j), or `None` for sky.
    #[must_use]
    pub fn point(&self, i: u32, j: u32) -> Option<DVec3> {
        let depth = self.depth[j as usize * self.width() as usize + i as usize];
        let ray = self.view.ray(i, j);
        depth
            .is_finite()
            .then(|| ray.origin + ray.direction.normalize_or_zero() * f64::from(depth))
    }

    /// Makes it an image of `view`, of the right size; the old pixels' memory is reused.
    ///
    /// # Panics
    /// Where there is not the memory for it.
    pub fn reset(&mut self, view: View) {
        self.try_reset(view)
            .unwrap_or_else(|refused| panic!("{refused}"));
    }

    /// As [`Image::reset`], without a panic.
    ///
    /// # Errors
    /// [`CastError::NoMemory`] where the system does not give it; the image is then as it was.
    pub fn try_reset(&mut self, view: View) -> Result<(), CastError> {
        let refused = |_| CastError::NoMemory { size: view.size };
        let pixels = view.size[0] as usize * view.size[1] as usize;
        self.colour
            .try_reserve_exact(pixels.saturating_sub(self.colour.len()))
            .map_err(refused)?;
        self.depth
            .try_reserve_exact(pixels.saturating_sub(self.depth.len()))
            .map_err(refused)?;
        self.view = view;
        use_huge_pages(self.colour.spare_capacity_mut());
        use_huge_pages(self.depth.spare_capacity_mut());
        self.colour
            .resize(pixels, u32::from_ne_bytes([0, 0, 0, 255]));
        self.depth.resize(pixels, f32::INFINITY);
        Ok(())
    }

    /// Red, green, blue (sRGB-encoded) and 255 of each pixel, row by row from the top.
    #[must_use]
    pub fn colour(&self) -> &[[u8; 4]] {
        bytemuck::cast_slice(&self.colour)
    }

    /// The colours, to be changed.
    pub fn colour_mut(&mut self) -> &mut [[u8; 4]] {
        bytemuck::cast_slice_mut(&mut self.colour)
    }

    /// Colours as words, and depths, to be filled by several threads.
    pub(crate) fn words_mut(&mut self) -> (&mut [u32], &mut [f32]) {
        (&mut self.colour, &mut self.depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_there_is_not_is_an_error_and_the_image_stays() {
        let mut image = Image::default();
        let small = View {
            size: [3, 2],
            ..image.view
        };
        image.reset(small);
        let size = [u32::MAX; 2];
        let refused = image.try_reset(View { size, ..small }).unwrap_err();
        assert_eq!(refused, CastError::NoMemory { size });
        assert_eq!((image.width(), image.colour().len()), (3, 6));
        let said = CastError::NoMemory {
            size: [32_768, 16_384],
        };
        let said = said.to_string();
        assert!(
            said.contains("32768 by 16384") && said.contains("4096 MiB"),
            "{said}"
        );
    }
}
