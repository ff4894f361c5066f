//! The default caster: coherence along vertical planes, exact for any eye and window (papers' row
//! G4).

mod afar;
mod alone;
mod climb;
mod coarser;
mod depart;
mod detail;
mod fall;
mod field;
mod floor;
mod footprint;
mod frame;
mod numbers;
mod patches;
mod pixels;
mod profile;
mod refined;
mod roofs;
mod rows;
mod sectors;
mod shade;
mod steepness;
mod strips;
mod survey;
mod texture;
mod walk;
mod wave;
mod widest;

pub use self::floor::ShadeFloor;
pub use self::survey::Survey;

use self::alone::Alone;
use self::detail::{Detail, DetailOptions};
use self::frame::{Frame, Level};
use self::roofs::Roofs;
use self::rows::{Scratch, cast_sector};
use self::sectors::{Bounds, ImageRays, Sector};
use self::steepness::{Steepness, SteepnessSeen};
use crate::canvas::Canvas;
use crate::lanes::{Isa, Kernel, Lanes, Portable};
use crate::options::{CasterOption, Options};
use crate::tally::{Tally, Uncounted};
use crate::units::UnitCaster;
use crate::{CastError, Caster, PreparedScene, Scene};
use glam::DVec3;
use sandtable_terrain::{Grid, Ground, TileIndex};
use sandtable_view::View;
use std::cell::RefCell;
use std::sync::Arc;

/// Casts along vertical planes.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    isa: Isa,
    detail: Option<DetailOptions>,
}

impl Planes {
    /// What asks for it with level of detail.
    pub const WITH_DETAIL: &str = "planes?lod=on";

    /// What can be set.
    pub const OPTIONS: [CasterOption; 4] = [
        CasterOption {
            name: "isa",
            meaning: "the instruction set: best, or of the processor's avx512, avx2, neon and portable",
        },
        DetailOptions::LOD,
        DetailOptions::CELL,
        DetailOptions::BLUR,
    ];

    pub(crate) fn read(options: &Options<'_>) -> Result<Self, CastError> {
        let all = Isa::all();
        let mut choices = vec![("best", Isa::best())];
        choices.extend(all.into_iter().map(|isa| (isa.name(), isa)));
        Ok(Self {
            isa: options.choice("isa", &choices)?,
            detail: DetailOptions::read(options)?,
        })
    }
}

impl Caster for Planes {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        Ok(Arc::new(PlanesScene::new(self.isa, self.detail, scene)))
    }
}

struct PlanesScene {
    isa: Isa,
    scene: Arc<Scene>,
    roofs: Roofs,
    steepness: Steepness,
    detail: Option<Detail>,
}

impl PlanesScene {
    fn new(isa: Isa, detail: Option<DetailOptions>, scene: Arc<Scene>) -> Self {
        Self {
            isa,
            roofs: Roofs::new(scene.ground.heights()),
            steepness: Steepness::new(scene.ground.heights()),
            detail: detail.map(|options| Detail::new(options, &scene.ground)),
            scene,
        }
    }
}

/// How many pixels of a step a sector has at most, about: many, as at each step's end loops run out
/// and groups are left half full.
const WIDTH: u32 = 1600;

/// The same where ground is coarsened: most of such a cast goes along planes, which do not end, and is
/// better shared by threads.
const COARSENED_WIDTH: u32 = 512;

/// About how many pixels of ground a sector has that is cut across its planes, so that many threads have
/// something to do: its first step's rays have none to begin from, and take as long as those of two to
/// nine other steps.
const WORK: f64 = 128_000.0;

/// Into how many sectors small images are cut, about, so that two threads end together, and about how many pixels
/// these have at least.
const PIECES: f64 = 6.0;
const LEAST_WORK: f64 = 16_000.0;

/// The same where ground is coarsened: most such images are one of a pair.
const COARSENED_WORK: f64 = 256_000.0;

/// About how far a part's lines may run along the other axis for each one along theirs: rays over the
/// ground, in cells, and planes over the image, in pixels. With 1 + √2 and more, a view straight down has
/// eight parts whichever way it is turned.
const MOST_SLANT: f64 = 2.5;

/// For how many pixels a block of ground it is worth while to find how steep that is.
const PIXELS_A_BLOCK: usize = 256;

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

struct CastSector<'a> {
    frame: &'a Frame<'a>,
    sector: &'a Sector,
    scratch: &'a mut Scratch,
    canvas: &'a Canvas<'a>,
}

impl Kernel for CastSector<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        cast_sector(
            lanes,
            self.frame,
            self.sector,
            self.scratch,
            self.canvas,
            &mut Uncounted,
        );
    }
}

impl UnitCaster for PlanesScene {
    type Frame<'a> = Frame<'a>;

    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        if self.scene.ground.grid() != scene.ground.grid() {
            let options = self.detail.as_ref().map(|detail| detail.options);
            return Ok(Arc::new(Self::new(self.isa, options, scene)));
        }
        Ok(Arc::new(Self {
            isa: self.isa,
            roofs: self.roofs.updated(scene.ground.heights(), changed),
            steepness: self.steepness.updated(scene.ground.heights(), changed),
            detail: self
                .detail
                .as_ref()
                .map(|detail| detail.updated(&self.scene.ground, &scene.ground, changed)),
            scene,
        }))
    }

    fn frame<'a>(&'a self, view: &'a View) -> Result<Frame<'a>, CastError> {
        let own = &*self.scene.ground;
        let [low, high] = own.range();
        let per_metre = |ground: &Ground| ground.grid().spacing.recip().extend(1.0);
        let own_level = Level::new(own.heights(), &self.roofs, &self.steepness);
        let coarser = self.detail.as_ref().filter(|detail| {
            let per_metre = per_metre(own);
            let (rays, heights) = (ImageRays::new(view, per_metre), [low, high].map(f64::from));
            rays.widest(view.eye * per_metre, own_level.cells, heights) > detail.widest_in_finest()
        });
        // The ground whose cells rays go over.
        let over = |coarser: Option<&'a Detail>| coarser.and_then(Detail::refined).unwrap_or(own);
        let rays_over = |ground| ImageRays::new(view, per_metre(ground));
        let ground = over(coarser);
        let alone = alone::is_close(own, view.eye)
            || rays_over(ground).are_too_fine(ground, view.eye, coarser.is_some());
        let coarser = coarser.filter(|_| !alone);
        let coarsens = coarser.is_some();
        let ground = over(coarser);
        let rays = rays_over(ground);
        let eye = in_cells(&ground.grid(), view.eye);
        let levels = match coarser {
            Some(detail) => detail.levels(own_level),
            None => vec![own_level],
        };
        let pixels = view.size[0] as usize * view.size[1] as usize;
        let bounds = Bounds {
            width: if coarsens { COARSENED_WIDTH } else { WIDTH },
            work: if coarsens {
                COARSENED_WORK
            } else {
                (pixels as f64 / PIECES).clamp(LEAST_WORK, WORK)
            },
            // A pixel's mean is taken along its plane, which must not run along lanes.
            most_slant: if coarsens { 1.0 } else { MOST_SLANT },
            eye: [eye.x, eye.y],
            cells: levels[0].cells,
            rise: f64::from(high) - view.eye.z,
        };
        let rounding = 1e-6 * low.abs().max(high.abs()).max(view.eye.z.abs() as f32);
        let is_worth_while =
            !coarsens && pixels >= PIXELS_A_BLOCK * self.steepness.blocks() && rays.are_slanted();
        let steepness =
            is_worth_while.then(|| SteepnessSeen::new(&self.steepness, &rays, eye, rounding));
        Ok(Frame {
            isa: self.isa,
            levels,
            detail: self.detail.as_ref().map(|detail| detail.frame(coarsens)),
            coarsens,
            ground,
            view,
            sectors: rays.sectors(&bounds),
            rays,
            eye,
            highest: high,
            rounding,
            steepness,
            alone: alone.then(|| Alone::new(own, view.eye)),
            ground_rise: 0.5 * ground.grid().cell_length() as f32,
        })
    }

    fn units(frame: &Frame<'_>) -> usize {
        match frame.alone {
            Some(_) => frame.view.size[1] as usize,
            None => frame.sectors.len(),
        }
    }

    fn cast_unit<T: Tally>(frame: &Frame<'_>, unit: usize, canvas: &Canvas<'_>, tally: &mut T) {
        if let Some(alone) = &frame.alone {
            alone::cast_row(frame, alone, unit as u32, canvas, tally);
            return;
        }
        let sector = &frame.sectors[unit];
        SCRATCH.with_borrow_mut(|scratch| {
            if T::COUNTS {
                // Rays are led the same way by all instruction sets, so what counts is compiled for one.
                cast_sector(Portable, frame, sector, scratch, canvas, tally);
            } else {
                frame.isa.run(CastSector {
                    frame,
                    sector,
                    scratch,
                    canvas,
                });
            }
        });
    }
}

/// A place in cells along the ground's axes, and in metres up. One right over the border is so in cells, too, however
/// lengths are rounded: a ray along the border that begins a little beside it may meet the ground's side anywhere.
fn in_cells(grid: &Grid, place: DVec3) -> DVec3 {
    let axis = |axis: usize, posts: u32| {
        let cells = f64::from(posts - 1);
        let [from_first, to_last] = [place[axis], grid.extent()[axis] - place[axis]]
            .map(|metres| metres / grid.spacing[axis]);
        // Lengths are told best from the nearer end.
        if to_last < from_first {
            cells - to_last
        } else {
            from_first
        }
    };
    DVec3::new(axis(0, grid.cols), axis(1, grid.rows), place.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CastPool, Image};
    use glam::{DVec2, DVec3};
    use sandtable_view::{Attitude, Camera};

    fn rough(cols: u32, rows: u32) -> Arc<Scene> {
        let height = |col: u32, row: u32| ((col * 37 + row * 91) % 113) as f32 * 0.2;
        Scene::new(Ground::from_fn(cols, rows, DVec2::ONE, height).expect("a sound grid"))
    }

    /// From 60 m over the ground or beside it, `y` metres north of its southern border.
    fn view(y: f64, pitch: f64, size: [u32; 2]) -> View {
        let camera = Camera {
            eye: DVec3::new(140.0, y, 60.0),
            attitude: Attitude {
                pitch,
                ..Attitude::default()
            },
            horizontal_fov: 1.0,
        };
        camera.view(size)
    }

    #[test]
    fn small_images_have_parts_for_several_threads() {
        let planes = PlanesScene::new(Isa::best(), None, rough(300, 290));
        let count = |size: [u32; 2]| {
            let view = view(20.0, -0.6, size);
            planes.frame(&view).expect("a sound view").sectors.len()
        };
        assert_eq!([[60, 50], [500, 400], [1920, 1080]].map(count), [2, 6, 16]);
    }

    #[test]
    fn another_grid_is_prepared_anew() {
        let scenes = [rough(300, 290), rough(290, 600)];
        let view = view(-30.0, -0.3, [120, 90]);
        let pool = CastPool::new(1).expect("a thread");
        let cast = |prepared: &dyn PreparedScene| {
            let mut image = [Image::default()];
            pool.cast(prepared, &[view], &mut image).expect("accepted");
            image
        };
        let options = DetailOptions {
            cell: 1.5,
            blur: 1.9,
        };
        for (before, after) in [(0, 1), (1, 0)] {
            for options in [None, Some(options)] {
                let new = |of: usize| PlanesScene::new(Isa::best(), options, scenes[of].clone());
                let changed: Vec<_> = scenes[after].ground.heights().tile_indices().collect();
                let updated = UnitCaster::updated(&new(before), scenes[after].clone(), &changed);
                let updated = cast(&*updated.expect("suits"));
                assert!(updated == cast(&new(after)), "detail: {options:?}");
            }
        }
    }
}
