//! Casters and Embree over one scene, timed in turns.

mod accuracy;
mod memory;
pub(crate) mod report;

use crate::embree::{Built, Embree, Geometry};
use crate::scenes::BenchScene;
use crate::warm_up::warm_up;
use accuracy::Truth;
use anyhow::Result;
use report::{Holding, Line, Run};
use sandtable_cast::standpoints::Standpoint;
use sandtable_cast::{CastPool, Image, PreparedScene, caster_by_name};
use sandtable_terrain::Ground;
use sandtable_view::View;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Most cells of which triangles are made: more take over 6 GB.
const MOST_CELLS: u64 = 1 << 25;

/// Who takes part.
#[derive(Clone, Copy)]
enum Contender {
    Embree(Geometry),
    /// One of ours, by its place.
    Ours(usize),
}

/// One of our casters, with what it was prepared to.
struct Ours {
    prepared: Arc<dyn PreparedScene>,
    images: [Image; 1],
}

/// A scene, and all who have prepared it.
pub(crate) struct Contest<'a> {
    scene: &'a BenchScene,
    pools: &'a [CastPool],
    embree: Option<Embree>,
    geometries: Vec<Geometry>,
    ours: Vec<Ours>,
    holdings: Vec<Holding>,
}

impl<'a> Contest<'a> {
    /// Prepares `scene` for each of `casters`, and for Embree where there is a `program`, all on
    /// one thread.
    pub(crate) fn prepare(
        scene: &'a BenchScene,
        casters: &[String],
        pools: &'a [CastPool],
        program: Option<&Path>,
    ) -> Result<Self> {
        let mut contest = Self {
            scene,
            pools,
            embree: None,
            geometries: Vec::new(),
            ours: Vec::new(),
            holdings: Vec::new(),
        };
        for name in casters {
            contest.prepare_ours(name)?;
        }
        if let Some(program) = program {
            contest.prepare_embree(program)?;
        }
        Ok(contest)
    }

    fn prepare_ours(&mut self, name: &str) -> Result<()> {
        let caster = caster_by_name(name)?;
        let one_thread = CastPool::new(1)?;
        let before = memory::resident_bytes();
        let begin = Instant::now();
        let prepared = one_thread.run(|| caster.prepare(Arc::clone(&self.scene.scene)))?;
        let ready_ms = begin.elapsed().as_secs_f64() * 1e3;
        let after = memory::resident_bytes();
        self.holdings.push(Holding {
            scene: self.scene.name.clone(),
            contender: name.to_owned(),
            ready_ms,
            terrain_bytes: self.scene.scene.ground.bytes() as u64,
            bytes: before
                .zip(after)
                .map(|(before, after)| after.saturating_sub(before)),
            peak_bytes: None,
        });
        self.ours.push(Ours {
            prepared,
            images: [Image::default()],
        });
        Ok(())
    }

    fn prepare_embree(&mut self, program: &Path) -> Result<()> {
        let ground: &Ground = &self.scene.scene.ground;
        let mut embree = Embree::start(program)?;
        let terrain_bytes = embree.load(ground)?;
        for geometry in Geometry::ALL {
            if geometry == Geometry::Triangles && ground.grid().posts() > MOST_CELLS {
                continue;
            }
            let Built {
                ms,
                bytes,
                peak_bytes,
            } = embree.build(geometry)?;
            self.holdings.push(Holding {
                scene: self.scene.name.clone(),
                contender: report::name(geometry).to_owned(),
                ready_ms: ms,
                terrain_bytes,
                bytes: Some(bytes),
                peak_bytes: Some(peak_bytes),
            });
            self.geometries.push(geometry);
        }
        self.embree = Some(embree);
        Ok(())
    }

    /// Times all contenders in one view on each number of threads, `rounds` frames each.
    pub(crate) fn race(&mut self, at: &Standpoint, rounds: usize) -> Result<Vec<Line>> {
        if let Some(embree) = &mut self.embree {
            embree.look(&at.view)?;
        }
        let truth = Truth::of(&self.scene.scene, &at.view)?;
        (0..self.pools.len())
            .map(|pool| self.line(at, &truth, pool, rounds))
            .collect()
    }

    fn line(&mut self, at: &Standpoint, truth: &Truth, pool: usize, rounds: usize) -> Result<Line> {
        let contenders: Vec<_> = (self.geometries.iter().copied().map(Contender::Embree))
            .chain((0..self.ours.len()).map(Contender::Ours))
            .collect();
        let mut line = Line {
            scene: self.scene.name.clone(),
            view: at.name.clone(),
            threads: self.pools[pool].threads(),
            embree: [None; Geometry::ALL.len()],
            ours: vec![None; self.ours.len()],
        };
        let mut taking_part = Vec::new();
        for contender in contenders {
            // This is also the frame that warms the memory of images.
            if self.frame(contender, &at.view, pool)?.is_some() {
                let right = self.share_right(contender, truth)?;
                taking_part.push((contender, right, Vec::with_capacity(rounds)));
            }
        }
        for _ in 0..rounds {
            for (contender, _, times) in &mut taking_part {
                // The others' frames have taken the caches, and threads have slept: frames before the
                // timed one bring back what a flight's last ones would have left.
                warm_up(|| {
                    self.frame(*contender, &at.view, pool)?;
                    Ok(())
                })?;
                times.extend(self.frame(*contender, &at.view, pool)?);
            }
            // Every other time in reverse, so that none always comes after the same other one.
            taking_part.reverse();
        }
        for (contender, right, times) in taking_part {
            let run = Run {
                median_ms: median(times),
                right,
            };
            match contender {
                Contender::Embree(geometry) => line.embree[geometry as usize] = Some(run),
                Contender::Ours(place) => line.ours[place] = Some(run),
            }
        }
        Ok(line)
    }

    /// The milliseconds of a contender's frame, or `None` where it does not take the view.
    fn frame(&mut self, contender: Contender, view: &View, pool: usize) -> Result<Option<f64>> {
        let pool = &self.pools[pool];
        match (contender, &mut self.embree) {
            (Contender::Embree(geometry), Some(embree)) => {
                embree.frame(geometry, pool.threads()).map(Some)
            }
            (Contender::Embree(_), None) => Ok(None),
            (Contender::Ours(place), _) => {
                let Ours { prepared, images } = &mut self.ours[place];
                let begin = Instant::now();
                let cast = pool.cast(&**prepared, &[*view], images);
                Ok(cast.ok().map(|()| begin.elapsed().as_secs_f64() * 1e3))
            }
        }
    }

    /// The share of a contender's last frame that is right.
    fn share_right(&mut self, contender: Contender, truth: &Truth) -> Result<f64> {
        Ok(match (contender, &mut self.embree) {
            (Contender::Embree(_), Some(embree)) => {
                let (depth, colour) = embree.image()?;
                truth.share_right(&depth, &colour)
            }
            (Contender::Embree(_), None) => 0.0,
            (Contender::Ours(place), _) => {
                let [image] = &self.ours[place].images;
                truth.share_right(&image.depth, image.colour())
            }
        })
    }

    /// What each contender took to be ready and held, in the end.
    pub(crate) fn into_holdings(self) -> Vec<Holding> {
        self.holdings
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
