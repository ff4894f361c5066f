//! Casting a volume of voxels: what `volume`, `boundary`, `conventional` and `roll-lines` share.

use crate::canvas::Canvas;
use crate::intersect::GridFrame;
use crate::options::{CasterOption, Options};
use crate::pixel_lines::PixelLines;
use crate::samples::{SampledRay, Solid};
use crate::shade::{bilinear_colour, sky};
use crate::tally::Tally;
use crate::units::UnitCaster;
use crate::{CastError, PreparedScene, Scene};
use glam::{DVec2, DVec3};
use sandtable_terrain::{
    BoundaryArray, DensityFilter, TileIndex, TiledRaster, VoxelShape, VoxelVolume, pre_texture,
    pre_texture_updated,
};
use sandtable_view::{Rays, View};
use std::sync::Arc;

/// How voxels are made of the ground and sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelOptions {
    /// Voxels between samples along a ray, above 0; the paper's 0.6 without another.
    pub interval: f64,
    /// The density above which a voxel or a sample counts as terrain: 0 to 254, as no density is
    /// above 255.
    pub threshold: u8,
    /// The number of slices of voxels; without one voxels are cubes.
    pub levels: Option<u32>,
    /// How densities are filtered against aliasing. Without a filter a caster of boundary cells
    /// takes them straight from the elevation map, and no volume is built.
    pub filter: DensityFilter,
}

impl VoxelOptions {
    /// The paper's figures, with an oriented box filter of 2 voxels.
    pub const FILTERED: Self = Self {
        interval: 0.6,
        threshold: 127,
        levels: None,
        filter: DensityFilter::OrientedBox { width: 2.0 },
    };

    /// The paper's figures, without a filter.
    pub const BINARY: Self = Self {
        filter: DensityFilter::None,
        ..Self::FILTERED
    };

    /// Reads what is given and takes the rest from `self`.
    pub(crate) fn read(self, options: &Options<'_>) -> Result<Self, CastError> {
        let filters = [
            ("", self.filter),
            ("box", DensityFilter::OrientedBox { width: 2.0 }),
            ("gaussian", DensityFilter::Gaussian { sigma: 1.0 }),
            ("none", DensityFilter::None),
        ];
        Ok(Self {
            interval: options
                .number("interval", 0.01..=100.0)?
                .unwrap_or(self.interval),
            threshold: options
                .number("threshold", 0..=254)?
                .unwrap_or(self.threshold),
            levels: options.number("levels", 8..=1024)?.or(self.levels),
            filter: options.choice("filter", &filters)?,
        })
    }
}

/// What can be set of all casters of voxels.
pub(crate) const VOXEL_OPTIONS: [CasterOption; 4] = [
    CasterOption {
        name: "interval",
        meaning: "voxels between samples along a ray, 0.01 to 100; 0.6",
    },
    CasterOption {
        name: "threshold",
        meaning: "the density above which there is terrain, 0 to 254; 127",
    },
    CasterOption {
        name: "levels",
        meaning: "slices of voxels over the ground's range, 8 to 1024; as many as make cubes",
    },
    CasterOption {
        name: "filter",
        meaning: "how voxels are antialiased: box, gaussian or none; box (boundary: none)",
    },
];

/// How rays look for the terrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// Each from where the ray before it in its line ended.
    Coherent,
    /// Each from the eye, or where that is not over the terrain, as `FromBounds`.
    FromEye,
    /// Each from where it enters the volume's bounds.
    FromBounds,
}

/// A caster of voxels, put together from its parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VoxelCaster {
    /// Its name, for errors.
    pub(crate) name: &'static str,
    pub(crate) options: VoxelOptions,
    /// Whether densities are interpolated, or boundary cells are terrain altogether.
    pub(crate) interpolates: bool,
    pub(crate) search: Search,
    /// Whether lines follow the vertical of a rolled image, or are columns always.
    pub(crate) rolled_lines: bool,
}

/// Pixel lines in a unit: enough that neighbours seldom share cache lines.
const LINES_PER_UNIT: usize = 16;

impl VoxelCaster {
    pub(crate) fn prepare(self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        let ground = &scene.ground;
        let failed = |error| CastError::Voxels {
            caster: self.name,
            error,
        };
        let shape = match self.options.levels {
            Some(levels) => VoxelShape::with_levels(ground, levels).map_err(failed)?,
            None => VoxelShape::cubic(ground),
        };
        let needs_volume = self.interpolates || self.options.filter != DensityFilter::None;
        let volume = needs_volume
            .then(|| VoxelVolume::new(ground, shape, self.options.filter))
            .transpose()
            .map_err(failed)?;
        let boundary = match &volume {
            Some(volume) => volume.boundary(self.options.threshold),
            None => BoundaryArray::from_heights(ground, shape),
        };
        let colours = pre_texture(ground);
        Ok(self.with_model(scene, shape, volume, boundary, colours))
    }

    fn with_model(
        self,
        scene: Arc<Scene>,
        shape: VoxelShape,
        volume: Option<VoxelVolume>,
        boundary: BoundaryArray,
        colours: TiledRaster<[u8; 4]>,
    ) -> Arc<dyn PreparedScene> {
        Arc::new(VoxelScene {
            caster: self,
            scene,
            shape,
            // Where only boundary cells are looked at, the densities have done their work.
            volume: volume.filter(|_| self.interpolates),
            boundary,
            colours,
        })
    }
}

/// The ground as voxels.
struct VoxelScene {
    caster: VoxelCaster,
    scene: Arc<Scene>,
    shape: VoxelShape,
    volume: Option<VoxelVolume>,
    boundary: BoundaryArray,
    colours: TiledRaster<[u8; 4]>,
}

/// One view of it.
struct Frame<'a> {
    scene: &'a VoxelScene,
    grid: GridFrame<'a>,
    rays: Rays,
    lines: PixelLines,
    /// Whether the eye stands over the rectangle of posts, at any height.
    eye_is_over_terrain: bool,
}

impl UnitCaster for VoxelScene {
    type Frame<'a> = Frame<'a>;

    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        // Voxels of a fixed shape follow an edit; cubes, and a given number of slices, may lie
        // elsewhere once the ground's range is another.
        let same_range = scene.ground.range() == self.scene.ground.range();
        if !same_range {
            return self.caster.prepare(scene);
        }
        let ground = &scene.ground;
        let volume = self.volume.as_ref();
        let volume = volume.map(|volume| volume.updated(ground, changed));
        let boundary = match &volume {
            Some(volume) => volume.boundary_updated(&self.boundary, changed),
            None if self.caster.options.filter == DensityFilter::None => self
                .boundary
                .from_heights_updated(ground, self.shape, changed),
            // The densities that made the array were not kept.
            None => return self.caster.prepare(scene),
        };
        let colours = pre_texture_updated(&self.colours, &self.scene.ground, ground, changed);
        Ok(self
            .caster
            .with_model(scene, self.shape, volume, boundary, colours))
    }

    fn frame<'a>(&'a self, view: &'a View) -> Result<Frame<'a>, CastError> {
        let lines = if self.caster.rolled_lines {
            PixelLines::rolled(view)
        } else {
            PixelLines::columns(view)
        };
        let extent = self.scene.ground.grid().extent();
        let eye = view.eye.truncate();
        Ok(Frame {
            eye_is_over_terrain: eye.clamp(DVec2::ZERO, extent) == eye,
            scene: self,
            grid: GridFrame::up_to(&self.scene.ground, self.shape.z(self.shape.levels as i32)),
            rays: view.rays(),
            lines,
        })
    }

    /// A unit is a block of neighbouring lines.
    fn units(frame: &Frame<'_>) -> usize {
        frame.lines.len().div_ceil(LINES_PER_UNIT)
    }

    fn cast_unit<T: Tally>(frame: &Frame<'_>, unit: usize, canvas: &Canvas<'_>, tally: &mut T) {
        let first = unit * LINES_PER_UNIT;
        let lines = first..(first + LINES_PER_UNIT).min(frame.lines.len());
        let VoxelScene {
            boundary, caster, ..
        } = frame.scene;
        for line in lines {
            match &frame.scene.volume {
                Some(volume) => {
                    let threshold = f32::from(caster.options.threshold);
                    let densities = Densities {
                        boundary,
                        volume,
                        threshold,
                    };
                    cast_line(frame, line, &densities, canvas, tally);
                }
                None => cast_line(frame, line, &BoundaryCells(boundary), canvas, tally),
            }
        }
    }
}

/// Rays set up ahead of their search.
const BLOCK: usize = 32;

/// A ray on its way through [`cast_line`].
#[derive(Clone, Copy, Default)]
struct LineRay {
    pixel: [u32; 2],
    /// Whether coherence begins anew with it.
    afresh: bool,
    /// Towards the pixel, in metres.
    direction: DVec3,
    /// `None` where the ray passes by the terrain.
    samples: Option<SampledRay>,
    hit: Option<u32>,
}

/// Casts the pixels of one line.
///
/// A search ends where the processor has guessed that it goes on, and all that it has begun to do
/// beyond is lost. So the rays of a block are set up before the first is searched for, and shaded
/// after the last.
#[inline]
fn cast_line<S: Solid, T: Tally>(
    frame: &Frame<'_>,
    line: usize,
    solid: &S,
    canvas: &Canvas<'_>,
    tally: &mut T,
) {
    // The distance at which the ray before ended: at its hit, or where it left the terrain.
    let mut reach = 0.0;
    let mut block = [LineRay::default(); BLOCK];
    let mut count = 0;
    let mut cast = |block: &mut [LineRay]| {
        for ray in &mut *block {
            tally.ray();
            frame.search(ray, &mut reach, solid, tally);
        }
        for ray in block {
            frame.shade(ray, canvas);
        }
    };
    frame.lines.walk(line, |pixel, afresh| {
        block[count] = frame.set_up(pixel, afresh);
        count += 1;
        if count == BLOCK {
            cast(&mut block);
            count = 0;
        }
    });
    cast(&mut block[..count]);
}

impl Frame<'_> {
    #[inline(always)]
    fn set_up(&self, [i, j]: [u32; 2], afresh: bool) -> LineRay {
        let VoxelScene { caster, shape, .. } = self.scene;
        let ray = self.rays.ray(i, j);
        let samples = self.grid.clip(&ray).map(|clipped| {
            let (mut origin, mut direction) = (clipped.origin, clipped.direction);
            origin.z = (origin.z - shape.base) / shape.height;
            direction.z /= shape.height;
            let enter = match caster.search {
                Search::FromEye if self.eye_is_over_terrain => 0.0,
                _ => clipped.enter,
            };
            let range = [enter, clipped.leave];
            let interval = caster.options.interval;
            SampledRay::new(origin, direction, ray.direction.length(), interval, range)
        });
        LineRay {
            pixel: [i, j],
            afresh,
            direction: ray.direction,
            samples,
            hit: None,
        }
    }

    #[inline(always)]
    fn search<S: Solid, T: Tally>(
        &self,
        ray: &mut LineRay,
        reach: &mut f64,
        solid: &S,
        tally: &mut T,
    ) {
        let Some(samples) = &ray.samples else {
            return;
        };
        ray.hit = match self.scene.caster.search {
            Search::Coherent if !ray.afresh => samples.hit_from(*reach, solid, tally),
            _ => samples.first_hit(solid, tally),
        };
        *reach = match ray.hit {
            Some(n) => samples.distance(n),
            None => samples.end(),
        };
    }

    #[inline]
    fn shade(&self, ray: &LineRay, canvas: &Canvas<'_>) {
        match (&ray.samples, ray.hit) {
            (Some(samples), Some(n)) => {
                let point = samples.point(n);
                let colour = bilinear_colour(&self.scene.colours, point.x, point.y);
                canvas.set(ray.pixel, colour, samples.distance(n) as f32);
            }
            _ => canvas.set(ray.pixel, sky(ray.direction), f32::INFINITY),
        }
    }
}

/// Boundary cells and what is below them are terrain (papers' row W6).
struct BoundaryCells<'a>(&'a BoundaryArray);

impl Solid for BoundaryCells<'_> {
    #[inline(always)]
    fn contains<T: Tally>(&self, point: DVec3, _: &mut T) -> bool {
        let [col, row, level] = cell_at(self.0, point);
        let [_, highest] = self.0.span(col as u32, row as u32);
        level <= i32::from(highest)
    }
}

/// Cells below the boundary are terrain, and in boundary cells the places whose interpolated
/// density is above the threshold (papers' row W4).
struct Densities<'a> {
    boundary: &'a BoundaryArray,
    volume: &'a VoxelVolume,
    threshold: f32,
}

impl Solid for Densities<'_> {
    #[inline(always)]
    fn contains<T: Tally>(&self, point: DVec3, tally: &mut T) -> bool {
        let [col, row, level] = cell_at(self.boundary, point);
        let [lowest, highest] = self.boundary.span(col as u32, row as u32);
        if level > i32::from(highest) {
            return false;
        }
        if level < i32::from(lowest) {
            return true;
        }
        tally.cell();
        let place = point - DVec3::new(f64::from(col), f64::from(row), f64::from(level));
        let [u, v, w] = place.as_vec3().to_array();
        let voxels = self
            .volume
            .cell(col as u32, row as u32, level)
            .map(f32::from);
        let [sw, se, nw, ne, sw1, se1, nw1, ne1] = voxels;
        let mix = |a: f32, b: f32, share: f32| a + (b - a) * share;
        let lower = mix(mix(sw, se, u), mix(nw, ne, u), v);
        let upper = mix(mix(sw1, se1, u), mix(nw1, ne1, u), v);
        mix(lower, upper, w) > self.threshold
    }
}

/// The cell in which a point of voxel space lies, the nearest one on the border.
#[inline]
fn cell_at(boundary: &BoundaryArray, point: DVec3) -> [i32; 3] {
    /// Lifts levels above 0, where cutting off is rounding down.
    const LIFT: f64 = 65536.0;
    let col = (point.x as i32).clamp(0, boundary.spans().cols() as i32 - 1);
    let row = (point.y as i32).clamp(0, boundary.spans().rows() as i32 - 1);
    [col, row, (point.z + LIFT) as i32 - LIFT as i32]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tally::Work;
    use sandtable_terrain::Ground;

    #[test]
    fn what_is_in_the_volume_is_in_its_boundary_cells_or_below() {
        let height = |col: u32, row: u32| ((col * 37 + row * 61) % 23) as f32 * 1.7;
        let ground = Ground::from_fn(40, 30, DVec2::ONE, height).expect("sound");
        let shape = VoxelShape::cubic(&ground);
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        };
        for filter in [VoxelOptions::FILTERED.filter, DensityFilter::None] {
            let volume = VoxelVolume::new(&ground, shape, filter).expect("sound");
            for threshold in [0, 127, 254] {
                let boundary = &volume.boundary(threshold);
                let densities = Densities {
                    boundary,
                    volume: &volume,
                    threshold: f32::from(threshold),
                };
                let mut inside = 0;
                for _ in 0..20_000 {
                    let place = DVec3::new(39.0 * random(), 29.0 * random(), 50.0 * random());
                    if densities.contains(place, &mut Work::default()) {
                        inside += 1;
                        let cells = BoundaryCells(boundary);
                        assert!(cells.contains(place, &mut Work::default()), "{place}");
                    }
                }
                assert!((500..19_500).contains(&inside), "{inside}");
            }
        }
    }
}
