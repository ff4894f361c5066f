//! From which ray before it a ray may begin.

use super::March;
use super::directions::Directions;
use super::scratch::{FARTHEST, MARGIN, MEMORY, Scratch};
use crate::lanes::Lanes;

/// From which ray each of a group begins.
#[derive(Clone, Copy)]
pub(super) struct Predecessor {
    /// Steps back.
    pub(super) steps: usize,
    /// Lanes aside.
    pub(super) lanes: i32,
    /// By how many metres for each 1 of t the group's rays are higher, about.
    pub(super) rise: f64,
}

impl<L: Lanes> March<'_, L> {
    /// Towards the vanishing point: lanes aside for each step back, as an affine function of the
    /// lane.
    #[inline(always)]
    pub(super) fn towards(&self, step: u32) -> [f64; 2] {
        let [along, across, w] = self.vertical;
        let back = (f64::from(step) * w - along).abs();
        [across / back, -w / back]
    }

    /// The nearest ray before a group's from which it may begin: one so much lower that ground
    /// that is not steeper than `steepest` cannot come between them. What that ray passed over is
    /// passed over by the group's rays then.
    #[inline(always)]
    pub(super) fn predecessor(
        &self,
        step: u32,
        slope: [f64; 2],
        [first, last]: [i32; 2],
        steepest: f64,
        most: usize,
    ) -> Option<Predecessor> {
        let ends = [
            self.directions.at(step, first),
            self.directions.at(step, last),
        ];
        let slope = slope[0] + 0.5 * f64::from(first + last) * slope[1];
        let Directions {
            step: u, lane: v, ..
        } = self.directions;
        for steps in 1..=most.min(step as usize) {
            let lanes = (slope * steps as f64).round();
            let to = lanes * v - steps as f64 * u;
            let mut rise = f64::INFINITY;
            // Right beside the vanishing point lines may run along steps.
            let mut sound = lanes.abs() <= FARTHEST;
            for end in ends {
                let higher = end.z * to.x - to.z * end.x;
                let aside = end.y * to.x - to.y * end.x;
                // Rays that enter the ground from its side must do so no earlier.
                let enters_later = self.bounds[1][0] <= 0.0 || aside <= 0.0;
                sound &=
                    higher >= 1.001 * steepest * aside.abs() && enters_later && end.x + to.x > 0.0;
                rise = rise.min(higher / (end.x * (end.x + to.x)));
            }
            if sound {
                return Some(Predecessor {
                    steps,
                    lanes: lanes as i32,
                    rise,
                });
            }
        }
        None
    }

    /// How steep the ground is at most where the last step's rays came to, in the resolution that
    /// suits rays there.
    ///
    /// What is nearer and finer may be steeper, and come between a ray and its predecessor by less
    /// than a pixel: where detail is chosen, that is too small to count.
    #[inline(always)]
    pub(super) fn steepest_near(
        &self,
        scratch: &Scratch,
        step: u32,
        ends: [i32; 2],
        across: f32,
    ) -> f64 {
        let before = step.wrapping_sub(1);
        // A step may have lanes that the one before has not: there lies what is left of others.
        let [from, to] = scratch.lanes[before as usize % MEMORY];
        if from >= to {
            return self.steepest[0];
        }
        let before = self.slot(before) + MARGIN;
        let reached = |lane: i32| scratch.reached[before + lane.clamp(from, to - 1) as usize].abs();
        let [first, last] = [reached(ends[0]), reached(ends[1])];
        let d = self.directions.at(step, ends[0]);
        let width = across / (d.x * d.x + d.y * d.y).sqrt() as f32 / d.x as f32;
        let covered = (first.min(last) * width).max(1.0);
        let coarsest = self.steepest.len() - 1;
        let level = (covered.to_bits() >> 23) as usize - 127;
        self.steepest[level.min(coarsest)]
    }
}
