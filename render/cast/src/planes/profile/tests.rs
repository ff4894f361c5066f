//! Profiles against the ground.

use super::crossing::Crossing;
use super::*;
use crate::lanes::Portable;
use crate::planes::field::Axis;
use crate::planes::field::Field;
use crate::planes::frame::Level;
use crate::planes::roofs::Roofs;
use crate::planes::steepness::Steepness;
use glam::DVec2;
use sandtable_terrain::{Ground, TiledRaster};

/// Rough ground of more tiles than one with its colours, as `each_field` has it.
fn each_rough_field(check: impl Fn(&Field<'_>, &Ground, &TiledRaster<[u8; 4]>)) {
    let height = |col: u32, row: u32| {
        let rough = ((col * 37 + row * 91) % 113) as f32;
        60.0 + 0.02 * rough + 30.0 * (0.04 * col as f32).sin() + 20.0 * (0.03 * row as f32).cos()
    };
    let colour = |col: u32, row: u32| {
        let code = |k: u32| ((col * (31 + k) + row * (17 + 3 * k)) % 251) as u8;
        [code(0), code(1), code(2), 255]
    };
    each_field([600, 540], height, colour, check);
}

/// Ground with its colours, and an eye beside it; the sign of its rays along either axis, and which of the
/// ground's axes the major one is, for each way that there is.
fn each_field(
    [cols, rows]: [u32; 2],
    height: impl Fn(u32, u32) -> f32 + Sync,
    colour: impl Fn(u32, u32) -> [u8; 4] + Sync,
    check: impl Fn(&Field<'_>, &Ground, &TiledRaster<[u8; 4]>),
) {
    let ground = Ground::from_fn(cols, rows, DVec2::ONE, height).expect("a sound grid");
    let colours = TiledRaster::from_fn(cols, rows, colour);
    let roofs = Roofs::new(ground.heights());
    let steepness = Steepness::new(ground.heights());
    let level = Level::new(ground.heights(), &roofs, &steepness).with_colours(&colours);
    for k in 0..8 {
        let major_axis = k & 1;
        let axis = |axis: usize, sign: i32| {
            let cells = level.cells[axis];
            let eye = if sign > 0 {
                -3.3
            } else {
                f64::from(cells) + 2.6
            };
            Axis::new(eye, cells, sign)
        };
        let sign = |bit: usize| if k & bit == 0 { 1 } else { -1 };
        let axes = [axis(major_axis, sign(2)), axis(1 - major_axis, sign(4))];
        let mut field = Field::of_level(&level, axes, major_axis);
        field.eye_height = 7.0;
        // Memory is asked for as it is of large grounds.
        field.ahead = (k & 2 == 0).then_some(0);
        check(&field, &ground, &colours);
    }
}

/// A channel of the colour at a place between posts.
fn code_at(colours: &TiledRaster<[u8; 4]>, [x, y]: [f64; 2], channel: usize) -> f64 {
    let ([col, row], [u, v]) = colours.locate(x, y);
    let [sw, se, nw, ne] = colours
        .cell(col, row)
        .map(|texel| f64::from(texel[channel]));
    let (south, north) = (sw + (se - sw) * u, nw + (ne - nw) * u);
    south + (north - south) * v
}

/// Planes from one that advances by `first` on, each by `more` more.
fn planes(first: f32, more: f32) -> PlaneGroup<Portable> {
    PlaneGroup::new(Portable, &std::array::from_fn(|k| first + more * k as f32))
}

/// Close together and far apart, inside of tiles and across their borders.
const GROUPS: [[f32; 2]; 4] = [[0.3, 1e-4], [0.9, -0.004], [0.05, 0.02], [0.0, 0.06]];

/// Where on the ground a place of a field lies.
fn place(field: &Field<'_>, major: f64, minor: f64) -> [f64; 2] {
    let along = |axis: &Axis, at: f64| {
        // Line 0 lies `fraction` before the eye.
        let lines = at + f64::from(axis.fraction);
        f64::from(axis.post(0)) + f64::from(axis.sign) * lines
    };
    let (major, minor) = (along(&field.major, major), along(&field.minor, minor));
    if field.major_axis == 0 {
        [major, minor]
    } else {
        [minor, major]
    }
}

fn ground_height(field: &Field<'_>, ground: &Ground, major: f64, minor: f64) -> Option<f64> {
    let [x, y] = place(field, major, minor);
    ground.height_at(x, y)
}

#[test]
fn profiles_are_the_grounds() {
    each_rough_field(|field, ground, colours| {
        for [first, more] in GROUPS {
            let planes = planes(first, more);
            let mut found = 0;
            for line in field.major.cells[0]..=field.major.cells[1] + 1 {
                let t = line as f32 - field.major.fraction;
                let crossing = Crossing::new(Portable, field, &planes, line, 0);
                let posts = crossing.posts(Portable, field, &planes);
                let heights = crossing.heights(Portable, posts);
                let tiles = field.colours.expect("they were given");
                let halves = crossing.colours(Portable, field, &planes, tiles);
                for (k, (height, advance)) in heights.iter().zip(planes.advance).enumerate() {
                    let (t, aside) = (f64::from(t), f64::from(advance) * f64::from(t));
                    let Some(truth) = ground_height(field, ground, t, aside) else {
                        continue;
                    };
                    let height = f64::from(height + field.eye_height);
                    assert!((height - truth).abs() < 0.05, "{height} and {truth} at {t}");
                    let place = place(field, t, aside);
                    for channel in 0..4 {
                        let truth = code_at(colours, place, channel);
                        let half = halves[channel % 2][k] >> (channel / 2 * 16) & 0xffff;
                        let off = (f64::from(half) - truth).abs();
                        assert!(off < 2.5, "{half} and {truth} at {t}");
                    }
                    found += 1;
                }
            }
            assert!(found > 4000, "{found}");
        }
    });
}

/// A stretch of the border has the mean of its colours, up to the ground's corners.
#[test]
fn the_borders_colours_are_the_grounds() {
    each_rough_field(|field, _, colours| {
        let axes = [&field.major, &field.minor];
        let begins = axes.map(|axis| axis.line(axis.cells[0]));
        let ends = axes.map(|axis| axis.line(axis.cells[1] + 1));
        for (border, along) in [(Border::Front, 1), (Border::Side, 0)] {
            for k in 0..200 {
                let from = begins[along] + (ends[along] - begins[along]) * k as f32 / 199.0;
                // In one cell, and over some.
                for (length, most) in [(0.0, 1.0), (0.4, 8.0), (2.6, 20.0)] {
                    let stretch = [from, (from + length).min(ends[along])];
                    let fields = std::slice::from_ref(field);
                    let mean = border.mean_colour(fields, begins, stretch);
                    for channel in 0..4 {
                        let truth = (0..100).map(|k| {
                            let share = (f64::from(k) + 0.5) / 100.0;
                            let [from, to] = stretch.map(f64::from);
                            let there = from + (to - from) * share;
                            let [major, minor] = begins.map(f64::from);
                            let place = match border {
                                Border::Front => place(field, major, there),
                                Border::Side => place(field, there, minor),
                            };
                            code_at(colours, place, channel)
                        });
                        let truth = truth.sum::<f64>() / 100.0;
                        let off = (f64::from(mean[channel]) - truth).abs();
                        assert!(off < most, "{mean:?} and {truth} at {stretch:?}");
                    }
                }
            }
        }
    });
}

/// The colours of a bent profile's pieces are the ground's, however cells are twisted.
#[test]
fn bent_colours_are_the_grounds() {
    each_rough_field(|field, _, colours| {
        let tiles = field.colours.expect("they were given");
        let (mut found, mut crossing) = (0, 0);
        for [first, more] in [[0.3, 1e-3], [0.9, -0.004], [0.05, 0.02]] {
            let planes = planes(first, more);
            let line = |line: i32| {
                let crossing = Crossing::new(Portable, field, &planes, line, 1);
                let texels = crossing.texels(Portable, field, &planes, tiles);
                (crossing, texels)
            };
            for number in (field.major.cells[0]..=field.major.cells[1]).step_by(3) {
                let [before, behind] = [line(number), line(number + 1)];
                let lines = [&before.0, &behind.0];
                let bend = Bend::new(Portable, &planes, lines, 1.0);
                let bent = bend.colours(Portable, lines, [&before.1, &behind.1]);
                let t = number as f32 - field.major.fraction;
                for (k, &advance) in planes.advance.iter().enumerate() {
                    let at = |share: f64| {
                        let t = f64::from(t) + share;
                        place(field, t, f64::from(advance) * t)
                    };
                    let inside = |[x, y]: [f64; 2]| {
                        let last = [colours.cols(), colours.rows()].map(|n| f64::from(n - 1));
                        (0.0..=last[0]).contains(&x) && (0.0..=last[1]).contains(&y)
                    };
                    if !inside(at(0.0)) || !inside(at(1.0)) {
                        continue;
                    }
                    crossing += usize::from(bend.crosses[k] != 0);
                    let share = f64::from(bend.share[k]);
                    let red = |halves: &[[i32; LANES]; 2]| {
                        f64::from(halves[0][k] & 0xffff) / f64::from(FINE)
                    };
                    for (piece, ends) in [[0.0, share], [share, 1.0]].into_iter().enumerate() {
                        let [begin, end] = [&bent.ends[piece], &bent.ends[piece + 1]].map(red);
                        let control = red(&bent.controls[piece]);
                        for s in [0.0, 0.3, 0.5, 0.8, 1.0] {
                            let [one, other] =
                                [[begin, control], [control, end]].map(|[a, b]| a + (b - a) * s);
                            let seen = one + (other - one) * s;
                            let place = at(ends[0] + (ends[1] - ends[0]) * s);
                            let truth = code_at(colours, place, 0);
                            assert!((seen - truth).abs() < 0.5, "{seen}, {truth} at {s}");
                            found += 1;
                        }
                    }
                }
            }
        }
        assert!(found > 10_000 && crossing > 500, "{found}, {crossing}");
    });
}

/// Bends lie on the ground, too; where cells are not twisted, so do the straight pieces between.
#[test]
fn bends_are_the_grounds() {
    // Ridges and valleys along both axes.
    let folded = |col: u32, row: u32| 50.0 + (col * 7 % 5) as f32 + (row * 5 % 7) as f32;
    each_field(
        [80, 70],
        folded,
        |_, _| [0; 4],
        |field, ground, _| {
            let (mut found, mut crossing) = (0, 0);
            for [first, more] in [[0.3, 1e-3], [0.9, -0.01], [0.05, 0.02]] {
                let planes = planes(first, more);
                let line = |line: i32| {
                    let crossing = Crossing::new(Portable, field, &planes, line, 1);
                    let posts = crossing.posts(Portable, field, &planes);
                    let heights = crossing.heights(Portable, posts);
                    (crossing, posts, heights)
                };
                for number in field.major.cells[0]..=field.major.cells[1] {
                    let [before, behind] = [line(number), line(number + 1)];
                    let bend = Bend::new(Portable, &planes, [&before.0, &behind.0], 1.0);
                    let heights = bend.heights(Portable, before.1, behind.1);
                    let t = number as f32 - field.major.fraction;
                    for (k, &advance) in planes.advance.iter().enumerate() {
                        let share = bend.share[k];
                        crossing += usize::from(bend.crosses[k] != 0);
                        let ends = [(0.0, before.2[k]), (share, heights[k]), (1.0, behind.2[k])];
                        for [(from, low), (to, high)] in [[ends[0], ends[1]], [ends[1], ends[2]]] {
                            for part in 0..=4 {
                                let part = part as f32 / 4.0;
                                let t = f64::from(t + from + (to - from) * part);
                                let aside = f64::from(advance) * t;
                                let Some(truth) = ground_height(field, ground, t, aside) else {
                                    continue;
                                };
                                let height =
                                    f64::from(low + (high - low) * part + field.eye_height);
                                assert!((height - truth).abs() < 2e-3, "{height}, {truth}");
                                found += 1;
                            }
                        }
                    }
                }
            }
            assert!(found > 10_000 && crossing > 500, "{found}, {crossing}");
        },
    );
}

/// The highest slope at which a plane sees the ground that it crosses along so many lines from `line` on.
fn highest_slope(field: &Field<'_>, ground: &Ground, advance: f32, line: i32, count: i32) -> f64 {
    let places = (0..3 * count).map(|third| f64::from(line) + f64::from(third) / 3.0);
    let slopes = places.filter_map(|line| {
        let t = line - f64::from(field.major.fraction);
        let height = ground_height(field, ground, t, f64::from(advance) * t)?;
        Some((height - f64::from(field.eye_height)) / t.max(0.1))
    });
    slopes.fold(-1e3, f64::max)
}

/// Looks from where every row of blocks begins, over horizons that lie so many metres over the ground there
/// or a little more. Where blocks are passed, no plane that goes on must see any ground of theirs. Gives of
/// how many rows nothing is seen, and how many lines are passed.
fn pass_blocks(field: &Field<'_>, ground: &Ground, metres: [f64; 3]) -> [i32; 2] {
    let (mut hidden, mut lines) = (0, 0);
    for (number, [first, more]) in GROUPS.into_iter().enumerate() {
        let groups = [0.0, 16.0].map(|k| planes(first + more * k, more));
        let blocks = field.major.cells[0]..=field.major.cells[1] + 1;
        for (at, from) in blocks
            .filter(|&line| field.major.is_block(line))
            .enumerate()
        {
            let t = f64::from(from) - f64::from(field.major.fraction);
            let mut outlooks = groups.each_ref().map(|group| {
                let (none, nowhere) = ([0; LANES], [-1e3; LANES]);
                Outlook::new(group, none, nowhere)
            });
            for outlook in &mut outlooks {
                for k in (0..LANES).filter(|k| k % 7 != 3) {
                    let metres = metres[(at + number) % 3] + 0.2 * (k % 5) as f64;
                    let ground = highest_slope(field, ground, outlook.advance[k], from, 8);
                    outlook.live[k] = u32::MAX;
                    outlook.horizon[k] = (ground + metres / t) as f32;
                }
            }
            let is_hidden = |outlooks: &[Outlook<Portable>; 2], count: i32, room: f64| {
                outlooks.iter().all(|outlook| {
                    (0..LANES).filter(|&k| outlook.live[k] != 0).all(|k| {
                        let slope = highest_slope(field, ground, outlook.advance[k], from, count);
                        slope < f64::from(outlook.horizon[k]) + room
                    })
                })
            };
            hidden += i32::from(is_hidden(&outlooks, 8, 0.0));
            let copies = outlooks.each_ref().map(|outlook| Outlook { ..*outlook });
            if let Some(behind) = passed(Portable, field, copies, from, f32::INFINITY) {
                assert!(
                    is_hidden(&outlooks, behind - from, 1e-5),
                    "{from} to {behind}"
                );
                lines += behind - from;
            }
        }
    }
    [hidden, lines]
}

#[test]
fn what_is_passed_is_hidden() {
    each_rough_field(|field, ground, _| {
        let [hidden, lines] = pass_blocks(field, ground, [-4.0, 1.0, 6.0]);
        assert!(
            hidden > 50 && lines > 3 * hidden,
            "{lines} lines, {hidden} blocks"
        );
    });
    // The roofs of whole blocks lie on this ground.
    let folded = |col: u32, row: u32| {
        let fold = |post: u32| (post % 64).abs_diff(32) as f32;
        30.0 + 0.8 * fold(col) + 0.7 * fold(row)
    };
    each_field(
        [600, 540],
        folded,
        |_, _| [0; 4],
        |field, ground, _| {
            let [hidden, lines] = pass_blocks(field, ground, [-0.3, 0.05, 3.0]);
            assert!(
                hidden > 50 && lines > 2 * hidden,
                "{lines} lines, {hidden} blocks"
            );
        },
    );
}
