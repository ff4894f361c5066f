//! A photograph that lies over the ground.

use crate::TiledRaster;
use glam::DVec2;

/// A colour photograph on a north-up grid of its own. Row 0 is south.
#[derive(Clone, Debug)]
pub struct Photo {
    /// Red, green, blue and coverage: 255 where the photograph has a pixel, 0 where it has none.
    pub pixels: TiledRaster<[u8; 4]>,
    /// World x and y, in metres, of the south-west pixel's centre.
    pub origin: DVec2,
    /// Metres between pixel centres, eastwards and northwards.
    pub spacing: DVec2,
}

impl Photo {
    /// Whether there is a colour everywhere from the world's origin to `extent` (metres).
    #[must_use]
    pub fn covers(&self, extent: DVec2) -> bool {
        let first = -self.origin / self.spacing;
        let last = (extent - self.origin) / self.spacing;
        let size = DVec2::new(f64::from(self.pixels.cols()), f64::from(self.pixels.rows()));
        let within = first.min_element() >= -0.5 && (size - last).min_element() >= 0.5;
        within
            && self.pixels.tile_indices().all(|tile| {
                let pixels = self.pixels.tile_posts(tile);
                pixels.iter().all(|pixel| pixel[3] != 0)
            })
    }

    /// Whether both are the same picture in the same place, between which nothing was changed.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        self.pixels.is_same(&other.pixels)
            && (self.origin, self.spacing) == (other.origin, other.spacing)
    }

    /// The bilinear colour at world `(x, y)`, or `None` off the photograph or beside a missing
    /// pixel. The outer half pixel belongs to the photograph.
    #[inline]
    #[must_use]
    pub fn colour_at(&self, x: f64, y: f64) -> Option<[u8; 3]> {
        let px = (x - self.origin.x) / self.spacing.x;
        let py = (y - self.origin.y) / self.spacing.y;
        let inside = px >= -0.5
            && py >= -0.5
            && px <= f64::from(self.pixels.cols()) - 0.5
            && py <= f64::from(self.pixels.rows()) - 0.5;
        if !inside {
            return None;
        }
        let ([col, row], [u, v]) = self.pixels.locate(px, py);
        let [sw, se, nw, ne] = self.pixels.cell(col, row);
        let (u, v) = (u as f32, v as f32);
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let texels = [sw, se, nw, ne];
        if texels
            .iter()
            .zip(weights)
            .any(|(texel, weight)| texel[3] == 0 && weight > 0.0)
        {
            return None;
        }
        let channel = |k: usize| {
            let sum: f32 = texels
                .iter()
                .zip(weights)
                .map(|(texel, weight)| f32::from(texel[k]) * weight)
                .sum();
            (sum + 0.5) as u8
        };
        Some([channel(0), channel(1), channel(2)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_blend_between_pixel_centres_and_end_at_the_outer_edge() {
        let mut photo = Photo {
            pixels: TiledRaster::from_fn(2, 2, |col, _| [100 * col as u8, 50, 0, 255]),
            origin: DVec2::new(10.0, 20.0),
            spacing: DVec2::new(4.0, 2.0),
        };
        assert_eq!(photo.colour_at(12.0, 21.0), Some([50, 50, 0]));
        assert_eq!(photo.colour_at(8.0, 19.0), Some([0, 50, 0]));
        assert_eq!(photo.colour_at(7.9, 19.0), None);
        photo.origin = DVec2::ZERO;
        assert!(photo.covers(DVec2::new(6.0, 3.0)) && !photo.covers(DVec2::new(6.1, 3.0)));
        photo.origin = DVec2::new(10.0, 20.0);
        assert!(!photo.covers(DVec2::ONE));
        photo.pixels = photo.pixels.edited(1..2, 0..2, |_, _, _| [0; 4]).0;
        assert!(!photo.covers(DVec2::ZERO));
        assert_eq!(photo.colour_at(12.0, 21.0), None);
        assert!(photo.colour_at(9.0, 21.0).is_some());
    }
}
