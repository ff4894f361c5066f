//! Measuring: runs that take turns, and the times of each.

use anyhow::Result;
use sandtable_cast::{CastError, CastPool, Image, PreparedScene, Scheme};
use sandtable_view::View;
use std::time::Instant;

/// Times of one run's repetitions, in milliseconds and in order.
#[derive(Clone, Debug)]
pub(crate) struct Times(Vec<f64>);

impl Times {
    fn sorted(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        Self(times)
    }

    /// The time below which `share` of the repetitions stayed.
    pub(crate) fn at(&self, share: f64) -> f64 {
        self.0[((self.0.len() - 1) as f64 * share).round() as usize]
    }

    /// The median.
    pub(crate) fn median(&self) -> f64 {
        self.at(0.5)
    }
}

/// Something that is timed.
pub(crate) type Work<'a> = Box<dyn FnMut() -> Result<()> + 'a>;

/// Times `frames` repetitions (at least one) of each of `works`, after one of each that warms the
/// caches.
///
/// They take turns, one repetition each and every other time in reverse, so that what else the
/// machine does meets all alike, none always finds the caches as the same other one left them, and
/// the ratios of their times stay fair.
///
/// # Errors
/// The first that one of them gives.
pub(crate) fn take_turns(frames: usize, works: &mut [Work<'_>]) -> Result<Vec<Times>> {
    for work in &mut *works {
        work()?;
    }
    let mut times = vec![Vec::with_capacity(frames); works.len()];
    let mut order: Vec<_> = (0..works.len()).collect();
    for _ in 0..frames.max(1) {
        for &place in &order {
            let begin = Instant::now();
            works[place]()?;
            times[place].push(begin.elapsed().as_secs_f64() * 1e3);
        }
        order.reverse();
    }
    Ok(times.into_iter().map(Times::sorted).collect())
}

/// One cast that can be repeated: a prepared scene on some threads, and the images it fills.
pub(crate) struct Run<'a> {
    pool: &'a CastPool,
    prepared: &'a dyn PreparedScene,
    scheme: Scheme,
    views: Vec<View>,
    images: Vec<Image>,
}

impl<'a> Run<'a> {
    /// A run that casts `views` as one job.
    ///
    /// # Errors
    /// [`CastError::View`] where the caster refuses one of them. This is found out by casting
    /// once.
    pub(crate) fn new(
        pool: &'a CastPool,
        prepared: &'a dyn PreparedScene,
        scheme: Scheme,
        views: Vec<View>,
    ) -> Result<Self, CastError> {
        let mut run = Self {
            pool,
            prepared,
            scheme,
            images: vec![Image::default(); views.len()],
            views,
        };
        run.cast()?;
        Ok(run)
    }

    /// Casts the views anew.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub(crate) fn cast(&mut self) -> Result<(), CastError> {
        let Self {
            prepared,
            scheme,
            views,
            images,
            ..
        } = self;
        self.pool.run(|| prepared.cast(views, images, *scheme))
    }

    /// The run as something to be timed.
    pub(crate) fn as_work(&mut self) -> Work<'_> {
        Box::new(|| Ok(self.cast()?))
    }

    /// What was cast last.
    pub(crate) fn images(&self) -> &[Image] {
        &self.images
    }
}

/// Times runs that take turns.
///
/// # Errors
/// As [`Run::new`].
pub(crate) fn race(frames: usize, runs: &mut [Run<'_>]) -> Result<Vec<Times>> {
    let mut works: Vec<_> = runs.iter_mut().map(Run::as_work).collect();
    take_turns(frames, &mut works)
}

/// The value of `work` and how many milliseconds it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begin = Instant::now();
    let value = work();
    (value, begin.elapsed().as_secs_f64() * 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn works_take_turns_after_a_warm_up() {
        let order = RefCell::new(String::new());
        let work = |name: char| -> Work<'_> {
            let order = &order;
            Box::new(move || {
                order.borrow_mut().push(name);
                Ok(())
            })
        };
        let times = take_turns(3, &mut [work('a'), work('b')]).unwrap();
        assert_eq!(*order.borrow(), "ababbaab");
        assert_eq!(times.len(), 2);
        assert_eq!(times[0].0.len(), 3);
    }

    #[test]
    fn times_are_read_at_shares_of_their_order() {
        let times = Times::sorted(vec![5.0, 1.0, 4.0, 2.0, 3.0]);
        assert_eq!(
            [0.0, 0.25, 0.5, 1.0].map(|share| times.at(share)),
            [1.0, 2.0, 3.0, 5.0]
        );
        assert_eq!(times.median(), 3.0);
    }
}
