//! Level of detail: which resolutions of ground and colours there are, and which a ray takes.

use super::field::Tiles;
use super::frame::Level;
use super::refined::{BetterByRays, Refined, better_by_rays};
use super::roofs::Roofs;
use super::steepness::Steepness;
use crate::CastError;
use crate::lanes::LANES;
use crate::options::{CasterOption, Options};
use rayon::prelude::*;
use sandtable_terrain::{
    Drape, Ground, HeightPyramid, Mipmap, Photo, TileIndex, TiledRaster, hypsometric,
};

/// How many posts a pixel covers at most in views of which each pixel's ray is cast over the ground's own
/// resolution: where pixels are so small, that takes less time than planes do.
const MAGNIFIED: f64 = 0.5;

/// How many posts a pixel covers, about, from which on it may lie between planes in other views; what is
/// nearer, right before the eye, has rays there, too.
const NEAR: f32 = 0.02;

/// How detail is chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct DetailOptions {
    /// How many pixels a cell is wide at most, where there is a finer one.
    pub(super) cell: f64,
    /// The width of the filter of near ground's colours in pixels.
    pub(super) blur: f64,
}

impl DetailOptions {
    pub(super) const LOD: CasterOption = CasterOption {
        name: "lod",
        meaning: "level of detail: off (each pixel one point of the finest data), or on (heights \
                  and colours at the resolution of the pixel's footprint); default off",
    };
    pub(super) const CELL: CasterOption = CasterOption {
        name: "cell",
        meaning: "with lod: pixels to a cell of heights and colours at most, from 0.25 (finer) to \
                  8 (faster); default 1.5",
    };
    pub(super) const BLUR: CasterOption = CasterOption {
        name: "blur",
        meaning: "with lod: width of the filter of near ground's colours in pixels, from 0.25 \
                  (sharper; 1.4 is nearest to the truth in a single picture) to 4 (calmer); default \
                  1.9",
    };

    pub(super) fn read(options: &Options<'_>) -> Result<Option<Self>, CastError> {
        let on = options.choice("lod", &[("off", false), ("on", true)])?;
        let read = Self {
            cell: options.number("cell", 0.25..=8.0)?.unwrap_or(1.5),
            blur: options.number("blur", 0.25..=4.0)?.unwrap_or(1.9),
        };
        Ok(on.then_some(read))
    }
}

/// Ground and colours at all resolutions.
pub(super) struct Detail {
    pub(super) options: DetailOptions,
    /// What levels begin with, where the photo's pixels lie between the ground's own posts.
    refined: Option<Refined>,
    /// Where planes see less of the photo than rays, in the first level's posts.
    by_rays: Option<BetterByRays>,
    heights: HeightPyramid,
    /// Of the levels of `heights` behind the first.
    bounds: Vec<(Roofs, Steepness)>,
    /// Colours of far ground.
    drape: Drape,
    /// Colours of near ground.
    photo: Option<Texture>,
    /// Tints in shaded relief, a pixel a post, where the photo does not cover all ground.
    tints: Option<Texture>,
}

/// The tint in shaded relief at a post, where a photo does not cover all ground.
fn tint_of(ground: &Ground) -> Option<impl Fn(u32, u32) -> [u8; 4] + Sync> {
    let light = ground.light()?;
    let [low, high] = ground.range();
    let per_metre = if high > low { 1.0 / (high - low) } else { 0.0 };
    Some(move |col, row| {
        let share = (ground.heights().post(col, row) - low) * per_metre;
        let [r, g, b] = hypsometric(share, f32::from(light.post(col, row)) / 256.0);
        [r, g, b, 255]
    })
}

/// Colours at all resolutions, and where the finest one's pixels lie: as [`Photo`] has it, in the
/// ground's own cells.
#[derive(Clone)]
struct Texture {
    mipmap: Mipmap,
    origin: [f64; 2],
    spacing: [f64; 2],
}

impl Texture {
    fn of_photo(photo: &Photo, ground: &Ground) -> Self {
        let cell = ground.grid().spacing;
        Self {
            mipmap: Mipmap::new(&photo.pixels),
            origin: (photo.origin / cell).to_array(),
            spacing: (photo.spacing / cell).to_array(),
        }
    }

    fn of_tints(image: &TiledRaster<[u8; 4]>) -> Self {
        Self {
            mipmap: Mipmap::new(image),
            origin: [0.0; 2],
            spacing: [1.0; 2],
        }
    }
}

impl Detail {
    pub(super) fn new(options: DetailOptions, ground: &Ground) -> Self {
        let refined = Refined::new(ground);
        let finest = refined.as_ref().map_or(ground, |refined| &refined.ground);
        let heights = HeightPyramid::new(finest.heights(), ground.range());
        let coarser = heights.levels()[1..].par_iter();
        Self {
            options,
            by_rays: better_by_rays(finest),
            bounds: coarser
                .map(|heights| (Roofs::new(heights), Steepness::new(heights)))
                .collect(),
            heights,
            drape: Drape::new(finest),
            photo: ground.photo().map(|photo| Texture::of_photo(photo, ground)),
            tints: tint_of(ground).map(|tint| {
                let grid = ground.grid();
                Texture::of_tints(&TiledRaster::from_fn(grid.cols, grid.rows, tint))
            }),
            refined,
        }
    }

    /// After an edit of `before` that made `ground` of it, on the same grid, in the tiles `changed`.
    pub(super) fn updated(&self, before: &Ground, ground: &Ground, changed: &[TileIndex]) -> Self {
        let same_photo = match (before.photo(), ground.photo()) {
            (Some(before), Some(photo)) => before.is_same(photo),
            (before, photo) => before.is_none() && photo.is_none(),
        };
        // A wider range of heights gives all heights other tints.
        let same_tints = before.range() == ground.range()
            && before.light().is_some() == ground.light().is_some();
        if !same_photo || !same_tints {
            return Self::new(self.options, ground);
        }
        let refined = self
            .refined
            .as_ref()
            .map(|refined| refined.updated(ground, changed));
        let (before_finest, finest, finest_changed) = match (&self.refined, &refined) {
            (Some(before), Some((refined, changed))) => {
                (&before.ground, &refined.ground, &**changed)
            }
            _ => (before, ground, changed),
        };
        let (heights, reached) =
            self.heights
                .updated(finest.heights(), ground.range(), finest_changed);
        let levels = self.bounds.iter().zip(&heights.levels()[1..]);
        Self {
            options: self.options,
            by_rays: self.by_rays,
            bounds: levels
                .zip(&reached[1..])
                .map(|(((roofs, steepness), heights), tiles)| {
                    (
                        roofs.updated(heights, tiles),
                        steepness.updated(heights, tiles),
                    )
                })
                .collect(),
            heights,
            drape: self.drape.updated(before_finest, finest, finest_changed),
            photo: self.photo.clone(),
            tints: self.tints.as_ref().map(|old| {
                let image = match tint_of(ground) {
                    Some(tint) => old.mipmap.levels()[0].with_tiles_renewed(changed, tint),
                    None => old.mipmap.levels()[0].clone(),
                };
                Texture {
                    mipmap: old.mipmap.updated(&image, changed),
                    ..*old
                }
            }),
            refined: refined.map(|(refined, _)| refined),
        }
    }

    /// The ground whose cells the first level has, if that is another one than the ground itself.
    pub(super) fn refined(&self) -> Option<&Ground> {
        self.refined.as_ref().map(|refined| &refined.ground)
    }

    /// The ground's levels; the ground's `own` is the first one where it is not refined.
    pub(super) fn levels<'a>(&'a self, own: Level<'a>) -> Vec<Level<'a>> {
        let coarser = self.heights.levels()[1..].iter().zip(&self.bounds);
        let coarser =
            coarser.map(|(heights, (roofs, steepness))| Level::new(heights, roofs, steepness));
        let finest = self.refined.as_ref().map_or(own, Refined::level);
        std::iter::once(finest)
            .chain(coarser)
            .zip(self.drape.levels())
            .map(|(level, colours)| level.with_colours(colours))
            .collect()
    }

    /// How many of the ground's own posts pixels may cover up to which all rays go over its own
    /// resolution.
    pub(super) fn widest_in_finest(&self) -> f64 {
        let most = self.by_rays.map_or(MAGNIFIED, |by_rays| by_rays.all);
        // From two of what is asked for to a cell on a ray changes to the next level.
        most.min(2.0 / self.options.cell) / f64::from(self.times())
    }

    /// How many of the first level's cells lie side by side in one of the ground's.
    fn times(&self) -> u32 {
        self.refined.as_ref().map_or(1, |refined| refined.times)
    }

    /// For rays over the levels, if the ground `coarsens`, or else over its own cells.
    pub(super) fn frame(&self, coarsens: bool) -> DetailFrame<'_> {
        let times = if coarsens { self.times() } else { 1 };
        let texture = |texture, covers| TextureFrame::new(texture, f64::from(times), covers);
        DetailFrame {
            cell: self.options.cell as f32,
            blur: self.options.blur as f32,
            far: self.by_rays.map_or(NEAR, |by_rays| by_rays.near as f32),
            // Of a small ground there is no coarser level.
            native: (times.ilog2() as usize).min(self.heights.levels().len() - 1),
            photo: self
                .photo
                .as_ref()
                .map(|photo| texture(photo, self.tints.is_none())),
            tints: self.tints.as_ref().map(|tints| texture(tints, true)),
        }
    }
}

/// What one view needs of it.
pub(super) struct DetailFrame<'a> {
    /// Pixels to a cell, at most.
    pub(super) cell: f32,
    /// The width of the filter of near ground's colours in pixels.
    pub(super) blur: f32,
    /// How many posts a pixel covers, about, from which on it may lie between planes.
    pub(super) far: f32,
    /// The level that has the ground's own posts, or the coarsest one where that has more.
    pub(super) native: usize,
    pub(super) photo: Option<TextureFrame<'a>>,
    pub(super) tints: Option<TextureFrame<'a>>,
}

/// Colours at all resolutions, as sixteen lanes read them.
pub(super) struct TextureFrame<'a> {
    pub(super) tiles: Tiles<'a, [u8; 4]>,
    /// How many levels there are, at most as many as a group has lanes: those behind have a few
    /// pixels in all. For each the number of its first tile, and its tiles from west to east.
    pub(super) levels: usize,
    pub(super) first_tiles: [i32; LANES],
    pub(super) tiles_across: [i32; LANES],
    /// The finest level's size in pixels, and where it lies, in cells that rays go over.
    pub(super) size: [u32; 2],
    pub(super) origin: [f64; 2],
    pub(super) spacing: [f64; 2],
    /// Whether it has a colour for all ground.
    pub(super) covers: bool,
}

impl<'a> TextureFrame<'a> {
    /// For rays that go over so many `cells` along each side of one of the ground's.
    fn new(texture: &'a Texture, cells: f64, covers: bool) -> Self {
        let levels = texture.mipmap.levels();
        let (mut first_tiles, mut tiles_across) = ([0; LANES], [0; LANES]);
        let mut tiles = 0;
        let tables = first_tiles.iter_mut().zip(&mut tiles_across);
        for (level, (first, across)) in levels.iter().zip(tables) {
            (*first, *across) = (tiles, level.tiles_across() as i32);
            tiles += level.tile_indices().len() as i32;
        }
        Self {
            tiles: Tiles::new(
                texture.mipmap.view(),
                levels[0].tiles_across(),
                levels[0].tile_stride(),
            ),
            levels: levels.len().min(LANES),
            first_tiles,
            tiles_across,
            size: [levels[0].cols(), levels[0].rows()],
            origin: texture.origin.map(|at| at * cells),
            spacing: texture.spacing.map(|spacing| spacing * cells),
            covers,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Isa;
    use crate::planes::PlanesScene;
    use crate::units::UnitCaster;
    use crate::{Scene, standpoints};
    use glam::{DVec2, DVec3};

    #[test]
    fn ground_is_coarsened_where_pixels_come_to_be_wider_than_asked_for() {
        let height = |col: u32, row: u32| ((col * 7 + row * 3) % 11) as f32;
        let ground = Ground::from_fn(400, 300, DVec2::ONE, height).expect("a sound grid");
        // With so many pixels to a post along each side.
        let photo = |pixels: u32| Photo {
            pixels: TiledRaster::from_fn(400 * pixels, 300 * pixels, |_, _| [9, 9, 9, 255]),
            origin: DVec2::ZERO,
            spacing: DVec2::splat(1.0 / f64::from(pixels)),
        };
        let scenes = [
            ground.clone(),
            ground.clone().with_photo(photo(1)),
            ground.with_photo(photo(2)),
        ];
        let coarsens = |cell: f64, size: [u32; 2]| {
            scenes.each_ref().map(|ground| {
                let options = DetailOptions { cell, blur: 1.9 };
                let scene = Scene::new(ground.clone());
                let scene = PlanesScene::new(Isa::best(), Some(options), scene);
                let eye = DVec3::new(0.0, -0.7, 0.6);
                let view = standpoints::at_table(&scene.scene.ground, eye, size);
                let frame = scene.frame(&view).expect("a proper view");
                assert_eq!(frame.coarsens, frame.levels.len() > 1);
                frame.coarsens
            })
        };
        assert_eq!(coarsens(1.5, [6400, 4000]), [false; 3]);
        assert_eq!(coarsens(1.5, [1600, 1000]), [false, false, true]);
        assert_eq!(coarsens(1.5, [800, 500]), [true; 3]);
        assert_eq!(coarsens(8.0, [1600, 1000]), [true; 3]);
    }
}
