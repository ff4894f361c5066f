//! What part of the ground a pixel covers, and the filter that suits it.

use super::detail::TextureFrame;
use super::wave::{CAPACITY, Column};
use crate::lanes::{LANES, Lanes, group, group_mut};

/// The rays of one step around a chunk, from the lane before the chunk's first on.
pub(super) struct Around<'a> {
    /// The step's first lane and the one behind its last, counted from the chunk's first; the same
    /// where there is no such step.
    pub(super) lanes: [i32; 2],
    /// As [`Chunk`](super::shade::Chunk) has them.
    pub(super) reached: &'a [f32],
    pub(super) advance: &'a [f32],
}

/// Places on the ground, in a texture's pixels from the eye along major and minor axis, and which
/// of them there are.
struct Places<L: Lanes> {
    major: L::F,
    minor: L::F,
    are: L::M,
}

impl Around<'_> {
    /// Where the rays of the group at `at` meet the ground, or those `aside` lanes beside it.
    #[inline(always)]
    fn places<L: Lanes>(&self, l: L, at: usize, aside: i32, scale: [f32; 2]) -> Places<L> {
        let from = (at as i32 + 1 + aside) as usize;
        let first = at as i32 + aside;
        let begin = (self.lanes[0] - first).clamp(0, LANES as i32);
        let end = (self.lanes[1] - first).clamp(begin, LANES as i32);
        let there = ((1_u32 << end) - (1_u32 << begin)) as u16;
        let t = l.load(group(self.reached, from));
        let advance = l.load(group(self.advance, from));
        Places {
            major: l.mul(t, l.splat(scale[0])),
            minor: l.mul(l.mul(t, advance), l.splat(scale[1])),
            are: l.and(l.mask(there), l.le(l.splat(0.0), t)),
        }
    }
}

/// The filters of a chunk's pixels.
#[repr(align(64))]
pub(super) struct Filters {
    /// From the pixel's place to where the second half of its footprint has its middle, in the
    /// texture's finest pixels along major and minor axis; to the first half it is as far the other
    /// way.
    pub(super) major: Column<f32>,
    pub(super) minor: Column<f32>,
    /// The texture's level.
    pub(super) level: Column<i32>,
    /// Which pixels of each group have two halves apart.
    pub(super) apart: [u16; CAPACITY / LANES],
}

impl Default for Filters {
    fn default() -> Self {
        Self {
            major: [0.0; CAPACITY],
            minor: [0.0; CAPACITY],
            level: [0; CAPACITY],
            apart: [0; CAPACITY / LANES],
        }
    }
}

/// A pixel's extent along one direction in the image, and its square.
struct Extent<L: Lanes> {
    major: L::F,
    minor: L::F,
    square: L::F,
}

/// The smaller one of the ways to a pixel's two neighbours, so that what lies behind a ridge does
/// not count; nothing where neither is ground.
#[inline(always)]
fn extent<L: Lanes>(l: L, here: &Places<L>, before: &Places<L>, behind: &Places<L>) -> Extent<L> {
    let (none, far) = (l.splat(0.0), l.splat(f32::MAX));
    let back_major = l.sub(here.major, before.major);
    let back_minor = l.sub(here.minor, before.minor);
    let back = l.add(l.mul(back_major, back_major), l.mul(back_minor, back_minor));
    let back = l.select(before.are, back, far);
    let on_major = l.sub(behind.major, here.major);
    let on_minor = l.sub(behind.minor, here.minor);
    let on = l.add(l.mul(on_major, on_major), l.mul(on_minor, on_minor));
    let on = l.select(behind.are, on, far);
    let closer = l.lt(on, back);
    let any = l.or(before.are, behind.are);
    Extent {
        major: l.select(any, l.select(closer, on_major, back_major), none),
        minor: l.select(any, l.select(closer, on_minor, back_minor), none),
        square: l.select(any, l.select(closer, on, back), none),
    }
}

/// Half of the way between the middles of a footprint's halves, as a part of its length.
const APART: f32 = 0.25;

/// How much longer than wide footprints are from which on their halves are looked at apart.
const LONG: f32 = 1.43;

/// Finds the filters of the pixels of a chunk in the groups that `wanted` names.
///
/// A pixel's footprint is the parallelogram of its extents along steps and lanes (the pyramid's
/// filter is made for its width, and two halves for its length).
#[inline(always)]
pub(super) fn filters<L: Lanes>(
    l: L,
    texture: &TextureFrame<'_>,
    scale: [f32; 2],
    blur: f32,
    [before, this, behind]: &[Around<'_>; 3],
    wanted: &[u16],
    filters: &mut Filters,
) {
    let coarsest = l.splat_i(texture.first_tiles.len() as i32 - 1);
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    for (group, &wanted) in wanted.iter().enumerate() {
        if wanted == 0 {
            continue;
        }
        let at = group * LANES;
        let here = this.places(l, at, 0, scale);
        let u = extent(
            l,
            &here,
            &this.places(l, at, -1, scale),
            &this.places(l, at, 1, scale),
        );
        let v = extent(
            l,
            &here,
            &before.places(l, at, 0, scale),
            &behind.places(l, at, 0, scale),
        );
        let longer = l.lt(u.square, v.square);
        let major = l.select(longer, v.major, u.major);
        let minor = l.select(longer, v.minor, u.minor);
        let length = l.sqrt(l.select(longer, v.square, u.square));
        let area = l.abs(l.sub(l.mul(u.major, v.minor), l.mul(u.minor, v.major)));
        let width = l.div(area, l.max(length, l.splat(1e-6)));
        // Where a footprint is smaller than a pixel, one place is as good as two.
        let is_long = l.lt(l.max(l.mul(width, l.splat(LONG)), one), length);
        let reach = l.select(
            is_long,
            l.mul(length, l.splat(0.4)),
            l.mul(length, l.splat(0.8)),
        );
        let wide = l.mul(l.max(width, reach), l.splat(blur));
        let level = l.min_i(l.exponent(l.max(wide, one)), coarsest);
        // No further than the footprint is wide: beyond a ridge there are other colours.
        let most = l.div(l.max(width, one), length);
        let apart = l.select(is_long, l.min(l.splat(APART), most), zero);
        l.store(l.mul(major, apart), group_mut(&mut filters.major, at));
        l.store(l.mul(minor, apart), group_mut(&mut filters.minor, at));
        l.store_i(level, group_mut(&mut filters.level, at));
        filters.apart[group] = l.bits(is_long);
    }
}
