//! What a caster fills: colour and depth of one view.

use glam::DVec3;
use rayon::prelude::*;
use sandtable_view::{Screen, View};

/// Colour and depth, row by row from the top, and the view that they were cast for.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The view that was cast.
    pub view: View,
    /// Red, green, blue (sRGB-encoded) and 255.
    pub colour: Vec<[u8; 4]>,
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
    pub fn reset(&mut self, view: View) {
        let pixels = view.size[0] as usize * view.size[1] as usize;
        self.view = view;
        self.colour.resize(pixels, [0, 0, 0, 255]);
        self.depth.resize(pixels, f32::INFINITY);
    }

    /// Cuts the image into upright strips of `width` columns that threads can fill apart.
    fn strips(&mut self, width: u32) -> Vec<ColumnStrip<'_>> {
        let view = self.view;
        let [w, h] = view.size;
        let mut strips: Vec<_> = (0..w)
            .step_by(width as usize)
            .map(|first| ColumnStrip {
                view,
                first,
                colour: Vec::with_capacity(h as usize),
                depth: Vec::with_capacity(h as usize),
            })
            .collect();
        if w == 0 {
            return strips;
        }
        let rows = self
            .colour
            .chunks_exact_mut(w as usize)
            .zip(self.depth.chunks_exact_mut(w as usize));
        for (colour, depth) in rows {
            let parts = colour
                .chunks_mut(width as usize)
                .zip(depth.chunks_mut(width as usize));
            for (strip, (colour, depth)) in strips.iter_mut().zip(parts) {
                strip.colour.push(colour);
                strip.depth.push(depth);
            }
        }
        strips
    }
}

/// Some neighbouring columns of an image, over its full height.
pub struct ColumnStrip<'a> {
    /// The view of the whole image.
    pub view: View,
    /// The image column at which the strip begins.
    pub first: u32,
    /// For each image row the strip's colours.
    pub colour: Vec<&'a mut [[u8; 4]]>,
    /// For each image row the strip's depths.
    pub depth: Vec<&'a mut [f32]>,
}

impl ColumnStrip<'_> {
    /// How many columns it has.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.colour.first().map_or(0, |row| row.len() as u32)
    }

    /// How many rows it has.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.colour.len() as u32
    }

    /// Sets the pixel at column `i` of the strip, row `j`.
    #[inline]
    pub fn set(&mut self, i: u32, j: u32, colour: [u8; 3], depth: f32) {
        let (i, j) = (i as usize, j as usize);
        let [r, g, b] = colour;
        self.colour[j][i] = [r, g, b, 255];
        self.depth[j][i] = depth;
    }
}

/// How many columns one task fills: narrow enough to balance, wide enough not to share cache lines
/// along every row.
pub(crate) const STRIP_WIDTH: u32 = 64;

/// Casts all `views` as one parallel job: every strip of every image is a task.
pub(crate) fn fill_strips(
    views: &[View],
    images: &mut [Image],
    fill: impl Fn(&mut ColumnStrip<'_>) + Send + Sync,
) {
    assert_eq!(views.len(), images.len(), "one image a view");
    let mut strips = Vec::new();
    for (image, view) in images.iter_mut().zip(views) {
        image.reset(*view);
        strips.extend(image.strips(STRIP_WIDTH));
    }
    strips.par_iter_mut().with_max_len(1).for_each(fill);
}
