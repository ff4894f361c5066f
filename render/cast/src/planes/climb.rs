//! Block by block: rays high over the ground skip what lies wholly below them.

use super::coarser::Coarser;
use super::field::{Axis, Field};
use super::roofs::{FINEST, LEVEL_BEGIN, TOP};
use super::strips::{NARROW, StripWidths};
use super::walk::Passage;
use super::wave::{Ray, Wave};
use crate::lanes::{LANES, Lanes, group, group_mut};

/// Cells that rays have to go at least, about, to be led to the roofs of their blocks and not right
/// through their cells.
pub(super) const NEAR: f32 = 1.0;

/// Cells to go from which on the finest blocks are too small.
pub(super) const FAR: f32 = 12.0;

/// How many levels rays go down under a roof: the next finer one is seldom much lower.
const DOWN: i32 = 2;

/// The level of blocks for rays with so many cells to go.
#[inline(always)]
pub(super) fn level_for<L: Lanes>(l: L, to_go: L::F) -> L::I {
    let finest = l.splat_i(FINEST as i32);
    let level = l.add_i(l.exponent(l.mul(to_go, l.splat(0.25))), finest);
    l.max_i(l.min_i(level, l.splat_i(TOP as i32)), finest)
}

/// How rays came to a block's roof, or past it.
pub(super) struct Approach<L: Lanes> {
    /// Those that begin over it, and those of them that stay over it as long as the block is under
    /// them.
    pub(super) begins: L::M,
    pub(super) clear: L::M,
    /// Where all ground is lower up to: where rays leave the block, or come under its roof; the
    /// mirrored cell there.
    pub(super) t: L::F,
    pub(super) cell: [L::I; 2],
    /// Metres over the roof, where that is less.
    pub(super) over: L::F,
}

/// Leads rays that are at t in a mirrored cell to the roof of their block, which lies at `place`. Where
/// rays keep `STRIPS`, none of the block's ground in them is higher.
#[inline(always)]
#[allow(
    clippy::too_many_arguments,
    reason = "where rays are, and what is beside them"
)]
pub(super) fn approach<L: Lanes, const STRIPS: bool>(
    l: L,
    field: &Field<'_>,
    mask: L::M,
    ray: &Ray<L>,
    t: L::F,
    [major, minor]: [L::I; 2],
    level: L::I,
    place: &[i32; LANES],
    widths: StripWidths,
) -> Approach<L> {
    let (zero, one) = (l.splat(0.0), l.splat_i(1));
    let eye = l.splat(field.eye_height - field.rounding);
    let [x, y] = field.cells(l, major, minor);
    let [height, major_rise, minor_rise] = roof(l, field, place);
    let (major_cell, minor_cell) = if field.major_axis == 0 {
        (x, y)
    } else {
        (y, x)
    };
    let major_last = last_of_block(l, &field.major, major, major_cell, level);
    let minor_last = last_of_block(l, &field.minor, minor, minor_cell, level);
    let major_end = line(l, &field.major, major_last);
    let minor_end = line(l, &field.minor, minor_last);
    let minor_t = l.mul(minor_end, ray.inverse);
    let by_major = l.lt(major_end, minor_t);
    let next = l.max(l.min(major_end, minor_t), t);
    let half = l.mul(l.to_float(l.shl_i(one, level)), l.splat(0.5));
    let along = l.add(l.sub(t, major_end), half);
    let mut advance = ray.advance;
    if STRIPS {
        // The roof is looked at on that side of the strip on which it is higher.
        let falls = l.lt(minor_rise, zero);
        advance = l.select(falls, l.sub(advance, l.splat(widths.by_t)), advance);
    }
    let aside = l.add(l.sub(l.mul(t, advance), minor_end), half);
    let roof = l.add(l.mul(major_rise, along), l.mul(minor_rise, aside));
    let over = l.sub(l.sub(l.add(l.mul(t, ray.slope), eye), height), roof);
    // It changes evenly.
    let rate = l.sub(l.sub(ray.slope, major_rise), l.mul(minor_rise, advance));
    let length = l.sub(next, t);
    let next_over = l.add(over, l.mul(rate, length));
    let mut begins = l.lt(zero, over);
    if STRIPS {
        let ends = [t, next];
        let rises = beside_rises(
            l, field, mask, ray, ends, major, minor_last, along, level, widths,
        );
        begins = l.and_not(begins, rises);
    }
    let clear = l.and(begins, l.lt(zero, next_over));
    // Where it comes under the roof: a little before, whatever is rounded.
    let part = l.mul(l.div(over, l.sub(over, next_over)), l.splat(0.999));
    let under = l.add(t, l.mul(part, length));
    let t = l.select(begins, l.select(clear, next, under), t);
    let next_major = l.select_i(
        l.and(clear, by_major),
        l.add_i(major_last, one),
        beside(l, t, &field.major, major, major_last),
    );
    let next_minor = l.select_i(
        l.and_not(clear, by_major),
        l.add_i(minor_last, one),
        beside(l, l.mul(t, ray.advance), &field.minor, minor, minor_last),
    );
    Approach {
        begins,
        clear,
        t,
        cell: [
            l.select_i(begins, next_major, major),
            l.select_i(begins, next_minor, minor),
        ],
        over: l.min(over, next_over),
    }
}

/// Beside which rays of `mask`, from one t to another, the roof of the block before their own along the minor axis
/// is higher than they are, where their strips are wider than a cell and reach out over it. `major` is a cell of their
/// own block along the major axis, `minor_last` the last one along the minor axis, and `along` is how far they are
/// behind its middle along the major axis, at the first t.
#[inline(always)]
#[allow(
    clippy::too_many_arguments,
    reason = "where rays are, and what is beside them"
)]
fn beside_rises<L: Lanes>(
    l: L,
    field: &Field<'_>,
    mask: L::M,
    ray: &Ray<L>,
    [t, next]: [L::F; 2],
    major: L::I,
    minor_last: L::I,
    along: L::F,
    level: L::I,
    widths: StripWidths,
) -> L::M {
    let none = l.mask(0);
    if widths.most <= NARROW {
        return none;
    }
    let mask = widths.are_wide(l, mask, [t, next]);
    if l.bits(mask) == 0 {
        return none;
    }
    let zero = l.splat(0.0);
    let size = l.shl_i(l.splat_i(1), level);
    let half = l.mul(l.to_float(size), l.splat(0.5));
    let last = l.sub_i(minor_last, size);
    let begin = line(l, &field.minor, last);
    let advance = l.sub(ray.advance, l.splat(widths.by_t));
    let sides = [t, next].map(|t| l.mul(t, advance));
    let there = l.gt_i(last, l.splat_i(field.minor.cells[0] - 1));
    let reaches = l.and(there, l.lt(l.min(sides[0], sides[1]), begin));
    let mask = l.and(mask, reaches);
    if l.bits(mask) == 0 {
        return none;
    }
    let mut at = [0; LANES];
    l.store_i(place(l, field, mask, [major, last], level), &mut at);
    let [height, major_rise, minor_rise] = roof(l, field, &at);
    // Where it is highest: at its end, or at the strip's.
    let eye = l.splat(field.eye_height - field.rounding);
    let ends_higher = l.lt(zero, minor_rise);
    let over = |t: L::F, side: L::F, along: L::F| {
        let aside = l.add(l.sub(side, begin), half);
        let aside = l.select(ends_higher, half, aside);
        let roof = l.add(l.mul(major_rise, along), l.mul(minor_rise, aside));
        l.sub(l.sub(l.add(l.mul(t, ray.slope), eye), height), roof)
    };
    let further = l.add(along, l.sub(next, t));
    let least = l.min(over(t, sides[0], along), over(next, sides[1], further));
    l.and_not(mask, l.lt(zero, least))
}

/// Roofs at places: their heights over the middles of their blocks, and how they rise along the mirrored major and
/// minor axis.
#[inline(always)]
fn roof<L: Lanes>(l: L, field: &Field<'_>, place: &[i32; LANES]) -> [L::F; 3] {
    let [height, rise] = l.pairs(&field.roofs.items, place);
    let height = l.float_of_bits(height);
    let east = l.float_of_bits(l.shl_i(rise, l.splat_i(16)));
    let north = l.float_of_bits(l.and_i(rise, l.splat_i(-65536)));
    let (major_rise, minor_rise) = if field.major_axis == 0 {
        (east, north)
    } else {
        (north, east)
    };
    [
        height,
        l.mul(major_rise, l.splat(field.major.sign as f32)),
        l.mul(minor_rise, l.splat(field.minor.sign as f32)),
    ]
}

/// Which rays are so far over the roofs of their blocks that larger ones will do.
#[inline(always)]
pub(super) fn rises_far<L: Lanes>(
    l: L,
    field: &Field<'_>,
    ray: &Ray<L>,
    to: &Approach<L>,
    level: L::I,
) -> L::M {
    let size = l.to_float(l.shl_i(l.splat_i(1), level));
    let far = l.mul(l.mul(size, l.splat(0.7)), field.closing_rate(l, ray.slope));
    l.and(to.clear, l.lt(far, to.over))
}

/// Leads each ray of `wave` over one block, or to where it comes under the block's roof, and to a
/// smaller block there. Those that are down to single cells go to `low`, and those that are too far
/// for this resolution to `coarser`. A ray that is far over a block goes on with larger ones.
///
/// Rays are closed up in a loop of its own, which knows at once which way each goes.
pub(super) fn climb<L: Lanes, const STRIPS: bool>(
    l: L,
    field: &Field<'_>,
    wave: &mut Wave,
    low: &mut Wave,
    passage: &mut Passage,
    widths: StripWidths,
    mut coarser: Option<Coarser<'_>>,
) {
    l.vectorize(
        #[inline(always)]
        || {
            let top = l.splat_i(TOP as i32);
            let finest = l.splat_i(FINEST as i32);
            let rays = wave.len();
            for at in (0..rays).step_by(LANES) {
                let place = place(
                    l,
                    field,
                    l.mask(wave.mask(at)),
                    wave.cell(l, at),
                    wave.level(l, at),
                );
                l.store_i(place, group_mut(&mut passage.place, at));
            }
            if field.ahead.is_some() {
                for at in (0..rays).step_by(LANES) {
                    ask(l, field, passage, at);
                }
            }
            for at in (0..rays).step_by(LANES) {
                let ray = wave.ray(l, at);
                let level = wave.level(l, at);
                let place = group(&passage.place, at);
                let to = approach::<L, STRIPS>(
                    l,
                    field,
                    l.mask(wave.mask(at)),
                    &ray,
                    wave.t(l, at),
                    wave.cell(l, at),
                    level,
                    place,
                    widths,
                );
                let left = l.and_not(to.begins, l.lt(to.t, ray.leave));
                let up = l.add_i_where(rises_far(l, field, &ray, &to, level), level, l.splat_i(1));
                let next = l.select_i(to.clear, l.min_i(up, top), l.sub_i(level, l.splat_i(DOWN)));
                // No level is negative: the sign tells what has left.
                let next = l.select_i(left, l.sub_i(l.splat_i(-1), level), next);
                wave.set_place(l, at, to.t, to.cell);
                wave.set_level(l, at, next);
            }
            let (mut kept, mut landed) = (0, low.len());
            for at in (0..rays).step_by(LANES) {
                let mask = l.mask(wave.mask(at));
                let ray = wave.ray(l, at);
                let level = wave.level(l, at);
                let (t, cell) = (wave.t(l, at), wave.cell(l, at));
                let left = l.and(mask, l.gt_i(l.splat_i(0), level));
                if let Some(coarser) = &mut coarser
                    && l.bits(left) != 0
                {
                    let leave = field.leave(l, ray.inverse, ray.slope);
                    let passes = l.and(left, l.lt(t, leave));
                    let level = l.sub_i(l.splat_i(-1), level);
                    coarser.take(l, passes, &ray, t, leave, Some(level));
                }
                let going = l.and_not(mask, left);
                let down = l.and(going, l.gt_i(finest, level));
                let going = l.and_not(going, down);
                wave.close_up_levels(l, kept, going, level);
                kept = wave.close_up(l, kept, going, &ray, t, cell);
                if l.bits(down) != 0 {
                    landed = low.put(l, landed, down, &ray, t, cell);
                }
            }
            wave.truncate(kept);
            low.truncate(landed);
        },
    )
}

/// Where the roofs of a group's blocks lie.
#[inline(always)]
pub(super) fn place<L: Lanes>(
    l: L,
    field: &Field<'_>,
    mask: L::M,
    [major, minor]: [L::I; 2],
    level: L::I,
) -> L::I {
    let [x, y] = field.cells(l, major, minor);
    let within = l.splat_i(255);
    let row = l.shr_i(l.and_i(y, within), level);
    let col = l.shr_i(l.and_i(x, within), level);
    let side = l.sub_i(l.splat_i(TOP as i32), level);
    let block_at = l.add_i(l.add_i(level_begin(l, level), l.shl_i(row, side)), col);
    let place = l.add_i(field.roofs.base(l, x, y), block_at);
    field.roofs.only(l, mask, place)
}

/// Asks for the memory of the roofs of a group's blocks, where it may be far.
#[inline(always)]
pub(super) fn ask<L: Lanes>(l: L, field: &Field<'_>, passage: &Passage, at: usize) {
    if field.ahead.is_some() {
        l.prefetch::<_, 1>(&field.roofs.items, group(&passage.place, at), 0);
    }
}

/// The distance from the eye of the line behind mirrored cell `last`.
#[inline(always)]
fn line<L: Lanes>(l: L, axis: &Axis, last: L::I) -> L::F {
    l.add(l.to_float(last), l.splat(1.0 - axis.fraction))
}

/// The mirrored cell at `along`, moved into `first` to `last` where rounding has put it aside, and to the
/// ground's last one where that is before the block's. A ray must not go back to a cell that it has left: it
/// might do so again and again.
#[inline(always)]
fn beside<L: Lanes>(l: L, along: L::F, axis: &Axis, first: L::I, last: L::I) -> L::I {
    let last = l.min_i(last, l.splat_i(axis.cells[1]));
    let cell = l.to_int(l.add(along, l.splat(axis.fraction)));
    l.max_i(l.min_i(cell, last), first)
}

/// The last mirrored cell of the block in which mirrored cell `cell` lies, which is the ground's
/// `ground`.
#[inline(always)]
fn last_of_block<L: Lanes>(l: L, axis: &Axis, cell: L::I, ground: L::I, level: L::I) -> L::I {
    let last = l.sub_i(l.shl_i(l.splat_i(1), level), l.splat_i(1));
    let inside = l.and_i(ground, last);
    let behind = if axis.sign > 0 {
        l.sub_i(last, inside)
    } else {
        inside
    };
    l.add_i(cell, behind)
}

/// Where the blocks of each lane's level begin.
#[inline(always)]
fn level_begin<L: Lanes>(l: L, level: L::I) -> L::I {
    // begin(l) = 4^(9 − l) + … + 4⁶, as each level has four times the blocks of the next.
    const ALL: i32 = LEVEL_BEGIN[TOP as usize] | 1;
    let left = l.sub_i(l.splat_i(TOP as i32 + 1), level);
    let four = l.shl_i(l.splat_i(1), l.add_i(left, left));
    l.and_i(l.splat_i(ALL), l.sub_i(l.splat_i(0), four))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;
    use crate::planes::frame::Level;
    use crate::planes::roofs::Roofs;
    use crate::planes::steepness::Steepness;
    use glam::DVec2;
    use sandtable_terrain::Ground;

    /// Right before the ground's border t · advance may round to its line, where the last block may go on.
    #[test]
    fn rays_stay_on_the_ground_of_blocks_that_reach_out_over_its_border() {
        let l = Portable;
        let mut rounded = 0;
        for k in 0..1000_u32 {
            let axis = Axis::new(-100.0 - 0.37 * f64::from(k), 197, 1);
            let border = axis.line(axis.cells[1] + 1);
            for along in [border.next_down(), border, border.next_up()] {
                rounded += u32::from((along + axis.fraction) as i32 > axis.cells[1]);
                let [first, last] = [axis.cells[1], axis.cells[1] + 3].map(|cell| l.splat_i(cell));
                let cell = beside(l, l.splat(along), &axis, first, last);
                assert_eq!(cell[0], axis.cells[1], "{along} of {border}");
            }
        }
        assert!(rounded > 1000, "{rounded} rounded to behind it");
    }

    /// A ray that goes back to a cell may do so for ever: over ground with high roofs it comes near
    /// to one, is led to it by less than the last digit of t, walks on by a cell, and so on.
    #[test]
    fn rays_never_go_back() {
        let l = Portable;
        let rough = |col: u32, row: u32| ((col * 37 + row * 91) % 113) as f32;
        let ground = Ground::from_fn(200, 200, DVec2::ONE, rough).expect("a sound grid");
        let roofs = Roofs::new(ground.heights());
        let steepness = Steepness::new(ground.heights());
        let level = Level::new(ground.heights(), &roofs, &steepness);
        let mut led = 0;
        for k in 0..4000_u32 {
            let share = |by: f64| (f64::from(k) * by).fract();
            let axes = [share(0.618_034), share(0.414_213_6)]
                .map(|share| Axis::new(-30.0 - 100.0 * share, 199, 1));
            let mut field = Field::of_level(&level, axes, 0);
            // On the line before a cell, along the minor axis.
            let row = axes[1].cells[0] + 1 + (k * 11 % 190) as i32;
            let advance = 0.5 + 0.5 * share(0.271) as f32;
            let inverse = 1.0 / advance;
            let t = axes[1].line(row) * inverse;
            let column = (t + axes[0].fraction) as i32;
            if column < axes[0].cells[0] || column >= axes[0].cells[1] {
                continue;
            }
            let cell = [column, row];
            let rays = |slope: f32| Ray {
                advance: [advance; LANES],
                inverse: [inverse; LANES],
                slope: [slope; LANES],
                leave: [1e4; LANES],
                id: [0; LANES],
            };
            let finest = l.splat_i(FINEST as i32);
            let cell = cell.map(|cell| l.splat_i(cell));
            let all = l.mask(u16::MAX);
            let place = place(l, &field, all, cell, finest);
            // The roof's height there.
            let bits = l.pairs(&field.roofs.items, &place);
            let number = |bits: u32| f64::from(f32::from_bits(bits));
            let [height, rises] = bits.map(|bits| bits[0] as u32);
            let aside = |axis: &Axis, cell: i32, at: f32| {
                let first = cell - (axis.base + cell) % 4;
                f64::from(at) - f64::from(axis.line(first)) - 2.0
            };
            let roof = number(height)
                + number(rises << 16) * aside(&axes[0], column, t)
                + number(rises & 0xffff_0000) * aside(&axes[1], row, t * advance);
            let slope = -1.0 - share(0.31) as f32 * 4.0;
            for above in [1e-5, 1e-4, 1e-3, 1e-2, 1.0] {
                field.eye_height = (roof - f64::from(slope) * f64::from(t) + above) as f32;
                let rays = rays(slope);
                let to = approach::<_, false>(
                    l,
                    &field,
                    all,
                    &rays,
                    l.splat(t),
                    cell,
                    finest,
                    &place,
                    StripWidths::default(),
                );
                led += u32::from(l.bits(to.begins) & !l.bits(to.clear) & 1);
                assert!(to.t[0] >= t);
                for (to, from) in to.cell.iter().zip(cell) {
                    assert!(to[0] >= from[0], "from cell {} to {}", from[0], to[0]);
                }
            }
        }
        assert!(led > 4000, "{led} were led to a roof");
    }
}
