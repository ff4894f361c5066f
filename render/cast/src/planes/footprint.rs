//! What part of the ground a pixel covers, and the filter that suits it.

use super::detail::TextureFrame;
use super::wave::{self, CAPACITY, Column};
use crate::lanes::{LANES, Lanes};

/// The rays of one step around a chunk, from the lane before the chunk's first on.
pub(super) struct Around<'a> {
    /// The step's first lane and the one behind its last, counted from the chunk's first.
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
        let t = l.load(numbers(self.reached, from));
        let advance = l.load(numbers(self.advance, from));
        Places {
            major: l.mul(t, l.splat(scale[0])),
            minor: l.mul(l.mul(t, advance), l.splat(scale[1])),
            are: l.and(l.mask(there), l.le(l.splat(0.0), t)),
        }
    }
}

fn numbers(numbers: &[f32], at: usize) -> &[f32; LANES] {
    numbers[at..].first_chunk().expect("room was made")
}

/// The filters of a chunk's pixels.
#[repr(align(64))]
pub(super) struct Filters {
    /// From the pixel's place to where the second half of its footprint has its middle, in the
    /// texture's pixels along major and minor axis; to the first half it is as far the other way.
    pub(super) major: Column<f32>,
    pub(super) minor: Column<f32>,
    /// The texture's level.
    pub(super) level: Column<i32>,
}

impl Default for Filters {
    fn default() -> Self {
        Self {
            major: [0.0; CAPACITY],
            minor: [0.0; CAPACITY],
            level: [0; CAPACITY],
        }
    }
}

/// A pixel's extent along one direction in the image: the smaller one of the ways to its two
/// neighbours, so that what lies behind a ridge does not count; nothing where neither is ground.
#[inline(always)]
fn extent<L: Lanes>(l: L, here: &Places<L>, there: [Option<Places<L>>; 2]) -> [L::F; 3] {
    let far = l.splat(f32::MAX);
    let mut least = [l.splat(0.0), l.splat(0.0), far];
    for (place, sign) in there.into_iter().zip([-1.0, 1.0]) {
        let Some(place) = place else { continue };
        let sign = l.splat(sign);
        let major = l.mul(l.sub(place.major, here.major), sign);
        let minor = l.mul(l.sub(place.minor, here.minor), sign);
        let square = l.add(l.mul(major, major), l.mul(minor, minor));
        let closer = l.and(place.are, l.lt(square, least[2]));
        least = [
            l.select(closer, major, least[0]),
            l.select(closer, minor, least[1]),
            l.select(closer, square, least[2]),
        ];
    }
    let none = l.le(far, least[2]);
    least[2] = l.select(none, l.splat(0.0), least[2]);
    least
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
    around: &[Option<Around<'_>>; 3],
    wanted: &[u16],
    filters: &mut Filters,
) {
    let Some(this) = &around[1] else { return };
    let coarsest = l.splat_i(texture.first_tiles.len() as i32 - 1);
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    for (group, &wanted) in wanted.iter().enumerate() {
        if wanted == 0 {
            continue;
        }
        let at = group * LANES;
        let here = this.places(l, at, 0, scale);
        let beside = [-1, 1].map(|aside| Some(this.places(l, at, aside, scale)));
        let along = [&around[0], &around[2]]
            .map(|step| step.as_ref().map(|step| step.places(l, at, 0, scale)));
        let u = extent(l, &here, beside);
        let v = extent(l, &here, along);
        let longer = l.lt(u[2], v[2]);
        let major = l.select(longer, v[0], u[0]);
        let minor = l.select(longer, v[1], u[1]);
        let length = l.sqrt(l.select(longer, v[2], u[2]));
        let area = l.abs(l.sub(l.mul(u[0], v[1]), l.mul(u[1], v[0])));
        let width = l.div(area, l.max(length, l.splat(1e-6)));
        let is_long = l.lt(l.mul(width, l.splat(LONG)), length);
        let reach = l.select(is_long, l.mul(length, l.splat(0.4)), l.mul(length, l.splat(0.8)));
        let wide = l.mul(l.max(width, reach), l.splat(blur));
        let level = l.min_i(l.exponent(l.max(wide, one)), coarsest);
        let apart = l.select(is_long, l.splat(APART), zero);
        l.store(l.mul(major, apart), wave::group_mut(&mut filters.major, at));
        l.store(l.mul(minor, apart), wave::group_mut(&mut filters.minor, at));
        l.store_i(level, wave::group_mut(&mut filters.level, at));
    }
}
