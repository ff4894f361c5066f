//! Numbers, masks and integers.

use super::*;

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

    fn shares_are_told_from_other_numbers<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            // From -1/2 to 3/2, and both ends among them.
            let mut number = || random.lanes(Random::int).map(|of| (of & 7) as f32 * 0.25 - 0.5);
            let (a, b) = (number(), number());
            let is_share = |of: f32| (0.0..=1.0).contains(&of);
            let are_shares = from_fn(|k| is_share(a[k]) && is_share(b[k]));
            assert_same_mask(l, "are_shares", l.are_shares(l.load(&a), l.load(&b)), are_shares);
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
            let least = |a: i32, b: i32| {
                let least = |shift: i32| ((a >> shift) as u16).min((b >> shift) as u16);
                i32::from(least(0)) | i32::from(least(16)) << 16
            };
            assert_same_ints(l, "min_halves", l.min_halves(x, y), from_fn(|k| least(a[k], b[k])));
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
            let y = l.splat_i(by[0]);
            assert_same_ints(l, "shl_i", l.shl_i(x, y), a.map(|a| a << by[0]));
            assert_same_ints(l, "shr_i", l.shr_i(x, y), a.map(|a| a >> by[0]));
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

    fn bits_are_numbers<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let numbers = random.lanes(Random::float);
            let bits = numbers.map(|number| number.to_bits() as i32);
            assert_same(l, "float_of_bits", l.float_of_bits(l.load_i(&bits)), numbers);
            assert_same_ints(l, "bits_of_float", l.bits_of_float(l.load(&numbers)), bits);
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
}
