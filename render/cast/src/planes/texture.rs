//! Colours at the resolutions that footprints ask for.

use super::detail::TextureFrame;
use super::frame::Frame;
use super::sectors::Sector;
use crate::lanes::Lanes;

/// How long textures are at most, in fixed point: a quarter of what there is room for.
const ROOM: f64 = (1 << 29) as f64;

/// A texture along one axis, as one sector's rays run along it: in fixed point, from the outer edge
/// of the first pixel, which all levels share.
struct Along {
    sign: i32,
    /// From where on rays' ways are counted, as far as it is from the eye: the eye, unless numbers have no
    /// room for the way from there to the texture.
    begin: f32,
    /// Where that is.
    from: i32,
    /// The least and the most that is counted: so far outside of the texture that it does not matter how far.
    ends: [f32; 2],
    /// Pixels of the finest level.
    pixels: i32,
}

impl Along {
    /// Of an eye at `eye`, in fixed point of so many `parts` a pixel; and whether there is no room for all ways
    /// to the ground, which are up to `farthest` long.
    fn new(eye: f64, parts: f64, pixels: u32, sign: i32, farthest: f64) -> (Self, bool) {
        let eye = (eye * parts).round();
        let nearest = if sign > 0 {
            -eye
        } else {
            eye - f64::from(pixels) * parts
        };
        // Whole, and ways to the texture are as coarse where they are as long: what is left of them has all of
        // their digits.
        let is_far = nearest.abs() > ROOM;
        let begin = if is_far { nearest as f32 } else { 0.0 };
        let from = eye + f64::from(sign) * f64::from(begin);
        let [before, behind] = [-ROOM - from, 2.0 * ROOM - from];
        let along = Self {
            sign,
            begin,
            from: from as i32,
            ends: if sign > 0 {
                [before as f32, behind as f32]
            } else {
                [-behind as f32, -before as f32]
            },
            pixels: pixels as i32,
        };
        (along, is_far || farthest * parts > ROOM)
    }

    /// Ways from the eye as they are counted where there is no room for all of them.
    #[inline(always)]
    fn counted<L: Lanes>(&self, l: L, along: L::F) -> L::F {
        let along = l.sub(along, l.splat(self.begin));
        l.max(l.min(along, l.splat(self.ends[1])), l.splat(self.ends[0]))
    }

    /// Where lies what is so far `along`, both in fixed point of the finest level.
    #[inline(always)]
    fn place<L: Lanes>(&self, l: L, along: L::I) -> L::I {
        let from = l.splat_i(self.from);
        if self.sign > 0 {
            l.add_i(from, along)
        } else {
            l.sub_i(from, along)
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

/// What lies farther aside than textures are long, only so far.
#[inline(always)]
fn within_room<L: Lanes>(l: L, aside: L::F) -> L::F {
    l.max(l.min(aside, l.splat(ROOM as f32)), l.splat(-ROOM as f32))
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
    /// Whether the eye or the ground's far end may be so far away that there is no room for it.
    is_far: bool,
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
            let (eye, spacing) = ([frame.eye.x, frame.eye.y][axis], texture.spacing[axis]);
            let cells = f64::from(frame.levels[0].cells[axis]);
            let farthest = eye.abs().max((cells - eye).abs());
            let eye = (eye - texture.origin[axis]) / spacing + 0.5;
            let pixels = texture.size[axis];
            Along::new(eye, parts, pixels, signs[axis], farthest / spacing)
        };
        let [(x, x_is_far), (y, y_is_far)] = [0, 1].map(along);
        let scale = texture.spacing.map(|spacing| (1.0 / spacing) as f32);
        Self {
            frame: texture,
            major: sector.major,
            x,
            y,
            scale: [scale[sector.major], scale[1 - sector.major]],
            bits,
            parts: parts as f32,
            is_far: x_is_far || y_is_far,
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
        let [mut major, mut minor] = [l.mul(halves.aside[0], parts), l.mul(halves.aside[1], parts)];
        if self.is_far {
            (major, minor) = (within_room(l, major), within_room(l, minor));
        }
        let (major, minor) = (l.to_int(major), l.to_int(minor));
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
        let (major, minor) = (l.mul(from_eye[0], parts), l.mul(from_eye[1], parts));
        let (mut x, mut y) = if self.major == 0 {
            (major, minor)
        } else {
            (minor, major)
        };
        if self.is_far {
            (x, y) = (self.x.counted(l, x), self.y.counted(l, y));
        }
        let x = self.x.place(l, l.to_int(x));
        let y = self.y.place(l, l.to_int(y));
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
