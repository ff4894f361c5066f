//! The threads that cast.

use crate::{CastError, Caster, Image, PreparedScene, Scene, Scheme};
use sandtable_view::View;
use std::sync::Arc;

/// A pool of casting threads.
///
/// Jobs from several callers share the threads: a worker that finds nothing left in one job takes
/// pieces of the next.
pub struct CastPool {
    threads: rayon::ThreadPool,
    scheme: Scheme,
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
        let scheme = Scheme::default();
        Ok(Self { threads, scheme })
    }

    /// The pool, sharing out its work by `scheme`.
    #[must_use]
    pub fn with_scheme(self, scheme: Scheme) -> Self {
        Self { scheme, ..self }
    }

    /// How many threads it has.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Casts `views` into `images` and waits for them.
    ///
    /// # Errors
    /// As [`PreparedScene::cast`].
    pub fn cast(
        &self,
        scene: &dyn PreparedScene,
        views: &[View],
        images: &mut [Image],
    ) -> Result<(), CastError> {
        self.threads
            .install(|| scene.cast(views, images, self.scheme))
    }

    /// Prepares `scene` for one cast of `view`.
    ///
    /// # Errors
    /// As [`Caster::prepare`] and [`PreparedScene::cast`].
    pub fn picture(
        &self,
        caster: &dyn Caster,
        scene: &Arc<Scene>,
        view: View,
    ) -> Result<Image, CastError> {
        let mut images = [Image::default()];
        let prepared = self.run(|| caster.prepare(Arc::clone(scene)))?;
        self.cast(&*prepared, &[view], &mut images)?;
        let [image] = images;
        Ok(image)
    }

    /// Runs `work` on the pool's threads and waits for it.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.threads.install(work)
    }
}
