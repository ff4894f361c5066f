//! The grounds of hard views.

use crate::random::Random;
use glam::DVec2;
use sandtable_terrain::{Ground, Photo, TiledRaster};

/// What stands on a ground, in shares of its height.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Needles,
    WallsAndPits,
    Noise,
    Tilted,
    Terraces,
    Town,
    Saddles,
    Cliffs,
    Fences,
    Level,
    Gorges,
    Comb,
}

const SHAPES: [Shape; 12] = [
    Shape::Needles,
    Shape::WallsAndPits,
    Shape::Noise,
    Shape::Tilted,
    Shape::Terraces,
    Shape::Town,
    Shape::Saddles,
    Shape::Cliffs,
    Shape::Fences,
    Shape::Level,
    Shape::Gorges,
    Shape::Comb,
];

/// What is drawn for a shape.
struct Drawn {
    shape: Shape,
    seed: u64,
    /// After how many posts it comes again, and on which share of posts chance puts something.
    period: u32,
    dense: f64,
    /// How rough the ground between is.
    rough: f64,
    tilt: [f64; 2],
    /// Where a single cliff, fence or needle is.
    at: [u32; 2],
}

/// Some ground, and what it is called.
pub(super) fn ground(random: &mut Random) -> (&'static str, Ground) {
    let posts = [side(random), side(random)];
    let shape = *random.choose(&SHAPES);
    let unit = if random.unit() < 0.6 {
        1.0
    } else {
        random.octaves(1e-3, 1e3)
    };
    let mut spacing = DVec2::splat(unit);
    match random.bits() % 6 {
        0 => spacing.x *= random.octaves(1.0, 100.0),
        1 => spacing.y *= random.octaves(1.0, 100.0),
        2 => spacing.x *= random.octaves(0.3, 3.0),
        _ => {}
    }
    let cell = spacing.min_element();
    let height = cell
        * match random.bits() % 4 {
            0 => random.octaves(1e-3, 0.3),
            1 => random.octaves(5.0, 30.0),
            _ => random.octaves(0.3, 30.0),
        };
    let base = match random.bits() % 8 {
        0 => 1e6 * cell,
        1 => -1e6 * cell,
        2 => random.between(-1e4, 1e4) * cell,
        3 => 8848.0,
        _ => 0.0,
    };
    let drawn = Drawn {
        shape,
        seed: random.bits(),
        period: random.between(3.0, 40.0) as u32,
        dense: random.octaves(1e-3, 0.2),
        rough: if random.unit() < 0.5 {
            0.0
        } else {
            random.octaves(1e-3, 0.3)
        },
        tilt: [random.between(-0.3, 0.3), random.between(-0.3, 0.3)],
        at: posts.map(|posts| (random.bits() % u64::from(posts)) as u32),
    };
    let height_of = |col: u32, row: u32| (base + height * drawn.share([col, row])) as f32;
    let ground = Ground::from_fn(posts[0], posts[1], spacing, height_of).expect("a sound grid");
    let ground = if random.unit() < 0.25 {
        with_photo(ground, random)
    } else {
        ground
    };
    (shape.name(), ground)
}

/// Posts along a side: few, as many as a tile has, give or take one, or any number.
fn side(random: &mut Random) -> u32 {
    match random.bits() % 10 {
        0 => 2,
        1 => *random.choose(&[3, 4, 5, 6, 7, 9]),
        2 | 3 => *random.choose(&[17, 33, 64, 65, 66]),
        4 => *random.choose(&[255, 256, 257, 258, 259]),
        5 => *random.choose(&[300, 513, 514, 515]),
        6 | 7 => random.between(30.0, 140.0) as u32,
        _ => random.between(8.0, 300.0) as u32,
    }
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Self::Needles => "needles",
            Self::WallsAndPits => "walls and pits",
            Self::Noise => "noise",
            Self::Tilted => "a tilted plane",
            Self::Terraces => "terraces",
            Self::Town => "a town",
            Self::Saddles => "saddles",
            Self::Cliffs => "cliffs",
            Self::Fences => "fences",
            Self::Level => "level ground",
            Self::Gorges => "gorges",
            Self::Comb => "a comb",
        }
    }
}

impl Drawn {
    /// The height of a post, as a share.
    fn share(&self, post: [u32; 2]) -> f64 {
        let [col, row] = post;
        let [x, y] = post.map(f64::from);
        let [at_col, at_row] = self.at;
        let (period, seed) = (self.period, self.seed);
        let chance = hash(post, seed);
        let ground = self.rough * smooth([x / 9.0, y / 7.0], seed ^ 5);
        let where_so = |so: bool, share: f64| if so { share } else { 0.0 };
        // At the edges of tiles, too, where rasters are sewn together.
        let is_at_seam = post.into_iter().any(|n| n > 250 && (n + 2) % 256 < 4);
        ground
            + match self.shape {
                Shape::Needles => where_so(
                    chance < self.dense || is_at_seam && chance < 0.1,
                    1.0 + 3.0 * hash(post, seed ^ 1),
                ),
                Shape::WallsAndPits => {
                    where_so(col % period == 1 && chance > 0.05, 1.0)
                        + where_so(row % period == 2 && chance > 0.1, 0.7)
                        - where_so(chance < self.dense, 2.0)
                }
                Shape::Noise => chance,
                Shape::Tilted => {
                    self.tilt[0] * x + self.tilt[1] * y + where_so(post == self.at, 4.0)
                }
                Shape::Terraces => (6.0 * smooth([x / 23.0, y / 17.0], seed)).floor(),
                Shape::Town => {
                    let periods = [period, period + 1];
                    let block = [col / periods[0], row / periods[1]];
                    let is_house = col % periods[0] > period / 3 && row % periods[1] > period / 3;
                    where_so(is_house, (4.0 * hash(block, seed) - 1.0).max(0.0))
                        + where_so(chance < 0.01, 0.5)
                }
                Shape::Saddles => f64::from((col + row) % 2),
                Shape::Cliffs => where_so(col >= at_col, 1.0) + where_so(row >= at_row, 0.3),
                Shape::Fences => where_so(
                    col == at_col || row == at_row || col + row == at_col + at_row,
                    1.0,
                ),
                Shape::Level => 0.0,
                Shape::Gorges => {
                    let is_gorge = col % period < 2 || (row + col / 3) % (period + 3) < 2;
                    where_so(is_gorge, -5.0)
                }
                Shape::Comb => chance * if col.is_multiple_of(2) { 1.0 } else { -1.0 },
            }
    }
}

/// A soft photo over all of a ground, with a pixel a post or of another size.
fn with_photo(ground: Ground, random: &mut Random) -> Ground {
    /// Small enough to be made at once.
    const MOST_PIXELS: u32 = 3000;
    let grid = ground.grid();
    let other = DVec2::new(random.octaves(0.3, 2.0), random.octaves(0.3, 2.0));
    let share = if random.unit() < 0.5 {
        DVec2::ONE
    } else {
        other
    };
    let spacing = grid.spacing * share;
    let sides = (grid.extent() / spacing).ceil().as_uvec2() + 1;
    if sides.max_element() > MOST_PIXELS {
        return ground;
    }
    let seed = random.bits();
    let pixels = TiledRaster::from_fn(sides.x.max(2), sides.y.max(2), |col, row| {
        let place = [col, row].map(|n| f64::from(n) / 25.0);
        let channel = |channel| (60.0 + 150.0 * smooth(place, seed ^ channel)) as u8;
        [channel(1), channel(2), channel(3), 255]
    });
    ground.with_photo(Photo {
        pixels,
        origin: DVec2::ZERO,
        spacing,
    })
}

/// A number from 0 to below 1 for each post.
fn hash([col, row]: [u32; 2], seed: u64) -> f64 {
    Random::new(seed ^ u64::from(col) << 32 ^ u64::from(row)).unit()
}

/// Numbers from 0 to 1 at whole places, and smooth in between.
fn smooth([x, y]: [f64; 2], seed: u64) -> f64 {
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v) = (ease(x.fract()), ease(y.fract()));
    let at = |east: u32, north: u32| hash([x as u32 + east, y as u32 + north], seed);
    let south = at(0, 0) + u * (at(1, 0) - at(0, 0));
    let north = at(0, 1) + u * (at(1, 1) - at(0, 1));
    south + v * (north - south)
}
