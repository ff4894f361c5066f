//! Pixels between planes.

use super::super::March;
use super::super::directions::Aim;
use super::super::scratch::{MARGIN, Scratch};
use super::corners::Corner;
use super::fan::Fan;
use super::march::PLANES;
use super::sight::SAME;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group, group_mut};
use crate::planes::profile::{halves, parts, twice, upper_bytes};
use crate::planes::shade::{Shader, sky_colours};

impl<L: Lanes> March<'_, L> {
    /// Gives a step's pixels what lies between what their planes see: a mean of colours, and how far
    /// they reach; where planes see different pieces of ground, as far as the nearer plane in the
    /// image.
    #[inline(always)]
    pub(super) fn between(
        &self,
        fan: &Fan,
        step: u32,
        shader: &Shader<'_>,
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
    ) {
        let [from, to] = fan.lanes(step);
        let is_seen = |corner: &Corner| corner.is_among(from, to - from);
        let corners = self.corners(fan, step).map(|corner| corner.filter(is_seen));
        self.pixels::<false>(fan, step, &corners, shader, canvas, scratch);
        if corners.iter().any(Option::is_some) {
            // Apart, as it is seldom asked for.
            self.l.vectorize(
                #[inline(always)]
                || self.pixels::<true>(fan, step, &corners, shader, canvas, scratch),
            );
        }
    }

    /// The pixels of the groups in which the ground ends at one of the `corners` if `CUT`, else the others.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "what `between` has")]
    fn pixels<const CUT: bool>(
        &self,
        fan: &Fan,
        step: u32,
        corners: &[Option<Corner>; 2],
        shader: &Shader<'_>,
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
    ) {
        let l = self.l;
        let aim = Aim::new(l, self.frame, self.directions.lane);
        let asked = scratch.pixels.asked(canvas, self.sector, step);
        let room = fan.room();
        let seen = &scratch.seen[(step - fan.from) as usize * room..][..room];
        let seen: &[i32] = bytemuck::cast_slice(seen);
        let numbers = l.load(&std::array::from_fn(|k| k as f32));
        let lanes = fan.lanes(step);
        let aside = l.mul(numbers, l.splat(fan.planes_to_lane(step) as f32));
        let pixel = self.pixel_width(step, 0.5 * f64::from(lanes[0] + lanes[1]));
        let same = l.splat(1.0 + SAME * pixel as f32);
        let planes = fan.planes_of(step);
        // The next fan goes on from where this one's last rays came.
        let is_last = step + 1 == fan.to;
        let zero = l.splat(0.0);
        for first in (lanes[0]..lanes[1]).step_by(LANES) {
            let corners =
                corners.map(|corner| corner.filter(|corner| corner.is_among(first, LANES as i32)));
            if corners.iter().any(Option::is_some) != CUT {
                continue;
            }
            asked.prefetch(l, canvas, first);
            let direction = aim.directions(l, self.directions.at(step, first).as_vec3());
            let length = shader.metres_of(l, direction);
            let plane = fan.plane(step, f64::from(first));
            let base = if CUT {
                let asked = corners.iter().flatten();
                asked.fold(plane, |first, corner| corner.first_asked(first)) as usize
            } else {
                plane as usize
            };
            let groups = base / PLANES..=(base + 2 * LANES - 1) / PLANES;
            let skies = groups.map(|group| scratch.skies.get(group));
            let (mut ground, inverse) = if skies.flatten().all(|&from| from <= step) {
                ([l.splat_i(0); 2], zero)
            } else {
                let plane = planes_asked(
                    l,
                    l.splat((plane - base as f64) as f32),
                    aside,
                    planes.end - base,
                );
                let seen = &seen[2 * base..];
                if CUT {
                    cut(l, seen, base, plane, same, &corners)
                } else {
                    mixed(l, seen, plane, same)
                }
            };
            let hit = l.lt(zero, inverse);
            if is_last {
                let at = self.slot(step) + MARGIN + first as usize;
                let t = l.select(hit, l.div(direction[0], inverse), l.splat(-1.0));
                l.store(t, group_mut(&mut scratch.reached, at));
            }
            let mut depth = l.select(hit, l.div(length, inverse), l.splat(f32::INFINITY));
            if CUT {
                // Not before: ground may be narrower than a pixel here, and wider in the next fan.
                let plane = l.add(l.splat((plane - base as f64) as f32), aside);
                let inside = all_inside(l, base, plane, &corners);
                depth = l.select(inside, depth, l.splat(f32::INFINITY));
            }
            // In the upper half of the second one.
            let alpha = l.shr_i(ground[1], l.splat_i(16));
            if l.bits(l.gt_i(l.splat_i(255), alpha)) != 0 {
                let sky = halves(l, sky_colours(l, l.div(direction[2], length)));
                let rest = l.sub_i(l.splat_i(256), l.add_i(alpha, l.shr_i(alpha, l.splat_i(7))));
                let rest = twice(l, rest);
                let light = [l.mul_halves(sky[0], rest), l.mul_halves(sky[1], rest)];
                ground = [
                    l.add_i(ground[0], upper_bytes(l, light[0])),
                    l.add_i(ground[1], upper_bytes(l, light[1])),
                ];
            }
            let colour = l.add_i(ground[0], l.shl_i(ground[1], l.splat_i(8)));
            let (to_colours, to_depths) = scratch.pixels.lanes_mut(step, first);
            l.store_i(colour, group_mut(to_colours, 0));
            l.store(depth, group_mut(to_depths, 0));
        }
    }
}

/// On which of `count` planes pixels lie, from the first one's and how far they are from it: however that is rounded,
/// before the last plane, as what lies beyond it is left of other casts.
#[inline(always)]
fn planes_asked<L: Lanes>(l: L, first: L::F, aside: L::F, count: usize) -> L::F {
    let last = (count - 1) as f32;
    l.min(l.add(first, aside), l.splat(last.next_down()))
}

/// What lies between planes, as `mixed` has it.
type Mixed<L> = ([<L as Lanes>::I; 2], <L as Lanes>::F);

/// As `mixed`, where the ground ends at `corners`; places are counted from plane `base` on. Pixels beside the ground
/// reach as far as what is next to them.
#[inline(always)]
fn cut<L: Lanes>(
    l: L,
    seen: &[i32],
    base: usize,
    plane: L::F,
    same: L::F,
    corners: &[Option<Corner>; 2],
) -> Mixed<L> {
    let (mut at, mut covered) = (plane, l.splat(1.0));
    for corner in corners.iter().flatten() {
        at = corner.asked(l, base, at);
        covered = l.min(covered, corner.covered(l, base, plane));
    }
    let (light, inverse) = mixed(l, seen, at, same);
    let covered = parts(l, covered);
    let none = l.splat_i(0);
    let light = light.map(|light| l.lerp_halves(none, light, covered));
    (light, inverse)
}

/// Which pixels have ground in their middle.
#[inline(always)]
fn all_inside<L: Lanes>(l: L, base: usize, plane: L::F, corners: &[Option<Corner>; 2]) -> L::M {
    let half = l.splat(0.5);
    let mut inside = l.mask(u16::MAX);
    for corner in corners.iter().flatten() {
        inside = l.and(inside, l.le(half, corner.covered(l, base, plane)));
    }
    inside
}

/// What lies between planes at the places `plane` among those of which `seen` is what they see in a
/// step: the light of the ground, as halves, and one over how far it is away, in lengths of the
/// direction. Ground that lies no more than `same` times as far away as other is taken for the same.
#[inline(always)]
fn mixed<L: Lanes>(l: L, seen: &[i32], plane: L::F, same: L::F) -> Mixed<L> {
    let load = |number: usize| l.load_i(group(seen, number * LANES));
    let (low, high) = ([load(0), load(1)], [load(2), load(3)]);
    let evens = l.load_i(&std::array::from_fn(|k| 2 * k as i32));
    let odds = l.add_i(evens, l.splat_i(1));
    let colours = [l.among(low, evens), l.among(high, evens)];
    let inverses = [l.among(low, odds), l.among(high, odds)];
    let before = l.to_int(plane);
    let behind = l.add_i(before, l.splat_i(1));
    let share = l.sub(plane, l.to_float(before));
    let left = l.float_of_bits(l.among(inverses, before));
    let right = l.float_of_bits(l.among(inverses, behind));
    let is_one = l.and(
        l.lt(l.splat(0.0), l.min(left, right)),
        l.le(l.max(left, right), l.mul(l.min(left, right), same)),
    );
    let nearer = l.select(l.lt(share, l.splat(0.5)), left, right);
    let inverse = l.select(
        is_one,
        l.add(left, l.mul(l.sub(right, left), share)),
        nearer,
    );
    let left = halves(l, l.among(colours, before));
    let right = halves(l, l.among(colours, behind));
    let share = parts(l, share);
    let light = [
        l.lerp_halves(left[0], right[0], share),
        l.lerp_halves(left[1], right[1], share),
    ];
    (light, inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;

    #[test]
    fn pixels_lie_before_the_last_plane_however_they_are_rounded() {
        let l = Portable;
        for count in 2..=2 * LANES {
            let last = (count - 1) as f32;
            for farthest in [last.next_down(), last, last.next_up()] {
                let mut aside = std::array::from_fn(|k| k as f32 / LANES as f32 * last);
                aside[LANES - 1] = farthest;
                let planes = planes_asked(l, l.splat(0.0), l.load(&aside), count);
                assert_eq!(planes[..LANES - 1], aside[..LANES - 1], "{count} planes");
                assert!(planes[LANES - 1] < last, "{count} planes, {farthest}");
            }
        }
    }
}
