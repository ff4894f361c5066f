//! Trials: casters asked for by name, timed against each other in turns.

use super::report::Cell;
use crate::command::bench::measure::{Run, Times, race};
use anyhow::Result;
use sandtable_cast::{CastError, CastPool, Image, PreparedScene, Scene, Scheme, caster_by_name};
use sandtable_view::View;
use std::sync::Arc;

/// A scene as a caster has prepared it.
pub(super) type Prepared = Arc<dyn PreparedScene>;

/// What a trial gives, or why it gives nothing.
pub(super) type Attempt = Result<Outcome, CastError>;

/// The caster that `text` asks for, with `scene` prepared.
///
/// # Errors
/// Where there is no such caster or option, or it does not suit the scene. Only views are refused
/// in a table: they belong to what is measured.
pub(super) fn prepared(pool: &CastPool, scene: &Arc<Scene>, text: &str) -> Result<Prepared> {
    let caster = caster_by_name(text)?;
    Ok(pool.run(|| caster.prepare(Arc::clone(scene)))?)
}

/// [`prepared`] for several casters.
pub(super) fn all_prepared<'a>(
    pool: &CastPool,
    scene: &Arc<Scene>,
    texts: impl IntoIterator<Item = &'a str>,
) -> Result<Vec<Prepared>> {
    let prepared = |text| prepared(pool, scene, text);
    texts.into_iter().map(prepared).collect()
}

/// One cast to be timed.
pub(super) struct Trial<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) pool: &'a CastPool,
    pub(super) scheme: Scheme,
    /// Cast as one job.
    pub(super) views: Vec<View>,
}

impl<'a> Trial<'a> {
    /// A trial of one view under the default scheme.
    pub(super) fn new(prepared: &'a Prepared, pool: &'a CastPool, view: View) -> Self {
        Self {
            prepared,
            pool,
            scheme: Scheme::default(),
            views: vec![view],
        }
    }

    /// The cast as something that can be repeated. It has been done once then.
    pub(super) fn run(&self) -> Result<Run<'a>, CastError> {
        Run::new(self.pool, &**self.prepared, self.scheme, self.views.clone())
    }

    /// The images, untimed.
    pub(super) fn images(&self) -> Result<Vec<Image>, CastError> {
        Ok(self.run()?.images().to_vec())
    }
}

/// Times and last images of a trial.
pub(super) struct Outcome {
    pub(super) times: Times,
    pub(super) images: Vec<Image>,
}

impl Outcome {
    /// Median milliseconds of the job.
    pub(super) fn ms(&self) -> f64 {
        self.times.median()
    }

    /// Millions of pixels a second.
    pub(super) fn mpix_per_s(&self) -> f64 {
        let pixels: usize = self.images.iter().map(|image| image.depth.len()).sum();
        pixels as f64 / self.ms() / 1e3
    }

    /// Frames a second.
    pub(super) fn fps(&self) -> f64 {
        1e3 * self.images.len() as f64 / self.ms()
    }
}

/// Times all trials, a frame each in turn; those that cannot be cast are left out of the turns.
pub(super) fn outcomes(frames: usize, trials: &[Trial<'_>]) -> Result<Vec<Attempt>> {
    let mut faults = Vec::new();
    let mut runs = Vec::new();
    for trial in trials {
        faults.push(match trial.run() {
            Ok(run) => {
                runs.push(run);
                None
            }
            Err(error) => Some(error),
        });
    }
    let times = race(frames, &mut runs)?;
    let mut casts = runs.iter().zip(times).map(|(run, times)| Outcome {
        times,
        images: run.images().to_vec(),
    });
    let attempt = |fault: Option<CastError>| match fault {
        Some(error) => Some(Err(error)),
        None => casts.next().map(Ok),
    };
    Ok(faults.into_iter().filter_map(attempt).collect())
}

/// A number of an outcome, or why there is none.
pub(super) fn cell(attempt: &Attempt, digits: usize, number: impl Fn(&Outcome) -> f64) -> Cell {
    match attempt {
        Ok(outcome) => Cell::Number(number(outcome), digits),
        Err(error) => Cell::Refused(error.to_string()),
    }
}

/// How many times as long `attempt` takes as `unit`, where both were timed.
pub(super) fn ratio(attempt: &Attempt, unit: &Attempt) -> Cell {
    match (attempt, unit) {
        (Ok(outcome), Ok(unit)) => Cell::Number(outcome.ms() / unit.ms(), 2),
        _ => Cell::Empty,
    }
}
