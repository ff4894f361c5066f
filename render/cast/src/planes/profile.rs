//! Profiles of the ground along vertical planes: its heights where planes cross lines of posts.

use super::field::{Axis, Field};
use super::roofs::LEVEL_BEGIN;
use super::walk::corners;
use crate::lanes::{LANES, Lanes};

/// Sixteen neighbouring vertical planes through the eye.
pub(super) struct PlaneGroup<L: Lanes> {
    /// Cells along the minor axis for each one along the major axis.
    pub(super) advance: L::F,
    /// Of the first and the last plane.
    pub(super) outer: [f32; 2],
}

impl<L: Lanes> PlaneGroup<L> {
    /// From which to which mirrored cell of the minor axis they reach, up to where they come in `t`
    /// cells from where they are in `from` cells.
    #[inline(always)]
    fn cells(&self, field: &Field<'_>, [from, to]: [f32; 2]) -> [i32; 2] {
        let [first, last] = self.outer;
        [
            field.minor.cell_alone(first.min(last) * from),
            field.minor.cell_alone(first.max(last) * to),
        ]
    }
}

/// Levels of blocks that planes may pass at once, as [`roofs`](super::roofs) has them: the larger
/// first.
pub(super) const PASSED: [usize; 3] = [6, 5, 4];

/// The smallest of them.
const LEAST_PASSED: usize = PASSED[PASSED.len() - 1];

/// How high over the eye, in metres, the ground rises at most that planes pass between the mirrored
/// line `line` and the one that lies 2 ^ `level` cells further; `None` where blocks do not begin at
/// that line, or the ground ends before.
#[inline(always)]
pub(super) fn ceiling<L: Lanes>(
    field: &Field<'_>,
    planes: &PlaneGroup<L>,
    line: i32,
    level: usize,
) -> Option<f32> {
    let (major, minor) = (&field.major, &field.minor);
    let size = 1 << level;
    let post = major.post(line);
    if post & (size - 1) != 0 || line < major.cells[0] || line + size > major.cells[1] + 1 {
        return None;
    }
    let from = line as f32 - major.fraction;
    let [first, last] = planes.cells(field, [from, from + size as f32]);
    let cells = [first, last].map(|cell| minor.ground_alone(cell) >> level);
    let along = major.ground_alone(line);
    let half = size as f32 * 0.5;
    let mut most = f32::MIN;
    for block in cells[0].min(cells[1])..=cells[0].max(cells[1]) {
        let aside = block << level;
        let (x, y) = if field.major_axis == 0 {
            (along, aside)
        } else {
            (aside, along)
        };
        let within = (((y & 255) >> level) << (8 - level)) + ((x & 255) >> level);
        let place = field.roofs.tile(x >> 8, y >> 8) + (LEVEL_BEGIN[level] + within) as u32;
        let [height, rise] = *field.roofs.items.from_place(place).first()?;
        let [east, north] = [rise << 16, rise & 0xffff_0000].map(|rise| f32::from_bits(rise).abs());
        most = most.max(f32::from_bits(height) + half * (east + north));
    }
    Some(most - field.eye_height + field.rounding)
}

/// Neighbouring posts of one line.
struct Posts<L: Lanes> {
    posts: [L::F; 2],
    /// What to take a mirrored line's number from for its place among them, or to take from that.
    from: i32,
    sign: i32,
}

/// Posts that are read at once.
const ROOM: i32 = 2 * LANES as i32;

/// How many lines of posts ahead memory is asked for, where lines are rows.
const ROWS_AHEAD: i32 = 8;

/// The same where they are columns: as many as there are in a line of the processor's cache.
const COLUMNS_AHEAD: i32 = 16;

impl Axis {
    /// The post on a mirrored line.
    fn post(&self, line: i32) -> i32 {
        if self.sign > 0 {
            self.base + line
        } else {
            self.base + 1 - line
        }
    }

    /// Whether at a mirrored line blocks begin that planes may pass.
    pub(super) fn is_block(&self, line: i32) -> bool {
        self.post(line) & ((1 << LEAST_PASSED) - 1) == 0
    }

    /// The ground's cell that is a mirrored one.
    fn ground_alone(&self, cell: i32) -> i32 {
        if self.sign > 0 {
            self.base + cell
        } else {
            self.base - cell
        }
    }

    /// As `cell`, of one place.
    fn cell_alone(&self, along: f32) -> i32 {
        let cell = (along + self.fraction) as i32;
        cell.min(self.cells[1]).max(self.cells[0])
    }
}

/// The ground's heights over the eye, in metres, where planes cross the mirrored line `line` of
/// posts, which is `t` cells of this resolution away along the major axis. Beside the ground its
/// outermost cells' slopes go on.
#[inline(always)]
pub(super) fn heights<L: Lanes>(
    l: L,
    field: &Field<'_>,
    planes: &PlaneGroup<L>,
    line: i32,
    t: f32,
) -> L::F {
    let line = line.max(field.major.cells[0]).min(field.major.cells[1] + 1);
    let along = l.mul(planes.advance, l.splat(t));
    let cell = field.minor.cell(l, along);
    let share = l.sub(
        l.add(along, l.splat(field.minor.fraction)),
        l.to_float(cell),
    );
    let cells = planes.cells(field, [t; 2]);
    let [near, far] = match posts(l, field, line, cells) {
        Some(Posts { posts, from, sign }) => {
            let from = l.splat_i(from);
            let (at, next) = if sign > 0 {
                (l.sub_i(cell, from), l.splat_i(1))
            } else {
                (l.sub_i(from, cell), l.splat_i(-1))
            };
            [l.among(posts, at), l.among(posts, l.add_i(at, next))]
        }
        None => apart(l, field, line, cell),
    };
    let height = l.add(near, l.mul(l.sub(far, near), share));
    l.sub(height, l.splat(field.eye_height))
}

/// The posts of a line that mirrored cells from the first to the last of `cells` have, where they
/// lie in one tile and are few enough.
#[inline(always)]
fn posts<L: Lanes>(
    l: L,
    field: &Field<'_>,
    line: i32,
    [first, last]: [i32; 2],
) -> Option<Posts<L>> {
    let minor = &field.minor;
    let begin = minor.post(first).min(minor.post(last + 1));
    let count = last - first + 2;
    let within = begin & 255;
    if count > ROOM || within + count > 257 {
        return None;
    }
    let major_post = field.major.post(line);
    // The last post of an axis belongs to the cell before it.
    let major_cells = field.major.cells[1] - field.major.cells[0];
    let major_tile = major_post.min(major_cells) >> 8;
    let major_within = major_post - (major_tile << 8);
    let heights = field.heights;
    let stride = heights.stride as usize;
    let is_column = field.major_axis == 0;
    let (tile, place) = if is_column {
        (
            heights.tile(major_tile, begin >> 8),
            within as usize * stride + major_within as usize,
        )
    } else {
        (
            heights.tile(begin >> 8, major_tile),
            major_within as usize * stride + within as usize,
        )
    };
    let place = tile + place as u32;
    if field.ahead.is_some() {
        let towards = field.major.sign;
        let (places, further) = if is_column {
            // A third of the lines that the next sixteen columns lie in.
            let row = 3 * (line & 7);
            let places = [0, 1, 2, 2].map(|k| (row + k).min(count) as u32 * stride as u32 + place);
            (places, towards * COLUMNS_AHEAD)
        } else {
            let places = [0, 15, 31, 31].map(|k: u32| place + k);
            (places, towards * ROWS_AHEAD * stride as i32)
        };
        let places = std::array::from_fn(|k| places[k / 4] as i32);
        l.prefetch::<_, 4>(&heights.items, &places, further);
    }
    let items = heights.items.from_place(place);
    let posts = if is_column {
        if items.len() <= (ROOM as usize - 1) * stride {
            return None;
        }
        let half = |from: usize| l.load(&std::array::from_fn(|k| items[(from + k) * stride]));
        let high = if count > LANES as i32 {
            half(LANES)
        } else {
            l.splat(0.0)
        };
        [half(0), high]
    } else {
        let (low, rest) = items.split_first_chunk::<LANES>()?;
        [l.load(low), l.load(rest.first_chunk::<LANES>()?)]
    };
    Some(Posts {
        posts,
        from: if minor.sign > 0 { first } else { last + 1 },
        sign: minor.sign,
    })
}

/// The near and the far posts of a line around planes, wherever they lie.
#[inline(always)]
fn apart<L: Lanes>(l: L, field: &Field<'_>, line: i32, minor: L::I) -> [L::F; 2] {
    l.vectorize(
        #[inline(always)]
        || {
            // A line's posts are the near ones of the cell behind it; the last one's the far ones
            // of the last cell.
            let last = field.major.cells[1];
            let place = field.place(l, [l.splat_i(line.min(last)), minor]);
            let mut places = [0; LANES];
            l.store_i(place, &mut places);
            let posts = l.cells(&field.heights.items, &places, field.heights.stride);
            let [near, far_major, far_minor, both] = corners::<L>(field, posts);
            if line > last {
                [far_major, both]
            } else {
                [near, far_minor]
            }
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;
    use crate::planes::field::Axis;
    use crate::planes::frame::Level;
    use crate::planes::roofs::Roofs;
    use crate::planes::steepness::Steepness;
    use glam::DVec2;
    use sandtable_terrain::Ground;

    /// Rough ground of more tiles than one, and an eye beside it; the sign of its rays along either
    /// axis, and which of the ground's axes is the major one, for each way that there is.
    fn each_field(check: impl Fn(&Field<'_>, &Ground)) {
        let height = |col: u32, row: u32| {
            let rough = ((col * 37 + row * 91) % 113) as f32;
            60.0 + 0.02 * rough
                + 30.0 * (0.04 * col as f32).sin()
                + 20.0 * (0.03 * row as f32).cos()
        };
        let ground = Ground::from_fn(600, 540, DVec2::ONE, height).expect("a sound grid");
        let roofs = Roofs::new(ground.heights());
        let level = Level::new(ground.heights(), &roofs, &Steepness::new(ground.heights()));
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
            check(&field, &ground);
        }
    }

    /// Planes from one that advances by `first` on, each by `more` more.
    fn planes(first: f32, more: f32) -> PlaneGroup<Portable> {
        let advance = std::array::from_fn(|k| first + more * k as f32);
        PlaneGroup {
            advance,
            outer: [advance[0], advance[LANES - 1]],
        }
    }

    /// Close together and far apart, inside of tiles and across their borders.
    const GROUPS: [[f32; 2]; 4] = [[0.3, 1e-4], [0.9, -0.004], [0.05, 0.02], [0.0, 0.06]];

    fn ground_height(field: &Field<'_>, ground: &Ground, major: f64, minor: f64) -> Option<f64> {
        let along = |axis: &Axis, at: f64| {
            // Line 0 lies `fraction` before the eye.
            let lines = at + f64::from(axis.fraction);
            f64::from(axis.post(0)) + f64::from(axis.sign) * lines
        };
        let (major, minor) = (along(&field.major, major), along(&field.minor, minor));
        let (x, y) = if field.major_axis == 0 {
            (major, minor)
        } else {
            (minor, major)
        };
        ground.height_at(x, y)
    }

    #[test]
    fn profiles_are_the_grounds() {
        each_field(|field, ground| {
            for [first, more] in GROUPS {
                let planes = planes(first, more);
                let mut found = 0;
                for line in field.major.cells[0]..=field.major.cells[1] + 1 {
                    let t = line as f32 - field.major.fraction;
                    let heights = heights(Portable, field, &planes, line, t);
                    for (height, advance) in heights.iter().zip(planes.advance) {
                        let aside = f64::from(advance) * f64::from(t);
                        let Some(truth) = ground_height(field, ground, f64::from(t), aside) else {
                            continue;
                        };
                        let height = f64::from(height + field.eye_height);
                        assert!((height - truth).abs() < 0.05, "{height} and {truth} at {t}");
                        found += 1;
                    }
                }
                assert!(found > 4000, "{found}");
            }
        });
    }

    #[test]
    fn no_ground_is_above_ceilings() {
        each_field(|field, ground| {
            for ([first, more], level) in GROUPS.into_iter().zip([4, 6, 4, 6]) {
                let planes = planes(first, more);
                let (mut found, mut highest) = (0, 0.0_f64);
                for line in field.major.cells[0]..=field.major.cells[1] + 1 {
                    let Some(most) = ceiling(field, &planes, line, level) else {
                        continue;
                    };
                    let most = f64::from(most + field.eye_height);
                    let from = line as f32 - field.major.fraction;
                    for part in 0..=50 {
                        let t = from + (part << level) as f32 / 50.0;
                        for advance in planes.advance {
                            let (t, aside) = (f64::from(t), f64::from(advance * t));
                            let Some(height) = ground_height(field, ground, t, aside) else {
                                continue;
                            };
                            assert!(height < most + 0.01, "{height} over {most} at {t}");
                            highest = highest.max(height / most);
                        }
                    }
                    found += 1;
                }
                assert!(found >= 600 >> level >> 2, "{found} blocks");
                assert!(highest > 0.5, "{highest}");
            }
        });
    }
}
