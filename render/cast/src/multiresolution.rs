//! Multiresolution casting along grid lines (papers' rows C1 to C4).

use crate::canvas::Canvas;
use crate::grid_track::{GridTrack, Sampler};
use crate::intersect::GridFrame;
use crate::level_window::LevelWindow;
use crate::options::{CasterOption, Options};
use crate::shade::sky;
use crate::tally::Tally;
use crate::units::UnitCaster;
use crate::{CastError, Caster, PreparedScene, Scene};
use sandtable_terrain::{LinearLight, Pyramid, TileIndex};
use sandtable_view::{Rays, View};
use std::sync::Arc;

/// Steps from grid line to grid line of the axis along which a ray runs faster, with the fraction
/// along the line as the weight of its two posts. The step doubles, at an even line, where a post's
/// footprint falls under a pixel, and heights and colours come from the pyramid's level of that
/// step, blended with the next by distance so that no border shows. A column's first ray finds its
/// start top-down through the pyramid, the others climb from the hit below; a pixel is sampled by
/// parallel rays one above the other (Cohen-Or, Rich, Lerner and Shenkar, A real-time
/// photo-realistic visual flythrough, 1996).
///
/// Known error: a hit lies on the first grid line behind the surface, up to a step away; coherence
/// takes columns for vertical planes, so that ground hidden in one row may be missed in the next
/// (little under 10° of field of view, more where it is wide and steep); the terrain beyond a
/// pixel's resolution is a filtered one. Windows with level rows only: the paper rolls the finished
/// image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multiresolution {
    /// Whether neighbouring levels are blended.
    pub blends: bool,
    /// Whether a ray whose foothold is in the terrain goes back (after Wan, Qu and Kaufman 1999;
    /// the paper's own fields of view are too narrow to need it).
    pub retraces: bool,
    /// Parallel rays a pixel, 1 to 8.
    pub rays: u32,
    /// Pixels that a post's footprint spans where the step doubles: above 1 is coarser and faster.
    pub scale: f64,
}

impl Default for Multiresolution {
    fn default() -> Self {
        Self {
            blends: true,
            retraces: true,
            rays: 2,
            scale: 1.0,
        }
    }
}

impl Multiresolution {
    /// The name by which users ask for it.
    pub(crate) const NAME: &str = "multiresolution";

    /// What can be set.
    pub(crate) const OPTIONS: [CasterOption; 4] = [
        CasterOption {
            name: "blend",
            meaning: "whether neighbouring levels are blended: on or off; on",
        },
        CasterOption {
            name: "retrace",
            meaning: "whether rays go back from a start inside the terrain: on or off; on",
        },
        CasterOption {
            name: "rays",
            meaning: "parallel rays a pixel, 1 to 8; 2",
        },
        CasterOption {
            name: "scale",
            meaning: "posts' size in pixels where the step doubles, 0.25 to 8: more is coarser; 1",
        },
    ];

    pub(crate) fn read(options: &Options<'_>) -> Result<Self, CastError> {
        let default = Self::default();
        Ok(Self {
            blends: options.choice("blend", &[("on", true), ("off", false)])?,
            retraces: options.choice("retrace", &[("on", true), ("off", false)])?,
            rays: options.number("rays", 1..=8)?.unwrap_or(default.rays),
            scale: options
                .number("scale", 0.25..=8.0)?
                .unwrap_or(default.scale),
        })
    }
}

impl Caster for Multiresolution {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        Ok(Arc::new(PyramidScene {
            caster: *self,
            pyramid: Pyramid::new(&scene.ground),
            light: LinearLight::tables(),
            scene,
        }))
    }
}

/// The ground and its pyramid.
struct PyramidScene {
    caster: Multiresolution,
    scene: Arc<Scene>,
    pyramid: Pyramid,
    light: &'static LinearLight,
}

/// Columns in a unit: their pixels in a row fill a cache line.
const COLUMNS_PER_UNIT: u32 = 16;

/// One view.
struct Frame<'a> {
    scene: &'a PyramidScene,
    grid: GridFrame<'a>,
    sampler: Sampler<'a>,
    rays: Rays,
    size: [u32; 2],
    /// Rows before and behind the eye, each in the order in which their rays rise.
    marches: [Vec<u32>; 2],
}

impl UnitCaster for PyramidScene {
    type Frame<'a> = Frame<'a>;

    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        Ok(Arc::new(Self {
            caster: self.caster,
            pyramid: self.pyramid.updated(&scene.ground, changed),
            light: self.light,
            scene,
        }))
    }

    fn frame<'a>(&'a self, view: &'a View) -> Result<Frame<'a>, CastError> {
        let window = LevelWindow::new(Multiresolution::NAME, view)?;
        let pixel = view.window.across().length() / f64::from(view.size[0]);
        let cell = self.scene.ground.grid().cell_length();
        let finest_border = cell / (pixel * self.caster.scale);
        Ok(Frame {
            scene: self,
            grid: GridFrame::new(&self.scene.ground),
            sampler: Sampler::new(&self.pyramid, finest_border, self.caster.blends),
            rays: view.rays(),
            size: view.size,
            marches: rows_by_rise(&window, view.size[1]),
        })
    }

    /// A unit is a block of columns.
    fn units(frame: &Frame<'_>) -> usize {
        frame.size[0].div_ceil(COLUMNS_PER_UNIT) as usize
    }

    fn cast_unit<T: Tally>(frame: &Frame<'_>, unit: usize, canvas: &Canvas<'_>, tally: &mut T) {
        let first = unit as u32 * COLUMNS_PER_UNIT;
        for column in first..frame.size[0].min(first + COLUMNS_PER_UNIT) {
            for rows in &frame.marches {
                cast_rows(frame, column, rows, canvas, tally);
            }
        }
    }
}

/// The rows before the eye and those behind it, each in the order in which their rays rise.
fn rows_by_rise(window: &LevelWindow, height: u32) -> [Vec<u32>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    for j in 0..height {
        let [ahead, _] = window.forward_and_up(j);
        parts[usize::from(ahead < 0.0)].push(j);
    }
    for part in &mut parts {
        let rise = |&j: &u32| {
            let [ahead, up] = window.forward_and_up(j);
            up / ahead.abs()
        };
        part.sort_by(|a, b| rise(a).total_cmp(&rise(b)));
    }
    parts
}

/// Casts some rows of one column, each ray climbing from where the one below it ended.
fn cast_rows<T: Tally>(
    frame: &Frame<'_>,
    column: u32,
    rows: &[u32],
    canvas: &Canvas<'_>,
    tally: &mut T,
) {
    let caster = &frame.scene.caster;
    let count = caster.rays;
    // Where the ray before came to.
    let mut foothold = None;
    for (at, &row) in rows.iter().enumerate() {
        let pixel = [column, row];
        let ray = frame.rays.ray(column, row);
        let Some(clipped) = frame.grid.clip(&ray) else {
            tally.ray();
            canvas.set(pixel, sky(ray.direction), f32::INFINITY);
            continue;
        };
        let mut track = GridTrack::new(&clipped);
        match foothold {
            Some(foothold) => {
                track.climb_from(foothold, &frame.sampler);
                if caster.retraces {
                    track.retrace(&frame.sampler, tally);
                }
            }
            None => track.start_top_down(&frame.sampler, tally),
        }
        // How much higher the ray of the row above rises on its way to the window.
        let above = rows.get(at + 1).or_else(|| rows.get(at.wrapping_sub(1)));
        let spread = above.map_or(0.0, |&other| {
            let other = frame.rays.ray(column, other).direction;
            let ground = |direction: glam::DVec3| direction.truncate().length();
            let level = ground(ray.direction).max(f64::MIN_POSITIVE);
            (other.z * level / ground(other).max(f64::MIN_POSITIVE) - ray.direction.z).abs()
        });
        let mut sum = [0.0; 3];
        let mut depth = f32::INFINITY;
        for sub in 0..count {
            tally.ray();
            let share = (f64::from(sub) + 0.5) / f64::from(count) - 0.5;
            track.lift(share * spread);
            let hit = track.first_hit(&frame.sampler, tally);
            let colour = match hit {
                Some(colour) => colour,
                None => sky(ray.direction),
            };
            // The depth is that of the middle, or just below it where there is sky.
            if sub <= count / 2 && hit.is_some() {
                depth = (track.way() * ray.direction.length()) as f32;
            }
            let linear = colour.map(|channel| frame.scene.light.decode(channel));
            sum = std::array::from_fn(|k| sum[k] + linear[k]);
            if count == 1 {
                canvas.set(pixel, colour, depth);
            }
        }
        foothold = Some(track.foothold());
        if count > 1 {
            let mean = sum.map(|sum| frame.scene.light.encode(sum / count as f32));
            canvas.set(pixel, mean, depth);
        }
    }
}
