//! Casters that have prepared one scene and are timed against each other in view after view.

use super::figures::Figures;
use super::measure::{Run, Times, Work, take_turns, timed};
use crate::cli::BenchArgs;
use crate::resident;
use crate::scene::ChosenCaster;
use anyhow::{Context, Result};
use sandtable_cast::{
    Brute, CastError, CastPool, Difference, Image, PreparedScene, Scene, Scheme, ShadeFloor,
};
use sandtable_view::View;
use std::sync::Arc;
use std::time::Instant;

/// A scene, and the casters that are timed over it.
pub(super) struct Contest {
    scene: Arc<Scene>,
    contenders: Vec<Contender>,
    all_cores: CastPool,
    /// Milliseconds from the program's start to the first picture; `None` where no caster took the
    /// first view.
    first_picture_ms: Option<f64>,
    /// Resident memory at its highest until then.
    peak_resident_bytes: Option<u64>,
}

/// A caster that has prepared the scene, or does not suit it.
struct Contender {
    name: String,
    prepared: Result<Arc<dyn PreparedScene>, CastError>,
    prepare_ms: f64,
}

/// A view with what does not depend on threads and schemes.
struct Task<'a> {
    name: &'a str,
    view: View,
    /// What brute force sees, where images are checked.
    exact: Option<Image>,
    /// The work of each contender, where it takes the view.
    works: Vec<Option<sandtable_cast::Work>>,
}

impl Contest {
    /// Prepares `scene` for each caster, on all cores, and casts `first_view` with the first one
    /// that takes it.
    pub(super) fn prepare(
        scene: &Arc<Scene>,
        casters: &[ChosenCaster],
        first_view: View,
        started: Instant,
    ) -> Result<Self> {
        let all_cores = CastPool::new(0).context("cannot start the casting threads")?;
        let mut contest = Self {
            scene: Arc::clone(scene),
            contenders: Vec::with_capacity(casters.len()),
            all_cores,
            first_picture_ms: None,
            peak_resident_bytes: None,
        };
        for chosen in casters {
            let prepare = || chosen.caster.prepare(Arc::clone(scene));
            let (prepared, prepare_ms) = timed(|| contest.all_cores.run(prepare));
            if let (None, Ok(prepared)) = (contest.first_picture_ms, &prepared) {
                let mut images = [Image::default()];
                let cast = contest
                    .all_cores
                    .cast(&**prepared, &[first_view], &mut images);
                if cast.is_ok() {
                    contest.first_picture_ms = Some(started.elapsed().as_secs_f64() * 1e3);
                    contest.peak_resident_bytes = resident::peak_bytes();
                }
            }
            contest.contenders.push(Contender {
                name: chosen.name.clone(),
                prepared,
                prepare_ms,
            });
        }
        Ok(contest)
    }

    /// The number of this machine's threads.
    pub(super) fn cores(&self) -> usize {
        self.all_cores.threads()
    }

    /// The figures of each view, number of threads, caster and scheme, in this order.
    pub(super) fn figures(
        &self,
        args: &BenchArgs,
        views: &[(String, View)],
    ) -> Result<Vec<Figures>> {
        let pools = args
            .threads
            .iter()
            .map(|&threads| CastPool::new(threads).context("cannot start the casting threads"))
            .collect::<Result<Vec<_>>>()?;
        let mut lines = Vec::new();
        for (name, view) in views {
            let task = self.task(name, *view, args.check)?;
            for pool in &pools {
                lines.extend(self.race(&task, pool, &args.scheme, args.frames)?);
            }
        }
        Ok(lines)
    }

    fn task<'a>(&self, name: &'a str, view: View, check: bool) -> Result<Task<'a>> {
        let exact = check.then(|| self.all_cores.picture(&Brute, &self.scene, view));
        let work = |contender: &Contender| {
            let prepared = contender.prepared.as_ref().ok()?;
            self.all_cores.run(|| prepared.work(&view)).ok()
        };
        Ok(Task {
            name,
            view,
            exact: exact.transpose()?,
            works: self.contenders.iter().map(work).collect(),
        })
    }

    /// Times every caster under every scheme in one view, a frame each in turn.
    fn race(
        &self,
        task: &Task<'_>,
        pool: &CastPool,
        schemes: &[Scheme],
        frames: usize,
    ) -> Result<Vec<Figures>> {
        let mut lines = Vec::new();
        // Each line's run, in the lines' order; a refused line has none.
        let mut runs = Vec::new();
        for (contender, work) in self.contenders.iter().zip(&task.works) {
            for &scheme in schemes {
                let mut line = self.line(contender, task, pool, scheme);
                let run = contender.prepared.as_ref().map_err(Clone::clone);
                match run.and_then(|it| Run::new(pool, &**it, scheme, vec![task.view])) {
                    Ok(run) => runs.push(run),
                    Err(error) => line.refused = Some(reason(error)),
                }
                if let Some(work) = work {
                    line.set_work(*work);
                }
                lines.push(line);
            }
        }
        let Some((floor, times)) = self.timed(pool, frames, &mut runs)? else {
            return Ok(lines);
        };
        let cell = self.scene.ground.grid().cell_length();
        let accepted = lines.iter_mut().filter(|line| line.refused.is_none());
        for ((line, run), times) in accepted.zip(&runs).zip(&times) {
            line.set_times(times);
            line.shade_only_ms = floor.as_ref().map(Times::median);
            let difference = |exact| Difference::between(&run.images()[0], exact, cell);
            line.check = task.exact.as_ref().map(|exact| difference(exact).into());
        }
        Ok(lines)
    }

    /// The times of shading alone, where there is a floor, and of each run, all taking turns;
    /// `None` without runs.
    fn timed(
        &self,
        pool: &CastPool,
        frames: usize,
        runs: &mut [Run<'_>],
    ) -> Result<Option<(Option<Times>, Vec<Times>)>> {
        let Some(first) = runs.first() else {
            return Ok(None);
        };
        let mut floor = ShadeFloor::new(&self.scene, &first.images()[0]);
        let mut works: Vec<Work<'_>> = runs.iter_mut().map(|run| run.as_work()).collect();
        if let Some(floor) = &mut floor {
            works.push(Box::new(|| {
                pool.run(|| floor.shade());
                Ok(())
            }));
        }
        let mut casts = take_turns(frames, &mut works)?;
        drop(works);
        let floor = casts.split_off(runs.len()).pop();
        Ok(Some((floor, casts)))
    }

    /// A line that nothing has been timed for yet.
    fn line(
        &self,
        contender: &Contender,
        task: &Task<'_>,
        pool: &CastPool,
        scheme: Scheme,
    ) -> Figures {
        let ground = &self.scene.ground;
        let photo_pixels = ground.photo().map_or(0, |photo| {
            u64::from(photo.pixels.cols()) * u64::from(photo.pixels.rows())
        });
        Figures {
            caster: contender.name.clone(),
            view: task.name.to_owned(),
            threads: pool.threads(),
            scheme: scheme.name(),
            isa: "generic",
            median_ms: None,
            p5_ms: None,
            p95_ms: None,
            mpix_per_s: None,
            shade_only_ms: None,
            pixels: u64::from(task.view.size[0]) * u64::from(task.view.size[1]),
            rays: None,
            rays_per_pixel: None,
            samples_per_ray: None,
            cells_per_ray: None,
            prepare_ms: contender.prepared.is_ok().then_some(contender.prepare_ms),
            refused: None,
            check: None,
            first_picture_ms: self.first_picture_ms,
            peak_resident_bytes: self.peak_resident_bytes,
            resident_limit_bytes: 300_000_000 + 4 * ground.grid().posts() + 4 * photo_pixels,
        }
    }
}

/// Why a caster does not cast a view; its name stands in the line already.
fn reason(error: CastError) -> String {
    match error {
        CastError::View { reason, .. } => reason,
        error => error.to_string(),
    }
}
