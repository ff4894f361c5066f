//! Which vertical planes see a range of a sector's steps.

use super::super::March;
use crate::lanes::{LANES, Lanes};
use crate::planes::sectors::Sector;
use std::ops::Range;

/// How much closer planes may lie in one of a fan's steps than in another.
const CLOSEST: f64 = 0.7;

/// How many lanes planes lie apart, in the mean of the steps in which they lie closest and farthest:
/// 0.77 to 1.1 of one then.
const APART: f64 = 0.92;

/// Vertical planes at equal distances, and the steps that they see: planes run together in the
/// vanishing point, so these are as many as leave the planes about a lane apart.
pub(super) struct Fan {
    pub(super) from: u32,
    pub(super) to: u32,
    /// Lanes aside for each step back from the last one on, of the plane at lane 0 there, and how
    /// many more of one a lane further.
    towards: [f64; 2],
    /// Where the first plane lies in the last step, and lanes from one to the next.
    first: f64,
    apart: f64,
    /// The lanes of the steps.
    lanes: Vec<[i32; 2]>,
    /// For each plane, the first step in which it is seen, and the one behind the last.
    seen: Vec<[u32; 2]>,
}

impl Fan {
    fn new(sector: &Sector, [from, to]: [u32; 2], towards: [f64; 2]) -> Self {
        let mut fan = Self {
            from,
            to,
            towards,
            first: 0.0,
            apart: 1.0,
            lanes: (from..to).map(|step| sector.lanes(step)).collect(),
            seen: Vec::new(),
        };
        let pixels = |(step, &[from, to]): (u32, &[i32; 2])| {
            (from < to).then(|| (step, [f64::from(from), f64::from(to - 1)]))
        };
        fan.apart = 1.0 / (fan.spacing(from).max(1.0) * CLOSEST.sqrt() / APART);
        let (mut least, mut most) = (f64::MAX, f64::MIN);
        for (step, [left, right]) in (from..to).zip(&fan.lanes).filter_map(pixels) {
            least = least.min(fan.plane(step, left));
            most = most.max(fan.plane(step, right));
        }
        if least > most {
            return fan;
        }
        // No pixel lies before the second plane, however numbers are rounded.
        fan.first = (least - 1.01) * fan.apart;
        fan.seen = vec![[to, from]; (most - least) as usize + 4];
        // Steps see one run of planes each, and the ends of these runs go one way and back at most.
        let mut before = 0..0;
        for step in fan.from..to {
            let planes = fan.planes_of(step);
            let come = [
                planes.start..planes.end.min(before.start),
                planes.start.max(before.end)..planes.end,
            ];
            for plane in come.into_iter().flatten() {
                fan.seen[plane][0] = fan.seen[plane][0].min(step);
            }
            let go = [
                before.start..before.end.min(planes.start),
                before.start.max(planes.end)..before.end,
            ];
            for plane in go.into_iter().flatten() {
                fan.seen[plane][1] = step;
            }
            before = planes;
        }
        for plane in before {
            fan.seen[plane][1] = to;
        }
        fan
    }

    /// How many lanes one of the last step's are in a step.
    fn spacing(&self, step: u32) -> f64 {
        1.0 + f64::from(self.to - 1 - step) * self.towards[1]
    }

    /// The lane of a step that lies on the plane at lane 0 of the last step.
    fn aside(&self, step: u32) -> f64 {
        f64::from(self.to - 1 - step) * self.towards[0]
    }

    /// The plane that a lane of a step lies on.
    pub(super) fn plane(&self, step: u32, lane: f64) -> f64 {
        ((lane - self.aside(step)) / self.spacing(step) - self.first) / self.apart
    }

    /// The lane of a step that lies on a plane.
    pub(super) fn lane(&self, step: u32, plane: usize) -> f64 {
        self.along(plane) * self.spacing(step) + self.aside(step)
    }

    /// Lanes aside for each step back along a plane.
    pub(super) fn back(&self, plane: usize) -> f64 {
        self.towards[0] + self.towards[1] * self.along(plane)
    }

    fn along(&self, plane: usize) -> f64 {
        self.first + self.apart * plane as f64
    }

    /// Planes from a lane of a step to the next.
    pub(super) fn planes_to_lane(&self, step: u32) -> f64 {
        1.0 / (self.spacing(step) * self.apart)
    }

    /// The lanes of a step, from the first to the one behind the last.
    pub(super) fn lanes(&self, step: u32) -> [i32; 2] {
        self.lanes[(step - self.from) as usize]
    }

    pub(super) fn planes(&self) -> usize {
        self.seen.len()
    }

    /// The planes between which a step's pixels lie.
    pub(super) fn planes_of(&self, step: u32) -> Range<usize> {
        let [from, to] = self.lanes(step);
        if from >= to {
            return 0..0;
        }
        let [first, last] = [from, to - 1].map(|lane| self.plane(step, f64::from(lane)) as usize);
        first..last + 2
    }

    /// The steps in which a plane is seen; none for one that there is not.
    pub(super) fn seen(&self, plane: usize) -> [u32; 2] {
        self.seen
            .get(plane)
            .copied()
            .unwrap_or([self.to, self.from])
    }

    /// Numbers for each step that has one of each plane, and is read a few groups at a time.
    pub(super) fn room(&self) -> usize {
        self.planes().next_multiple_of(LANES) + 2 * LANES
    }

    /// The step from which on planes, of which `first` is the first, all see the sky: after its first
    /// step, each sees ground in so many pixels. Clears what of the sky lies before.
    pub(super) fn clear_skies(
        &self,
        first: usize,
        ground: &[[i32; LANES]; 2],
        seen: &mut [[i32; 2]],
    ) -> u32 {
        let ground = ground.as_flattened();
        let sky = |k: usize| {
            let [begin, end] = self.seen(first + k);
            end.min(begin + ground[k] as u32)..end
        };
        let all_from = (0..ground.len()).map(|k| sky(k).start).max();
        let all_from = all_from.map_or(self.from, |step| step.max(self.from));
        for k in 0..ground.len() {
            for step in sky(k).start..sky(k).end.min(all_from) {
                seen[self.place(step, first + k)] = [0; 2];
            }
        }
        all_from
    }

    /// Where among what is seen a plane's pixel of a step is.
    pub(super) fn place(&self, step: u32, plane: usize) -> usize {
        (step - self.from) as usize * self.room() + plane
    }
}

impl<L: Lanes> March<'_, L> {
    /// The fan that sees the steps before `to`, as many as it may but not those before `begin`.
    pub(super) fn fan(&self, begin: u32, to: u32) -> Fan {
        let mut towards = self.towards(to - 1);
        let may_see = |step: u32| {
            let spacing = 1.0 + f64::from(to - 1 - step) * towards[1];
            (CLOSEST..=1.0 / CLOSEST).contains(&spacing)
        };
        let mut from = to - 1;
        while from > begin && may_see(from - 1) {
            from -= 1;
        }
        if from + 1 == to {
            // Where planes run together there is no telling where to; one step has no need of it.
            towards = [0.0; 2];
        }
        Fan::new(self.sector, [from, to], towards)
    }
}
