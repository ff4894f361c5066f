//! Where planes are: on lines of posts, and between them.

use super::PlaneGroup;
use super::crossing::{Crossing, Texels};
use super::halves::{between, parts as parts_of};
use crate::lanes::Lanes;
use crate::planes::field::{Field, Tiles};

/// A place along the major axis: a mirrored line of posts, and which part of the way from it to the next.
#[derive(Clone, Copy)]
pub(in crate::planes) struct Mark {
    pub(in crate::planes) line: i32,
    pub(in crate::planes) part: f32,
}

/// Where planes are at a [`Mark`].
#[derive(Clone, Copy)]
pub(in crate::planes) struct Station<L: Lanes> {
    pub(in crate::planes) crossing: Crossing<L>,
    /// Where that is not on a line: the next line, and how much of the way to it.
    next: Option<(Crossing<L>, f32)>,
}

impl<L: Lanes> Station<L> {
    /// Where planes cross a line; as many posts `beside` those around them are to be known, too.
    #[inline(always)]
    pub(in crate::planes) fn on_line(
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        line: i32,
        beside: i32,
    ) -> Self {
        Self {
            crossing: Crossing::new(l, field, planes, line, beside),
            next: None,
        }
    }

    /// Where planes are between a line and the next one; one post beside those around them is known, too.
    #[inline(always)]
    pub(in crate::planes) fn between(
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        Mark { line, part }: Mark,
    ) -> Self {
        let t = line as f32 - field.major.fraction + part;
        Self {
            crossing: Crossing::at(l, field, planes, line, t, 1),
            next: Some((Crossing::at(l, field, planes, line + 1, t, 1), part)),
        }
    }

    /// The heights over the eye of the ground at the near and the far side of the cells that planes are in: between
    /// lines, of their edges there.
    #[inline(always)]
    pub(in crate::planes) fn posts(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
    ) -> [L::F; 2] {
        let posts = self.crossing.posts(l, field, planes);
        let Some((next, part)) = &self.next else {
            return posts;
        };
        let part = l.splat(*part);
        let to = next.posts(l, field, planes);
        [
            l.add(posts[0], l.mul(l.sub(to[0], posts[0]), part)),
            l.add(posts[1], l.mul(l.sub(to[1], posts[1]), part)),
        ]
    }

    /// The colours there, and one cell further on either side, as [`Crossing::texels`] has them.
    #[inline(always)]
    pub(in crate::planes) fn texels(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        colours: &Tiles<'_, [u8; 4]>,
    ) -> Texels<L> {
        let texels = self.crossing.texels(l, field, planes, colours);
        let Some((next, part)) = &self.next else {
            return texels;
        };
        let part = parts_of(l, l.splat(*part));
        let to = next.texels(l, field, planes, colours);
        [
            between(l, texels[0], to[0], part),
            between(l, texels[1], to[1], part),
            between(l, texels[2], to[2], part),
            between(l, texels[3], to[3], part),
        ]
    }
}

/// The way of planes from one line of posts to the next.
pub(in crate::planes) struct Stretch<L: Lanes> {
    pub(in crate::planes) planes: PlaneGroup<L>,
    /// Where they are on both lines, and the heights of the posts around them there.
    pub(in crate::planes) stations: [Station<L>; 2],
    pub(in crate::planes) posts: [[L::F; 2]; 2],
    /// Which of them go on.
    pub(in crate::planes) live: L::M,
}

impl<L: Lanes> Stretch<L> {
    /// How much more one side of the cells rises than the other that planes come through: metres, of those that
    /// go on. `None` where planes lie many cells apart.
    #[inline(always)]
    fn twist(&self, l: L, field: &Field<'_>) -> Option<L::F> {
        let [before, behind] = &self.stations;
        let [here, there] = self.posts;
        let [_, after] = before.crossing.outer_posts(l, field, &self.planes)?;
        let [ahead, _] = behind.crossing.outer_posts(l, field, &self.planes)?;
        // From one cell into the next, or in one.
        let crosses = l.gt_i(behind.crossing.cell, before.crossing.cell);
        let [from, to] = [l.sub(here[1], here[0]), l.sub(there[1], there[0])];
        let first = l.select(crosses, l.sub(there[0], ahead), to);
        let last = l.select(crosses, l.sub(after, here[1]), from);
        let twist = l.max(l.abs(l.sub(first, from)), l.abs(l.sub(to, last)));
        Some(l.select(self.live, twist, l.splat(0.0)))
    }
}

/// Into how many parts, no more than 2 to the power of `most`, planes cut their ways so that each part of a cell is
/// twisted by no more than what is `allowed`, in metres.
#[inline(always)]
pub(in crate::planes) fn parts<L: Lanes>(
    l: L,
    field: &Field<'_>,
    stretches: [Stretch<L>; 2],
    allowed: f32,
    most: u32,
) -> i32 {
    let [left, right] = &stretches;
    let (Some(left), Some(right)) = (left.twist(l, field), right.twist(l, field)) else {
        return 1;
    };
    let twist = l.max(left, right);
    // Each half of a part has a quarter of its twist.
    let mut parts = 1;
    let mut allowed = allowed.max(f32::MIN_POSITIVE);
    while parts < 1 << most && l.bits(l.lt(l.splat(allowed), twist)) != 0 {
        parts *= 2;
        allowed *= 4.0;
    }
    parts
}
