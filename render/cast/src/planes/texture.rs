//! Colours at the resolutions that footprints ask for.

use super::detail::TextureFrame;
use super::frame::Frame;
use super::sectors::Sector;
use crate::lanes::Lanes;

/// A texture along one axis, as one sector's rays run along it: in fixed point, from the outer edge
/// of the first pixel, which all levels share.
struct Along {
    sign: i32,
    /// Where the eye is.
    eye: i32,
    /// Pixels of the finest level.
    pixels: i32,
}

impl Along {
    /// Where lies what is `along` from the eye, both in fixed point of the finest level.
    #[inline(always)]
    fn place<L: Lanes>(&self, l: L, along: L::I) -> L::I {
        let eye = l.splat_i(self.eye);
        if self.sign > 0 {
            l.add_i(eye, along)
        } else {
            l.sub_i(eye, along)
        }
    }

    /// Where that lies in `level`, from the first pixel's centre. At the border the outer pixel's colour
    /// goes on: all but a hair of it.
    #[inline(always)]
    fn coarser<L: Lanes>(&self, l: L, place: L::I, level: L::I, bits: L::I) -> L::I {
        let (none, one) = (l.splat_i(0), l.splat_i(1));
        let half = l.shr_i(l.shl_i(one, bits), one);
        let last = l.shl_i(l.shr_i(l.splat_i(self.pixels - 1), level), bits);
        let place = l.sub_i(l.shr_i(place, level), half);
        l.max_i(l.min_i(place, l.sub_i(last, one)), none)
    }

    /// As `coarser`, in the finest level.
    #[inline(always)]
    fn finest<L: Lanes>(&self, l: L, place: L::I, bits: i32) -> L::I {
        let last = l.splat_i(((self.pixels - 1) << bits) - 1);
        let place = l.sub_i(place, l.splat_i(1 << bits >> 1));
        l.max_i(l.min_i(place, last), l.splat_i(0))
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
    /// Bits of fractions, and how many parts a pixel has in fixed point.
    bits: i32,
    parts: f32,
}

/// Where colours lie in a texture.
pub(super) struct Located<L: Lanes> {
    pub(super) at: L::I,
    /// The weights of eastern and northern texels, in 15-bit fixed point.
    pub(super) east: L::I,
    pub(super) north: L::I,
}

/// The two halves of a footprint: from its middle, how far aside they lie in pixels of the finest
/// level along major and minor axis (one half there, and one as far the other way), and the levels
/// that suit them.
pub(super) struct Halves<L: Lanes> {
    pub(super) aside: [L::F; 2],
    pub(super) levels: [L::I; 2],
}

impl<'a> Mipmapped<'a> {
    pub(super) fn new(
        texture: &'a TextureFrame<'a>,
        frame: &Frame<'_>,
        sector: &Sector,
        signs: [i32; 2],
    ) -> Self {
        // As many as leave room for the longer side, and no more than weights of colours have.
        let side = texture.size[0].max(texture.size[1]).next_power_of_two();
        let bits = 15.min(29 - side.trailing_zeros() as i32);
        let parts = f64::from(1 << bits);
        let along = |axis: usize| {
            let eye = [frame.eye.x, frame.eye.y][axis];
            let eye = (eye - texture.origin[axis]) / texture.spacing[axis] + 0.5;
            Along {
                sign: signs[axis],
                eye: (eye * parts).round() as i32,
                pixels: texture.size[axis] as i32,
            }
        };
        let [x, y] = texture.spacing.map(|spacing| (1.0 / spacing) as f32);
        Self {
            frame: texture,
            major: sector.major,
            x: along(0),
            y: along(1),
            scale: if sector.major == 0 { [x, y] } else { [y, x] },
            bits,
            parts: parts as f32,
        }
    }

    /// Where hits are: how many finest pixels from the eye along major and minor axis.
    #[inline(always)]
    pub(super) fn pixels_to<L: Lanes>(&self, l: L, reached: L::F, advance: L::F) -> [L::F; 2] {
        let [major, minor] = self.scale;
        [
            l.mul(reached, l.splat(major)),
            l.mul(l.mul(reached, advance), l.splat(minor)),
        ]
    }

    /// Where the colours of the halves of footprints lie of which the middles are `middle` finest
    /// pixels from the eye along major and minor axis; and which of them the texture has.
    #[inline(always)]
    pub(super) fn locate<L: Lanes>(
        &self,
        l: L,
        mask: L::M,
        middle: [L::F; 2],
        halves: &Halves<L>,
    ) -> ([Located<L>; 2], L::M) {
        let parts = l.splat(self.parts);
        let ([x, y], on) = self.place(l, mask, middle);
        let major = l.to_int(l.mul(halves.aside[0], parts));
        let minor = l.to_int(l.mul(halves.aside[1], parts));
        let (aside_x, aside_y) = if self.major == 0 {
            (major, minor)
        } else {
            (minor, major)
        };
        // Rays run the other way where the sign is less than 0, which for halves on both sides
        // matters only between the axes.
        let aside_y = if self.x.sign == self.y.sign {
            aside_y
        } else {
            l.sub_i(l.splat_i(0), aside_y)
        };
        let before = [l.sub_i(x, aside_x), l.sub_i(y, aside_y)];
        let behind = [l.add_i(x, aside_x), l.add_i(y, aside_y)];
        let before = self.texels(l, mask, halves.levels[0], before);
        let behind = self.texels(l, mask, halves.levels[1], behind);
        ([before, behind], on)
    }

    /// As `locate`, of footprints so small that both halves have the place and the level of their middle:
    /// the finest.
    #[inline(always)]
    pub(super) fn locate_small<L: Lanes>(
        &self,
        l: L,
        mask: L::M,
        middle: [L::F; 2],
    ) -> (Located<L>, L::M) {
        let ([x, y], on) = self.place(l, mask, middle);
        let x = self.x.finest(l, x, self.bits);
        let y = self.y.finest(l, y, self.bits);
        let bits = l.splat_i(self.bits);
        let tiles = &self.frame.tiles;
        let place = tiles.place(l, l.shr_i(x, bits), l.shr_i(y, bits));
        (self.located(l, mask, [x, y], place), on)
    }

    /// In fixed point, where places lie that are so many finest pixels from the eye along major and minor
    /// axis; and which of them the texture has.
    #[inline(always)]
    fn place<L: Lanes>(&self, l: L, mask: L::M, from_eye: [L::F; 2]) -> ([L::I; 2], L::M) {
        let bits = l.splat_i(self.bits);
        let parts = l.splat(self.parts);
        let major = l.to_int(l.mul(from_eye[0], parts));
        let minor = l.to_int(l.mul(from_eye[1], parts));
        let (x, y) = if self.major == 0 {
            (major, minor)
        } else {
            (minor, major)
        };
        let (x, y) = (self.x.place(l, x), self.y.place(l, y));
        let mut on = mask;
        if !self.frame.covers {
            let none = l.splat_i(0);
            let off_x = l.or(
                l.gt_i(none, x),
                l.gt_i(l.shr_i(x, bits), l.splat_i(self.x.pixels - 1)),
            );
            let off_y = l.or(
                l.gt_i(none, y),
                l.gt_i(l.shr_i(y, bits), l.splat_i(self.y.pixels - 1)),
            );
            on = l.and_not(mask, l.or(off_x, off_y));
        }
        ([x, y], on)
    }

    /// The texels around a place in fixed point, in a level, and their weights.
    #[inline(always)]
    fn texels<L: Lanes>(&self, l: L, mask: L::M, level: L::I, [x, y]: [L::I; 2]) -> Located<L> {
        let bits = l.splat_i(self.bits);
        let x = self.x.coarser(l, x, level, bits);
        let y = self.y.coarser(l, y, level, bits);
        let first_tile = l.pick(l.load_i(&self.frame.first_tiles), level);
        let across = l.pick(l.load_i(&self.frame.tiles_across), level);
        let (col, row) = (l.shr_i(x, bits), l.shr_i(y, bits));
        let place = self.frame.tiles.place_in(l, first_tile, across, col, row);
        self.located(l, mask, [x, y], place)
    }

    /// The texels at `place`, with the weights of a place in fixed point of their level.
    #[inline(always)]
    fn located<L: Lanes>(&self, l: L, mask: L::M, [x, y]: [L::I; 2], place: L::I) -> Located<L> {
        let fraction = l.splat_i((1 << self.bits) - 1);
        let more_bits = l.splat_i(15 - self.bits);
        Located {
            at: self.frame.tiles.only(l, mask, place),
            east: l.shl_i(l.and_i(x, fraction), more_bits),
            north: l.shl_i(l.and_i(y, fraction), more_bits),
        }
    }
}
