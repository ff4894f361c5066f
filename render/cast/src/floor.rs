//! The floor under every caster: shading alone.

use crate::Image;
use rayon::prelude::*;
use sandtable_terrain::Ground;

/// An image whose hits are known: what remains is one colour fetch and one write a pixel.
///
/// Its time is what a caster would need if finding hits cost nothing.
pub struct ShadeFloor {
    hits: Vec<Option<[f64; 2]>>,
    width: usize,
    colour: Vec<[u8; 4]>,
}

impl ShadeFloor {
    /// Takes the hits from a finished image.
    #[must_use]
    pub fn new(image: &Image) -> Self {
        let [width, height] = image.view.size;
        let hits = (0..height)
            .flat_map(|j| (0..width).map(move |i| (i, j)))
            .map(|(i, j)| image.point(i, j).map(|point| [point.x, point.y]))
            .collect();
        Self {
            hits,
            width: width.max(1) as usize,
            colour: vec![[0; 4]; image.colour().len()],
        }
    }

    /// Colours every pixel, on the current thread pool.
    pub fn shade(&mut self, ground: &Ground) {
        let rows = self
            .colour
            .par_chunks_mut(self.width)
            .zip(self.hits.par_chunks(self.width));
        rows.for_each(|(colours, hits)| {
            for (colour, hit) in colours.iter_mut().zip(hits) {
                let [r, g, b] = hit.map_or([0; 3], |[x, y]| ground.colour_at(x, y));
                *colour = [r, g, b, 255];
            }
        });
    }
}
