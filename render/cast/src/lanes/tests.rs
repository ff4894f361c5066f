//! Every instruction set that this processor has against arithmetic lane by lane.

use super::{Isa, Kernel, LANES, Lanes, Portable, Texels};
use sandtable_terrain::{Slab, SlabView, Slot};
use std::any::type_name;
use std::array::from_fn;
use std::sync::Arc;

/// A test of each instruction set: `l` are its lanes.
macro_rules! each_isa {
    ($(fn $name:ident<$lanes:ident>($l:ident) $body:block)*) => {$(
        #[test]
        fn $name() {
            struct Check;
            impl Kernel for Check {
                type Output = ();
                fn run<$lanes: Lanes>(self, $l: $lanes) $body
            }
            for isa in Isa::all_ways() {
                isa.run(Check);
            }
        }
    )*};
}

/// Numbers that look random, the same ones each time.
struct Random(u64);

impl Random {
    fn new() -> Self {
        Self(2463534242)
    }

    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 24) as u32
    }

    fn below(&mut self, limit: u32) -> u32 {
        self.next() % limit
    }

    /// In [0, 1], both ends included.
    fn share(&mut self) -> f32 {
        self.below(10_001) as f32 / 10_000.0
    }

    /// Any bits at all, or one of `special`.
    fn bits(&mut self, special: &[u32]) -> u32 {
        match self.below(3) {
            0 => special[self.below(special.len() as u32) as usize],
            _ => self.next(),
        }
    }

    fn float(&mut self) -> f32 {
        const SPECIAL: [f32; 24] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            -1.5,
            3.0,
            1e-30,
            -1e30,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
            -f32::NAN,
            f32::MIN_POSITIVE,
            -f32::MIN_POSITIVE,
            f32::MIN_POSITIVE / 2.0,
            -f32::MIN_POSITIVE / 4.0,
            1.401e-45,
            f32::MAX,
            f32::MIN,
            8_388_607.5,
            -2_147_483_600.0,
            2_147_483_500.0,
            0.333_333_34,
        ];
        f32::from_bits(self.bits(&SPECIAL.map(f32::to_bits)))
    }

    fn int(&mut self) -> i32 {
        const SPECIAL: [i32; 8] = [0, 1, -1, 2, i32::MAX, i32::MIN, 1 << 24 | 1, 0xffff];
        self.bits(&SPECIAL.map(|special| special as u32)) as i32
    }

    fn lanes<T>(&mut self, mut lane: impl FnMut(&mut Self) -> T) -> [T; LANES] {
        from_fn(|_| lane(self))
    }
}

/// Groups that each test tries: enough for each pair of special values.
const GROUPS: usize = 2000;

fn floats<L: Lanes>(l: L, value: L::F) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    l.store(value, &mut lanes);
    lanes
}

fn ints<L: Lanes>(l: L, value: L::I) -> [i32; LANES] {
    let mut lanes = [0; LANES];
    l.store_i(value, &mut lanes);
    lanes
}

fn truths(mask: u16) -> [bool; LANES] {
    from_fn(|k| mask >> k & 1 == 1)
}

/// The same bits in all lanes.
fn assert_same<L: Lanes>(l: L, what: &str, found: L::F, expected: [f32; LANES]) {
    let (found, expected) = (floats(l, found), expected);
    assert_eq!(
        found.map(f32::to_bits),
        expected.map(f32::to_bits),
        "{what} on {}: {found:?}, not {expected:?}",
        type_name::<L>()
    );
}

/// The same bits in all lanes; of NaNs only that they are: which of its operands' or whose sign a
/// new one gets depends on the processor.
fn assert_same_number<L: Lanes>(l: L, what: &str, found: L::F, expected: [f32; LANES]) {
    let one_nan = |lane: f32| if lane.is_nan() { f32::NAN } else { lane };
    let (found, expected) = (floats(l, found).map(one_nan), expected.map(one_nan));
    assert_eq!(
        found.map(f32::to_bits),
        expected.map(f32::to_bits),
        "{what} on {}: {found:?}, not {expected:?}",
        type_name::<L>()
    );
}

fn assert_same_ints<L: Lanes>(l: L, what: &str, found: L::I, expected: [i32; LANES]) {
    assert_eq!(ints(l, found), expected, "{what} on {}", type_name::<L>());
}

fn assert_same_mask<L: Lanes>(l: L, what: &str, found: L::M, expected: [bool; LANES]) {
    assert_eq!(
        truths(l.bits(found)),
        expected,
        "{what} on {}",
        type_name::<L>()
    );
}

each_isa! {
    fn floats_are_stored_as_they_were_loaded<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let a = random.lanes(Random::float);
            assert_same(l, "load", l.load(&a), a);
            assert_same(l, "splat", l.splat(a[0]), [a[0]; LANES]);
            assert_same(l, "abs", l.abs(l.load(&a)), a.map(f32::abs));
        }
    }

    fn arithmetic_is_rounded_correctly<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let (a, b) = (random.lanes(Random::float), random.lanes(Random::float));
            let (x, y) = (l.load(&a), l.load(&b));
            assert_same_number(l, "add", l.add(x, y), from_fn(|k| a[k] + b[k]));
            assert_same_number(l, "sub", l.sub(x, y), from_fn(|k| a[k] - b[k]));
            assert_same_number(l, "mul", l.mul(x, y), from_fn(|k| a[k] * b[k]));
            assert_same_number(l, "div", l.div(x, y), from_fn(|k| a[k] / b[k]));
            assert_same_number(l, "sqrt", l.sqrt(x), a.map(f32::sqrt));
        }
    }

    fn a_product_is_rounded_before_it_is_added_to<L>(l) {
        let a = [1.0 + f32::EPSILON; LANES];
        let x = l.load(&a);
        let square = l.mul(x, x);
        assert_same(l, "mul and sub", l.sub(square, l.add(x, l.splat(f32::EPSILON))), [0.0; LANES]);
    }

    fn extremes_of_unordered_and_of_equal_numbers_are_the_second<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let (a, b) = (random.lanes(Random::float), random.lanes(Random::float));
            let (x, y) = (l.load(&a), l.load(&b));
            assert_same(l, "min", l.min(x, y), from_fn(|k| if a[k] < b[k] { a[k] } else { b[k] }));
            assert_same(l, "max", l.max(x, y), from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] }));
        }
    }

    fn numbers_are_compared<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let (a, b) = (random.lanes(Random::float), random.lanes(Random::float));
            let (x, y) = (l.load(&a), l.load(&b));
            assert_same_mask(l, "lt", l.lt(x, y), from_fn(|k| a[k] < b[k]));
            assert_same_mask(l, "le", l.le(x, y), from_fn(|k| a[k] <= b[k]));
            assert_same_mask(l, "le", l.le(x, x), from_fn(|k| !a[k].is_nan()));
            let (a, b) = (random.lanes(Random::int), random.lanes(Random::int));
            let (x, y) = (l.load_i(&a), l.load_i(&b));
            assert_same_mask(l, "gt_i", l.gt_i(x, y), from_fn(|k| a[k] > b[k]));
            assert_same_mask(l, "eq_i", l.eq_i(x, y), from_fn(|k| a[k] == b[k]));
            assert_same_mask(l, "eq_i", l.eq_i(x, x), [true; LANES]);
        }
    }

    fn masks_are_sets_of_lanes<L>(l) {
        let mut random = Random::new();
        for bits in 0..=u16::MAX {
            assert_eq!(l.bits(l.mask(bits)), bits, "on {}", type_name::<L>());
            let other = random.next() as u16;
            let (a, b) = (l.mask(bits), l.mask(other));
            assert_eq!(l.bits(l.and(a, b)), bits & other, "on {}", type_name::<L>());
            assert_eq!(l.bits(l.or(a, b)), bits | other, "on {}", type_name::<L>());
            assert_eq!(l.bits(l.and_not(a, b)), bits & !other, "on {}", type_name::<L>());
        }
    }

    fn masks_choose_lanes<L>(l) {
        let mut random = Random::new();
        for bits in 0..=u16::MAX {
            let (mask, yes) = (l.mask(bits), truths(bits));
            let (a, b) = (random.lanes(Random::float), random.lanes(Random::float));
            let (x, y) = (l.load(&a), l.load(&b));
            assert_same(l, "select", l.select(mask, x, y), from_fn(|k| if yes[k] { a[k] } else { b[k] }));
            let (a, b) = (random.lanes(Random::int), random.lanes(Random::int));
            let (x, y) = (l.load_i(&a), l.load_i(&b));
            let chosen = |k: usize| if yes[k] { a[k] } else { b[k] };
            assert_same_ints(l, "select_i", l.select_i(mask, x, y), from_fn(chosen));
            let sum = |k: usize| if yes[k] { a[k].wrapping_add(b[k]) } else { a[k] };
            assert_same_ints(l, "add_i_where", l.add_i_where(mask, x, y), from_fn(sum));
        }
    }

    fn lanes_of_masks_are_closed_up<L>(l) {
        let mut random = Random::new();
        for bits in 0..=u16::MAX {
            let yes = truths(bits);
            let [a, b] = [random.lanes(Random::int), random.lanes(Random::int)];
            let (mask, values) = (l.mask(bits), [l.load_i(&a), l.load_i(&b)]);
            let [mut one, mut first, mut second] = [[0; LANES]; 3];
            l.compress_i(mask, values[0], &mut one);
            l.compress_all(mask, values, [&mut first, &mut second]);
            for (to, lanes) in [(one, a), (first, a), (second, b)] {
                let kept: Vec<_> = (0..LANES).filter(|&k| yes[k]).map(|k| lanes[k]).collect();
                assert_eq!(to[..kept.len()], kept, "on {}", type_name::<L>());
            }
        }
    }

    fn compared_lanes_are_closed_up<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let a = random.lanes(Random::int);
            let mut to = [0; LANES];
            let mask = l.gt_i(l.load_i(&a), l.splat_i(5));
            l.compress_i(mask, l.load_i(&a), &mut to);
            let kept: Vec<_> = a.into_iter().filter(|&lane| lane > 5).collect();
            assert_eq!(to[..kept.len()], kept, "on {}", type_name::<L>());
        }
    }

    fn integers_wrap_around<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let (a, b) = (random.lanes(Random::int), random.lanes(Random::int));
            let (x, y) = (l.load_i(&a), l.load_i(&b));
            assert_same_ints(l, "load_i", x, a);
            assert_same_ints(l, "splat_i", l.splat_i(a[0]), [a[0]; LANES]);
            assert_same_ints(l, "add_i", l.add_i(x, y), from_fn(|k| a[k].wrapping_add(b[k])));
            assert_same_ints(l, "sub_i", l.sub_i(x, y), from_fn(|k| a[k].wrapping_sub(b[k])));
            assert_same_ints(l, "mul_i", l.mul_i(x, y), from_fn(|k| a[k].wrapping_mul(b[k])));
            let [small, others] = [a, b].map(|n| n.map(|n| n & 0x7fff));
            let product = l.mul_small(l.load_i(&small), l.load_i(&others));
            assert_same_ints(l, "mul_small", product, from_fn(|k| small[k] * others[k]));
            let halves = |a: i32, b: i32| {
                let product = |shift: i32| ((a >> shift) as u16).wrapping_mul((b >> shift) as u16);
                i32::from(product(0)) | i32::from(product(16)) << 16
            };
            assert_same_ints(l, "mul_halves", l.mul_halves(x, y), from_fn(|k| halves(a[k], b[k])));
            let share = random.lanes(Random::int);
            let between = |k: usize| {
                let half = |shift: i32| {
                    let [a, b, share] = [a[k], b[k], share[k]].map(|n| i32::from((n >> shift) as i16));
                    // As far apart as they may lie.
                    let (a, b) = (a / 2, b / 2);
                    (a, b, i32::from((a + (((b - a) * share + (1 << 14)) >> 15)) as u16))
                };
                [half(0), half(16)]
            };
            let joined = |low: i32, high: i32| (low & 0xffff) | high << 16;
            let ends = |end: fn((i32, i32, i32)) -> i32| -> [i32; LANES] {
                from_fn(|k| {
                    let [low, high] = between(k).map(end);
                    joined(low, high)
                })
            };
            let (near, far) = (l.load_i(&ends(|half| half.0)), l.load_i(&ends(|half| half.1)));
            let found = l.lerp_halves(near, far, l.load_i(&share));
            assert_same_ints(l, "lerp_halves", found, ends(|half| half.2));
            assert_eq!(l.ends(x), [a[0], a[LANES - 1]], "ends on {}", type_name::<L>());
            assert_same_ints(l, "and_i", l.and_i(x, y), from_fn(|k| a[k] & b[k]));
            assert_same_ints(l, "min_i", l.min_i(x, y), from_fn(|k| a[k].min(b[k])));
            assert_same_ints(l, "max_i", l.max_i(x, y), from_fn(|k| a[k].max(b[k])));
            let by = random.lanes(|random| random.below(32) as i32);
            let y = l.load_i(&by);
            assert_same_ints(l, "shl_i", l.shl_i(x, y), from_fn(|k| a[k] << by[k]));
            assert_same_ints(l, "shr_i", l.shr_i(x, y), from_fn(|k| a[k] >> by[k]));
        }
    }

    fn numbers_are_converted<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let a = random.lanes(Random::int);
            assert_same(l, "to_float", l.to_float(l.load_i(&a)), a.map(|a| a as f32));
            // Only what fits.
            let a = random.lanes(Random::float);
            let a = a.map(|a| if (-2_147_483_648.0..2_147_483_648.0).contains(&a) { a } else { -7.75 });
            assert_same_ints(l, "to_int", l.to_int(l.load(&a)), a.map(|a| a as i32));
        }
        let edge = [-2_147_483_648.0, 2_147_483_520.0, -0.99, 0.99];
        let a = from_fn(|k| edge[k % 4]);
        assert_same_ints(l, "to_int", l.to_int(l.load(&a)), a.map(|a| a as i32));
    }

    fn conversions_of_what_does_not_fit_give_some_number<L>(l) {
        for a in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e9, -3e9] {
            ints(l, l.to_int(l.splat(a)));
            ints(l, l.exponent(l.splat(a)));
        }
    }

    fn exponents_are_logarithms_rounded_down<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let a = random.lanes(Random::float).map(f32::abs);
            let a = a.map(|a| if a.is_normal() { a } else { 1.0 });
            let expected = a.map(|a| f64::from(a).log2().floor() as i32);
            assert_same_ints(l, "exponent", l.exponent(l.load(&a)), expected);
        }
    }

    fn entries_are_picked<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let table = random.lanes(Random::int);
            let at = random.lanes(Random::int);
            let expected = at.map(|at| table[at as usize % LANES]);
            let found = l.pick(l.load_i(&table), l.load_i(&at));
            assert_same_ints(l, "pick", found, expected);
        }
    }

    fn columns_are_given_for_rows<L>(l) {
        let rows: [[i32; LANES]; LANES] = from_fn(|row| from_fn(|col| (100 * row + col) as i32));
        let columns = l.transpose(rows.map(|row| l.load_i(&row)));
        for (col, &found) in columns.iter().enumerate() {
            assert_same_ints(l, "transpose", found, from_fn(|row| rows[row][col]));
        }
    }

    fn lanes_are_scattered_to_their_places<L>(l) {
        let mut random = Random::new();
        for len in [1, 15, 16, 100] {
            for _ in 0..GROUPS {
                let (bits, a) = (random.next() as u16, random.lanes(Random::float));
                // Places behind the end are the last one, which is scratch.
                let at = random.lanes(|random| match random.below(9) {
                    0 => random.int(),
                    _ => random.below(len as u32) as i32,
                });
                let mut found = vec![7.0; len];
                l.scatter(l.mask(bits), l.load_i(&at), l.load(&a), &mut found);
                let mut expected = vec![7.0; len];
                for k in (0..LANES).filter(|&k| truths(bits)[k]) {
                    expected[(at[k] as u32 as usize).min(len - 1)] = a[k];
                }
                let bits = |numbers: &[f32]| -> Vec<u32> {
                    numbers[..len - 1].iter().map(|n| n.to_bits()).collect()
                };
                assert_eq!(bits(&found), bits(&expected), "on {}", type_name::<L>());
            }
        }
    }

    fn pairs_of_lanes_are_scattered_to_their_places<L>(l) {
        let mut random = Random::new();
        for len in [1, 15, 16, 100] {
            for _ in 0..GROUPS {
                let bits = random.next() as u16;
                let (a, b) = (random.lanes(Random::int), random.lanes(Random::int));
                let at = random.lanes(|random| match random.below(9) {
                    0 => random.int(),
                    _ => random.below(len as u32) as i32,
                });
                let mut found = vec![[7; 2]; len];
                let pairs = [l.load_i(&a), l.load_i(&b)];
                l.scatter_pairs(l.mask(bits), l.load_i(&at), pairs, &mut found);
                let mut expected = vec![[7; 2]; len];
                for k in (0..LANES).filter(|&k| truths(bits)[k]) {
                    expected[(at[k] as u32 as usize).min(len - 1)] = [a[k], b[k]];
                }
                // The last one is scratch.
                assert_eq!(found[..len - 1], expected[..len - 1], "on {}", type_name::<L>());
            }
        }
    }

    fn entries_are_looked_up<L>(l) {
        let mut random = Random::new();
        for len in [1, 7, 300] {
            let table: Vec<u32> = (0..len).map(|_| random.next()).collect();
            for _ in 0..GROUPS {
                let at = random.lanes(|random| match random.below(9) {
                    0 => random.int(),
                    _ => random.below(len) as i32,
                });
                let entry = |k: usize| table[(at[k] as u32).min(len - 1) as usize] as i32;
                assert_same_ints(l, "look_up", l.look_up(&table, l.load_i(&at)), from_fn(entry));
            }
        }
    }

    fn memory_is_asked_for_anywhere<L>(l) {
        let (slab, slots) = slots(2, 8, |k| k as f32);
        let view = SlabView::new(&slab, &slots);
        for at in [0, 15, 16, -1, i32::MAX, i32::MIN] {
            l.prefetch::<_, 4>(&view, &[at; LANES], 0);
            l.prefetch::<_, 1>(&view, &[at; LANES], -7);
            l.prefetch_read(&slots[0], at as u32 as usize);
            l.prefetch_write(&slots[0], at as u32 as usize);
        }
    }
}

/// Full slots with items by their places, so many of such a length.
fn slots<T: Copy + bytemuck::Zeroable>(
    count: usize,
    len: usize,
    item: impl Fn(usize) -> T,
) -> (Arc<Slab<T>>, Vec<Slot<T>>) {
    let slab = Slab::new(count, len);
    let slots = (0..count).map(|number| {
        let mut slot = slab.take().expect("free");
        for (k, to) in slot.items_mut().iter_mut().enumerate() {
            *to = item(number * len + k);
        }
        slot
    });
    let slots = slots.collect();
    (slab, slots)
}

/// Tiles of so many posts: (columns, rows, tiles).
const TILES: [[usize; 3]; 3] = [[2, 2, 1], [5, 4, 3], [9, 9, 2]];

/// Places of cells of tiles: lane by lane, with the very last place in each group, and if
/// `anything`, with lanes that lie nowhere.
fn cells(random: &mut Random, [cols, rows, tiles]: [usize; 3], anything: bool) -> [i32; LANES] {
    let below = |random: &mut Random, limit: usize| random.below(limit as u32) as usize;
    let mut places = random.lanes(|random| {
        if anything && random.below(4) == 0 {
            return random.int();
        }
        let tile = below(random, tiles);
        let (col, row) = (below(random, cols - 1), below(random, rows - 1));
        (tile * cols * rows + row * cols + col) as i32
    });
    places[below(random, LANES)] = (tiles * cols * rows - cols - 2) as i32;
    places
}

/// Whether a place is that of a cell.
fn is_cell(place: i32, [cols, rows, tiles]: [usize; 3]) -> bool {
    let place = place as u32 as usize;
    let (tile, within) = (place / (cols * rows), place % (cols * rows));
    tile < tiles && within % cols < cols - 1 && within / cols < rows - 1
}

each_isa! {
    fn corners_of_cells_are_found<L>(l) {
        let mut random = Random::new();
        for tiles in TILES {
            let [cols, rows, count] = tiles;
            let height = |place: usize| place as f32 + 0.25;
            let (slab, slots) = slots(count, cols * rows, height);
            let view = SlabView::new(&slab, &slots);
            for group in 0..GROUPS {
                let at = cells(&mut random, tiles, group % 2 == 1);
                let found = l.cells(&view, &at, cols as u32).map(|corner| floats(l, corner));
                for k in (0..LANES).filter(|&k| is_cell(at[k], tiles)) {
                    let place = at[k] as usize;
                    let corners = [0, 1, cols, cols + 1].map(|further| height(place + further));
                    let found = found.map(|corner| corner[k]);
                    assert_eq!(found, corners, "{place} on {}", type_name::<L>());
                }
            }
        }
    }

    fn corners_of_bytes_are_found<L>(l) {
        let mut random = Random::new();
        for [cols, rows, count] in TILES {
            // Real slabs have room to spare; one slot more is enough for what is read beside.
            let tiles = [cols, rows, count + 1];
            let light = |place: usize| (place * 37 % 251) as u8;
            let (slab, slots) = slots(count + 1, cols * rows, light);
            let view = SlabView::new(&slab, &slots);
            for group in 0..GROUPS {
                let at = cells(&mut random, tiles, group % 2 == 1);
                let found = l.byte_cells(&view, l.load_i(&at), cols as u32).map(|corner| floats(l, corner));
                for k in (0..LANES).filter(|&k| is_cell(at[k], tiles)) {
                    let place = at[k] as usize;
                    let corners = [0, 1, cols, cols + 1].map(|further| f32::from(light(place + further)));
                    let found = found.map(|corner| corner[k]);
                    assert_eq!(found, corners, "{place} on {}", type_name::<L>());
                }
            }
        }
    }

    fn bits_are_numbers<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let numbers = random.lanes(Random::float);
            let bits = numbers.map(|number| number.to_bits() as i32);
            assert_same(l, "float_of_bits", l.float_of_bits(l.load_i(&bits)), numbers);
            assert_same_ints(l, "bits_of_float", l.bits_of_float(l.load(&numbers)), bits);
        }
    }

    fn pairs_of_numbers_are_found<L>(l) {
        let mut random = Random::new();
        for [count, len] in [[1, 1], [1, 7], [3, 21], [2, 30_000]] {
            let pair = |place: usize| [7 * place as u32, u32::MAX - place as u32];
            let (slab, slots) = slots(count, len, pair);
            let view = SlabView::new(&slab, &slots);
            let places = (count * len) as u32;
            for group in 0..GROUPS {
                let mut at = random.lanes(|random| match random.below(4) {
                    0 if group % 2 == 1 => random.int(),
                    _ => random.below(places) as i32,
                });
                at[random.below(LANES as u32) as usize] = places as i32 - 1;
                let found = l.pairs(&view, &at).map(|numbers| ints(l, numbers));
                for k in (0..LANES).filter(|&k| (at[k] as u32) < places) {
                    let pair = pair(at[k] as usize).map(|number| number as i32);
                    let name = type_name::<L>();
                    assert_eq!([found[0][k], found[1][k]], pair, "{} on {name}", at[k]);
                }
            }
        }
    }

    fn lanes_are_picked_from_among_two_groups<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let tables = [random.lanes(Random::int), random.lanes(Random::int)];
            let at = random.lanes(Random::int);
            let found = l.among(tables.each_ref().map(|table| l.load_i(table)), l.load_i(&at));
            let expected = at.map(|at| tables[at as usize / LANES % 2][at as usize % LANES]);
            assert_eq!(ints(l, found), expected, "{}", type_name::<L>());
        }
    }

    fn texels_are_blended_as_by_the_reference<L>(l) {
        let mut random = Random::new();
        for tiles in TILES {
            let [cols, rows, count] = tiles;
            let texel = |place: usize| -> [u8; 4] {
                let hash = (place as u32 + 1).wrapping_mul(2_654_435_761);
                let [r, g, b, a] = hash.to_be_bytes();
                // Black and white in between, for the widest steps.
                match place % 3 {
                    0 => [0, 255, r, 255],
                    1 => [255, 0, g, 255],
                    _ => [r, g, b, a],
                }
            };
            let (slab, slots) = slots(count, cols * rows, texel);
            let view = SlabView::new(&slab, &slots);
            for group in 0..GROUPS {
                let anything = group % 2 == 1;
                let at = cells(&mut random, tiles, anything);
                let weight = |random: &mut Random| match random.below(6) {
                    0 => 0.0,
                    1 => 1.0,
                    _ => random.share(),
                };
                let (mut east, mut north) = (random.lanes(weight), random.lanes(weight));
                for k in (0..LANES).filter(|&k| !is_cell(at[k], tiles)) {
                    (east[k], north[k]) = (random.float(), random.float());
                }
                let found = l.texels(
                    &view,
                    &at,
                    cols as u32,
                    l.load(&east),
                    l.load(&north),
                );
                let found = ints(l, found).map(i32::to_ne_bytes);
                let expected = Portable.texels(&view, &at, cols as u32, east, north);
                for k in (0..LANES).filter(|&k| is_cell(at[k], tiles)) {
                    let place = at[k] as usize;
                    let [sw, se, nw, ne] = [0, 1, cols, cols + 1].map(|further| texel(place + further));
                    assert_eq!(found[k], expected[k].to_ne_bytes(), "{place} on {}", type_name::<L>());
                    for channel in 0..4 {
                        let along = |from: [f64; 2], share: f32| from[0] + (from[1] - from[0]) * f64::from(share);
                        let [sw, se, nw, ne] = [sw, se, nw, ne].map(|texel| f64::from(texel[channel]));
                        let blend = along([along([sw, se], east[k]), along([nw, ne], east[k])], north[k]);
                        let found = f64::from(found[k][channel]);
                        assert!((found - blend).abs() < 0.55, "{found}, not {blend}, on {}", type_name::<L>());
                    }
                }
            }
        }
    }

    fn the_mean_of_texels_is_the_references<L>(l) {
        let mut random = Random::new();
        for tiles in TILES {
            let [cols, rows, count] = tiles;
            let texel = |place: usize| (place as u32 + 1).wrapping_mul(2_654_435_761).to_be_bytes();
            let (slab, slots) = slots(count, cols * rows, texel);
            let view = SlabView::new(&slab, &slots);
            for group in 0..GROUPS {
                let anything = group % 2 == 1;
                let at: [_; 2] = from_fn(|_| cells(&mut random, tiles, anything));
                // From one texel to the next, both ends included, in 15-bit fixed point.
                let weight = |random: &mut Random| (random.share() * 32767.0) as i32;
                let east: [_; 2] = from_fn(|_| random.lanes(weight));
                let north: [_; 2] = from_fn(|_| random.lanes(weight));
                let places = [0, 1].map(|n| Texels {
                    at: &at[n],
                    east: l.load_i(&east[n]),
                    north: l.load_i(&north[n]),
                });
                let found = ints(l, l.mean_texels(&view, cols as u32, places));
                let places = [0, 1].map(|n| Texels::<Portable> {
                    at: &at[n],
                    east: east[n],
                    north: north[n],
                });
                let expected = Portable.mean_texels(&view, cols as u32, places);
                for k in (0..LANES).filter(|&k| at.iter().all(|at| is_cell(at[k], tiles))) {
                    assert_eq!(found[k], expected[k], "lane {k} on {}", type_name::<L>());
                    for channel in 0..4 {
                        let blend = |n: usize| {
                            let place = at[n][k] as usize;
                            let corner = |further: usize| f64::from(texel(place + further)[channel]);
                            let [east, north] = [east[n][k], north[n][k]].map(|share| f64::from(share) / 32767.0);
                            let south = corner(0) + (corner(1) - corner(0)) * east;
                            let north_row = corner(cols) + (corner(cols + 1) - corner(cols)) * east;
                            south + (north_row - south) * north
                        };
                        let mean = 0.5 * (blend(0) + blend(1));
                        let found = f64::from(found[k].to_ne_bytes()[channel]);
                        // Half of a byte, and 1 / 128 of the steps between texels.
                        assert!((found - mean).abs() < 2.6, "{found}, not {mean}");
                    }
                }
            }
        }
    }

    fn opaque_texels_stay_opaque<L>(l) {
        let (slab, slots) = slots(1, 4, |_| [9, 200, 77, 255]);
        let view = SlabView::new(&slab, &slots);
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let (east, north) = (random.lanes(Random::share), random.lanes(Random::share));
            let found = l.texels(&view, &[0; LANES], 2, l.load(&east), l.load(&north));
            let expected = [i32::from_ne_bytes([9, 200, 77, 255]); LANES];
            assert_same_ints(l, "texels", found, expected);
            let share = |random: &mut Random| random.below(1 << 15) as i32;
            let place = Texels {
                at: &[0; LANES],
                east: l.load_i(&random.lanes(share)),
                north: l.load_i(&random.lanes(share)),
            };
            assert_same_ints(l, "mean_texels", l.mean_texels(&view, 2, [place; 2]), expected);
        }
    }
}

#[test]
fn the_best_is_the_first_and_the_reference_the_last() {
    let names: Vec<_> = Isa::all().into_iter().map(Isa::name).collect();
    assert_eq!(names[0], Isa::best().name());
    assert_eq!(names.last(), Some(&"portable"));
    let order = ["avx512", "avx2", "neon", "portable"];
    let ranks: Vec<_> = names
        .iter()
        .map(|name| order.iter().position(|other| other == name))
        .collect();
    assert!(ranks.is_sorted() && !ranks.contains(&None), "{names:?}");
}
