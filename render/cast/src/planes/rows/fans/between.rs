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
use crate::tally::Tally;

impl<L: Lanes> March<'_, L> {
    /// Gives a step's pixels what lies between what their planes see: a mean of colours, and how far
    /// they reach; where planes see different pieces of ground, as far as the nearer plane in the
    /// image.
    #[inline(always)]
    pub(super) fn between<T: Tally>(
        &self,
        fan: &Fan,
        step: u32,
        shader: &Shader<'_>,
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
        tally: &mut T,
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
        // The next fan goes on from where this one's last rays came: those beside a corner, too, as ground may be
        // narrower than a pixel here.
        let is_last = step + 1 == fan.to;
        let zero = l.splat(0.0);
        let corners = self.corners(fan, step);
        for first in (lanes[0]..lanes[1]).step_by(LANES) {
            asked.prefetch(l, canvas, first);
            let direction = aim.directions(l, self.directions.at(step, first));
            let length = shader.metres_of(l, direction);
            let plane = fan.plane(step, f64::from(first));
            let last = plane + LANES as f64 * fan.planes_to_lane(step);
            let corners = corners.map(|corner| corner.filter(|at| at.is_between(plane, last)));
            let asked = corners.iter().flatten();
            let base = asked.fold(plane, |first, corner| corner.first_asked(first)) as usize;
            let groups = base / PLANES..=(base + 2 * LANES - 1) / PLANES;
            let skies = groups.map(|group| scratch.skies.get(group));
            let mut is_inside = l.mask(u16::MAX);
            let (mut ground, inverse) = if skies.flatten().all(|&from| from <= step) {
                ([l.splat_i(0); 2], zero)
            } else {
                let plane = l.add(l.splat((plane - base as f64) as f32), aside);
                if corners.iter().any(Option::is_some) {
                    // Apart, and made for the instruction set: it is seldom asked for. It gets copies, as what it
                    // might reach would have to lie in memory, all of the time.
                    let seen = &seen[2 * base..];
                    let cut = l.vectorize(
                        #[inline(always)]
                        move || cut(l, seen, base, plane, same, corners),
                    );
                    is_inside = cut.1;
                    cut.0
                } else {
                    mixed(l, &seen[2 * base..], plane, same)
                }
            };
            let hit = l.lt(zero, inverse);
            if is_last {
                let at = self.slot(step) + MARGIN + first as usize;
                let t = l.select(hit, l.div(direction[0], inverse), l.splat(-1.0));
                l.store(t, group_mut(&mut scratch.reached, at));
            }
            let hit = l.and(hit, is_inside);
            let depth = l.select(hit, l.div(length, inverse), l.splat(f32::INFINITY));
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
            for _ in first..lanes[1].min(first + LANES as i32) {
                tally.ray();
            }
        }
    }
}

/// What lies between planes, as `mixed` has it.
type Mixed<L> = ([<L as Lanes>::I; 2], <L as Lanes>::F);

/// As `mixed`, where the ground ends at `corners`, and which pixels have ground in their middle; places are counted
/// from plane `base` on.
#[inline(always)]
fn cut<L: Lanes>(
    l: L,
    seen: &[i32],
    base: usize,
    plane: L::F,
    same: L::F,
    corners: [Option<Corner>; 2],
) -> (Mixed<L>, L::M) {
    let (mut at, mut covered) = (plane, l.splat(1.0));
    let mut is_inside = l.mask(u16::MAX);
    for corner in corners.into_iter().flatten() {
        at = corner.asked(l, base, at);
        let (part, inside) = corner.covered(l, base, plane);
        covered = l.min(covered, part);
        is_inside = l.and(is_inside, inside);
    }
    let (light, inverse) = mixed(l, seen, at, same);
    let covered = parts(l, covered);
    let none = l.splat_i(0);
    let light = light.map(|light| l.lerp_halves(none, light, covered));
    ((light, inverse), is_inside)
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
