//! Repetitions that take turns.

use anyhow::Result;
use std::time::Instant;

/// Something that is timed, again and again.
pub(super) type Entry<'a> = Box<dyn FnMut() -> Result<()> + 'a>;

/// The median milliseconds of each of `entries`, over `rounds` repetitions.
///
/// Each timed repetition comes after one that is not, which brings back into the caches what the
/// others have taken; and every other time they take turns in reverse.
pub(super) fn medians(rounds: usize, mut entries: Vec<Entry<'_>>) -> Result<Vec<f64>> {
    let mut times = vec![Vec::with_capacity(rounds); entries.len()];
    let mut order: Vec<_> = (0..entries.len()).collect();
    for _ in 0..rounds {
        for &place in &order {
            let entry = &mut entries[place];
            entry()?;
            let begin = Instant::now();
            entry()?;
            times[place].push(begin.elapsed().as_secs_f64() * 1e3);
        }
        order.reverse();
    }
    let median = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    Ok(times.into_iter().map(median).collect())
}
