//! How the units of an image are shared out among threads.

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A way of sharing out a job's units (some pixel lines each) among the threads of a pool.
///
/// None of them changes a byte of the images: each pixel belongs to one unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// rayon's work stealing: the units wait in their order with the thread that began the job, and
    /// every thread that has nothing to do takes the next.
    #[default]
    WorkStealing,
    /// Thread k of n casts units k, k + n, k + 2n, … and then rests (Wan, Qu and Kaufman 1999;
    /// papers' row W9).
    StaticInterleave,
    /// Each thread takes the next unit from one pool. The pool goes on into the job's next view,
    /// so that no thread waits for the others between frames cast as one job (Cohen-Or and others
    /// 1996; papers' row C6).
    ColumnPool,
}

impl Scheme {
    /// All schemes.
    pub const ALL: [Self; 3] = [Self::WorkStealing, Self::StaticInterleave, Self::ColumnPool];

    /// The name by which users ask for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WorkStealing => "stealing",
            Self::StaticInterleave => "interleave",
            Self::ColumnPool => "pool",
        }
    }

    /// Does `work` for each of `units`, on the current thread pool, and waits for all of it.
    pub(crate) fn run(self, units: usize, work: impl Fn(usize) + Send + Sync) {
        match self {
            Self::WorkStealing => {
                let work = &work;
                rayon::scope_fifo(|scope| {
                    for unit in 0..units {
                        scope.spawn_fifo(move |_| work(unit));
                    }
                });
            }
            Self::StaticInterleave => {
                rayon::broadcast(|thread| {
                    (thread.index()..units)
                        .step_by(thread.num_threads())
                        .for_each(&work);
                });
            }
            Self::ColumnPool => {
                let next = AtomicUsize::new(0);
                rayon::broadcast(|_| {
                    loop {
                        let unit = next.fetch_add(1, Ordering::Relaxed);
                        if unit >= units {
                            break;
                        }
                        work(unit);
                    }
                });
            }
        }
    }
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Scheme {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|scheme| scheme.name() == name)
            .ok_or_else(|| {
                let known: Vec<_> = Self::ALL.iter().map(|scheme| scheme.name()).collect();
                format!("no scheme is called {name:?}: use {}", known.join(", "))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_is_done_once_whatever_the_scheme_and_threads() {
        for scheme in Scheme::ALL {
            for threads in [1, 2, 7] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let done: Vec<_> = (0..50).map(|_| AtomicUsize::new(0)).collect();
                pool.build().expect("threads").install(|| {
                    scheme.run(done.len(), |unit| {
                        done[unit].fetch_add(1, Ordering::Relaxed);
                    });
                });
                assert!(done.iter().all(|unit| unit.load(Ordering::Relaxed) == 1));
            }
        }
    }

    #[test]
    fn schemes_are_found_by_their_names() {
        for scheme in Scheme::ALL {
            assert_eq!(scheme.name().parse(), Ok(scheme));
        }
        assert!("columns".parse::<Scheme>().is_err());
    }
}
