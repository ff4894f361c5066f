//! One thread for all tests that have a GPU, here and in the app.

use sandtable_stage::{Gpu, GpuError};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::LazyLock;
use std::sync::mpsc::{self, Sender};
use std::thread;

/// What the thread does that has all GPUs.
type Job = Box<dyn FnOnce() + Send>;

/// That thread. It never ends: with NVIDIA's driver (580), the end of a thread that has had a device and the begin of
/// another device, on another thread, may wait for each other for ever.
static GPU_THREAD: LazyLock<Sender<Job>> = LazyLock::new(|| {
    let (jobs, to_do) = mpsc::channel::<Job>();
    thread::spawn(move || to_do.into_iter().for_each(|job| job()));
    jobs
});

/// Runs a test with a GPU, one after the other; none with a message where the machine has no adapter at all.
pub(crate) fn on_a_gpu(test: impl FnOnce(Gpu) + Send + 'static) {
    let (done, outcome) = mpsc::channel();
    let job = move || {
        let test = AssertUnwindSafe(|| gpu().map(test));
        // Nobody listens any more where the test is being given up.
        let _ = done.send(catch_unwind(test));
    };
    GPU_THREAD.send(Box::new(job)).expect("it never ends");
    if let Err(panic) = outcome.recv().expect("it never ends") {
        resume_unwind(panic);
    }
}

fn gpu() -> Option<Gpu> {
    match Gpu::offscreen() {
        Ok(gpu) => Some(gpu),
        Err(GpuError::NoAdapter(error)) => {
            eprintln!("skipped: no graphics adapter ({error})");
            None
        }
        Err(error) => panic!("{error}"),
    }
}
