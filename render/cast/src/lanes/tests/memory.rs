//! What is written to places, and read from them.

use super::tiles::{TILES, cells, is_cell, slots};
use super::*;

each_isa! {
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

    fn other_lanes_need_no_places<L>(l) {
        let mut random = Random::new();
        for round in 0..GROUPS {
            let a = random.lanes(Random::int);
            // A run of lanes, as pixels of a row are, or any; never none.
            let bits = match round % 3 {
                0 => random.next() as u16 | 1,
                1 => (u16::MAX << random.below(16)) & (u16::MAX >> random.below(16)) | 0x80,
                _ => 1 << random.below(16),
            };
            // No more memory than from the first of them to the last.
            let (first, last) = (bits.trailing_zeros() as usize, bits.ilog2() as usize);
            let mut found = vec![7; last - first + 1];
            let to = found.as_mut_ptr().wrapping_sub(first);
            #[allow(unsafe_code, reason = "what is tested")]
            // SAFETY: there is room from the first one to the last.
            unsafe {
                l.store_those(bits, l.load_i(&a), to);
            }
            let expected: Vec<i32> = (first..=last)
                .map(|k| if truths(bits)[k] { a[k] } else { 7 })
                .collect();
            assert_eq!(found, expected, "on {}", type_name::<L>());
        }
    }

    fn lanes_are_stored_where_a_mask_says<L>(l) {
        let mut random = Random::new();
        for _ in 0..GROUPS {
            let bits = random.next() as u16;
            let (a, before) = (random.lanes(Random::float), random.lanes(Random::float));
            let mut found = before;
            l.store_where(l.mask(bits), l.load(&a), &mut found);
            let expected: Vec<u32> = (0..LANES)
                .map(|k| if truths(bits)[k] { a[k] } else { before[k] }.to_bits())
                .collect();
            assert_eq!(found.map(f32::to_bits).to_vec(), expected, "on {}", type_name::<L>());
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
}
