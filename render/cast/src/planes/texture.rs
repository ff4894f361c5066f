//! Colours at the resolutions that footprints ask for.

use super::detail::TextureFrame;
use super::frame::Frame;
use super::sectors::Sector;
use crate::lanes::Lanes;

/// A texture along one axis, as one sector's rays run along it.
struct Along {
    sign: i32,
    /// A pixel of the finest level, and how far along the rays' direction the eye lies from there.
    base: i32,
    fraction: f32,
    /// Pixels of the finest level.
    pixels: i32,
}

/// Pixels by which half a footprint may reach behind the eye.
const BEHIND: i32 = 64;

impl Along {
    fn new(eye: f64, sign: i32, pixels: u32) -> Self {
        let base = if sign > 0 { eye.floor() } else { eye.ceil() };
        Self {
            base: base as i32 - sign * BEHIND,
            sign,
            // From a pixel's outer edge, which all levels share.
            fraction: ((eye - base).abs() + 0.5 + f64::from(BEHIND)) as f32,
            pixels: pixels as i32,
        }
    }

    /// For what lies `along` pixels of the finest level from the eye: the pixel of `level` before
    /// it (in the texture's own direction) and the weight of the one behind; and whether it lies
    /// off the texture.
    #[inline(always)]
    fn locate<L: Lanes>(
        &self,
        l: L,
        along: L::F,
        level: L::I,
        inverse_size: L::F,
    ) -> (L::I, L::F, L::M) {
        let (none, one) = (l.splat_i(0), l.splat_i(1));
        let half = l.splat(0.5);
        let along = l.add(along, l.splat(self.fraction));
        let whole = l.to_int(along);
        let share = l.sub(along, l.to_float(whole));
        let base = l.splat_i(self.base);
        let (at, share) = if self.sign > 0 {
            (l.add_i(base, whole), share)
        } else {
            (l.sub_i(base, whole), l.sub(l.splat(1.0), share))
        };
        let off = l.or(l.gt_i(none, at), l.gt_i(at, l.splat_i(self.pixels - 1)));
        // In pixels of the level, from their centres.
        let coarse = l.shr_i(at, level);
        let rest = l.to_float(l.sub_i(at, l.shl_i(coarse, level)));
        let share = l.sub(l.mul(l.add(rest, share), inverse_size), half);
        let before = l.lt(share, l.splat(0.0));
        let coarse = l.add_i_where(before, coarse, l.splat_i(-1));
        let share = l.select(before, l.add(share, l.splat(1.0)), share);
        // At the border the outer pixel's colour goes on.
        let last = l.sub_i(l.shr_i(l.splat_i(self.pixels - 1), level), one);
        let last = l.max_i(last, none);
        let share = l.select(l.gt_i(none, coarse), l.splat(0.0), share);
        let share = l.select(l.gt_i(coarse, last), l.splat(1.0), share);
        (l.max_i(l.min_i(coarse, last), none), share, off)
    }
}

/// A texture as one sector's rays meet it.
pub(super) struct Mipmapped<'a> {
    pub(super) frame: &'a TextureFrame<'a>,
    /// The axis along which rays advance more.
    major: usize,
    x: Along,
    y: Along,
    /// Pixels of the finest level for each cell along major and minor axis.
    pub(super) scale: [f32; 2],
}

/// Where colours lie in a texture.
pub(super) struct Located<L: Lanes> {
    pub(super) at: L::I,
    pub(super) east: L::F,
    pub(super) north: L::F,
    /// Whether the texture reaches there.
    pub(super) on: L::M,
}

impl<'a> Mipmapped<'a> {
    pub(super) fn new(
        texture: &'a TextureFrame<'a>,
        frame: &Frame<'_>,
        sector: &Sector,
        [x_sign, y_sign]: [i32; 2],
    ) -> Self {
        let eye = [0, 1].map(|axis| {
            let eye = [frame.eye.x, frame.eye.y][axis];
            (eye - texture.origin[axis]) / texture.spacing[axis]
        });
        let [x, y] = texture.spacing.map(|spacing| (1.0 / spacing) as f32);
        Self {
            frame: texture,
            major: sector.major,
            x: Along::new(eye[0], x_sign, texture.size[0]),
            y: Along::new(eye[1], y_sign, texture.size[1]),
            scale: if sector.major == 0 { [x, y] } else { [y, x] },
        }
    }

    /// Where the colours of `level` lie at places so many finest pixels from the eye along major
    /// and minor axis.
    #[inline(always)]
    pub(super) fn locate<L: Lanes>(
        &self,
        l: L,
        mask: L::M,
        [major, minor]: [L::F; 2],
        level: L::I,
    ) -> Located<L> {
        let [x, y] = if self.major == 0 {
            [major, minor]
        } else {
            [minor, major]
        };
        let exponent = l.sub_i(l.splat_i(127), level);
        let inverse_size = l.float_of_bits(l.shl_i(exponent, l.splat_i(23)));
        let (x, east, off_x) = self.x.locate(l, x, level, inverse_size);
        let (y, north, off_y) = self.y.locate(l, y, level, inverse_size);
        let tiles = &self.frame.tiles;
        let first_tile = l.look_up(&self.frame.first_tiles, level);
        let across = l.look_up(&self.frame.tiles_across, level);
        let place = tiles.place_in(l, first_tile, across, x, y);
        Located {
            at: tiles.only(l, mask, place),
            east,
            north,
            on: l.and_not(mask, l.or(off_x, off_y)),
        }
    }
}
