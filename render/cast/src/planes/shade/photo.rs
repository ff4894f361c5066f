//! Where hits' colours lie in a photograph.

use crate::lanes::Lanes;
use crate::planes::field::Tiles;
use crate::planes::frame::Frame;
use sandtable_terrain::Photo;

/// A photograph along one axis, as one sector's rays run along it.
pub(super) struct Along {
    sign: i32,
    /// The pixel under the eye or, where rays run backwards, the one behind it; and how far along
    /// the rays' direction the eye lies from there.
    base: i32,
    fraction: f32,
    /// Pixels for each cell of advance.
    pixels: f32,
    /// The last pixel but one.
    last: i32,
}

impl Along {
    pub(super) fn new(eye: f64, per_cell: f64, sign: i32, pixels: u32) -> Self {
        let base = if sign > 0 { eye.floor() } else { eye.ceil() };
        Self {
            sign,
            base: base as i32,
            fraction: (eye - base).abs() as f32,
            pixels: per_cell as f32,
            last: pixels as i32 - 2,
        }
    }

    /// The pixel before the place to which rays advanced, and the weight of the one behind it.
    #[inline(always)]
    pub(super) fn locate<L: Lanes>(&self, l: L, advance: L::F) -> (L::I, L::F) {
        let along = l.add(l.mul(advance, l.splat(self.pixels)), l.splat(self.fraction));
        let whole = l.to_int(along);
        let share = l.sub(along, l.to_float(whole));
        if self.sign > 0 {
            (l.add_i(l.splat_i(self.base), whole), share)
        } else {
            (
                l.sub_i(l.splat_i(self.base - 1), whole),
                l.sub(l.splat(1.0), share),
            )
        }
    }

    /// A number that is negative where the photo has not both a pixel and the one behind it.
    #[inline(always)]
    fn room<L: Lanes>(&self, l: L, at: L::I) -> L::I {
        l.min_i(at, l.sub_i(l.splat_i(self.last), at))
    }

    /// The same for places beyond the outer pixels' centres, where their colours go on for half a
    /// pixel; and where there is none any more.
    #[inline(always)]
    pub(super) fn at_border<L: Lanes>(&self, l: L, at: L::I, share: L::F) -> (L::I, L::F, L::M) {
        let (none, last) = (l.splat_i(0), l.splat_i(self.last));
        let half = l.splat(0.5);
        let (before, behind) = (l.gt_i(none, at), l.gt_i(at, last));
        let near_before = l.and(l.eq_i(at, l.splat_i(-1)), l.le(half, share));
        let near_behind = l.and(l.eq_i(at, l.splat_i(self.last + 1)), l.le(share, half));
        let off = l.and_not(l.or(before, behind), l.or(near_before, near_behind));
        let share = l.select(before, l.splat(0.0), l.select(behind, l.splat(1.0), share));
        (l.max_i(l.min_i(at, last), none), share, off)
    }
}

/// A photograph as one sector's rays meet it.
pub(super) struct Mapped<'a> {
    pub(super) tiles: Tiles<'a, [u8; 4]>,
    pub(super) x: Along,
    pub(super) y: Along,
    /// Whether it covers all ground: then no hit is off it, but for rounding.
    pub(super) covers: bool,
}

impl<'a> Mapped<'a> {
    pub(super) fn new(photo: &'a Photo, frame: &Frame<'_>, signs: [i32; 2]) -> Self {
        let raster = &photo.pixels;
        let spacing = frame.ground.grid().spacing;
        let eye = (frame.view.eye.truncate() - photo.origin) / photo.spacing;
        let per_cell = spacing / photo.spacing;
        Self {
            tiles: Tiles::new(raster.view(), raster.tiles_across(), raster.tile_stride()),
            x: Along::new(eye.x, per_cell.x, signs[0], raster.cols()),
            y: Along::new(eye.y, per_cell.y, signs[1], raster.rows()),
            covers: frame.ground.light().is_none(),
        }
    }

    /// Where the colours of rays lie that advanced by so many cells along x and y: the place,
    /// the weights of the eastern and northern pixels, and whether the photo
    /// reaches there.
    #[inline(always)]
    pub(super) fn locate<L: Lanes>(&self, l: L, mask: L::M, advances: [L::F; 2]) -> Located<L> {
        let (mut x, mut east) = self.x.locate(l, advances[0]);
        let (mut y, mut north) = self.y.locate(l, advances[1]);
        let mut on = mask;
        let room = l.min_i(self.x.room(l, x), self.y.room(l, y));
        if l.bits(l.and(mask, l.gt_i(l.splat_i(0), room))) != 0 {
            let (off_x, off_y);
            (x, east, off_x) = self.x.at_border(l, x, east);
            (y, north, off_y) = self.y.at_border(l, y, north);
            if !self.covers {
                on = l.and_not(mask, l.or(off_x, off_y));
            }
        }
        Located {
            at: self.tiles.only(l, mask, self.tiles.place(l, x, y)),
            east,
            north,
            on,
        }
    }
}

/// Where colours lie in a photo.
pub(super) struct Located<L: Lanes> {
    pub(super) at: L::I,
    pub(super) east: L::F,
    pub(super) north: L::F,
    pub(super) on: L::M,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, Portable};
    use glam::DVec2;
    use sandtable_terrain::TiledRaster;

    /// All the way across its four borders, for rays in all four directions.
    #[test]
    fn colours_lie_where_the_photo_has_them() {
        let l = Portable;
        let size = [5, 4];
        let pixel = |col: u32, row: u32| [40 * col as u8, 60 * row as u8, 7, 255];
        let photo = Photo {
            pixels: TiledRaster::from_fn(size[0], size[1], pixel),
            origin: DVec2::ZERO,
            spacing: DVec2::ONE,
        };
        let eye = DVec2::new(2.25, 1.75);
        for [east, north] in [[1, 1], [1, -1], [-1, 1], [-1, -1]] {
            let mapped = Mapped {
                tiles: Tiles::new(
                    photo.pixels.view(),
                    photo.pixels.tiles_across(),
                    photo.pixels.tile_stride(),
                ),
                x: Along::new(eye.x, 1.0, east, size[0]),
                y: Along::new(eye.y, 1.0, north, size[1]),
                covers: false,
            };
            for (x, y) in (0..40 * 40).map(|at| (at % 40, at / 40)) {
                // Never half a pixel beside the outer ones, where it depends on rounding.
                let advance = DVec2::new(f64::from(x), f64::from(y)) * 0.13;
                let at = eye + advance * DVec2::new(f64::from(east), f64::from(north));
                let advances = advance.to_array().map(|cells| l.splat(cells as f32));
                let located = mapped.locate(l, l.mask(u16::MAX), advances);
                let seen = photo.colour_at(at.x, at.y);
                let on = l.bits(located.on);
                assert_eq!(on, if seen.is_some() { u16::MAX } else { 0 }, "{at}");
                let Some(seen) = seen else { continue };
                let (tiles, mut places) = (&mapped.tiles, [0; LANES]);
                l.store_i(located.at, &mut places);
                let texels = l.texels(
                    &tiles.items,
                    &places,
                    tiles.stride,
                    located.east,
                    located.north,
                );
                let mut colours = [0; LANES];
                l.store_i(texels, &mut colours);
                for (colour, seen) in colours[0].to_le_bytes().into_iter().zip(seen) {
                    assert!(colour.abs_diff(seen) <= 1, "{colour}, not {seen} at {at}");
                }
            }
        }
    }
}
