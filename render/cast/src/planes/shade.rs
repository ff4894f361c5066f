//! Colours and depths of a step's hits.

mod filter;
mod photo;
mod sky;
mod tints;

pub(super) use sky::sky_colours;

use self::filter::Half;
use self::photo::Mapped;
use self::tints::Tints;
use super::field::Field;
use super::footprint::{Around, Filters};
use super::frame::Frame;
use super::rows::Directions;
use super::sectors::Sector;
use super::texture::Mipmapped;
use super::wave::{CAPACITY, Column, first_lanes};
use crate::lanes::{LANES, Lanes, group, group_mut, groups, groups_mut};

/// What colouring one chunk of a step needs between its loops.
// On a page's border, as `Numbers` are.
#[repr(align(4096))]
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
    /// And the pixels of each group for which it takes more than their middles; for how many chunks to
    /// come it is not looked whether there are any others.
    filtered: [u16; CAPACITY / LANES],
    all_filtered: u32,
}

impl Shading {
    /// Makes ready for a sector.
    pub(super) fn begin(&mut self) {
        self.all_filtered = 0;
    }

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
            filtered: [0; CAPACITY / LANES],
            all_filtered: 0,
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

/// Turns what rays reached into pixels.
pub(super) struct Shader<'a> {
    sector: &'a Sector,
    photo: Option<Mapped<'a>>,
    /// Metres a cell along the major and the minor axis; and the square of those along the major axis.
    metres: [f32; 2],
    major_square: f32,
    field: &'a Field<'a>,
    /// None where a photo covers all ground.
    tints: Option<Tints<'a>>,
    /// Where detail is chosen: the photo, and tints.
    textures: [Option<Mipmapped<'a>>; 2],
    blur: f32,
    /// Where the ground begins, in cells from the eye along the major and the minor axis, if that lies beside it.
    begins: Option<[f32; 2]>,
    /// Whether the ground is too large for the processor's nearer caches; and whether memory is asked for
    /// ahead of hits then, as it is where rays go over its own resolution alone.
    large: bool,
    asks_ahead: bool,
}

/// How many cells ahead of a hit memory is asked for.
const AHEAD: f32 = 20.0;

/// Rows of posts from a step to the next from which on too many would be asked for in vain.
const MOST_ROWS: f64 = 4.0;

/// Of which lanes memory is asked for: of every second one, as neighbours lie close by. What rays pass that run along
/// a row of posts lies side by side, so that a line of the processor's cache has it for some steps; there it is asked
/// for every few of these, but for all lanes, as each has a row of its own. Up to so many cells from a step to the next.
const NONE: usize = 0;
const ALL: usize = 1;
const SECOND: usize = 2;
const EVERY_STEP: u32 = 4;
const ALONG_ROW: f64 = 2.0;

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
            metres: metres.map(|metres| metres as f32),
            major_square: (metres[0] * metres[0]) as f32,
            field,
            tints: Tints::new(frame.ground),
            textures,
            blur: frame.detail.as_ref().map_or(1.0, |detail| detail.blur),
            begins: Some([&field.major, &field.minor].map(|axis| axis.begin))
                .filter(|begins| begins.iter().any(|&begin| begin > 0.0)),
            large: frame.levels[0].is_large(),
            asks_ahead: frame.levels[0].is_large()
                && !frame.coarsens
                && frame.ground.photo().is_some(),
        }
    }

    /// Of every how many lanes memory is asked for ahead of a chunk's hits; or of none.
    #[inline(always)]
    fn asks_every(&self, chunk: &Chunk<'_>) -> usize {
        if !self.asks_ahead {
            return NONE;
        }
        let runs_along = self.sector.major == 0;
        if !runs_along || self.cells_to_next(chunk, chunk.count / 2) > ALONG_ROW {
            return SECOND;
        }
        if chunk.step.is_multiple_of(EVERY_STEP) {
            ALL
        } else {
            NONE
        }
    }

    /// How many cells the ray of the step behind that of lane `at` goes further, where the ground is level.
    #[inline(always)]
    fn cells_to_next(&self, chunk: &Chunk<'_>, at: usize) -> f64 {
        let from = chunk.directions.at(chunk.step, chunk.first + at as i32);
        let to = from + chunk.directions.step;
        // By how much more of itself than the first ray's slope the second one's is higher: one division.
        let rise = (to.z * from.x - from.z * to.x) / (to.x * from.z.abs());
        f64::from(chunk.reached[at].abs()) * rise
    }

    /// Asks for the ground that the next step's rays will meet behind a group's hits: as many rows
    /// of posts as they will pass.
    #[inline(always)]
    fn prefetch<L: Lanes, const EVERY: usize>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        at: usize,
        hit: L::M,
        reached: L::F,
        advance: L::F,
    ) {
        let rows = self.cells_to_next(chunk, at);
        if rows > MOST_ROWS {
            return;
        }
        // Along a row there is but one.
        let rows = if EVERY == ALL {
            1
        } else {
            rows.max(1.0) as u32
        };
        let none = l.splat(0.0);
        let mut places = [0; LANES];
        for row in 0..rows {
            let t = l.add(reached, l.splat(AHEAD + row as f32));
            let t = l.select(hit, t, none);
            let place = self.field.place(l, self.field.cell_at(l, t, advance));
            l.store_i(place, &mut places);
            l.prefetch::<_, EVERY>(&self.field.heights.items, &places, 0);
            if let Some(photo) = &self.photo {
                let aside = l.mul(t, advance);
                let advances = if self.sector.major == 0 {
                    [t, aside]
                } else {
                    [aside, t]
                };
                let (x, _) = photo.x.locate(l, advances[0]);
                let (y, _) = photo.y.locate(l, advances[1]);
                l.store_i(photo.tiles.place(l, x, y), &mut places);
                l.prefetch::<_, EVERY>(&photo.tiles.items, &places, 0);
            } else if let Some(photo) = &self.textures[0] {
                let (located, _) = photo.locate_small(l, hit, photo.pixels_to(l, t, advance));
                l.store_i(located.at, &mut places);
                l.prefetch::<_, EVERY>(&photo.frame.tiles.items, &places, 0);
            }
        }
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
        let sees_sky = match self.asks_every(chunk) {
            NONE => l.vectorize(
                #[inline(always)]
                || self.locate::<L, NONE>(l, chunk, shading, depths),
            ),
            ALL => l.vectorize(
                #[inline(always)]
                || self.locate::<L, ALL>(l, chunk, shading, depths),
            ),
            _ => l.vectorize(
                #[inline(always)]
                || self.locate::<L, SECOND>(l, chunk, shading, depths),
            ),
        };
        if let Some(photo) = &self.photo {
            l.vectorize(
                #[inline(always)]
                || {
                    let count = chunk.count.div_ceil(LANES);
                    let places = groups(&shading.at, count);
                    let east = groups(&shading.east, count);
                    let north = groups(&shading.north, count);
                    let colours = groups_mut(colours, count);
                    let on = &shading.on[..count];
                    let rest = &mut shading.rest[..count];
                    for number in 0..count {
                        if on[number] == 0 {
                            continue;
                        }
                        let texels = l.texels(
                            &photo.tiles.items,
                            &places[number],
                            photo.tiles.stride,
                            l.load(&east[number]),
                            l.load(&north[number]),
                        );
                        l.store_i(texels, &mut colours[number]);
                        if !photo.covers {
                            let whole = l.eq_i(l.shr_i(texels, l.splat_i(24)), l.splat_i(-1));
                            rest[number] |= on[number] & !l.bits(whole);
                        }
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
            self.colour_skies(l, chunk.directions, chunk.step, lanes, shading, colours);
        }
        sees_sky
    }

    /// How many metres long directions are whose components are cells along the major and the minor
    /// axis, and metres up.
    #[inline(always)]
    pub(super) fn metres_of<L: Lanes>(&self, l: L, [major, minor, up]: [L::F; 3]) -> L::F {
        let major = l.mul(major, l.splat(self.metres[0]));
        let minor = l.mul(minor, l.splat(self.metres[1]));
        let square = l.add(l.mul(minor, minor), l.mul(major, major));
        l.sqrt(l.add(square, l.mul(up, up)))
    }

    /// Metres for each 1 of t.
    #[inline(always)]
    fn length<L: Lanes>(&self, l: L, advance: L::F, slope: L::F) -> L::F {
        let minor_length = l.mul(advance, l.splat(self.metres[1]));
        let square = l.add(
            l.mul(minor_length, minor_length),
            l.splat(self.major_square),
        );
        l.sqrt(l.add(square, l.mul(slope, slope)))
    }

    /// Finds depths, and where the colours of hits are; gives whether some see the sky. Of `EVERY` how many lanes
    /// memory is asked for ahead is known where it is compiled, as that needs many registers.
    #[inline(always)]
    fn locate<L: Lanes, const EVERY: usize>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        shading: &mut Shading,
        depths: &mut [f32],
    ) -> bool {
        let count = chunk.count.div_ceil(LANES);
        let mut locating = Locating {
            reached: groups(chunk.reached, count),
            advance: groups(chunk.advance, count),
            slope: groups(chunk.slope, count),
            depths: groups_mut(depths, count),
            places: groups_mut(&mut shading.at, count),
            east: groups_mut(&mut shading.east, count),
            north: groups_mut(&mut shading.north, count),
            sky: &mut shading.sky[..count],
            rest: &mut shading.rest[..count],
            on: &mut shading.on[..count],
        };
        let mut sees_sky = 0;
        let whole = chunk.count / LANES;
        for number in 0..whole {
            sees_sky |= self.locate_group::<L, EVERY>(l, chunk, &mut locating, number, u16::MAX);
        }
        if whole < count {
            let mask = chunk.mask(whole * LANES);
            sees_sky |= self.locate_group::<L, EVERY>(l, chunk, &mut locating, whole, mask);
        }
        sees_sky != 0
    }

    /// As `locate`, of the group with a number, of which the lanes of `mask` are there; gives those that see the sky.
    #[inline(always)]
    fn locate_group<L: Lanes, const EVERY: usize>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        locating: &mut Locating<'_>,
        number: usize,
        mask: u16,
    ) -> u16 {
        let reached = l.load(&locating.reached[number]);
        let advance = l.load(&locating.advance[number]);
        let slope = l.load(&locating.slope[number]);
        let hit = l.and(l.mask(mask), l.le(l.splat(0.0), reached));
        let length = self.length(l, advance, slope);
        let depth = l.select(hit, l.mul(reached, length), l.splat(f32::INFINITY));
        l.store(depth, &mut locating.depths[number]);
        let hits = l.bits(hit);
        let sky = mask & !hits;
        locating.sky[number] = sky;
        let mut on = 0;
        if EVERY != NONE && hits != 0 {
            self.prefetch::<L, EVERY>(l, chunk, number * LANES, hit, reached, advance);
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
            on = l.bits(located.on);
            l.store_i(located.at, &mut locating.places[number]);
            l.store(located.east, &mut locating.east[number]);
            l.store(located.north, &mut locating.north[number]);
        }
        locating.on[number] = on;
        locating.rest[number] = hits & !on;
        sky
    }
}

/// What is known of a chunk's pixels before their colours are fetched, and where it goes, group by group.
struct Locating<'a> {
    reached: &'a [[f32; LANES]],
    advance: &'a [[f32; LANES]],
    slope: &'a [[f32; LANES]],
    depths: &'a mut [[f32; LANES]],
    /// As [`Shading`] has them.
    places: &'a mut [[i32; LANES]],
    east: &'a mut [[f32; LANES]],
    north: &'a mut [[f32; LANES]],
    sky: &'a mut [u16],
    rest: &'a mut [u16],
    on: &'a mut [u16],
}
