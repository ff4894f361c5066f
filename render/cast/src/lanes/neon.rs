//! NEON: four lanes a register, four registers a group.

use super::{LANES, Lanes, Portable, Texels};
use sandtable_terrain::SlabView;
use std::arch::aarch64::*;

/// The proof that the processor has NEON: it is one for which the program is compiled, and all of
/// them have it.
#[derive(Clone, Copy)]
pub(crate) struct Neon(());

impl Neon {
    pub(crate) fn new() -> Self {
        const { assert!(cfg!(target_feature = "neon")) };
        Self(())
    }
}

type F = [float32x4_t; 4];
type I = [int32x4_t; 4];
/// All ones or all zeros a lane.
type M = [uint32x4_t; 4];

/// Intrinsics on values.
macro_rules! on_values {
    ($intrinsics:expr) => {
        // SAFETY: whoever holds a `Neon` knows that the processor has the instructions.
        unsafe { $intrinsics }
    };
}

/// An intrinsic on the quarters of groups.
macro_rules! on_quarters {
    ($intrinsic:expr, $($group:ident),+) => {
        on_values!([
            $intrinsic($($group[0]),+),
            $intrinsic($($group[1]),+),
            $intrinsic($($group[2]),+),
            $intrinsic($($group[3]),+),
        ])
    };
}

/// For each mask of four lanes, the bytes of its lanes, closed up.
static CLOSED_UP: [[u8; 16]; 16] = {
    let mut table = [[0; 16]; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut byte, mut end) = (0, 0);
        while byte < 16 {
            if mask >> (byte / 4) & 1 == 1 {
                table[mask][end] = byte as u8;
                end += 1;
            }
            byte += 1;
        }
        mask += 1;
    }
    table
};

/// Lane k's bit, where all are in one register.
static BITS: [u32; LANES] = {
    let mut bits = [0; LANES];
    let mut lane = 0;
    while lane < LANES {
        bits[lane] = 1 << lane;
        lane += 1;
    }
    bits
};

/// `BITS` by quarters.
#[target_feature(enable = "neon")]
#[inline]
fn lane_bits() -> M {
    let bits = BITS.as_ptr();
    // SAFETY: there are sixteen lanes.
    unsafe {
        [
            vld1q_u32(bits),
            vld1q_u32(bits.add(4)),
            vld1q_u32(bits.add(8)),
            vld1q_u32(bits.add(12)),
        ]
    }
}

/// Two neighbouring items at each of four places: the first ones, and the second ones.
///
/// # Safety
/// Eight bytes can be read at each.
#[target_feature(enable = "neon")]
#[inline]
unsafe fn pairs<T>(items: *const T, places: &[u32]) -> [uint32x4_t; 2] {
    macro_rules! pair {
        ($k:expr) => {
            // SAFETY: the caller's promise.
            unsafe { vld1_u8(items.wrapping_add(places[$k] as usize).cast()) }
        };
    }
    let low = vreinterpretq_u32_u8(vcombine_u8(pair!(0), pair!(1)));
    let high = vreinterpretq_u32_u8(vcombine_u8(pair!(2), pair!(3)));
    [vuzp1q_u32(low, high), vuzp2q_u32(low, high)]
}

/// Each corner of the cells at lanes' places, by quarters of the group. Places behind the last cell
/// are moved to it.
#[inline(always)]
fn corners<T>(items: &SlabView<'_, T>, at: &[i32; LANES], stride: u32) -> [[uint32x4_t; 4]; 4] {
    const { assert!(size_of::<T>() == 4) };
    assert!(items.len() >= stride as usize + 2, "a tile has a cell");
    let last = items.len() - (stride as usize + 2);
    let last = u32::try_from(last).unwrap_or(u32::MAX);
    let places = at.map(
        #[inline(always)]
        |place| (place as u32).min(last),
    );
    let south = items.as_ptr();
    let north = south.wrapping_add(stride as usize);
    let mut corners = [[on_values!(vdupq_n_u32(0)); 4]; 4];
    for k in 0..4 {
        let places = &places[4 * k..4 * k + 4];
        // SAFETY: from each place on there is a row and two items.
        unsafe {
            [corners[0][k], corners[1][k]] = pairs(south, places);
            [corners[2][k], corners[3][k]] = pairs(north, places);
        }
    }
    corners
}

/// From `from` to `to` by a share in 15-bit fixed point.
#[target_feature(enable = "neon")]
#[inline]
fn along(from: int16x8_t, to: int16x8_t, share: int16x8_t) -> int16x8_t {
    vaddq_s16(from, vqrdmulhq_s16(vsubq_s16(to, from), share))
}

/// Blends four lanes' texels.
#[target_feature(enable = "neon")]
#[inline]
fn blend(corners: [uint32x4_t; 4], east: float32x4_t, north: float32x4_t) -> int32x4_t {
    let weights = [east, north].map(
        #[inline(always)]
        |share| vreinterpretq_u8_s32(vcvtq_s32_f32(vmulq_n_f32(share, 32767.0))),
    );
    let [sw, se, nw, ne] = corners.map(
        #[inline(always)]
        |corner| vreinterpretq_u8_u32(corner),
    );
    // Two lanes' texels, 16 bits a channel, six of them a fraction; the lanes' weights are given as
    // the bytes to take.
    macro_rules! two {
        ($half:ident, $bytes:expr) => {{
            let channels = [sw, se, nw, ne].map(
                #[inline(always)]
                |corner| vreinterpretq_s16_u16(vshll_n_u8::<6>($half(corner))),
            );
            let [sw, se, nw, ne] = channels;
            let bytes: [u8; 16] = $bytes;
            // SAFETY: there are sixteen bytes.
            let bytes = unsafe { vld1q_u8(bytes.as_ptr()) };
            let [east, north] = weights.map(
                #[inline(always)]
                |weights| vreinterpretq_s16_u8(vqtbl1q_u8(weights, bytes)),
            );
            let blended = along(along(sw, se, east), along(nw, ne, east), north);
            let rounded = vaddq_s16(blended, vdupq_n_s16(32));
            vshrn_n_u16::<6>(vreinterpretq_u16_s16(rounded))
        }};
    }
    let low = two!(
        vget_low_u8,
        [0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5]
    );
    let high = two!(
        vget_high_u8,
        [8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13]
    );
    vreinterpretq_s32_u8(vcombine_u8(low, high))
}

/// Columns for rows, of a square of four.
#[target_feature(enable = "neon")]
#[inline]
fn transposed([a, b, c, d]: I) -> I {
    let pairs = [
        vtrn1q_s32(a, b),
        vtrn2q_s32(a, b),
        vtrn1q_s32(c, d),
        vtrn2q_s32(c, d),
    ];
    let [a, b, c, d] = pairs.map(
        #[inline(always)]
        |pair| vreinterpretq_s64_s32(pair),
    );
    [
        vtrn1q_s64(a, c),
        vtrn1q_s64(b, d),
        vtrn2q_s64(a, c),
        vtrn2q_s64(b, d),
    ]
    .map(
        #[inline(always)]
        |column| vreinterpretq_s32_s64(column),
    )
}

impl Lanes for Neon {
    type F = F;
    type I = I;
    type M = M;

    const HOLDS_LITTLE: bool = true;

    #[inline(always)]
    fn vectorize<R>(self, work: impl FnOnce() -> R) -> R {
        // Apart, as the portable kernels are: in one function they take a compiler more than twelve minutes, not four.
        Portable.vectorize(work)
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F {
        on_values!([vdupq_n_f32(value); 4])
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> F {
        let from = from.as_ptr();
        // SAFETY: there are sixteen lanes.
        unsafe {
            [
                vld1q_f32(from),
                vld1q_f32(from.add(4)),
                vld1q_f32(from.add(8)),
                vld1q_f32(from.add(12)),
            ]
        }
    }
    #[inline(always)]
    fn store(self, value: F, to: &mut [f32; LANES]) {
        let to = to.as_mut_ptr();
        // SAFETY: there is room for sixteen lanes.
        unsafe {
            vst1q_f32(to, value[0]);
            vst1q_f32(to.add(4), value[1]);
            vst1q_f32(to.add(8), value[2]);
            vst1q_f32(to.add(12), value[3]);
        }
    }
    #[inline(always)]
    fn add(self, a: F, b: F) -> F {
        on_quarters!(vaddq_f32, a, b)
    }
    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        on_quarters!(vsubq_f32, a, b)
    }
    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        on_quarters!(vmulq_f32, a, b)
    }
    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        on_quarters!(vdivq_f32, a, b)
    }
    #[inline(always)]
    fn sqrt(self, a: F) -> F {
        on_quarters!(vsqrtq_f32, a)
    }
    #[inline(always)]
    fn abs(self, a: F) -> F {
        on_quarters!(vabsq_f32, a)
    }
    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        // The instruction for minima gives NaN where one is.
        self.select(self.lt(a, b), a, b)
    }
    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        self.select(self.lt(b, a), a, b)
    }

    #[inline(always)]
    fn lt(self, a: F, b: F) -> M {
        on_quarters!(vcltq_f32, a, b)
    }
    #[inline(always)]
    fn le(self, a: F, b: F) -> M {
        on_quarters!(vcleq_f32, a, b)
    }
    #[inline(always)]
    fn select(self, mask: M, yes: F, no: F) -> F {
        on_quarters!(vbslq_f32, mask, yes, no)
    }

    #[inline(always)]
    fn mask(self, bits: u16) -> M {
        let bits = on_values!([vdupq_n_u32(u32::from(bits)); 4]);
        let lanes = on_values!(lane_bits());
        on_quarters!(vtstq_u32, bits, lanes)
    }
    #[inline(always)]
    fn bits(self, mask: M) -> u16 {
        let bits = self.and(mask, on_values!(lane_bits()));
        on_values!(vaddvq_u32(vorrq_u32(
            vorrq_u32(bits[0], bits[1]),
            vorrq_u32(bits[2], bits[3])
        ))) as u16
    }
    #[inline(always)]
    fn and(self, a: M, b: M) -> M {
        on_quarters!(vandq_u32, a, b)
    }
    #[inline(always)]
    fn or(self, a: M, b: M) -> M {
        on_quarters!(vorrq_u32, a, b)
    }
    #[inline(always)]
    fn and_not(self, a: M, b: M) -> M {
        on_quarters!(vbicq_u32, a, b)
    }

    #[inline(always)]
    fn splat_i(self, value: i32) -> I {
        on_values!([vdupq_n_s32(value); 4])
    }
    #[inline(always)]
    fn load_i(self, from: &[i32; LANES]) -> I {
        let from = from.as_ptr();
        // SAFETY: there are sixteen lanes.
        unsafe {
            [
                vld1q_s32(from),
                vld1q_s32(from.add(4)),
                vld1q_s32(from.add(8)),
                vld1q_s32(from.add(12)),
            ]
        }
    }
    #[inline(always)]
    fn store_i(self, value: I, to: &mut [i32; LANES]) {
        let to = to.as_mut_ptr();
        // SAFETY: there is room for sixteen lanes.
        unsafe {
            vst1q_s32(to, value[0]);
            vst1q_s32(to.add(4), value[1]);
            vst1q_s32(to.add(8), value[2]);
            vst1q_s32(to.add(12), value[3]);
        }
    }
    #[inline(always)]
    fn ends(self, value: I) -> [i32; 2] {
        on_values!([vgetq_lane_s32::<0>(value[0]), vgetq_lane_s32::<3>(value[3])])
    }
    #[inline(always)]
    fn add_i(self, a: I, b: I) -> I {
        on_quarters!(vaddq_s32, a, b)
    }
    #[inline(always)]
    fn sub_i(self, a: I, b: I) -> I {
        on_quarters!(vsubq_s32, a, b)
    }
    #[inline(always)]
    fn mul_i(self, a: I, b: I) -> I {
        on_quarters!(vmulq_s32, a, b)
    }
    #[inline(always)]
    fn mul_small(self, a: I, b: I) -> I {
        self.mul_i(a, b)
    }
    #[inline(always)]
    fn min_halves(self, a: I, b: I) -> I {
        on_values!(std::array::from_fn(|k| {
            let least = vminq_u16(vreinterpretq_u16_s32(a[k]), vreinterpretq_u16_s32(b[k]));
            vreinterpretq_s32_u16(least)
        }))
    }
    #[inline(always)]
    fn mul_halves(self, a: I, b: I) -> I {
        on_values!(std::array::from_fn(|k| {
            let product = vmulq_s16(vreinterpretq_s16_s32(a[k]), vreinterpretq_s16_s32(b[k]));
            vreinterpretq_s32_s16(product)
        }))
    }
    #[inline(always)]
    fn lerp_halves(self, a: I, b: I, share: I) -> I {
        on_values!(std::array::from_fn(|k| {
            let [a, b, share] = [a[k], b[k], share[k]].map(|x| vreinterpretq_s16_s32(x));
            let part = vqrdmulhq_s16(vsubq_s16(b, a), share);
            vreinterpretq_s32_s16(vaddq_s16(a, part))
        }))
    }
    #[inline(always)]
    fn and_i(self, a: I, b: I) -> I {
        on_quarters!(vandq_s32, a, b)
    }
    #[inline(always)]
    fn min_i(self, a: I, b: I) -> I {
        on_quarters!(vminq_s32, a, b)
    }
    #[inline(always)]
    fn max_i(self, a: I, b: I) -> I {
        on_quarters!(vmaxq_s32, a, b)
    }
    #[inline(always)]
    fn shl_i(self, a: I, by: I) -> I {
        on_quarters!(vshlq_s32, a, by)
    }
    #[inline(always)]
    fn shr_i(self, a: I, by: I) -> I {
        let left = on_quarters!(vnegq_s32, by);
        on_quarters!(vshlq_s32, a, left)
    }
    #[inline(always)]
    fn gt_i(self, a: I, b: I) -> M {
        on_quarters!(vcgtq_s32, a, b)
    }
    #[inline(always)]
    fn eq_i(self, a: I, b: I) -> M {
        on_quarters!(vceqq_s32, a, b)
    }
    #[inline(always)]
    fn select_i(self, mask: M, yes: I, no: I) -> I {
        on_quarters!(vbslq_s32, mask, yes, no)
    }
    #[inline(always)]
    fn add_i_where(self, mask: M, a: I, b: I) -> I {
        let mask = on_quarters!(vreinterpretq_s32_u32, mask);
        self.add_i(a, self.and_i(b, mask))
    }
    #[inline(always)]
    fn bits_of_float(self, number: F) -> I {
        on_values!(number.map(|quarter| vreinterpretq_s32_f32(quarter)))
    }
    #[inline(always)]
    fn float_of_bits(self, bits: I) -> F {
        on_quarters!(vreinterpretq_f32_s32, bits)
    }
    #[inline(always)]
    fn to_float(self, a: I) -> F {
        on_quarters!(vcvtq_f32_s32, a)
    }
    #[inline(always)]
    fn to_int(self, a: F) -> I {
        on_quarters!(vcvtq_s32_f32, a)
    }

    #[inline(always)]
    fn exponent(self, a: F) -> I {
        let bits = on_quarters!(vreinterpretq_u32_f32, a);
        let biased = on_quarters!(vshrq_n_u32::<23>, bits);
        let biased = on_quarters!(vreinterpretq_s32_u32, biased);
        self.sub_i(biased, self.splat_i(127))
    }

    #[inline(always)]
    fn compress_i(self, mask: M, value: I, to: &mut [i32; LANES]) {
        let bits = usize::from(self.bits(mask));
        let to = to.as_mut_ptr();
        let mut end = 0;
        for k in 0..4 {
            let lanes = bits >> (4 * k) & 0xf;
            // SAFETY: a table's entry has sixteen bytes; a quarter takes four of the sixteen
            // places, and no more than those of the quarters before it are before it.
            unsafe {
                let bytes = vld1q_u8(CLOSED_UP[lanes].as_ptr());
                let closed_up = vqtbl1q_u8(vreinterpretq_u8_s32(value[k]), bytes);
                vst1q_s32(to.add(end), vreinterpretq_s32_u8(closed_up));
            }
            end += lanes.count_ones() as usize;
        }
    }

    #[inline(always)]
    fn transpose(self, rows: [I; LANES]) -> [I; LANES] {
        let mut columns = rows;
        for from in 0..4 {
            for to in 0..4 {
                let square = std::array::from_fn(
                    #[inline(always)]
                    |k| rows[4 * from + k][to],
                );
                let square = on_values!(transposed(square));
                for k in 0..4 {
                    columns[4 * to + k][from] = square[k];
                }
            }
        }
        columns
    }

    #[inline(always)]
    fn scatter(self, mask: M, at: I, value: F, to: &mut [f32]) {
        assert!(!to.is_empty());
        let last = to.len() - 1;
        let (mut places, mut values) = ([0; LANES], [0.0; LANES]);
        // All sixteen: how many lanes there are is not foreseen, and to find that out takes longer.
        self.store_i(self.select_i(mask, at, self.splat_i(-1)), &mut places);
        self.store(value, &mut values);
        for k in 0..LANES {
            to[(places[k] as u32 as usize).min(last)] = values[k];
        }
    }

    #[inline(always)]
    fn cells(self, posts: &SlabView<'_, f32>, at: &[i32; LANES], stride: u32) -> [F; 4] {
        corners(posts, at, stride).map(
            #[inline(always)]
            |corner| on_quarters!(vreinterpretq_f32_u32, corner),
        )
    }

    #[inline(always)]
    fn byte_cells(self, bytes: &SlabView<'_, u8>, at: I, stride: u32) -> [F; 4] {
        assert!(bytes.len() >= stride as usize + 2, "a tile has a cell");
        let last = bytes.len() - (stride as usize + 2);
        let mut lanes = [0; LANES];
        self.store_i(at, &mut lanes);
        let places = lanes.map(|lane| (lane as u32 as usize).min(last));
        [0, 1, stride as usize, stride as usize + 1].map(|offset| {
            // SAFETY: from each place on there is a row and two bytes.
            let corner =
                places.map(|place| unsafe { i32::from(bytes.as_ptr().add(place + offset).read()) });
            self.to_float(self.load_i(&corner))
        })
    }

    #[inline(always)]
    fn pairs(self, pairs: &SlabView<'_, [u32; 2]>, at: &[i32; LANES]) -> [I; 2] {
        assert!(!pairs.is_empty());
        let last = pairs.len() - 1;
        // SAFETY: no place is behind the last pair.
        let found =
            at.map(|place| unsafe { pairs.as_ptr().add((place as u32 as usize).min(last)).read() });
        [0, 1].map(|k| self.load_i(&found.map(|pair| pair[k] as i32)))
    }

    #[inline(always)]
    fn pick(self, table: I, at: I) -> I {
        let (mut entries, mut lanes) = ([0; LANES], [0; LANES]);
        self.store_i(table, &mut entries);
        self.store_i(at, &mut lanes);
        for lane in &mut lanes {
            *lane = entries[*lane as usize % LANES];
        }
        self.load_i(&lanes)
    }

    #[inline(always)]
    fn among(self, table: [I; 2], at: I) -> I {
        let (mut numbers, mut lanes) = ([[0; LANES]; 2], [0; LANES]);
        for (numbers, group) in numbers.iter_mut().zip(table) {
            self.store_i(group, numbers);
        }
        self.store_i(at, &mut lanes);
        self.load_i(&lanes.map(|lane| numbers[lane as usize / LANES % 2][lane as usize % LANES]))
    }

    #[inline(always)]
    fn look_up(self, table: &[u32], at: I) -> I {
        assert!(!table.is_empty());
        let last = table.len() - 1;
        let mut lanes = [0; LANES];
        self.store_i(at, &mut lanes);
        for lane in &mut lanes {
            *lane = table[(*lane as u32 as usize).min(last)] as i32;
        }
        self.load_i(&lanes)
    }

    #[inline(always)]
    fn texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        at: &[i32; LANES],
        stride: u32,
        east: F,
        north: F,
    ) -> I {
        let corners = corners(texels, at, stride);
        std::array::from_fn(
            #[inline(always)]
            |k| {
                let corners = corners.map(
                    #[inline(always)]
                    |corner| corner[k],
                );
                on_values!(blend(corners, east[k], north[k]))
            },
        )
    }

    #[inline(always)]
    fn mean_texels(
        self,
        texels: &SlabView<'_, [u8; 4]>,
        stride: u32,
        places: [Texels<'_, Self>; 2],
    ) -> I {
        // Compilers see by themselves what is side by side there.
        let shares = |weights: I| {
            let mut lanes = [0; LANES];
            self.store_i(weights, &mut lanes);
            lanes
        };
        let [first, second] = places.map(|of| Texels::<Portable> {
            at: of.at,
            east: shares(of.east),
            north: shares(of.north),
        });
        let mean = Portable.mean_texels(texels, stride, [first, second]);
        self.load_i(&mean)
    }
}
