//! Colours are blended as by the reference.

use super::tiles::{TILES, cells, is_cell, slots};
use super::*;

each_isa! {
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
