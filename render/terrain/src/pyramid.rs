//! The ground at halved and halved again resolution (Cohen-Or, Rich, Lerner, Shenkar 1996,
//! section 2).

use crate::halving::{half, halved, halved_renewed};
use crate::voxel::texture;
use crate::{Grid, Ground, LinearLight, TileIndex, TiledCells, TiledRaster, pre_texture, reach};

/// A pyramid of resolutions over a ground, vertex-centred: post i of a level stands at post 2 i
/// of the level below it.
///
/// Level 0 is the ground itself. A post of a coarser level is the mean of the finer posts around
/// it, weighted by [1 2 1] / 4 along each axis; beyond the border the outermost post repeats. A
/// side of n posts becomes one of ⌈(n − 1) / 2⌉ + 1, so a coarser level may reach out over the
/// terrain's border, by less than one of its cells: its last post then repeats the border. The
/// top has 2 by 2 posts.
///
/// Levels are in tiles of their own and shared between snapshots.
#[derive(Clone, Debug)]
pub struct Pyramid {
    grid: Grid,
    /// The range of heights that the tints of level 0 refer to.
    range: [f32; 2],
    levels: Vec<PyramidLevel>,
}

/// One resolution of a [`Pyramid`]; at level l a cell is 2ˡ of the ground's cells wide.
#[derive(Clone, Debug)]
pub struct PyramidLevel {
    /// Mean heights in metres.
    pub heights: TiledRaster<f32>,
    /// Mean colours, filtered in linear light: red, green, blue, sRGB-encoded, and 255.
    pub colours: TiledRaster<[u8; 4]>,
    /// The lowest and highest height in each cell, metres: of this level's surface and of all
    /// finer ones, the ground's included. A ray above the upper bound meets none of them there.
    pub bounds: TiledCells<[f32; 2]>,
}

impl Pyramid {
    /// Builds all levels, tiles in parallel. Level 0 shares the ground's heights; its colours are
    /// those of [`pre_texture`].
    #[must_use]
    pub fn new(ground: &Ground) -> Self {
        let heights = ground.heights().clone();
        let bounds = TiledCells::from_fn(heights.cols() - 1, heights.rows() - 1, |col, row| {
            range(heights.cell(col, row))
        });
        let mut finest = PyramidLevel {
            heights,
            colours: pre_texture(ground),
            bounds,
        };
        let mut levels = Vec::new();
        while finest.heights.cols() > 2 || finest.heights.rows() > 2 {
            let coarser = finest.coarser();
            levels.push(finest);
            finest = coarser;
        }
        levels.push(finest);
        Self {
            grid: ground.grid(),
            range: ground.range(),
            levels,
        }
    }

    /// The pyramid after an edit; `changed` are all tiles whose heights, light or photograph
    /// differ. Equal to one built anew; tiles out of the edit's reach are shared with `self`. A
    /// ground on another grid gives a pyramid built anew.
    ///
    /// Where the edit leaves the ground's range of heights, all tints change with it, and all
    /// colours are made anew.
    #[must_use]
    pub fn updated(&self, ground: &Ground, changed: &[TileIndex]) -> Self {
        if ground.grid() != self.grid {
            return Self::new(ground);
        }
        let mut recoloured = texture::reached_tiles(self.range, ground, changed);
        let mut reshaped = changed.to_vec();
        let heights = ground.heights().clone();
        let finest = PyramidLevel {
            colours: texture::renewed(&self.levels[0].colours, &recoloured, ground),
            bounds: self.levels[0]
                .bounds
                .with_tiles_renewed(changed, |col, row| range(heights.cell(col, row))),
            heights,
        };
        let mut levels = vec![finest];
        for old in &self.levels[1..] {
            let (cols, rows) = (old.heights.cols(), old.heights.rows());
            reshaped = reach::coarser(&reshaped, cols, rows);
            recoloured = reach::coarser(&recoloured, cols, rows);
            let finer = &levels[levels.len() - 1];
            levels.push(finer.coarser_renewed(old, &reshaped, &recoloured));
        }
        Self {
            grid: self.grid,
            range: ground.range(),
            levels,
        }
    }

    /// Number of levels, at least 1.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// A level; 0 is the ground's own resolution.
    ///
    /// # Panics
    /// Where there is no such level.
    #[inline]
    #[must_use]
    pub fn level(&self, level: usize) -> &PyramidLevel {
        &self.levels[level]
    }

    /// Bytes held by all levels, among them the heights of level 0, which the ground holds too.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let level = |level: &PyramidLevel| {
            level.heights.bytes() + level.colours.bytes() + level.bounds.bytes()
        };
        self.levels.iter().map(level).sum()
    }
}

impl PyramidLevel {
    /// The level of half this one's resolution.
    fn coarser(&self) -> Self {
        let (cols, rows) = (half(self.heights.cols()), half(self.heights.rows()));
        let heights = halved(&self.heights);
        let bounds = TiledCells::from_fn(cols - 1, rows - 1, |col, row| {
            self.bounds_over(heights.cell(col, row), col, row)
        });
        Self {
            colours: TiledRaster::from_fn(cols, rows, |col, row| self.mean_colour(col, row)),
            heights,
            bounds,
        }
    }

    /// [`PyramidLevel::coarser`] from one that was `old`, with these tiles made anew.
    fn coarser_renewed(
        &self,
        old: &Self,
        reshaped: &[TileIndex],
        recoloured: &[TileIndex],
    ) -> Self {
        let heights = halved_renewed(&self.heights, &old.heights, reshaped);
        let bounds = old.bounds.with_tiles_renewed(reshaped, |col, row| {
            self.bounds_over(heights.cell(col, row), col, row)
        });
        Self {
            colours: old
                .colours
                .with_tiles_renewed(recoloured, |col, row| self.mean_colour(col, row)),
            heights,
            bounds,
        }
    }

    /// The mean of this level's colours around post (`col`, `row`) of the next.
    fn mean_colour(&self, col: u32, row: u32) -> [u8; 4] {
        let light = LinearLight::tables();
        let (cols, rows) = self.taps(col, row);
        let around = rows.map(|row| cols.map(|col| self.colours.post(col, row)));
        let [r, g, b] = [0, 1, 2].map(|channel| {
            let along = |row: [[u8; 4]; 3]| weighted(row.map(|post| light.decode(post[channel])));
            light.encode(weighted(around.map(along)))
        });
        [r, g, b, 255]
    }

    /// The columns and rows of this level around post (`col`, `row`) of the next.
    fn taps(&self, col: u32, row: u32) -> ([u32; 3], [u32; 3]) {
        let around = |post: u32, posts: u32| {
            [(2 * post).saturating_sub(1), 2 * post, 2 * post + 1].map(|at| at.min(posts - 1))
        };
        (
            around(col, self.heights.cols()),
            around(row, self.heights.rows()),
        )
    }

    /// The bounds of cell (`col`, `row`) of the next level, whose own posts are `posts`.
    fn bounds_over(&self, posts: [f32; 4], col: u32, row: u32) -> [f32; 2] {
        let finer = |at: u32, cells: u32| 2 * at..cells.min(2 * at + 2);
        let [mut low, mut high] = range(posts);
        for row in finer(row, self.bounds.rows()) {
            for col in finer(col, self.bounds.cols()) {
                let [lowest, highest] = self.bounds.get(col, row);
                low = low.min(lowest);
                high = high.max(highest);
            }
        }
        [low, high]
    }
}

/// The mean of three values with weights of a quarter, a half and a quarter.
fn weighted<T>([before, at, after]: [T; 3]) -> T
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<Output = T> + From<f32>,
{
    (before + after) * T::from(0.25) + at * T::from(0.5)
}

fn range(posts: [f32; 4]) -> [f32; 2] {
    posts.iter().fold([posts[0]; 2], |[low, high], &height| {
        [low.min(height), high.max(height)]
    })
}
