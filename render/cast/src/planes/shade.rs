//! Colours and depths of a step's hits.

use super::field::{Field, Tiles};
use super::footprint::{Around, Filters, filters};
use super::frame::Frame;
use super::rows::Directions;
use super::sectors::Sector;
use super::texture::{Halves, Mipmapped};
use super::wave::{CAPACITY, Column, first_lanes};
use crate::lanes::{LANES, Lanes, Texels, group, group_mut};
use crate::shade::{DEPTHS, HAZE, HORIZON, ZENITH};
use sandtable_terrain::{Ground, Photo, hypsometric_tints};
use std::sync::LazyLock;

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
        let along = l.add(l.mul(advance, l.splat(self.pixels)), l.splat(self.fraction));
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
        let off = l.or(l.gt_i(l.splat_i(0), at), l.gt_i(at, l.splat_i(self.last)));
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
    tiles: Tiles<'a, [u8; 4]>,
    x: Along,
    y: Along,
    /// Whether it covers all ground: then no hit is off it, but for rounding.
    covers: bool,
}

impl<'a> Mapped<'a> {
    fn new(photo: &'a Photo, frame: &Frame<'_>, signs: [i32; 2]) -> Self {
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
    fn locate<L: Lanes>(&self, l: L, mask: L::M, advances: [L::F; 2]) -> Located<L> {
        let (mut x, mut east, off_x) = self.x.locate(l, advances[0]);
        let (mut y, mut north, off_y) = self.y.locate(l, advances[1]);
        let mut on = mask;
        if l.bits(l.and(mask, l.or(off_x, off_y))) != 0 {
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
struct Located<L: Lanes> {
    at: L::I,
    east: L::F,
    north: L::F,
    on: L::M,
}

/// What colouring one chunk of a step needs between its loops.
#[repr(align(64))]
pub(super) struct Shading {
    at: Column<i32>,
    east: Column<f32>,
    north: Column<f32>,
    /// The sine of the angle over the horizon of those that see the sky.
    up: Column<f32>,
    /// For each group: its pixels that the photo may cover; its other pixels; and its pixels that
    /// see the sky.
    on: [u16; CAPACITY / LANES],
    rest: [u16; CAPACITY / LANES],
    sky: [u16; CAPACITY / LANES],
    /// Where detail is chosen: the pixels' filters, and where the halves of their footprints lie.
    filters: Filters,
    halves: [Half; 2],
}

/// Where colours lie in a texture, and the weights of eastern and northern texels in fixed point.
#[repr(align(64))]
struct Half {
    at: Column<i32>,
    east: Column<i32>,
    north: Column<i32>,
}

impl Default for Half {
    fn default() -> Self {
        Self {
            at: [0; CAPACITY],
            east: [0; CAPACITY],
            north: [0; CAPACITY],
        }
    }
}

impl Half {
    #[inline(always)]
    fn texels<L: Lanes>(&self, l: L, at: usize) -> Texels<'_, L> {
        Texels {
            at: group(&self.at, at),
            east: l.load_i(group(&self.east, at)),
            north: l.load_i(group(&self.north, at)),
        }
    }
}

impl Shading {
    /// For each group of the first `count` lanes, its pixels that see the sky.
    pub(super) fn sky(&self, count: usize) -> &[u16] {
        &self.sky[..count.div_ceil(LANES)]
    }
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            at: [0; CAPACITY],
            east: [0.0; CAPACITY],
            north: [0.0; CAPACITY],
            up: [0.0; CAPACITY],
            on: [0; CAPACITY / LANES],
            rest: [0; CAPACITY / LANES],
            sky: [0; CAPACITY / LANES],
            filters: Filters::default(),
            halves: Default::default(),
        }
    }
}

/// A part of a step whose rays have come to their ends, a number a lane in each slice (and room
/// for a whole last group).
pub(super) struct Chunk<'a> {
    pub(super) step: u32,
    /// The first lane, and how many there are.
    pub(super) first: i32,
    pub(super) count: usize,
    pub(super) directions: &'a Directions,
    /// How far rays came: to hits, or (negative) to nothing.
    pub(super) reached: &'a [f32],
    pub(super) advance: &'a [f32],
    pub(super) slope: &'a [f32],
    /// The step before, its own, and the one behind.
    pub(super) around: [Around<'a>; 3],
}

impl Chunk<'_> {
    /// Which lanes of the group that begins at lane `at` there are.
    fn mask(&self, at: usize) -> u16 {
        first_lanes((self.count - at) as i32)
    }
}

/// The ground's own colours, where there is no photo.
struct Tints<'a> {
    light: Tiles<'a, u8>,
    low: f32,
    /// Tints for each metre.
    steps: f32,
    /// Red, green and blue of each tint, as bits of floats.
    channels: &'static [[u32; 512]; 3],
}

impl<'a> Tints<'a> {
    fn new(ground: &'a Ground) -> Option<Self> {
        let light = ground.light()?;
        static CHANNELS: LazyLock<[[u32; 512]; 3]> =
            LazyLock::new(|| [0, 1, 2].map(|k| hypsometric_tints().map(|tint| tint[k].to_bits())));
        let [low, high] = ground.range();
        let steps = (hypsometric_tints().len() - 1) as f32;
        Some(Self {
            light: Tiles::new(light.view(), light.tiles_across(), light.tile_stride()),
            low,
            steps: if high > low {
                steps / (high - low)
            } else {
                0.0
            },
            channels: &CHANNELS,
        })
    }
}

/// Turns what rays reached into pixels.
pub(super) struct Shader<'a> {
    sector: &'a Sector,
    photo: Option<Mapped<'a>>,
    /// Metres a cell along the major and the minor axis.
    metres: [f64; 2],
    field: &'a Field<'a>,
    /// None where a photo covers all ground.
    tints: Option<Tints<'a>>,
    /// Where detail is chosen: the photo, and tints.
    textures: [Option<Mipmapped<'a>>; 2],
    blur: f32,
    /// Whether the ground is too large for the processor's nearer caches.
    large: bool,
}

/// How many cells ahead of a hit memory is asked for.
const AHEAD: f32 = 20.0;

/// Rows of posts from a step to the next from which on too many would be asked for in vain.
const MOST_ROWS: f64 = 4.0;

impl<'a> Shader<'a> {
    pub(super) fn new(frame: &'a Frame<'a>, sector: &'a Sector, field: &'a Field<'a>) -> Self {
        let [x, y] = field.x_y().map(|axis| axis.sign);
        let spacing = frame.ground.grid().spacing;
        let metres = if sector.major == 0 {
            [spacing.x, spacing.y]
        } else {
            [spacing.y, spacing.x]
        };
        let textures = match &frame.detail {
            Some(detail) => [&detail.photo, &detail.tints].map(|texture| {
                texture
                    .as_ref()
                    .map(|texture| Mipmapped::new(texture, frame, sector, [x, y]))
            }),
            None => [None, None],
        };
        Self {
            sector,
            photo: frame
                .ground
                .photo()
                .filter(|_| frame.detail.is_none())
                .map(|photo| Mapped::new(photo, frame, [x, y])),
            metres,
            field,
            tints: Tints::new(frame.ground),
            textures,
            blur: frame.detail.as_ref().map_or(1.0, |detail| detail.blur),
            large: frame.levels[0].is_large(),
        }
    }

    /// Asks for the ground that the next step's rays will meet behind a group's hits: as many rows
    /// of posts as they will pass.
    #[inline(always)]
    fn prefetch<L: Lanes>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        at: usize,
        hit: L::M,
        reached: L::F,
        advance: L::F,
    ) {
        let from = chunk.directions.at(chunk.step, chunk.first + at as i32);
        let to = from + chunk.directions.step;
        let rise = (to.z / to.x - from.z / from.x) / (from.z / from.x).abs();
        let rows = f64::from(chunk.reached[at].abs()) * rise;
        if rows > MOST_ROWS {
            return;
        }
        let rows = rows.max(1.0) as u32;
        let none = l.splat(0.0);
        let mut places = [0; LANES];
        for row in 0..rows {
            let t = l.add(reached, l.splat(AHEAD + row as f32));
            let t = l.select(hit, t, none);
            let place = self.field.place(l, self.field.cell_at(l, t, advance));
            l.store_i(place, &mut places);
            l.prefetch::<_, 2>(&self.field.heights.items, &places, 0);
            if let Some(photo) = &self.photo {
                let aside = l.mul(t, advance);
                let advances = if self.sector.major == 0 {
                    [t, aside]
                } else {
                    [aside, t]
                };
                let (x, _, _) = photo.x.locate(l, advances[0]);
                let (y, _, _) = photo.y.locate(l, advances[1]);
                l.store_i(photo.tiles.place(l, x, y), &mut places);
                l.prefetch::<_, 2>(&photo.tiles.items, &places, 0);
            }
        }
    }

    /// The ground's own colours where rays reached it: hypsometric tints in shaded relief, as
    /// [`Ground::colour_at`](sandtable_terrain::Ground::colour_at) has them without a photo.
    #[inline(always)]
    fn tints<L: Lanes>(
        &self,
        l: L,
        mask: L::M,
        tints: &Tints<'_>,
        reached: L::F,
        advance: L::F,
    ) -> L::I {
        let field = self.field;
        // How far into its cell each place lies, eastwards and northwards.
        let cell = field.cell_at(l, reached, advance);
        let aside = l.mul(reached, advance);
        let major = field.major.inside(l, reached, cell[0]);
        let minor = field.minor.inside(l, aside, cell[1]);
        let [east, north] = if field.major_axis == 0 {
            [major, minor]
        } else {
            [minor, major]
        };
        let [x, y] = field.cells(l, cell[0], cell[1]);
        let place = tints.light.only(l, mask, tints.light.place(l, x, y));
        let light = l.byte_cells(&tints.light.items, place, tints.light.stride);
        let light = bilinear(l, light, east, north);
        // The ground's height, not the hit's: a wall has the colours of the columns behind it.
        let place = field.heights.only(l, mask, field.heights.place(l, x, y));
        let mut places = [0; LANES];
        l.store_i(place, &mut places);
        let height = l.cells(&field.heights.items, &places, field.heights.stride);
        let height = bilinear(l, height, east, north);
        let share = l.mul(l.sub(height, l.splat(tints.low)), l.splat(tints.steps));
        let step = l.to_int(l.max(l.add(share, l.splat(0.5)), l.splat(0.0)));
        let gain = l.mul(light, l.splat(2.0 / 256.0));
        let mut colour = l.splat_i(255 << 24);
        for (k, channel) in tints.channels.iter().enumerate() {
            let tint = l.float_of_bits(l.look_up(channel, step));
            let byte = l.to_int(l.min(l.mul(tint, gain), l.splat(255.0)));
            colour = l.add_i(colour, l.shl_i(byte, l.splat_i(8 * k as i32)));
        }
        colour
    }

    /// Writes the colours and depths of a chunk's pixels, a number a lane (and room for a whole
    /// last group). Gives whether some see the sky.
    ///
    /// Three loops, as [`walk`](super::walk::walk) has.
    #[inline(always)]
    pub(super) fn shade<L: Lanes>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        shading: &mut Shading,
        colours: &mut [i32],
        depths: &mut [f32],
    ) -> bool {
        let sees_sky = l.vectorize(
            #[inline(always)]
            || self.locate(l, chunk, shading, depths),
        );
        if let Some(photo) = &self.photo {
            l.vectorize(
                #[inline(always)]
                || {
                    for at in (0..chunk.count).step_by(LANES) {
                        let number = at / LANES;
                        if shading.on[number] == 0 {
                            continue;
                        }
                        let texels = l.texels(
                            &photo.tiles.items,
                            group(&shading.at, at),
                            photo.tiles.stride,
                            l.load(group(&shading.east, at)),
                            l.load(group(&shading.north, at)),
                        );
                        l.store_i(texels, group_mut(colours, at));
                        let whole = l.eq_i(l.shr_i(texels, l.splat_i(24)), l.splat_i(-1));
                        shading.rest[number] |= shading.on[number] & !l.bits(whole);
                    }
                },
            );
        }
        for texture in self.textures.iter().flatten() {
            self.filter(l, chunk, texture, shading, colours);
        }
        if let Some(ground_tints) = &self.tints {
            for at in (0..chunk.count).step_by(LANES) {
                let rest = shading.rest[at / LANES];
                if rest == 0 {
                    continue;
                }
                l.vectorize(
                    #[inline(always)]
                    || {
                        let tints = self.tints(
                            l,
                            l.mask(rest),
                            ground_tints,
                            l.load(group(chunk.reached, at)),
                            l.load(group(chunk.advance, at)),
                        );
                        let colours = group_mut(colours, at);
                        let others = l.load_i(colours);
                        l.store_i(l.select_i(l.mask(rest), tints, others), colours);
                    },
                );
            }
        }
        if sees_sky {
            let lanes = [chunk.first, chunk.first + chunk.count as i32];
            l.vectorize(
                #[inline(always)]
                || self.skies(l, chunk.directions, chunk.step, lanes, shading, colours),
            );
        }
        sees_sky
    }

    /// Writes the colours and depths of lanes of a step that see nothing but the sky.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "which pixels, and where they go")]
    pub(super) fn shade_sky<L: Lanes>(
        &self,
        l: L,
        directions: &Directions,
        step: u32,
        [first, behind]: [i32; 2],
        shading: &mut Shading,
        colours: &mut [i32],
        depths: &mut [f32],
    ) {
        let count = (behind - first) as usize;
        depths[..count].fill(f32::INFINITY);
        shading.sky[..count.div_ceil(LANES)].fill(u16::MAX);
        l.vectorize(
            #[inline(always)]
            || self.skies(l, directions, step, [first, behind], shading, colours),
        );
    }

    /// Colours those of a step's lanes that see the sky.
    ///
    /// Two loops: all of it is one chain, of which hardly two fit a processor's window.
    #[inline(always)]
    fn skies<L: Lanes>(
        &self,
        l: L,
        directions: &Directions,
        step: u32,
        [first, behind]: [i32; 2],
        shading: &mut Shading,
        colours: &mut [i32],
    ) {
        let groups = || (0..(behind - first) as usize).step_by(LANES);
        let numbers = l.load(&std::array::from_fn(|k| k as f32));
        let first = directions.at(step, first).as_vec3();
        let lane = directions.lane.as_vec3();
        let major = l.add(l.splat(first.x), l.mul(l.splat(lane.x), numbers));
        let minor = l.add(l.splat(first.y), l.mul(l.splat(lane.y), numbers));
        let height = l.add(l.splat(first.z), l.mul(l.splat(lane.z), numbers));
        for at in groups() {
            if shading.sky[at / LANES] != 0 {
                let further = lane * at as f32;
                let height = l.add(height, l.splat(further.z));
                let direction = [
                    l.add(major, l.splat(further.x)),
                    l.add(minor, l.splat(further.y)),
                    height,
                ];
                let up = l.div(height, self.metres_of(l, direction));
                l.store(up, group_mut(&mut shading.up, at));
            }
        }
        for at in groups() {
            let sky = shading.sky[at / LANES];
            if sky != 0 {
                let up = l.load(group(&shading.up, at));
                let colours = group_mut(colours, at);
                let ground = l.load_i(colours);
                l.store_i(l.select_i(l.mask(sky), sky_colours(l, up), ground), colours);
            }
        }
    }

    /// Colours the pixels of `shading.rest` from a texture, each by the filter of its footprint,
    /// and leaves those there that it has no colours for.
    ///
    /// A footprint's colour is that of its two halves, in the texture's level of their width. Where
    /// a tinted pixel covers no more than a post, the tint of its own height is as good.
    #[inline(always)]
    fn filter<L: Lanes>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        texture: &Mipmapped<'_>,
        shading: &mut Shading,
        colours: &mut [i32],
    ) {
        let groups = chunk.count.div_ceil(LANES);
        let is_photo = self.textures[0]
            .as_ref()
            .is_some_and(|photo| std::ptr::eq(photo, texture));
        l.vectorize(
            #[inline(always)]
            || {
                filters(
                    l,
                    texture.frame.levels,
                    texture.scale,
                    self.blur,
                    &chunk.around,
                    &shading.rest[..groups],
                    &mut shading.filters,
                );
            },
        );
        l.vectorize(
            #[inline(always)]
            || {
                for at in (0..chunk.count).step_by(LANES) {
                    let number = at / LANES;
                    let mut wanted = shading.rest[number];
                    if wanted == 0 {
                        continue;
                    }
                    let filters = &mut shading.filters;
                    let halves = Halves {
                        aside: [
                            l.load(group(&filters.major, at)),
                            l.load(group(&filters.minor, at)),
                        ],
                        levels: [
                            l.load_i(group(&filters.levels[0], at)),
                            l.load_i(group(&filters.levels[1], at)),
                        ],
                    };
                    if !is_photo {
                        wanted &= l.bits(l.gt_i(halves.levels[0], l.splat_i(0)));
                    }
                    let reached = l.load(group(chunk.reached, at));
                    let advance = l.load(group(chunk.advance, at));
                    let [major, minor] = texture.scale;
                    let place = |t: L::F| {
                        [
                            l.mul(t, l.splat(major)),
                            l.mul(l.mul(t, advance), l.splat(minor)),
                        ]
                    };
                    let (located, on) = texture.locate(l, l.mask(wanted), place(reached), &halves);
                    shading.on[number] = l.bits(on);
                    for (to, half) in shading.halves.iter_mut().zip(&located) {
                        l.store_i(half.at, group_mut(&mut to.at, at));
                        l.store_i(half.east, group_mut(&mut to.east, at));
                        l.store_i(half.north, group_mut(&mut to.north, at));
                    }
                }
            },
        );
        l.vectorize(
            #[inline(always)]
            || {
                if self.large {
                    let tiles = &texture.frame.tiles;
                    for at in (0..chunk.count).step_by(LANES) {
                        if shading.on[at / LANES] & shading.rest[at / LANES] != 0 {
                            for half in &shading.halves {
                                let place = group(&half.at, at);
                                l.prefetch::<_, 1>(&tiles.items, place, 0);
                                l.prefetch::<_, 1>(&tiles.items, place, tiles.stride as i32);
                            }
                        }
                    }
                }
                for at in (0..chunk.count).step_by(LANES) {
                    let number = at / LANES;
                    let on = shading.on[number] & shading.rest[number];
                    if on == 0 {
                        continue;
                    }
                    let tiles = &texture.frame.tiles;
                    let [first, second] = &shading.halves;
                    let first = first.texels(l, at);
                    let texels = if shading.filters.two[number] & on != 0 {
                        let places = [first, second.texels(l, at)];
                        l.mean_texels(&tiles.items, tiles.stride, places)
                    } else {
                        // Magnified, colours change by little from pixel to pixel. Weights have been
                        // rounded down, by half a part on average.
                        let share = |weight: L::I| {
                            let parts = l.add(l.to_float(weight), l.splat(0.5));
                            l.mul(parts, l.splat(1.0 / 32768.0))
                        };
                        let (east, north) = (share(first.east), share(first.north));
                        l.texels(&tiles.items, first.at, tiles.stride, east, north)
                    };
                    // The mean of coverage is 255 where both have 255, or one 254: none has.
                    let whole = l.eq_i(l.shr_i(texels, l.splat_i(24)), l.splat_i(-1));
                    let on = l.and(l.mask(on), whole);
                    let colours = group_mut(colours, at);
                    l.store_i(l.select_i(on, texels, l.load_i(colours)), colours);
                    shading.rest[number] &= !l.bits(on);
                }
            },
        );
    }

    /// How many metres long directions are whose components are cells along the major and the minor
    /// axis, and metres up.
    #[inline(always)]
    pub(super) fn metres_of<L: Lanes>(&self, l: L, [major, minor, up]: [L::F; 3]) -> L::F {
        let major = l.mul(major, l.splat(self.metres[0] as f32));
        let minor = l.mul(minor, l.splat(self.metres[1] as f32));
        let square = l.add(l.mul(minor, minor), l.mul(major, major));
        l.sqrt(l.add(square, l.mul(up, up)))
    }

    /// Metres for each 1 of t.
    #[inline(always)]
    fn length<L: Lanes>(&self, l: L, advance: L::F, slope: L::F) -> L::F {
        let minor_metres = l.splat(self.metres[1] as f32);
        let major_square = l.splat((self.metres[0] * self.metres[0]) as f32);
        let minor_length = l.mul(advance, minor_metres);
        let square = l.add(l.mul(minor_length, minor_length), major_square);
        l.sqrt(l.add(square, l.mul(slope, slope)))
    }

    #[inline(always)]
    fn locate<L: Lanes>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        shading: &mut Shading,
        depths: &mut [f32],
    ) -> bool {
        let mut sees_sky = 0;
        let infinity = l.splat(f32::INFINITY);
        for at in (0..chunk.count).step_by(LANES) {
            let number = at / LANES;
            let mask = chunk.mask(at);
            let reached = l.load(group(chunk.reached, at));
            let advance = l.load(group(chunk.advance, at));
            let slope = l.load(group(chunk.slope, at));
            let hit = l.and(l.mask(mask), l.le(l.splat(0.0), reached));
            let length = self.length(l, advance, slope);
            let depth = l.select(hit, l.mul(reached, length), infinity);
            l.store(depth, group_mut(depths, at));
            let hits = l.bits(hit);
            shading.sky[number] = mask & !hits;
            sees_sky |= mask & !hits;
            shading.rest[number] = hits;
            shading.on[number] = 0;
            if self.large && hits != 0 && self.photo.is_some() {
                self.prefetch(l, chunk, at, hit, reached, advance);
            }
            if let Some(photo) = &self.photo
                && hits != 0
            {
                let aside = l.mul(reached, advance);
                let advances = if self.sector.major == 0 {
                    [reached, aside]
                } else {
                    [aside, reached]
                };
                let located = photo.locate(l, hit, advances);
                let on = l.bits(located.on);
                shading.on[number] = on;
                shading.rest[number] = hits & !on;
                l.store_i(located.at, group_mut(&mut shading.at, at));
                l.store(located.east, group_mut(&mut shading.east, at));
                l.store(located.north, group_mut(&mut shading.north, at));
            }
        }
        sees_sky != 0
    }
}

/// Blends a cell's corners (south-west, south-east, north-west, north-east) at a place in it.
#[inline(always)]
fn bilinear<L: Lanes>(l: L, [sw, se, nw, ne]: [L::F; 4], east: L::F, north: L::F) -> L::F {
    let south = l.add(sw, l.mul(l.sub(se, sw), east));
    let north_row = l.add(nw, l.mul(l.sub(ne, nw), east));
    l.add(south, l.mul(l.sub(north_row, south), north))
}

/// The sky's colours along directions of which the sine of the angle over the horizon is `up`.
#[inline(always)]
pub(super) fn sky_colours<L: Lanes>(l: L, up: L::F) -> L::I {
    let zero = l.splat(0.0);
    let over = l.le(zero, up);
    let mut share = l.sqrt(l.max(up, zero));
    let mut far = [l.splat(ZENITH[0]), l.splat(ZENITH[1]), l.splat(ZENITH[2])];
    if l.bits(over) != u16::MAX {
        let below = l.min(l.mul(up, l.splat(-1.0 / HAZE)), l.splat(1.0));
        let haze = l.mul(below, l.sub(l.splat(2.0), below));
        share = l.select(over, share, haze);
        for k in 0..3 {
            far[k] = l.select(over, far[k], l.splat(DEPTHS[k]));
        }
    }
    let mut colour = l.splat_i(255 << 24);
    for k in 0..3 {
        let horizon = l.splat(HORIZON[k]);
        let mixed = l.add(horizon, l.mul(l.sub(far[k], horizon), share));
        let byte = l.to_int(l.add(mixed, l.splat(0.5)));
        colour = l.add_i(colour, l.shl_i(byte, l.splat_i(8 * k as i32)));
    }
    colour
}
