//! The pieces of ground that rays met, for their neighbours: who knows a cell's surface need not
//! look for it.

use super::field::Field;
use super::rows::BLOCK;
use super::wave::Column;
use crate::lanes::{LANES, Lanes, group, group_mut};
use std::ops::Range;

/// The mirrored cell from which on, along either axis, a cell's two numbers do not fit into one.
const MOST_CELLS: i32 = (1 << 15) - 1;

/// No cell. Other negative numbers are none either, but say into which cell a ray comes next that is
/// still on its way.
pub(super) const NONE: i32 = -1;

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

/// Added to the number of a cell into which a ray comes: that it does so across a line of the minor
/// axis, and that it is still on its way.
pub(super) const CROSSES_MINOR: i32 = 1 << 15;
const ON_ITS_WAY: i32 = i32::MIN;

/// The cell into which rays come next whose numbers are negative.
#[inline(always)]
pub(super) fn next_cell<L: Lanes>(l: L, cell: L::I) -> [L::I; 2] {
    let half = l.splat_i(0x7fff);
    [
        l.and_i(l.shr_i(cell, l.splat_i(16)), half),
        l.and_i(cell, half),
    ]
}

/// A cell's two numbers in one.
#[inline(always)]
pub(super) fn packed<L: Lanes>(l: L, [major, minor]: [L::I; 2]) -> L::I {
    l.add_i(l.shl_i(major, l.splat_i(16)), minor)
}

/// What rays of the last steps met, a number for each of those that are kept of steps.
///
/// One may be of a ray long gone: it is true ground all the same, as a cell's name and surface are
/// kept together.
#[derive(Default)]
pub(super) struct Patches {
    /// The bits of a [`Patch`]'s numbers, one after the other.
    bits: Vec<i32>,
    /// How far they lie apart: not by whole pages, so that they do not fight for the same lines of the
    /// processor's cache.
    apart: usize,
}

/// How many numbers a [`Patch`] has.
pub(super) const NUMBERS: usize = 5;

impl Patches {
    /// Whether cells of the ground can be named.
    pub(super) fn can_name(field: &Field<'_>) -> bool {
        let fits = |cells: [i32; 2]| cells[1] < MOST_CELLS;
        fits(field.major.cells) && fits(field.minor.cells)
    }

    /// Makes room for so many.
    pub(super) fn begin(&mut self, count: usize) {
        self.apart = count + BLOCK + 11 * LANES;
        let size = self.bits.len().max(NUMBERS * self.apart);
        self.bits.resize(size, NONE);
    }

    /// Forgets those of a range.
    pub(super) fn forget(&mut self, numbers: Range<usize>) {
        self.bits[numbers].fill(NONE);
    }

    /// Those of two blocks of neighbours, the first to be written.
    #[inline(always)]
    pub(super) fn of_steps(&mut self, at: [usize; 2]) -> (BlockMut<'_>, Block<'_>) {
        let mut numbers = self.bits.chunks_exact_mut(self.apart).map(|numbers| {
            let ranges = at.map(|at| at..at + BLOCK);
            let blocks = numbers.get_disjoint_mut(ranges);
            let [to, from] = blocks.expect("steps do not share numbers");
            let is_whole = "a block has its size";
            let to: &mut [i32; BLOCK] = to.try_into().expect(is_whole);
            let from: &[i32; BLOCK] = (&*from).try_into().expect(is_whole);
            (to, from)
        });
        let mut next = || numbers.next().expect("there are all numbers");
        let [(a, f), (b, g), (c, h), (d, i), (e, j)] = [next(), next(), next(), next(), next()];
        (BlockMut([a, b, c, d, e]), Block([f, g, h, i, j]))
    }

    /// The numbers of a group's cells.
    #[inline(always)]
    pub(super) fn cells<L: Lanes>(&self, l: L, at: usize) -> L::I {
        l.load_i(group(&self.bits, at))
    }

    #[inline(always)]
    pub(super) fn store<L: Lanes>(&mut self, l: L, at: usize, patch: &Patch<L>) {
        for (number, bits) in patch.bits(l).into_iter().enumerate() {
            l.store_i(bits, group_mut(&mut self.bits, number * self.apart + at));
        }
    }

    /// Leaves only those of a group's cells in the lanes of `mask`.
    #[inline(always)]
    pub(super) fn keep_cells<L: Lanes>(&mut self, l: L, at: usize, mask: L::M) {
        let cells = group_mut(&mut self.bits, at);
        l.store_i(l.select_i(mask, l.load_i(cells), l.splat_i(NONE)), cells);
    }

    /// Writes what sixteen rays met to their numbers; of those that met nothing, to where no ray has
    /// any.
    ///
    /// One by one: a processor's own scattering takes longer.
    #[inline(always)]
    pub(super) fn scatter(&mut self, ids: &[i32], patches: &[Column<i32>; NUMBERS], at: usize) {
        let none = self.apart - 1;
        let mut to = self.bits.chunks_exact_mut(self.apart);
        let mut next = || to.next().expect("there are all numbers");
        let mut to = [next(), next(), next(), next(), next()];
        let ids: &[i32; LANES] = group(ids, at);
        for (lane, &id) in ids.iter().enumerate() {
            let place = (id as u32 as usize).min(none);
            for (to, numbers) in to.iter_mut().zip(patches) {
                to[place] = numbers[at + lane];
            }
        }
    }
}

/// What neighbours met, to be read.
pub(super) struct Block<'a>([&'a [i32; BLOCK]; NUMBERS]);

/// What neighbours meet, to be written.
pub(super) struct BlockMut<'a>([&'a mut [i32; BLOCK]; NUMBERS]);

impl Block<'_> {
    /// That of the group that begins at lane `at`.
    #[inline(always)]
    pub(super) fn load<L: Lanes>(&self, l: L, at: usize) -> Patch<L> {
        let bits = |number: usize| l.load_i(group(self.0[number], at));
        Patch {
            cell: bits(0),
            corner: l.float_of_bits(bits(1)),
            by_minor: l.float_of_bits(bits(2)),
            by_major: l.float_of_bits(bits(3)),
            twist: l.float_of_bits(bits(4)),
        }
    }
}

impl BlockMut<'_> {
    /// Writes that of the group that begins at lane `at`.
    #[inline(always)]
    pub(super) fn store<L: Lanes>(&mut self, l: L, at: usize, patch: &Patch<L>) {
        for (to, bits) in self.0.iter_mut().zip(patch.bits(l)) {
            l.store_i(bits, group_mut(*to, at));
        }
    }

    /// Sets the numbers of the cells of a group's lanes that are not of `mask`.
    #[inline(always)]
    pub(super) fn set_cells<L: Lanes>(&mut self, l: L, at: usize, mask: L::M, cells: L::I) {
        let to = group_mut(self.0[0], at);
        l.store_i(l.select_i(mask, l.load_i(to), cells), to);
    }
}

/// How rays come through a cell whose ground is known.
pub(super) struct Path<L: Lanes> {
    /// Those that are in it at all.
    pub(super) is_in: L::M,
    /// How far the line behind it lies along the axis that it crosses, and the number of the cell behind
    /// it as that of a ray on its way.
    pub(super) line: L::F,
    pub(super) next: L::I,
    pub(super) end: End<L>,
}

impl<L: Lanes> Path<L> {
    /// That of rays at t.
    #[inline(always)]
    pub(super) fn new(
        l: L,
        field: &Field<'_>,
        [advance, slope]: [L::F; 2],
        t: L::F,
        patch: &Patch<L>,
    ) -> Self {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let major = l.shr_i(patch.cell, l.splat_i(16));
        let minor = l.and_i(patch.cell, l.splat_i(0x7fff));
        let to_major = l.add(l.to_float(major), l.splat(1.0 - field.major.fraction));
        let to_minor = l.add(l.to_float(minor), l.splat(1.0 - field.minor.fraction));
        let major_left = l.sub(to_major, t);
        let minor_left = l.sub(to_minor, l.mul(t, advance));
        let is_in = l.and(
            l.le(zero, l.min(major_left, minor_left)),
            l.le(l.max(major_left, minor_left), one),
        );
        let height = l.add(
            l.mul(patch.by_minor, major_left),
            l.mul(
                minor_left,
                l.add(patch.by_major, l.mul(patch.twist, major_left)),
            ),
        );
        let here = l.sub(l.sub(l.mul(t, slope), patch.corner), height);
        let twisted = l.mul(patch.twist, l.add(minor_left, l.mul(advance, major_left)));
        let rate = l.add(slope, l.add(patch.by_minor, l.mul(advance, patch.by_major)));
        let rate = l.add(rate, twisted);
        let bend = l.mul(patch.twist, advance);
        let fourfold = l.mul(here, l.splat(4.0));
        let discriminant = l.add(l.mul(rate, rate), l.mul(fourfold, bend));
        let crosses_major = l.lt(l.mul(major_left, advance), minor_left);
        let to_next = l.select_i(
            crosses_major,
            l.splat_i(ON_ITS_WAY + (1 << 16)),
            l.splat_i(ON_ITS_WAY + CROSSES_MINOR + 1),
        );
        Self {
            is_in,
            line: l.select(crosses_major, to_major, to_minor),
            next: l.add_i(patch.cell, to_next),
            end: End {
                major_left,
                minor_left,
                here,
                rate,
                discriminant,
            },
        }
    }
}

/// What tells where a [`Path`] ends.
pub(super) struct End<L: Lanes> {
    /// What is left of the cell.
    pub(super) major_left: L::F,
    pub(super) minor_left: L::F,
    /// The clearance s further on is `here` + `rate` s + b s².
    pub(super) here: L::F,
    pub(super) rate: L::F,
    /// `rate`² − 4 b `here`.
    pub(super) discriminant: L::F,
}

impl<L: Lanes> End<L> {
    /// Which rays meet the ground in the cell, and how much further on, if they are clear here: as
    /// [`meet`](super::walk::meet) finds it.
    #[inline(always)]
    pub(super) fn find(&self, l: L, advance: L::F) -> (L::M, L::F) {
        let zero = l.splat(0.0);
        let root = l.sqrt(l.max(self.discriminant, zero));
        // Where the clearance falls through 0, which it does once at most: so a ray that is clear here
        // and does not do so in the cell is clear up to its end. One that is not clear has only just
        // come down.
        let below = l.le(self.here, zero);
        let further = l.div(l.add(self.here, self.here), l.sub(root, self.rate));
        let falls = l.and(l.le(zero, self.discriminant), l.le(zero, further));
        let further = l.select(below, zero, further);
        let left = l.min(
            l.sub(self.major_left, further),
            l.sub(self.minor_left, l.mul(further, advance)),
        );
        (l.and(l.or(below, falls), l.le(zero, left)), further)
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
    use crate::planes::walk::{Passage, cross, fetch, meet, place};
    use crate::planes::wave::Ray;
    use glam::DVec2;
    use sandtable_terrain::Ground;

    /// Through cells of rough ground, with known patches and as all rays go.
    #[test]
    fn patches_tell_what_their_cells_do() {
        let l = Portable;
        let rough = |col: u32, row: u32| ((3 * col * col + 5 * row * col + 11 * row) % 13) as f32;
        let ground = Ground::from_fn(200, 200, DVec2::ONE, rough).expect("a sound grid");
        let roofs = Roofs::new(ground.heights());
        let level = Level::new(ground.heights(), &roofs, &Steepness::new(ground.heights()));
        let mut passage = Box::new(Passage::default());
        let (mut hits, mut passes, mut bends) = (0, 0, 0);
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
            let fall = |field: &Field<'_>, slope: f32| {
                let ray = ray(slope);
                let (_, patch) = cross(l, field, &ray, t, cells, posts);
                let path = Path::new(l, field, [ray.advance, ray.slope], t, &patch);
                [path.end.here[0], path.end.rate[0]]
            };
            // Half of the rays run almost along the ground; all are a little over it here.
            let mut height = 0.5 * share(0.911) as f32;
            if k % 4 < 2 {
                slope -= fall(&field, slope)[1] + 6.0 * share(0.367) as f32;
                height *= 0.2;
            }
            field.eye_height += height - fall(&field, slope)[0];
            let ray = ray(slope);
            let (crossing, patch) = cross(l, &field, &ray, t, cells, posts);
            let met = meet(l, t, &crossing);
            let path = Path::new(l, &field, [ray.advance, ray.slope], t, &patch);
            assert!(l.bits(path.is_in) & 1 == 1, "{cell:?} at {major}");
            let (hit, further) = path.end.find(l, ray.advance);
            let (hit, hits_here) = (l.bits(hit) & 1 == 1, l.bits(met.hit) & 1 == 1);
            if hit != hits_here {
                // Just at the line behind the cell, or where a ray touches the ground.
                let grazes =
                    crossing.clearance[0].abs() < 1e-4 || path.end.discriminant[0].abs() < 1e-3;
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
            let crosses_minor = path.next[0] & CROSSES_MINOR != 0;
            let line = path.line[0] * if crosses_minor { 1.0 / advance } else { 1.0 };
            assert!((line - crossing.next[0]).abs() < 1e-4 * line, "{k}");
            let next = next_cell(l, path.next).map(|cell| cell[0]);
            let stepped = [cell[0] + 1, cell[1] + 1];
            let expected = if crosses_minor {
                [cell[0], stepped[1]]
            } else {
                [stepped[0], cell[1]]
            };
            assert!(path.next[0] < 0 && next == expected, "{k}: {next:?}");
            passes += 1;
        }
        assert!(hits > 4000 && passes > 2000, "{hits} {passes}");
        assert!(bends > 20, "{bends} come out of the ground again");
    }

    #[test]
    fn what_is_forgotten_is_no_cell() {
        let l = Portable;
        let mut patches = Patches::default();
        patches.begin(4 * BLOCK);
        let patch = Patch {
            cell: packed(l, [[70; LANES], [9; LANES]]),
            corner: [1.0; LANES],
            by_minor: [2.0; LANES],
            by_major: [3.0; LANES],
            twist: [4.0; LANES],
        };
        patches.store(l, BLOCK + 3, &patch);
        let (_, known) = patches.of_steps([0, BLOCK]);
        let found: Patch<Portable> = known.load(l, 3);
        assert_eq!(found.cell, [70 << 16 | 9; LANES]);
        assert_eq!([found.corner[0], found.twist[0]], [1.0, 4.0]);
        patches.forget(BLOCK + 4..BLOCK + 6);
        let (_, known) = patches.of_steps([0, BLOCK]);
        let found: Patch<Portable> = known.load(l, 3);
        assert_eq!(found.cell[..4], [70 << 16 | 9, NONE, NONE, 70 << 16 | 9]);
        let field = |patch: &Patch<Portable>| patch.cell.map(|cell| cell >> 16);
        assert!(field(&found)[1] < 0);
    }
}
