//! The threads that cast.

use crate::{Image, PreparedScene};
use sandtable_view::View;

/// A pool of casting threads.
///
/// Jobs from several callers share the threads: a worker that finds nothing left in one job takes
/// pieces of the next.
pub struct CastPool {
    threads: rayon::ThreadPool,
}

impl CastPool {
    /// A pool of `threads` threads; 0 means one for each core.
    ///
    /// # Errors
    /// Where the system refuses to start threads.
    pub fn new(threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("cast-{index}"))
            .build()?;
        Ok(Self { threads })
    }

    /// How many threads it has.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Casts `views` into `images` and waits for them.
    pub fn cast(&self, scene: &dyn PreparedScene, views: &[View], images: &mut [Image]) {
        self.threads.install(|| scene.cast(views, images));
    }

    /// Runs `work` on the pool's threads and waits for it.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.threads.install(work)
    }
}
