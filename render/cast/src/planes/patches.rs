//! The pieces of ground that rays met, for their neighbours: who knows a cell's surface need not
//! look for it.

use super::fall::Fall;
use super::field::Field;
use super::numbers::Numbers;
use super::rows::BLOCK;
use super::strips::{Line, Way};
use super::wave::Column;
use crate::lanes::{LANES, Lanes, group, group_mut, groups};

/// The mirrored cell from which on, along either axis, a cell's two numbers do not fit into one.
const MOST_CELLS: i32 = (1 << 15) - 1;

/// No cell.
const NONE: i32 = -1;

/// The ground in a mirrored cell of each of sixteen rays.
pub(super) struct Patch<L: Lanes> {
    /// The cell's numbers along the major axis and (the lower half) along the minor one, or
    /// [`NONE`].
    pub(super) cell: L::I,
    /// Metres over the eye of the corner that is far along both axes; and by how much higher those
    /// corners are that are far along the minor axis only, and along the major one only.
    pub(super) corner: L::F,
    pub(super) by_minor: L::F,
    pub(super) by_major: L::F,
    /// By how much the nearest corner is higher than those three tell.
    pub(super) twist: L::F,
}

impl<L: Lanes> Patch<L> {
    #[inline(always)]
    pub(super) fn bits(&self, l: L) -> [L::I; NUMBERS] {
        [
            self.cell,
            l.bits_of_float(self.corner),
            l.bits_of_float(self.by_minor),
            l.bits_of_float(self.by_major),
            l.bits_of_float(self.twist),
        ]
    }
}

/// A cell's two numbers in one.
#[inline(always)]
pub(super) fn packed<L: Lanes>(l: L, [major, minor]: [L::I; 2]) -> L::I {
    l.add_i(l.shl_i(major, l.splat_i(16)), minor)
}

/// What the last rays met that came along, a place for each lane of a step.
///
/// Places drift from step to step as lines through the vanishing point do in the middle of the sector,
/// so that a ray finds at its own place what one met that went below it, or hardly aside. That one may
/// be long gone: what it met is true ground all the same, as a cell's name and surface are kept together.
#[derive(Default)]
pub(super) struct Patches {
    /// The bits of a [`Patch`]'s numbers, one after the other.
    bits: Numbers<i32>,
    /// How far they lie apart: not by whole pages, so that they do not fight for the same lines of the
    /// processor's cache.
    apart: usize,
    /// Lanes from a step to the next, and where the first step's lane 0 has its place.
    drift: f64,
    first: f64,
    /// What is left of the number that a ray has among all that are kept of steps, for its lane; and
    /// where lane 0 has its place in this step.
    lane_bits: i32,
    offset: i32,
}

/// How many numbers a [`Patch`] has.
pub(super) const NUMBERS: usize = 5;

impl Patches {
    /// Whether cells of the ground can be named.
    pub(super) fn can_name(field: &Field<'_>) -> bool {
        let fits = |cells: [i32; 2]| cells[1] < MOST_CELLS;
        fits(field.major.cells) && fits(field.minor.cells)
    }

    /// Makes ready for a sector of so many steps, of which each has `room` numbers (a power of two), in
    /// whose middle lines through the vanishing point come from so many lanes aside.
    pub(super) fn begin(&mut self, room: usize, steps: u32, aside: f64) {
        // Not far, even where the middle is the vanishing point itself.
        self.drift = aside.clamp(-4.0, 4.0);
        let way = self.drift * f64::from(steps);
        self.first = (-way).max(0.0).ceil();
        self.lane_bits = room as i32 - 1;
        self.apart = room + way.abs() as usize + BLOCK + 11 * LANES;
        self.bits.grow(NUMBERS * self.apart);
        self.set_step(0);
    }

    /// Goes on to a step.
    pub(super) fn set_step(&mut self, step: u32) {
        self.offset = (self.first + self.drift * f64::from(step)).round() as i32;
    }

    /// Forgets all.
    pub(super) fn forget(&mut self) {
        self.bits[..self.apart].fill(NONE);
    }

    /// The place of the ray of this step that has a number among all that are kept of steps.
    #[inline(always)]
    fn place(&self, number: usize) -> usize {
        (number as i32 & self.lane_bits) as usize + self.offset as usize
    }

    /// Those of so many groups of neighbours that begin at a ray with a number.
    #[inline(always)]
    pub(super) fn groups(&self, number: usize, count: usize) -> Groups<'_> {
        let at = self.place(number);
        let of = |number: usize| groups(&self.bits[number * self.apart + at..], count);
        Groups(std::array::from_fn(of))
    }

    /// Writes what a group's rays met that begins at a ray with a number.
    #[inline(always)]
    pub(super) fn store<L: Lanes>(&mut self, l: L, number: usize, patch: &Patch<L>) {
        let at = self.place(number);
        for (number, bits) in patch.bits(l).into_iter().enumerate() {
            l.store_i(bits, group_mut(&mut self.bits, number * self.apart + at));
        }
    }

    /// Leaves only those of a group's cells in the lanes of `mask`.
    #[inline(always)]
    pub(super) fn keep_cells<L: Lanes>(&mut self, l: L, number: usize, mask: L::M) {
        let at = self.place(number);
        let cells = group_mut(&mut self.bits, at);
        l.store_i(l.select_i(mask, l.load_i(cells), l.splat_i(NONE)), cells);
    }

    /// The places of the rays of `mask` by their numbers; of others, one that no ray has.
    ///
    /// Rays of earlier steps, who are a little late, get the places of this step's.
    #[inline(always)]
    pub(super) fn places<L: Lanes>(&self, l: L, mask: L::M, numbers: L::I) -> L::I {
        let lanes = l.and_i(numbers, l.splat_i(self.lane_bits));
        let places = l.add_i(lanes, l.splat_i(self.offset));
        l.select_i(mask, places, l.splat_i(self.apart as i32 - 1))
    }

    /// Writes what sixteen rays met to their places.
    ///
    /// One by one: a processor's own scattering takes longer.
    #[inline(always)]
    pub(super) fn scatter(&mut self, places: &[i32], patches: &[Column<i32>; NUMBERS], at: usize) {
        let none = self.apart - 1;
        let mut to = self.bits.chunks_exact_mut(self.apart);
        let mut next = || to.next().expect("there are all numbers");
        let mut to = [next(), next(), next(), next(), next()];
        let places: &[i32; LANES] = group(places, at);
        for (lane, &place) in places.iter().enumerate() {
            let place = (place as u32 as usize).min(none);
            for (to, numbers) in to.iter_mut().zip(patches) {
                to[place] = numbers[at + lane];
            }
        }
    }
}

/// What groups of neighbours met.
pub(super) struct Groups<'a>([&'a [[i32; LANES]]; NUMBERS]);

impl Groups<'_> {
    /// That of a group.
    #[inline(always)]
    pub(super) fn load<L: Lanes>(&self, l: L, group: usize) -> Patch<L> {
        let bits = |number: usize| l.load_i(&self.0[number][group]);
        Patch {
            cell: bits(0),
            corner: l.float_of_bits(bits(1)),
            by_minor: l.float_of_bits(bits(2)),
            by_major: l.float_of_bits(bits(3)),
            twist: l.float_of_bits(bits(4)),
        }
    }
}

/// How rays come through a cell whose ground is known.
pub(super) struct Path<L: Lanes> {
    /// Those that are in it at all.
    pub(super) is_in: L::M,
    /// How far the line behind it lies along the axis that it crosses; negative along the minor one.
    pub(super) line: L::F,
    /// The clearance where they are, in metres: below 0 in the ground.
    pub(super) over: L::F,
    /// How far the lines behind it lie.
    to_major: L::F,
    to_minor: L::F,
    /// What is left of the cell.
    major_left: L::F,
    minor_left: L::F,
    /// The clearance further on.
    fall: Fall<L>,
}

impl<L: Lanes> Path<L> {
    /// Where the lines behind cell 0 lie along the major and the minor axis.
    #[inline(always)]
    pub(super) fn lines(l: L, field: &Field<'_>) -> [L::F; 2] {
        [field.major, field.minor].map(
            #[inline(always)]
            |axis| l.splat(1.0 - axis.fraction),
        )
    }

    /// That of rays at t; `lines` as [`Path::lines`] has them.
    #[inline(always)]
    pub(super) fn new(
        l: L,
        lines: [L::F; 2],
        [advance, slope]: [L::F; 2],
        t: L::F,
        patch: &Patch<L>,
    ) -> Self {
        let zero = l.splat(0.0);
        let major = l.shr_i(patch.cell, l.splat_i(16));
        let minor = l.and_i(patch.cell, l.splat_i(0x7fff));
        let to_major = l.add(l.to_float(major), lines[0]);
        let to_minor = l.add(l.to_float(minor), lines[1]);
        let major_left = l.sub(to_major, t);
        let minor_left = l.sub(to_minor, l.mul(t, advance));
        let is_in = l.are_shares(major_left, minor_left);
        // How the ground falls along the minor axis here, and along the major one.
        let falls_minor = l.add(patch.by_major, l.mul(patch.twist, major_left));
        let falls_major = l.add(patch.by_minor, l.mul(patch.twist, minor_left));
        let height = l.add(
            l.mul(patch.by_minor, major_left),
            l.mul(minor_left, falls_minor),
        );
        let over = l.sub(l.sub(l.mul(t, slope), patch.corner), height);
        let falls = l.add(falls_major, l.mul(advance, falls_minor));
        let half_rate = l.mul(l.add(slope, falls), l.splat(0.5));
        let bend = l.mul(patch.twist, advance);
        let crosses_major = l.lt(l.mul(major_left, advance), minor_left);
        Self {
            is_in,
            line: l.select(crosses_major, to_major, l.sub(zero, to_minor)),
            over,
            to_major,
            to_minor,
            major_left,
            minor_left,
            fall: Fall {
                // One that is below the ground has only just come down.
                here: l.max(over, zero),
                half_rate,
                bend,
            },
        }
    }

    /// Where rays of `mask`, which are at t and clear so far, end in the cell; or, where they do not, the line behind it
    /// on which they go on. Of others, what is given. And which rays do not end here.
    #[inline(always)]
    pub(super) fn tell(
        &self,
        l: L,
        mask: L::M,
        advance: L::F,
        t: L::F,
        others: L::F,
    ) -> (L::F, u16) {
        let (hit, further) = self.find(l, advance);
        let hit = l.and(mask, hit);
        let from = l.select(mask, self.line, others);
        (l.select(hit, l.add(t, further), from), !l.bits(hit))
    }

    /// Which rays meet the ground in the cell, and how much further on, if they are clear here: as
    /// [`meet`](super::walk::meet) finds it.
    #[inline(always)]
    fn find(&self, l: L, advance: L::F) -> (L::M, L::F) {
        // A ray that is clear here, and whose clearance does not come down to 0 in the cell, is clear up to its end.
        let further = self.fall.first_zero(l);
        let in_major = l.le(further, self.major_left);
        let in_minor = l.le(l.mul(further, advance), self.minor_left);
        (l.and(in_major, in_minor), further)
    }

    /// Beside which rays, on their way through the cell from t on, ground inside their narrow strips rises over them: as
    /// [`Strips::rises`](super::strips::Strips::rises) finds it. `slants` and `width` as a [`Way`] has them.
    #[inline(always)]
    pub(super) fn rises_beside(
        &self,
        l: L,
        slants: [L::F; 3],
        t: L::F,
        width: f32,
        patch: &Patch<L>,
    ) -> L::M {
        let [_, inverse, _] = slants;
        let next = l.min(self.to_major, l.mul(self.to_minor, inverse));
        let way = Way {
            slants,
            ends: [t, l.max(next, t)],
            to_major: self.to_major,
            width,
        };
        let away = l.sub(self.to_minor, l.splat(1.0));
        l.and(
            self.is_in,
            way.passes_under(l, &Line::before(l, patch, away)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;
    use crate::planes::field::Axis;
    use crate::planes::frame::Level;
    use crate::planes::roofs::Roofs;
    use crate::planes::steepness::Steepness;
    use crate::planes::strips::{NARROW, StripWidths, Strips};
    use crate::planes::walk::{Passage, cross, fetch, meet, place};
    use crate::planes::wave::{CAPACITY, Ray};
    use glam::DVec2;
    use sandtable_terrain::Ground;

    /// Through cells of rough ground, with known patches and as all rays go; and what rises beside them.
    #[test]
    fn patches_tell_what_their_cells_do() {
        let l = Portable;
        let rough = |col: u32, row: u32| ((3 * col * col + 5 * row * col + 11 * row) % 13) as f32;
        let ground = Ground::from_fn(200, 200, DVec2::ONE, rough).expect("a sound grid");
        let roofs = Roofs::new(ground.heights());
        let steepness = Steepness::new(ground.heights());
        let level = Level::new(ground.heights(), &roofs, &steepness);
        let mut passage = Box::new(Passage::default());
        let (mut hits, mut passes, mut bends, mut rises) = (0, 0, 0, 0);
        for k in 0..20_000_u32 {
            let share = |by: f64| (f64::from(k) * by).fract();
            let sign = |by: f64| if share(by) < 0.5 { 1 } else { -1 };
            let axes = [(0.618_034, 0.123), (0.414_213_6, 0.377)]
                .map(|(by, turn)| Axis::new(100.0 + share(by), 199, sign(turn)));
            let mut field = Field::of_level(&level, axes, (k % 2) as usize);
            let cell = [
                1 + (share(0.173) * 90.0) as i32,
                (share(0.719) * 90.0) as i32,
            ];
            let inside = [share(0.551), share(0.853)].map(|share| share as f32);
            let [major, minor] = [0, 1].map(|n| axes[n].line(cell[n]) + inside[n]);
            if minor < 0.0 || minor > major || major <= 0.0 {
                continue;
            }
            let (advance, mut slope) = (minor / major, -3.0 + 5.0 * share(0.237) as f32);
            let t = l.splat(major);
            let ray = |slope: f32| Ray {
                advance: l.splat(advance),
                inverse: l.splat(1.0 / advance),
                slope: l.splat(slope),
                leave: l.splat(1e4),
                id: l.splat_i(0),
            };
            let cells = cell.map(|cell| l.splat_i(cell));
            place(l, &field, l.mask(u16::MAX), cells, &mut passage, 0);
            let posts = fetch(l, &field, &passage, 0);
            // Seen from far above, so that no ray is below the ground.
            let fall = |field: &mut Field<'_>, slope: f32| {
                field.eye_height += 1024.0;
                let ray = ray(slope);
                let (_, patch) = cross(l, field, &ray, t, cells, posts);
                let path = Path::new(
                    l,
                    Path::lines(l, field),
                    [ray.advance, ray.slope],
                    t,
                    &patch,
                );
                field.eye_height -= 1024.0;
                [path.fall.here[0] - 1024.0, 2.0 * path.fall.half_rate[0]]
            };
            // Half of the rays run almost along the ground; all are a little over it here.
            let mut height = 0.5 * share(0.911) as f32;
            if k % 4 < 2 {
                slope -= fall(&mut field, slope)[1] + 6.0 * share(0.367) as f32;
                height *= 0.2;
            }
            field.eye_height += height - fall(&mut field, slope)[0];
            let ray = ray(slope);
            let (crossing, patch) = cross(l, &field, &ray, t, cells, posts);
            let met = meet(l, t, &crossing);
            let path = Path::new(
                l,
                Path::lines(l, &field),
                [ray.advance, ray.slope],
                t,
                &patch,
            );
            assert!(l.bits(path.is_in) & 1 == 1, "{cell:?} at {major}");
            let width = (share(0.319) / f64::from(major.max(1.0))) as f32;
            let strips = Strips {
                widths: StripWidths {
                    by_t: width,
                    most: NARROW,
                },
                clear: &mut [],
            };
            let one = l.mask(1);
            let expected = strips.rises(l, &field, one, &ray, t, cells, &crossing, &patch);
            let slants = [ray.advance, ray.inverse, ray.slope];
            let found = l.and(one, path.rises_beside(l, slants, t, width, &patch));
            assert_eq!(l.bits(found), l.bits(expected), "{k}");
            rises += l.bits(expected);
            let (hit, further) = path.find(l, ray.advance);
            let (hit, hits_here) = (l.bits(hit) & 1 == 1, l.bits(met.hit) & 1 == 1);
            if hit != hits_here {
                // Just at the line behind the cell, or where a ray touches the ground.
                let grazes =
                    crossing.clearance[0].abs() < 1e-4 || path.fall.discriminant(l)[0].abs() < 1e-3;
                assert!(grazes, "{k}: {hit} {hits_here} {}", crossing.clearance[0]);
                continue;
            }
            if hit {
                let (found, expected) = (major + further[0], met.hit_t[0]);
                // Along the ground a little height is a long way.
                let close = (found - expected).abs() < 5e-3;
                assert!(close, "{k}: at {found} instead of {expected}");
                hits += 1;
                bends += u32::from(crossing.clearance[0] > 0.0);
                continue;
            }
            let crosses_minor = path.line[0] < 0.0;
            let line = path.line[0] * if crosses_minor { -1.0 / advance } else { 1.0 };
            assert!((line - crossing.next[0]).abs() < 1e-4 * line, "{k}");
            let crosses = [!crosses_minor, crosses_minor].map(|is| l.mask(u16::from(is)));
            let next = field.cell_behind(l, l.splat(line), l.splat(advance), crosses);
            let stepped = [cell[0] + 1, cell[1] + 1];
            let expected = if crosses_minor {
                [cell[0], stepped[1]]
            } else {
                [stepped[0], cell[1]]
            };
            assert_eq!(next.map(|cell| cell[0]), expected, "{k}");
            passes += 1;
        }
        assert!(hits > 4000 && passes > 2000, "{hits} {passes}");
        assert!(bends > 20, "{bends} come out of the ground again");
        assert!(rises > 1000, "{rises} have ground rise beside them");
    }

    #[test]
    fn what_is_forgotten_is_no_cell() {
        let l = Portable;
        let mut patches = Patches::default();
        let number = 2 * 256 + 40;
        patches.begin(256, 100, 0.0);
        patches.store(l, number, &numbered(70));
        let found: Patch<Portable> = patches.groups(number, 1).load(l, 0);
        assert_eq!(found.cell, [70 << 16 | 9; LANES]);
        assert_eq!([found.corner[0], found.twist[0]], [1.0, 4.0]);
        patches.keep_cells(l, number, l.mask(0b1001));
        let found: Patch<Portable> = patches.groups(number, 1).load(l, 0);
        assert_eq!(found.cell[..4], [70 << 16 | 9, NONE, NONE, 70 << 16 | 9]);
        patches.forget();
        let found: Patch<Portable> = patches.groups(number, 1).load(l, 0);
        assert_eq!(found.cell, [NONE; LANES]);
        assert!(found.cell[0] >> 16 < 0, "before all cells");
    }

    /// What a ray meets is found by the ray of the next step that lies over it.
    #[test]
    fn places_drift_with_the_lines_through_the_vanishing_point() {
        let l = Portable;
        let (room, steps) = (256, 100);
        for aside in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            let mut patches = Patches::default();
            patches.begin(room, steps, aside);
            patches.forget();
            for step in 0..steps {
                patches.set_step(step);
                let lane = |step: u32| 120 + (f64::from(step) * -aside).round() as i32;
                let number = |step: u32| step as usize % 8 * room + lane(step) as usize;
                let (first, numbers) = (number(step), l.load_i(&std::array::from_fn(|k| k as i32)));
                let places = patches.places(
                    l,
                    l.mask(u16::MAX),
                    l.add_i(numbers, l.splat_i(first as i32)),
                );
                if step > 0 {
                    // Rounded twice, by half a lane each.
                    let found: Patch<Portable> = patches.groups(first - 1, 1).load(l, 0);
                    let names = found.cell.map(|cell| cell >> 16);
                    assert!(
                        names[..3].contains(&(step as i32 - 1)),
                        "{aside}: {names:?}"
                    );
                }
                let mut one = numbered(step as i32)
                    .bits(l)
                    .map(|bits| [bits[0]; CAPACITY]);
                one[0][1..].fill(NONE);
                patches.scatter(&places, &one, 0);
            }
        }
    }

    fn numbered(major: i32) -> Patch<Portable> {
        Patch {
            cell: packed(Portable, [[major; LANES], [9; LANES]]),
            corner: [1.0; LANES],
            by_minor: [2.0; LANES],
            by_major: [3.0; LANES],
            twist: [4.0; LANES],
        }
    }
}
