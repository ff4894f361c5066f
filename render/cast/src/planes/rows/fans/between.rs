//! Pixels' hits, between those of the planes beside them.

use super::super::March;
use super::super::directions::{Aim, Aimed};
use super::super::scratch::{MARGIN, Scratch};
use super::fan::Fan;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group, group_mut};
use crate::tally::Tally;

/// How many pixels wide apart two hits may lie along the ground that are taken for one piece of it.
const SAME: f32 = 5.0;

/// How far from either plane, as a part of the way between the two, a pixel has at least to lie to
/// have the colours of both where these see other ground.
const PARTED: f32 = 0.2;

impl<L: Lanes> March<'_, L> {
    /// Finds how far a step's rays reach from how far its planes' do. Where these see one piece of
    /// ground a pixel's lies between; else it is that of the nearer plane in the image.
    #[inline(always)]
    pub(super) fn between<T: Tally>(
        &self,
        fan: &Fan,
        step: u32,
        hits: &[f32],
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
        tally: &mut T,
    ) {
        let l = self.l;
        let aim = Aim::new(l, self.frame, self.directions.lane);
        let room = fan.room();
        let hits = &hits[(step - fan.from) as usize * room..][..room];
        let numbers = l.load(&std::array::from_fn(|k| k as f32));
        let lanes = fan.lanes(step);
        let aside = l.mul(numbers, l.splat(fan.planes_to_lane(step) as f32));
        let pixel = self.pixel_width(step, 0.5 * f64::from(lanes[0] + lanes[1]));
        let same = l.splat(1.0 + SAME * pixel as f32);
        let zero = l.splat(0.0);
        let one = l.splat_i(1);
        for first in (lanes[0]..lanes[1]).step_by(LANES) {
            let at = self.slot(step) + MARGIN + first as usize;
            let pixels = [first, lanes[1].min(first + LANES as i32)];
            scratch
                .pixels
                .prefetch(l, canvas, self.sector, step, pixels);
            let Aimed { advance, slope, .. } = aim.at(l, self.directions.at(step, first));
            l.store(advance, group_mut(&mut scratch.advance, at));
            l.store(slope, group_mut(&mut scratch.slope, at));
            let plane = fan.plane(step, f64::from(first));
            let base = (plane as usize).saturating_sub(1);
            let planes = [group(hits, base), group(hits, base + LANES)].map(|hits| l.load(hits));
            let plane = l.add(l.splat((plane - base as f64) as f32), aside);
            let before = l.to_int(plane);
            let share = l.sub(plane, l.to_float(before));
            let left = l.among(planes, before);
            let right = l.among(planes, l.add_i(before, one));
            let is_one = are_one(l, same, left, right);
            let mut beyond = l.splat(0.0);
            let mut reached = l.add(left, l.mul(l.sub(right, left), share));
            if l.bits(is_one) != u16::MAX {
                // What the nearer plane sees goes on as it does on that plane's other side.
                let beyond_left = l.among(planes, l.sub_i(before, one));
                let beyond_right = l.among(planes, l.add_i(before, l.splat_i(2)));
                let rest = l.sub(l.splat(1.0), share);
                let from_left = l.add(left, l.mul(l.sub(left, beyond_left), share));
                let from_right = l.add(right, l.mul(l.sub(right, beyond_right), rest));
                let from_left = l.select(are_one(l, same, beyond_left, left), from_left, left);
                let from_right = l.select(are_one(l, same, right, beyond_right), from_right, right);
                let is_left = l.lt(share, l.splat(0.5));
                let nearer = l.select(is_left, from_left, from_right);
                let other = l.select(is_left, from_right, from_left);
                // An edge of ground lies between the planes, on average in the midst.
                let parted = l.and(
                    l.and(l.lt(zero, nearer), l.lt(zero, other)),
                    l.and(l.lt(l.splat(PARTED), share), l.lt(l.splat(PARTED), rest)),
                );
                beyond = l.select(l.and_not(parted, is_one), other, beyond);
                reached = l.select(is_one, reached, nearer);
            }
            l.store(reached, group_mut(&mut scratch.reached, at));
            l.store(beyond, group_mut(&mut scratch.beyond, at));
            for _ in pixels[0]..pixels[1] {
                tally.ray();
            }
        }
    }
}

/// Which hits of neighbouring planes are one piece of ground's: the farther one's t is less than
/// `same` times the other's.
#[inline(always)]
fn are_one<L: Lanes>(l: L, same: L::F, a: L::F, b: L::F) -> L::M {
    let nearer = l.min(a, b);
    let farther = l.max(a, b);
    l.and(
        l.le(l.splat(0.0), nearer),
        l.le(farther, l.mul(nearer, same)),
    )
}
