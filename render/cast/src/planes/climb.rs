//! Block by block: rays high over the ground skip what lies wholly below them.

use super::coarser::Coarser;
use super::field::{Axis, Field};
use super::maxima::{LEVEL_BEGIN, TOP};
use super::walk::Passage;
use super::wave::{Wave, group, group_mut};
use crate::lanes::{LANES, Lanes};

/// The level of blocks for rays over the ground by so many times the limit of nearness.
#[inline(always)]
pub(super) fn level_for<L: Lanes>(l: L, over: L::F) -> L::I {
    let one = l.splat_i(1);
    let level = l.add_i(l.exponent(over), one);
    l.max_i(l.min_i(level, l.splat_i(TOP as i32)), one)
}

/// Leads each ray of `wave` over one block, or to a smaller one where it is not wholly above it.
/// Those that are down to single cells go to `low`, and those that are too far for this resolution
/// to `coarser`. A ray that is over a block by more than the limit of nearness, times its size, goes
/// on with larger ones.
#[inline(always)]
pub(super) fn climb<L: Lanes>(
    l: L,
    field: &Field<'_>,
    wave: &mut Wave,
    low: &mut Wave,
    passage: &mut Passage,
    mut coarser: Option<Coarser<'_>>,
) {
    let (zero, one) = (l.splat_i(0), l.splat_i(1));
    let top = l.splat_i(TOP as i32);
    let eye = l.splat(field.eye_height);
    let near = l.splat(field.near);
    let rays = wave.len();
    for at in (0..rays).step_by(LANES) {
        place(l, field, wave, passage, at);
    }
    let (mut kept, mut landed) = (0, low.len());
    for at in (0..rays).step_by(LANES) {
        let mask = l.mask(wave.mask(at));
        let ray = wave.ray(l, at);
        let t = wave.t(l, at);
        let [major, minor] = wave.cell(l, at);
        let level = wave.level(l, at);
        let [x, y] = field.cells(l, major, minor);
        let place = l.load_i(group(&passage.place, at));
        let code = l.halves(&field.maxima.items, place);
        let highest = l.add(
            l.mul(l.to_float(code), l.splat(field.code_step)),
            l.splat(field.code_base),
        );
        let (major_cell, minor_cell) = if field.major_axis == 0 {
            (x, y)
        } else {
            (y, x)
        };
        let (major_first, major_last) = block(l, &field.major, major, major_cell, level);
        let (minor_first, minor_last) = block(l, &field.minor, minor, minor_cell, level);
        let major_t = line(l, &field.major, major_last);
        let minor_t = l.mul(line(l, &field.minor, minor_last), ray.inverse);
        let by_major = l.lt(major_t, minor_t);
        let next = l.max(l.min(major_t, minor_t), t);
        let height = l.add(l.mul(t, ray.slope), eye);
        let next_height = l.add(l.mul(next, ray.slope), eye);
        let over = l.sub(l.min(height, next_height), highest);
        let clear = l.lt(l.splat(field.rounding), over);
        let along = l.mul(next, ray.advance);
        let next_major = l.select_i(
            by_major,
            l.add_i(major_last, one),
            beside(l, next, &field.major, major_first, major_last),
        );
        let next_minor = l.select_i(
            by_major,
            beside(l, along, &field.minor, minor_first, minor_last),
            l.add_i(minor_last, one),
        );
        let major = l.select_i(clear, next_major, major);
        let minor = l.select_i(clear, next_minor, minor);
        let t = l.select(clear, next, t);
        let left = l.and_not(l.and(mask, clear), l.lt(next, ray.leave));
        if let Some(coarser) = &mut coarser
            && l.bits(left) != 0
        {
            let leave = field.leave(l, ray.inverse, ray.slope);
            let passes = l.and(left, l.lt(next, leave));
            coarser.take(l, passes, &ray, next, leave, Some(level));
        }
        let size = l.to_float(l.shl_i(one, level));
        let high = l.and(clear, l.lt(l.mul(size, near), over));
        let level = l.add_i_where(high, level, one);
        let level = l.add_i_where(l.and_not(mask, clear), level, l.splat_i(-1));
        let level = l.min_i(level, top);
        let going = l.and_not(mask, left);
        let high = l.gt_i(level, zero);
        kept = wave.put_at_level(l, kept, l.and(going, high), &ray, t, [major, minor], level);
        let down = l.and_not(going, high);
        if l.bits(down) != 0 {
            landed = low.put(l, landed, down, &ray, t, [major, minor]);
        }
    }
    wave.truncate(kept);
    low.truncate(landed);
}

/// Finds where the bounds of a group's blocks lie, and asks for their memory where it may be far:
/// all of a wave's before any is read.
#[inline(always)]
fn place<L: Lanes>(l: L, field: &Field<'_>, wave: &Wave, passage: &mut Passage, at: usize) {
    let [major, minor] = wave.cell(l, at);
    let level = wave.level(l, at);
    let [x, y] = field.cells(l, major, minor);
    let within = l.splat_i(255);
    let row = l.shr_i(l.and_i(y, within), level);
    let col = l.shr_i(l.and_i(x, within), level);
    let side = l.sub_i(l.splat_i(TOP as i32), level);
    let block_at = l.add_i(l.add_i(level_begin(l, level), l.shl_i(row, side)), col);
    let place = l.add_i(field.maxima.base(l, x, y), block_at);
    let place = field.maxima.only(l, l.mask(wave.mask(at)), place);
    if field.ahead.is_some() {
        l.prefetch::<_, 1>(&field.maxima.items, place);
    }
    l.store_i(place, group_mut(&mut passage.place, at));
}

/// The distance from the eye of the line behind mirrored cell `last`.
#[inline(always)]
fn line<L: Lanes>(l: L, axis: &Axis, last: L::I) -> L::F {
    l.add(l.to_float(last), l.splat(1.0 - axis.fraction))
}

/// The mirrored cell at `along`, moved into `first` to `last` where rounding has put it aside.
#[inline(always)]
fn beside<L: Lanes>(l: L, along: L::F, axis: &Axis, first: L::I, last: L::I) -> L::I {
    let cell = l.to_int(l.add(along, l.splat(axis.fraction)));
    l.max_i(l.min_i(cell, last), first)
}

/// The first and the last mirrored cell of the block in which mirrored cell `cell` lies, which is
/// the ground's `ground`.
#[inline(always)]
fn block<L: Lanes>(l: L, axis: &Axis, cell: L::I, ground: L::I, level: L::I) -> (L::I, L::I) {
    let one = l.splat_i(1);
    let last = l.sub_i(l.shl_i(one, level), one);
    let inside = l.and_i(ground, last);
    let (before, behind) = if axis.sign > 0 {
        (inside, l.sub_i(last, inside))
    } else {
        (l.sub_i(last, inside), inside)
    };
    (l.sub_i(cell, before), l.add_i(cell, behind))
}

/// Where the blocks of each lane's level begin.
#[inline(always)]
fn level_begin<L: Lanes>(l: L, level: L::I) -> L::I {
    // begin(l) = (4⁸ − 4^(9 − l)) / 3, as each level has four times the blocks of the next.
    const ALL: i32 = (LEVEL_BEGIN[TOP as usize] + 1) * 3 + 1;
    let left = l.sub_i(l.splat_i(TOP as i32 + 1), level);
    let four = l.shl_i(l.splat_i(1), l.add_i(left, left));
    let thrice = l.sub_i(l.splat_i(ALL), four);
    // The inverse of 3 modulo 2³²: of multiples of 3 it makes a third, exactly.
    l.mul_i(thrice, l.splat_i(-1_431_655_765))
}
