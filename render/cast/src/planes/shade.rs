//! Colours and depths of a step's hits.

use super::field::Field;
use super::frame::Frame;
use super::rows::Directions;
use super::sectors::Sector;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes};
use crate::shade::sky;
use glam::DVec3;
use sandtable_terrain::Photo;

/// A photograph along one axis, as one sector's rays run along it.
struct Along {
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
    fn new(eye: f64, per_cell: f64, sign: i32, pixels: u32) -> Self {
        let base = if sign > 0 { eye.floor() } else { eye.ceil() };
        Self {
            sign,
            base: base as i32,
            fraction: (eye - base).abs() as f32,
            pixels: per_cell as f32,
            last: pixels as i32 - 2,
        }
    }

    /// The pixel before the place to which rays advanced, the weight of the one behind it, and
    /// whether the photo has both.
    #[inline(always)]
    fn locate<L: Lanes>(&self, l: L, advance: L::F) -> (L::I, L::F, L::M) {
        let along = l.add(
            l.mul(advance, l.splat(self.pixels)),
            l.splat(self.fraction),
        );
        let whole = l.to_int(along);
        let share = l.sub(along, l.to_float(whole));
        let (at, share) = if self.sign > 0 {
            (l.add_i(l.splat_i(self.base), whole), share)
        } else {
            (
                l.sub_i(l.splat_i(self.base - 1), whole),
                l.sub(l.splat(1.0), share),
            )
        };
        let off = l.or(
            l.gt_i(l.splat_i(0), at),
            l.gt_i(at, l.splat_i(self.last)),
        );
        (at, share, off)
    }

    /// The same for places beyond the outer pixels' centres, where their colours go on for half a
    /// pixel; and where there is none any more.
    #[inline(always)]
    fn at_border<L: Lanes>(&self, l: L, at: L::I, share: L::F) -> (L::I, L::F, L::M) {
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
struct Mapped<'a> {
    tiles: Vec<&'a [[u8; 4]]>,
    across: i32,
    stride: u32,
    x: Along,
    y: Along,
}

impl<'a> Mapped<'a> {
    fn new(photo: &'a Photo, frame: &Frame<'_>, signs: [i32; 2]) -> Self {
        let raster = &photo.pixels;
        let spacing = frame.ground.grid().spacing;
        let eye = (frame.view.eye.truncate() - photo.origin) / photo.spacing;
        let per_cell = spacing / photo.spacing;
        Self {
            tiles: raster
                .tile_indices()
                .map(|tile| raster.tile_posts(tile))
                .collect(),
            across: raster.tiles_across() as i32,
            stride: raster.tile_stride() as u32,
            x: Along::new(eye.x, per_cell.x, signs[0], raster.cols()),
            y: Along::new(eye.y, per_cell.y, signs[1], raster.rows()),
        }
    }

    /// The colours under rays that advanced by `x` and `y` cells, and the lanes for which the
    /// photo has one.
    #[inline(always)]
    fn colours<L: Lanes>(&self, l: L, mask: L::M, advances: [L::F; 2]) -> (L::I, L::M) {
        let (mut x, mut east, off_x) = self.x.locate(l, advances[0]);
        let (mut y, mut north, off_y) = self.y.locate(l, advances[1]);
        let mut covered = mask;
        if l.bits(l.and(mask, l.or(off_x, off_y))) != 0 {
            let (off_x, off_y);
            (x, east, off_x) = self.x.at_border(l, x, east);
            (y, north, off_y) = self.y.at_border(l, y, north);
            covered = l.and_not(mask, l.or(off_x, off_y));
        }
        let shift = l.splat_i(8);
        let within = l.splat_i(255);
        let numbers = l.add_i(
            l.mul_i(l.shr_i(y, shift), l.splat_i(self.across)),
            l.shr_i(x, shift),
        );
        let at = l.add_i(
            l.mul_i(l.and_i(y, within), l.splat_i(self.stride as i32)),
            l.and_i(x, within),
        );
        let tiles = Field::sources(l, &self.tiles, numbers, mask);
        let texels = l.texels(&tiles, at, self.stride, east, north);
        let whole = l.eq_i(l.shr_i(texels, l.splat_i(24)), l.splat_i(-1));
        (texels, l.and(covered, whole))
    }
}

/// A group of pixels of a step.
pub(super) struct Pixels<'a> {
    pub(super) step: u32,
    /// The first lane's place in the step, and which lanes are pixels.
    pub(super) first: i32,
    pub(super) bits: u16,
    pub(super) directions: &'a Directions,
}

/// Turns what rays reached into pixels.
pub(super) struct Shader<'a> {
    frame: &'a Frame<'a>,
    sector: &'a Sector,
    photo: Option<Mapped<'a>>,
    /// Metres a cell along the major and the minor axis.
    metres: [f64; 2],
}

impl<'a> Shader<'a> {
    pub(super) fn new(frame: &'a Frame<'a>, sector: &'a Sector, field: &Field<'_>) -> Self {
        let [x, y] = field.x_y().map(|axis| axis.sign);
        let spacing = frame.ground.grid().spacing;
        let metres = if sector.major == 0 {
            [spacing.x, spacing.y]
        } else {
            [spacing.y, spacing.x]
        };
        Self {
            frame,
            sector,
            photo: frame
                .ground
                .photo()
                .map(|photo| Mapped::new(photo, frame, [x, y])),
            metres,
        }
    }

    /// The colours of lanes that see no photo: the sky's, or the ground's own.
    #[cold]
    #[inline(never)]
    fn colour_rest(
        &self,
        pixels: &Pixels<'_>,
        mut rest: u16,
        reached: &[f32; LANES],
        colours: &mut [i32; LANES],
    ) {
        let first = self.world(pixels.directions.at(pixels.step, pixels.first));
        let lane = self.world(pixels.directions.lane);
        while rest != 0 {
            let k = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let direction = first + k as f64 * lane;
            let [r, g, b] = if reached[k] >= 0.0 {
                let along = if self.sector.major == 0 {
                    direction.x / self.metres[0]
                } else {
                    direction.y / self.metres[0]
                };
                let t = f64::from(reached[k]) / along.abs().max(1e-6);
                let point = self.frame.view.eye + t * direction;
                self.frame.ground.colour_at(point.x, point.y)
            } else {
                sky(direction)
            };
            colours[k] = i32::from_ne_bytes([r, g, b, 255]);
        }
    }

    /// A direction of the sector in world metres.
    fn world(&self, v: DVec3) -> DVec3 {
        let major = v.x * f64::from(self.sector.signs[0]) * self.metres[0];
        let minor = v.y * f64::from(self.sector.signs[1]) * self.metres[1];
        if self.sector.major == 0 {
            DVec3::new(major, minor, v.z)
        } else {
            DVec3::new(minor, major, v.z)
        }
    }

    /// Sets a group's pixels, whose rays `reached` so far: to a hit, or (negative) to nothing.
    #[inline(always)]
    pub(super) fn shade<L: Lanes>(
        &self,
        l: L,
        canvas: &Canvas<'_>,
        pixels: &Pixels<'_>,
        reached: L::F,
        advance: L::F,
        slope: L::F,
    ) {
        let &Pixels {
            step,
            first,
            bits,
            ..
        } = pixels;
        let hit = l.and(l.mask(bits), l.le(l.splat(0.0), reached));
        let [major_metres, minor_metres] = self.metres;
        let minor_length = l.mul(advance, l.splat(minor_metres as f32));
        let length = l.sqrt(l.add(
            l.add(
                l.mul(minor_length, minor_length),
                l.splat((major_metres * major_metres) as f32),
            ),
            l.mul(slope, slope),
        ));
        let depth = l.select(hit, l.mul(reached, length), l.splat(f32::INFINITY));
        let minor_advance = l.mul(reached, advance);
        let advances = if self.sector.major == 0 {
            [reached, minor_advance]
        } else {
            [minor_advance, reached]
        };
        let mut colours = [0; LANES];
        let mut rest = bits;
        if let Some(photo) = &self.photo
            && l.bits(hit) != 0
        {
            let (texels, covered) = photo.colours(l, hit, advances);
            l.store_i(texels, &mut colours);
            rest &= !l.bits(covered);
        }
        let mut depths = [0.0; LANES];
        l.store(depth, &mut depths);
        if rest != 0 {
            let mut ts = [0.0; LANES];
            l.store(reached, &mut ts);
            self.colour_rest(pixels, rest, &ts, &mut colours);
        }
        let along_step = (self.sector.first_step + self.sector.direction * step as i32) as u32;
        let count = bits.count_ones() as usize;
        if self.sector.step_axis == 1 {
            let pixel = [first as u32, along_step];
            // SAFETY: each pixel belongs to one sector, and a sector to one thread.
            #[allow(unsafe_code, reason = "as `Canvas::set_row` says")]
            unsafe {
                if count == LANES {
                    canvas.set_row(pixel, &colours, &depths);
                } else {
                    canvas.set_row(pixel, &colours[..count], &depths[..count]);
                }
            }
        } else {
            canvas.set_column([along_step, first as u32], &colours[..count], &depths[..count]);
        }
    }
}
