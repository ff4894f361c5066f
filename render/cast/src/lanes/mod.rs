//! Sixteen rays at a time: the arithmetic of the fast kernels, over the processor's widest registers.
//!
//! A kernel is written once, over [`Lanes`], and compiled for each instruction set. All of them
//! give the same bits: every operation here is one IEEE 754 operation a lane, correctly rounded
//! (no fused multiply-add, no approximate reciprocal). [`Portable`] is the reference; the others
//! are tested against it.
//!
//! A value of an instruction set's type is the proof that the processor has it: [`Isa::best`] and
//! [`Isa::all`] hand out no others. Inside [`Lanes::vectorize`] the compiler may use it.

#[allow(
    unsafe_code,
    reason = "a read that a compiler may not join with others"
)]
mod alone;
#[allow(unsafe_code, reason = "there is no safe way to ask")]
mod ask;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "instructions of one processor")]
mod avx2;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "instructions of one processor")]
mod avx512;
mod isa;
#[cfg(target_arch = "aarch64")]
#[allow(unsafe_code, reason = "instructions of one processor")]
mod neon;
mod portable;
#[cfg(test)]
mod tests;

use alone::place_alone;
pub(crate) use isa::{Isa, Kernel};
pub(crate) use portable::Portable;
use sandtable_terrain::SlabView;

/// Lanes in a group.
pub(crate) const LANES: usize = 16;

/// The numbers of the group that begins at number `at`. There must be room for a whole one.
#[inline(always)]
pub(crate) fn group<T>(numbers: &[T], at: usize) -> &[T; LANES] {
    numbers[at..].first_chunk().expect("room for a group")
}

/// As [`group`], to be written.
#[inline(always)]
pub(crate) fn group_mut<T>(numbers: &mut [T], at: usize) -> &mut [T; LANES] {
    numbers[at..].first_chunk_mut().expect("room for a group")
}

/// The first `count` groups of some numbers: what loops over several of them go through side by side, so that
/// none compares its place with an end. There must be room for them.
#[inline(always)]
pub(crate) fn groups<T>(numbers: &[T], count: usize) -> &[[T; LANES]] {
    &numbers.as_chunks().0[..count]
}

/// As [`groups`], to be written.
#[inline(always)]
pub(crate) fn groups_mut<T>(numbers: &mut [T], count: usize) -> &mut [[T; LANES]] {
    &mut numbers.as_chunks_mut().0[..count]
}

/// Places between texels.
#[derive(Clone, Copy)]
pub(crate) struct Texels<'a, L: Lanes> {
    /// The place of the south-western one, and the weights of the eastern and northern ones.
    pub(crate) at: &'a [i32; LANES],
    pub(crate) east: L::I,
    pub(crate) north: L::I,
}

/// Sixteen lanes of one instruction set. `F` holds 32-bit floats, `I` 32-bit integers, `M` one
/// truth value a lane.
pub(crate) trait Lanes: Copy {
    type F: Copy;
    type I: Copy;
    type M: Copy;

    /// Whether registers hold so little that most numbers lie in memory anyway. Then work is better done in one loop
    /// than in several, as what is kept between loops costs more than what a processor gains by doing more at once;
    /// and what is called from several places is hardly slower as one piece of code, which [`share`](Self::share)
    /// makes of it, and compiled in a fraction of the time.
    const HOLDS_LITTLE: bool = false;

    /// Runs `work`, in which this instruction set may be used, out of line.
    fn vectorize<R>(self, work: impl FnOnce() -> R) -> R;

    /// Runs `work` inside of [`vectorize`](Self::vectorize): out of line where registers hold little, else in each place
    /// that it is called from.
    #[inline(always)]
    fn share<R>(self, work: impl FnOnce() -> R) -> R {
        if Self::HOLDS_LITTLE {
            self.vectorize(work)
        } else {
            work()
        }
    }

    fn splat(self, value: f32) -> Self::F;
    fn load(self, from: &[f32; LANES]) -> Self::F;
    fn store(self, value: Self::F, to: &mut [f32; LANES]);
    /// As `store`, in the lanes of `mask`.
    #[inline(always)]
    fn store_where(self, mask: Self::M, value: Self::F, to: &mut [f32; LANES]) {
        self.store(self.select(mask, value, self.load(to)), to);
    }
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    fn sqrt(self, a: Self::F) -> Self::F;
    fn abs(self, a: Self::F) -> Self::F;
    /// `a` where it is less than `b`, else `b`: so `b` where one is NaN.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a` where it is greater than `b`, else `b`.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;

    fn lt(self, a: Self::F, b: Self::F) -> Self::M;
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// Where both are from 0 to 1; no matter what is told of -0, and of what is no number.
    #[inline(always)]
    fn are_shares(self, a: Self::F, b: Self::F) -> Self::M {
        self.and(
            self.le(self.splat(0.0), self.min(a, b)),
            self.le(self.max(a, b), self.splat(1.0)),
        )
    }
    /// `yes` where `mask`, else `no`.
    fn select(self, mask: Self::M, yes: Self::F, no: Self::F) -> Self::F;

    fn mask(self, bits: u16) -> Self::M;
    fn bits(self, mask: Self::M) -> u16;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// `a` and not `b`.
    fn and_not(self, a: Self::M, b: Self::M) -> Self::M;

    fn splat_i(self, value: i32) -> Self::I;
    fn load_i(self, from: &[i32; LANES]) -> Self::I;
    fn store_i(self, value: Self::I, to: &mut [i32; LANES]);
    /// As `store_i`, only the lanes of `mask`: other lanes' places are not touched.
    ///
    /// # Safety
    /// Those of `mask` from `to` on can be written.
    #[allow(unsafe_code, reason = "places of which only some are one's own")]
    #[inline(always)]
    unsafe fn store_those(self, mask: u16, value: Self::I, to: *mut i32) {
        let mut numbers = [0; LANES];
        self.store_i(value, &mut numbers);
        for (k, number) in numbers.into_iter().enumerate() {
            if mask >> k & 1 != 0 {
                // SAFETY: by the caller's promise.
                unsafe { to.add(k).write(number) };
            }
        }
    }
    /// The first lane and the last one.
    fn ends(self, value: Self::I) -> [i32; 2];
    fn add_i(self, a: Self::I, b: Self::I) -> Self::I;
    fn sub_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// The low 32 bits of each product.
    fn mul_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// Each product of numbers from 0 to 2¹⁵ − 1; of others, some number.
    fn mul_small(self, a: Self::I, b: Self::I) -> Self::I;
    /// The lesser of each 16 bits without a sign.
    fn min_halves(self, a: Self::I, b: Self::I) -> Self::I;
    /// The low 16 bits of the product of each 16 bits.
    fn mul_halves(self, a: Self::I, b: Self::I) -> Self::I;
    /// As much of the way from `a` to `b` as `share` has of 2¹⁵, rounded, of each 16 bits: signed
    /// numbers that lie no more than 2¹⁵ − 1 apart.
    fn lerp_halves(self, a: Self::I, b: Self::I, share: Self::I) -> Self::I;
    fn and_i(self, a: Self::I, b: Self::I) -> Self::I;
    fn min_i(self, a: Self::I, b: Self::I) -> Self::I;
    fn max_i(self, a: Self::I, b: Self::I) -> Self::I;
    /// `a << by`, each lane by its own count below 32.
    fn shl_i(self, a: Self::I, by: Self::I) -> Self::I;
    /// `a >> by`, arithmetic, each lane by its own count below 32.
    fn shr_i(self, a: Self::I, by: Self::I) -> Self::I;
    fn gt_i(self, a: Self::I, b: Self::I) -> Self::M;
    fn eq_i(self, a: Self::I, b: Self::I) -> Self::M;
    fn select_i(self, mask: Self::M, yes: Self::I, no: Self::I) -> Self::I;
    fn add_i_where(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I;
    /// The numbers of which these are the bits.
    fn float_of_bits(self, bits: Self::I) -> Self::F;
    fn bits_of_float(self, number: Self::F) -> Self::I;
    fn to_float(self, a: Self::I) -> Self::F;
    /// Towards zero; any integer where it does not fit.
    fn to_int(self, a: Self::F) -> Self::I;
    /// ⌊log₂ a⌋ of positive, finite, normal numbers; any integer of others.
    fn exponent(self, a: Self::F) -> Self::I;

    /// Writes the lanes of `mask`, closed up, to the front of `to`; what follows is scratch.
    fn compress_i(self, mask: Self::M, value: Self::I, to: &mut [i32; LANES]);
    /// As `compress_i`, of several columns.
    #[inline(always)]
    fn compress_all<const N: usize>(
        self,
        mask: Self::M,
        values: [Self::I; N],
        to: [&mut [i32; LANES]; N],
    ) {
        for (value, to) in values.into_iter().zip(to) {
            self.compress_i(mask, value, to);
        }
    }

    /// Asks for the memory of an item, to be read soon.
    #[inline(always)]
    fn prefetch_read<T>(self, items: &[T], at: usize) {
        ask::to_read(items.as_ptr().wrapping_add(at));
    }
    /// Asks for the memory of an item, to be written soon.
    #[inline(always)]
    fn prefetch_write<T>(self, items: &[T], at: usize) {
        ask::to_write(items.as_ptr().wrapping_add(at));
    }
    /// Asks for the memory `further` on from the places of every `EVERY`-th lane, to be read soon.
    #[inline(always)]
    fn prefetch<T, const EVERY: usize>(
        self,
        items: &SlabView<'_, T>,
        at: &[i32; LANES],
        further: i32,
    ) {
        let from = items.as_ptr().wrapping_offset(further as isize);
        for k in (0..LANES).step_by(EVERY) {
            ask::to_read(from.wrapping_add(place_alone(at, k)));
        }
    }
    /// Columns for rows.
    fn transpose(self, rows: [Self::I; LANES]) -> [Self::I; LANES];

    /// Writes the lanes of `mask`, each to its own place of `to`, of which the last one is scratch: it takes
    /// those for places beyond it, too.
    fn scatter(self, mask: Self::M, at: Self::I, value: Self::F, to: &mut [f32]);

    /// Writes the lanes of `mask`, a pair of numbers each, to their own places of `to`, of which the
    /// last one is scratch.
    #[inline(always)]
    fn scatter_pairs(self, mask: Self::M, at: Self::I, pairs: [Self::I; 2], to: &mut [[i32; 2]]) {
        // Lanes of the first group and of the second, in turn.
        const LOW: [i32; LANES] = [0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23];
        const HIGH: [i32; LANES] = [8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31];
        let last = to.len() - 1;
        let at = self.select_i(mask, at, self.splat_i(last as i32));
        let (mut places, mut numbers) = ([0; LANES], [0; 2 * LANES]);
        self.store_i(at, &mut places);
        let low = self.among(pairs, self.load_i(&LOW));
        let high = self.among(pairs, self.load_i(&HIGH));
        self.store_i(low, group_mut(&mut numbers, 0));
        self.store_i(high, group_mut(&mut numbers, LANES));
        let pairs: &[[i32; 2]; LANES] = bytemuck::cast_ref(&numbers);
        for k in 0..LANES {
            to[(places[k] as u32 as usize).min(last)] = pairs[k];
        }
    }

    /// The four posts of the cell at each lane's place (south-west, south-east, north-west,
    /// north-east), of which the northern ones are `stride` further on. Places are those of cells
    /// of the view's tiles; what else is read is any number. They are read one by one, so they are
    /// best written long before: a processor that has a whole group on its way to memory waits for
    /// it.
    fn cells(self, posts: &SlabView<'_, f32>, at: &[i32; LANES], stride: u32) -> [Self::F; 4];
    /// The two numbers at each lane's place.
    fn pairs(self, pairs: &SlabView<'_, [u32; 2]>, at: &[i32; LANES]) -> [Self::I; 2];
    /// The lane of `table` that the last four bits of each lane name.
    fn pick(self, table: Self::I, at: Self::I) -> Self::I;
    /// The lane of two groups that the last five bits of each lane name.
    fn among(self, table: [Self::I; 2], at: Self::I) -> Self::I;
    /// The entry of a table at each lane's place; beyond its end the last one.
    fn look_up(self, table: &[u32], at: Self::I) -> Self::I;
    /// As `cells`, of bytes.
    fn byte_cells(self, bytes: &SlabView<'_, u8>, at: Self::I, stride: u32) -> [Self::F; 4];
    /// Four neighbouring texels blended, rounded to bytes: as `cells`, with `east` and `north` in
    /// [0, 1] the weights of the eastern and northern ones. The fourth byte is 255 where it is so
    /// in all four texels.
    fn texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        at: &[i32; LANES],
        stride: u32,
        east: Self::F,
        north: Self::F,
    ) -> Self::I;
    /// The mean of the `texels` at two places, for less: weights are in 15-bit fixed point, of which
    /// six bits of `east` count.
    fn mean_texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        stride: u32,
        places: [Texels<'_, Self>; 2],
    ) -> Self::I;
}
