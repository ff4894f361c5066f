//! The ground's colours as a texture.

use super::error::MeshError;
use glam::DVec2;
use sandtable_terrain::{Grid, Ground};

/// The ground's colours as a grid of texels whose centres lie in the world, the first row south.
pub(super) struct Texels {
    /// World x and y of the south-west texel's centre, in metres.
    origin: DVec2,
    /// Metres between centres, eastwards and northwards.
    spacing: DVec2,
    /// Texels from west to east and from south to north.
    pub(super) size: [u32; 2],
    /// Column and row, among the photograph's pixels, of the south-west texel, where these are
    /// its pixels.
    in_photo: Option<[i64; 2]>,
}

impl Texels {
    /// The texels of a photograph that lie over the ground, or one a post where there is none, or
    /// more of them than `longest` along a side.
    pub(super) fn new(ground: &Ground, longest: u32) -> Result<Self, MeshError> {
        if let Some(texels) = Self::of_photo(ground, longest) {
            return Ok(texels);
        }
        let Grid {
            cols,
            rows,
            spacing,
        } = ground.grid();
        if cols.max(rows) > longest {
            return Err(MeshError::Texture {
                cols,
                rows,
                longest,
            });
        }
        Ok(Self {
            origin: DVec2::ZERO,
            spacing,
            size: [cols, rows],
            in_photo: None,
        })
    }

    fn of_photo(ground: &Ground, longest: u32) -> Option<Self> {
        let photo = ground.photo()?;
        // Pixels up to the centres on or beyond the ground's borders.
        let first = (-photo.origin / photo.spacing).floor();
        let last = ((ground.grid().extent() - photo.origin) / photo.spacing).ceil();
        let count = last - first + 1.0;
        (count.max_element() <= f64::from(longest)).then(|| Self {
            origin: photo.origin + first * photo.spacing,
            spacing: photo.spacing,
            size: [count.x as u32, count.y as u32],
            in_photo: Some([first.x as i64, first.y as i64]),
        })
    }

    /// Where a post lies in the texture, in shares of its sides.
    pub(super) fn place(&self, post: DVec2) -> DVec2 {
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        ((post - self.origin) / self.spacing + 0.5) / size
    }

    /// The texels, row by row.
    pub(super) fn colours(&self, ground: &Ground) -> Vec<[u8; 4]> {
        let [cols, rows] = self.size;
        (0..rows)
            .flat_map(|row| (0..cols).map(move |col| [col, row]))
            .map(|texel| self.colour(ground, texel))
            .collect()
    }

    fn colour(&self, ground: &Ground, [col, row]: [u32; 2]) -> [u8; 4] {
        let pixel = || {
            let [first_col, first_row] = self.in_photo?;
            let pixels = &ground.photo()?.pixels;
            let col = u32::try_from(first_col + i64::from(col)).ok()?;
            let row = u32::try_from(first_row + i64::from(row)).ok()?;
            let inside = col < pixels.cols() && row < pixels.rows();
            inside
                .then(|| pixels.post(col, row))
                .filter(|pixel| pixel[3] != 0)
        };
        pixel().unwrap_or_else(|| {
            let centre = DVec2::new(f64::from(col), f64::from(row));
            let centre = self.origin + centre * self.spacing;
            let [r, g, b] = ground.colour_at(centre.x, centre.y);
            [r, g, b, 255]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_terrain::{Photo, TiledRaster};

    fn photographed(origin: DVec2) -> Ground {
        let ground = Ground::from_fn(5, 3, DVec2::splat(10.0), |_, _| 0.0).unwrap();
        ground.with_photo(Photo {
            pixels: TiledRaster::from_fn(30, 20, |col, row| [col as u8, row as u8, 7, 255]),
            origin,
            spacing: DVec2::splat(3.0),
        })
    }

    #[test]
    fn a_photographs_pixels_over_the_ground_are_the_texels() {
        let texels = Texels::new(&photographed(DVec2::new(-10.0, -4.0)), 64).unwrap();
        // From the centre at −1 to that at 41 eastwards, from −1 to 20 northwards.
        assert_eq!(texels.size, [15, 8]);
        assert_eq!(texels.origin, DVec2::new(-1.0, -1.0));
        let colours = texels.colours(&photographed(DVec2::new(-10.0, -4.0)));
        assert_eq!(colours[0], [3, 1, 7, 255]);
        assert_eq!(colours[15 * 8 - 1], [17, 8, 7, 255]);
        let place = texels.place(DVec2::new(2.0, 5.0));
        assert!((place - DVec2::new(1.5 / 15.0, 2.5 / 8.0)).length() < 1e-12);
    }

    #[test]
    fn a_photograph_too_large_leaves_a_texel_a_post() {
        let ground = photographed(DVec2::ZERO);
        let texels = Texels::new(&ground, 14).unwrap();
        assert_eq!((texels.size, texels.in_photo), ([5, 3], None));
        assert_eq!(texels.spacing, DVec2::splat(10.0));
        let east = texels.colours(&ground)[1];
        let [r, g, b] = ground.colour_at(10.0, 0.0);
        assert_eq!(east, [r, g, b, 255]);
        assert!(matches!(
            Texels::new(&ground, 4),
            Err(MeshError::Texture { longest: 4, .. })
        ));
    }
}
