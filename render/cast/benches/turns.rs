//! Casts and other repetitions that take turns.

use crate::scenes::BenchScene;
use crate::warm_up::warm_up;
use anyhow::Result;
use sandtable_cast::{CastPool, Image, PreparedScene, caster_by_name};
use sandtable_view::View;
use std::sync::Arc;
use std::time::Instant;

/// Something that is timed, again and again.
pub(crate) type Entry<'a> = Box<dyn FnMut() -> Result<()> + 'a>;

/// The milliseconds of each of `entries`, over `rounds` repetitions, from the least on.
///
/// Each timed repetition comes after others that are not ([`warm_up`]), and every other time they take
/// turns in reverse.
pub(crate) fn timed(rounds: usize, mut entries: Vec<Entry<'_>>) -> Result<Vec<Vec<f64>>> {
    let mut times = vec![Vec::with_capacity(rounds); entries.len()];
    let mut order: Vec<_> = (0..entries.len()).collect();
    for _ in 0..rounds {
        for &place in &order {
            let entry = &mut entries[place];
            warm_up(&mut *entry)?;
            let begin = Instant::now();
            entry()?;
            times[place].push(begin.elapsed().as_secs_f64() * 1e3);
        }
        order.reverse();
    }
    for times in &mut times {
        times.sort_by(f64::total_cmp);
    }
    Ok(times)
}

/// The caster `name` with a scene.
pub(crate) fn prepared(
    scene: &BenchScene,
    pool: &CastPool,
    name: &str,
) -> Result<Arc<dyn PreparedScene>> {
    let caster = caster_by_name(name)?;
    Ok(pool.run(|| caster.prepare(Arc::clone(&scene.scene)))?)
}

/// Casting `views` as one job, to be repeated.
pub(crate) fn cast<'a>(
    pool: &'a CastPool,
    prepared: &'a Arc<dyn PreparedScene>,
    views: Vec<View>,
) -> Entry<'a> {
    let mut images = vec![Image::default(); views.len()];
    Box::new(move || Ok(pool.cast(&**prepared, &views, &mut images)?))
}
