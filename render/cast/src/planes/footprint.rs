//! What part of the ground a pixel covers, and the filter that suits it.

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

/// Places on the ground, in a texture's pixels from the eye along major and minor axis, and which of
/// them there are.
struct Places<L: Lanes> {
    major: L::F,
    minor: L::F,
    are: L::M,
}

impl<L: Lanes> Places<L> {
    /// Whether they lie on the ground's walls, where the ground begins at `begins` from the eye.
    #[inline(always)]
    fn are_on_walls(&self, l: L, begins: [f32; 2]) -> L::M {
        // A little behind, however places are rounded: what is no wall there is as long as one.
        let [major, minor] = begins.map(|begin| l.splat(begin * 1.00001));
        let before = [l.le(self.major, major), l.le(self.minor, minor)];
        l.or(before[0], before[1])
    }

    /// The squares of how far away others are; infinity where there are none.
    #[inline(always)]
    fn away(&self, l: L, other: &Self) -> L::F {
        let major = l.sub(other.major, self.major);
        let minor = l.sub(other.minor, self.minor);
        let square = l.add(l.mul(major, major), l.mul(minor, minor));
        l.select(other.are, square, l.splat(f32::INFINITY))
    }
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

/// How long extents are at most, in pixels of a texture, of footprints of which it needs no more than
/// their middle: for [`filters`] of so much `blur`, whatever else is around.
pub(super) fn most_small(blur: f32) -> f32 {
    // A footprint's length and its width are no more than that then, it is not a long one, and both of
    // its halves are in the finest level.
    (0.999 * 2.0 / (STAGGER * blur)).min(1.0)
}

/// Which pixels of the group at `at` have footprints with extents that are surely no longer than `most`.
///
/// Of two neighbours on opposite sides the nearer one counts, so it is enough that one is near, or that
/// there is none.
#[inline(always)]
pub(super) fn are_small<L: Lanes>(
    l: L,
    scale: [f32; 2],
    most: f32,
    [before, this, behind]: &[Around<'_>; 3],
    wanted: u16,
    at: usize,
) -> L::M {
    let here = this.places(l, at, 0, scale);
    let most = l.splat(most * most);
    let along_lanes = here.away(l, &this.places(l, at, 1, scale));
    let along_steps = here.away(l, &before.places(l, at, 0, scale));
    let small = l.and(l.le(along_lanes, most), l.le(along_steps, most));
    if l.bits(small) & wanted == wanted {
        return small;
    }
    // The others ask their other neighbours, too.
    let along_lanes = l.min(along_lanes, here.away(l, &this.places(l, at, -1, scale)));
    let along_steps = l.min(along_steps, here.away(l, &behind.places(l, at, 0, scale)));
    let none = l.splat(f32::INFINITY);
    l.and(
        l.or(l.le(along_lanes, most), l.le(none, along_lanes)),
        l.or(l.le(along_steps, most), l.le(none, along_steps)),
    )
}

/// The filters of a chunk's pixels.
#[repr(align(64))]
pub(super) struct Filters {
    /// From the pixel's place to where the second half of its footprint has its middle, in the
    /// texture's finest pixels along major and minor axis; to the first half it is as far the other
    /// way.
    pub(super) major: Column<f32>,
    pub(super) minor: Column<f32>,
    /// The halves' levels of the texture.
    pub(super) levels: [Column<i32>; 2],
    /// Which pixels of each group have two halves that differ.
    pub(super) two: [u16; CAPACITY / LANES],
}

impl Default for Filters {
    fn default() -> Self {
        Self {
            major: [0.0; CAPACITY],
            minor: [0.0; CAPACITY],
            levels: [[0; CAPACITY]; 2],
            two: [0; CAPACITY / LANES],
        }
    }
}

/// A pixel's extent along one direction in the image, and its square.
struct Extent<L: Lanes> {
    major: L::F,
    minor: L::F,
    square: L::F,
    /// Whether ground is seen on one side only: on the other one there is the sky, or the sector ends.
    is_guess: L::M,
}

impl<L: Lanes> Extent<L> {
    /// The smaller one of the ways to a pixel's two neighbours, so that what lies behind a ridge
    /// does not count; nothing where neither is ground.
    #[inline(always)]
    fn new(l: L, here: &Places<L>, before: &Places<L>, behind: &Places<L>) -> Self {
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
        let both = l.and(before.are, behind.are);
        Self {
            major: l.select(any, l.select(closer, on_major, back_major), none),
            minor: l.select(any, l.select(closer, on_minor, back_minor), none),
            square: l.select(any, l.select(closer, on, back), none),
            is_guess: l.and_not(any, both),
        }
    }

    /// Whether it is a guess that is so much longer than the `other` extent that the one neighbour
    /// that is known must lie behind a ridge.
    #[inline(always)]
    fn leads_astray(&self, l: L, other: &Self) -> L::M {
        let most = l.mul(other.square, l.splat(ASTRAY));
        l.and(self.is_guess, l.lt(most, self.square))
    }

    /// Nothing where it is a guess at a place where guesses lead `astray`.
    #[inline(always)]
    fn unless(&self, l: L, astray: L::M) -> Self {
        let none = l.splat(0.0);
        let astray = l.and(astray, self.is_guess);
        Self {
            major: l.select(astray, none, self.major),
            minor: l.select(astray, none, self.minor),
            square: l.select(astray, none, self.square),
            is_guess: self.is_guess,
        }
    }
}

/// How many times as large as the other extent's the square of a guess is from which on it is taken
/// to lead elsewhere.
const ASTRAY: f32 = 16.0;

/// Half of the way between the middles of a footprint's halves, as a part of its length.
const APART: f32 = 0.25;

/// As how many times as wide one half of a footprint is filtered, and the other one as narrow: as a
/// footprint grows, they come to a coarser level one after the other.
const STAGGER: f32 = 1.189_207_1;

/// How much longer than wide footprints are from which on their halves are looked at apart.
const LONG: f32 = 1.43;

/// Of footprints less than 1 / `NARROW` pixels of the texture wide only a part of the length counts:
/// `NARROW` times the width, but `NARROWEST` at least. A pixel of a coarser level is as wide as it is
/// long, and would take in colours that lie beside them.
const NARROW: f32 = 0.7;
const NARROWEST: f32 = 0.15;

/// A texture, as footprints meet it.
#[derive(Clone, Copy)]
pub(super) struct Sampling {
    /// How many levels it has, and how many pixels the finest one has to a cell along major and minor axis.
    pub(super) levels: usize,
    pub(super) scale: [f32; 2],
    /// Where the ground begins, in its pixels from the eye along both, if the eye lies beside the ground.
    pub(super) begins: Option<[f32; 2]>,
    /// How many times as wide as pixels filters are.
    pub(super) blur: f32,
}

/// How wide footprints on walls are taken to be, as a part of their length: they have no width, but a wall has the
/// colours of the border from top to bottom, so that there is nothing beside them to take in.
const WALL: f32 = 0.35;

/// Finds the filters of the pixels of a chunk in the groups that `wanted` names.
///
/// A pixel's footprint is the parallelogram of its extents along steps and lanes (the pyramid's
/// filter is made for its width, and two halves for its length).
#[inline(always)]
pub(super) fn filters<L: Lanes>(
    l: L,
    sampling: &Sampling,
    [before, this, behind]: &[Around<'_>; 3],
    wanted: &[u16],
    filters: &mut Filters,
) {
    let Sampling {
        levels,
        scale,
        begins,
        blur,
    } = *sampling;
    let coarsest = l.splat_i(levels as i32 - 1);
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    for (number, &wanted) in wanted.iter().enumerate() {
        if wanted == 0 {
            continue;
        }
        let at = number * LANES;
        let here = this.places(l, at, 0, scale);
        let u = Extent::new(
            l,
            &here,
            &this.places(l, at, -1, scale),
            &this.places(l, at, 1, scale),
        );
        let v = Extent::new(
            l,
            &here,
            &before.places(l, at, 0, scale),
            &behind.places(l, at, 0, scale),
        );
        let astray = l.or(u.leads_astray(l, &v), v.leads_astray(l, &u));
        let (u, v) = (u.unless(l, astray), v.unless(l, astray));
        let longer = l.lt(u.square, v.square);
        let major = l.select(longer, v.major, u.major);
        let minor = l.select(longer, v.minor, u.minor);
        let length = l.sqrt(l.select(longer, v.square, u.square));
        let area = l.abs(l.sub(l.mul(u.major, v.minor), l.mul(u.minor, v.major)));
        let per_length = l.div(one, l.max(length, l.splat(1e-6)));
        let mut width = l.mul(area, per_length);
        if let Some(begins) = begins {
            let on_wall = l.mul(length, l.splat(WALL));
            width = l.select(here.are_on_walls(l, begins), on_wall, width);
        }
        // Where a footprint is smaller than a pixel, one place is as good as two.
        let is_long = l.lt(l.max(l.mul(width, l.splat(LONG)), one), length);
        let reach = l.select(
            is_long,
            l.mul(length, l.splat(0.4)),
            l.mul(length, l.splat(0.8)),
        );
        let counts = l.max(l.mul(width, l.splat(NARROW)), l.splat(NARROWEST));
        let reach = l.mul(reach, l.min(counts, one));
        let wide = l.mul(l.max(width, reach), l.splat(blur));
        let wider = l.max(l.mul(wide, l.splat(STAGGER)), one);
        let narrower = l.max(l.mul(wide, l.splat(1.0 / STAGGER)), one);
        let levels = [
            l.min_i(l.exponent(wider), coarsest),
            l.min_i(l.exponent(narrower), coarsest),
        ];
        // No further than the footprint is wide: beyond a ridge there are other colours.
        let most = l.mul(l.max(width, one), per_length);
        let apart = l.select(is_long, l.min(l.splat(APART), most), zero);
        l.store(l.mul(major, apart), group_mut(&mut filters.major, at));
        l.store(l.mul(minor, apart), group_mut(&mut filters.minor, at));
        l.store_i(levels[0], group_mut(&mut filters.levels[0], at));
        l.store_i(levels[1], group_mut(&mut filters.levels[1], at));
        filters.two[number] = l.bits(l.or(is_long, l.gt_i(levels[0], levels[1])));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;

    /// The levels of the first four pixels of a step, of which each step has the lanes `lanes`, and
    /// `place` says where on the ground the pixel of a step and a lane lies, in pixels of a texture
    /// along the major and the minor axis.
    fn levels(lanes: [i32; 2], place: impl Fn(i32, i32) -> [f32; 2]) -> [i32; 4] {
        levels_beside(None, lanes, place)
    }

    /// The same of ground that begins somewhere.
    fn levels_beside(
        begins: Option<[f32; 2]>,
        lanes: [i32; 2],
        place: impl Fn(i32, i32) -> [f32; 2],
    ) -> [i32; 4] {
        let steps = [-1, 0, 1].map(|step| {
            let numbers = (-1..LANES as i32 + 1).map(|lane| place(step, lane));
            let (reached, advance): (Vec<_>, Vec<_>) =
                numbers.map(|[major, minor]| (major, minor / major)).unzip();
            (reached, advance)
        });
        let around = steps.each_ref().map(|(reached, advance)| Around {
            lanes,
            reached,
            advance,
        });
        let mut found = Box::<Filters>::default();
        let sampling = Sampling {
            levels: 9,
            scale: [1.0; 2],
            begins,
            blur: 1.9,
        };
        filters(Portable, &sampling, &around, &[0xf], &mut found);
        std::array::from_fn(|lane| found.levels[0][lane])
    }

    #[test]
    fn narrow_footprints_are_not_filtered_as_wide_as_they_are_long() {
        let long_and_wide = |width: f32| {
            levels([-1, 17], |step, lane| {
                [200.0 + 6.0 * step as f32, 50.0 + width * lane as f32]
            })
        };
        assert_eq!(long_and_wide(3.0), [2; 4]);
        assert_eq!(long_and_wide(1.5), [2; 4]);
        assert_eq!(long_and_wide(0.1), [0; 4]);
    }

    #[test]
    fn on_a_wall_all_of_the_length_counts() {
        // Lines of the image lead down the wall, beside each other along the border.
        let on_the_side = |_: i32, lane: i32| [100.0 + 6.0 * lane as f32, 20.0];
        let beside = |begins| levels_beside(Some(begins), [-1, 17], on_the_side);
        assert_eq!(beside([-5.0, 20.0]), [2; 4]);
        assert_eq!(beside([100.0 - 6.0, 3.0]), [0; 4]);
        let on_the_front = |_: i32, lane: i32| [100.0, 20.0 + 6.0 * lane as f32];
        let begins = Some([100.0, -40.0]);
        assert_eq!(levels_beside(begins, [-1, 17], on_the_front), [2; 4]);
        assert_eq!(levels([-1, 17], on_the_front), [0; 4]);
    }

    #[test]
    fn beside_a_sectors_border_what_lies_behind_a_ridge_does_not_count() {
        // Lane 0 sees a ridge, and all the others the ground behind it.
        let ridge = |step: i32, lane: i32| {
            let near = if lane < 1 { 100.0 } else { 400.0 };
            [near + step as f32, lane as f32]
        };
        let [in_the_midst, ..] = levels([-1, 17], ridge);
        let [at_the_border, ..] = levels([0, 17], ridge);
        assert_eq!([in_the_midst, at_the_border], [1, 0]);
        // A guess that is no further astray than the other extent stays.
        let plain = |step: i32, lane: i32| [100.0 + 2.0 * step as f32, 2.0 * lane as f32];
        assert_eq!(levels([0, 17], plain), [2; 4]);
    }

    /// Small footprints are those of which a filter would take no more than one place of the finest level.
    #[test]
    fn small_footprints_need_no_filter() {
        let l = Portable;
        let number = |k: u32, of: u32| {
            let n = (k ^ of.wrapping_mul(0x9e37_79b9)).wrapping_mul(0x2c1b_3c6d);
            let n = (n ^ (n >> 15)).wrapping_mul(0x85eb_ca6b);
            ((n ^ (n >> 13)) >> 8) as f32 / 16_777_216.0
        };
        let (mut small, mut filtered) = (0, 0);
        for blur in [0.25, 1.0, 1.9, 4.0] {
            for k in 0..4000 {
                // Extents of all sizes, ridges here and there, and borders.
                let size = 4.0 * number(k, 1).powi(2);
                let ridge = (number(k, 2) * 40.0) as i32;
                let lanes = [(number(k, 3) * 30.0) as i32 - 28, 17];
                let numbers = [-1, 0, 1].map(|step: i32| {
                    let place = |lane: i32| {
                        let seed = k * 100 + (step + 1) as u32 * 20 + (lane + 1) as u32;
                        let shaken = |of: u32| size * (number(seed, of) - 0.5);
                        let beyond = if lane > ridge { 7.0 } else { 0.0 };
                        let aside = 30.0 + size * lane as f32 * 0.7 + shaken(5);
                        let major = 100.0 + size * step as f32 + shaken(4) + beyond;
                        let sky = number(seed, 6) < 0.05;
                        (if sky { -major } else { major }, aside / major)
                    };
                    (-1..LANES as i32 + 1)
                        .map(place)
                        .unzip::<f32, f32, Vec<_>, Vec<_>>()
                });
                let around = numbers.each_ref().map(|(reached, advance)| Around {
                    lanes,
                    reached,
                    advance,
                });
                let mut wanted = 0;
                for lane in 0..LANES {
                    let is_ground = numbers[1].0[lane + 1] >= 0.0 && lane as i32 >= lanes[0];
                    wanted |= u16::from(is_ground) << lane;
                }
                let most = most_small(blur);
                let are = are_small(l, [1.0; 2], most, &around, wanted, 0);
                let are = l.bits(are) & wanted;
                let mut found = Box::<Filters>::default();
                let sampling = Sampling {
                    levels: 9,
                    scale: [1.0; 2],
                    begins: None,
                    blur,
                };
                filters(l, &sampling, &around, &[wanted], &mut found);
                for lane in (0..LANES).filter(|lane| wanted >> lane & 1 != 0) {
                    let levels = [0, 1].map(|half| found.levels[half][lane]);
                    let needs = found.two[0] >> lane & 1 != 0 || levels != [0; 2];
                    let is_small = are >> lane & 1 != 0;
                    assert!(!(needs && is_small), "lane {lane} of {k}, blur {blur}");
                    small += u32::from(is_small);
                    filtered += u32::from(needs);
                }
            }
        }
        assert!(small > 40_000 && filtered > 40_000, "{small}, {filtered}");
    }
}
