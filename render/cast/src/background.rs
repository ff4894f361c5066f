//! Casting in the background: newest views in, newest finished images out.

use crate::{CastError, CastPool, Image, PreparedScene};
use sandtable_view::View;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What to cast next.
#[derive(Clone)]
pub struct Request {
    /// The scene, prepared by the caster that shall cast it.
    pub scene: Arc<dyn PreparedScene>,
    /// The views: one, or a left and a right eye.
    pub views: Vec<View>,
    /// The caller's own number for this request.
    pub frame: u64,
}

/// What was cast.
#[derive(Clone, Debug)]
pub struct Finished {
    /// An image a view, in the request's order.
    pub images: Vec<Image>,
    /// The request's number.
    pub frame: u64,
    /// When the cast began.
    pub begun: Instant,
    /// How long it took, of all views together.
    pub cast_time: Duration,
}

#[derive(Default)]
struct Mailbox {
    /// The newest request not yet begun. A newer one replaces it.
    request: Option<Request>,
    /// The newest finished images.
    finished: Option<Arc<Finished>>,
    /// Why the newest request begun was not cast.
    refusal: Option<CastError>,
    stop: bool,
}

/// A thread that casts the newest request and keeps the newest result.
///
/// Neither side waits for the other: a request replaces one not yet begun, and a result is there
/// until a newer one is.
pub struct BackgroundCaster {
    shared: Arc<(Mutex<Mailbox>, Condvar)>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl BackgroundCaster {
    /// Starts the thread. `on_finished` is called on it after each result or refusal.
    ///
    /// # Errors
    /// Where the system refuses to start a thread.
    pub fn start(
        pool: Arc<CastPool>,
        on_finished: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        let shared = Arc::new((Mutex::new(Mailbox::default()), Condvar::new()));
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("casting".into())
            .spawn(move || {
                // Results that nobody holds any more give their memory to the next cast.
                let mut retired: Vec<Arc<Finished>> = Vec::new();
                while let Some(request) = next_request(&theirs) {
                    let spare = retired.iter().position(|old| Arc::strong_count(old) == 1);
                    let mut images = spare
                        .and_then(|index| Arc::into_inner(retired.swap_remove(index)))
                        .map_or_else(Vec::new, |old| old.images);
                    images.resize_with(request.views.len(), Image::default);
                    let begun = Instant::now();
                    if let Err(error) = pool.cast(&*request.scene, &request.views, &mut images) {
                        lock(&theirs.0).refusal = Some(error);
                        on_finished();
                        continue;
                    }
                    let finished = Arc::new(Finished {
                        images,
                        frame: request.frame,
                        begun,
                        cast_time: begun.elapsed(),
                    });
                    let old = {
                        let mut mailbox = lock(&theirs.0);
                        mailbox.refusal = None;
                        mailbox.finished.replace(finished)
                    };
                    retired.truncate(2);
                    retired.extend(old);
                    on_finished();
                }
            })?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Asks for `request` to be cast as soon as the present cast is finished; returns the one not
    /// yet begun that it replaces, which will never be cast.
    pub fn request(&self, request: Request) -> Option<Request> {
        let replaced = lock(&self.shared.0).request.replace(request);
        self.shared.1.notify_one();
        replaced
    }

    /// The newest finished images, if any yet.
    #[must_use]
    pub fn newest(&self) -> Option<Arc<Finished>> {
        lock(&self.shared.0).finished.clone()
    }

    /// Why the newest request begun could not be cast, if it could not: what was cast before it
    /// stays the newest.
    #[must_use]
    pub fn refusal(&self) -> Option<CastError> {
        lock(&self.shared.0).refusal.clone()
    }
}

impl BackgroundCaster {
    /// Whether the thread has ended, which only a caster that panicked brings about: what was cast
    /// last stays, and nothing follows.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread
            .as_ref()
            .is_none_or(|thread| thread.is_finished())
    }
}

impl Drop for BackgroundCaster {
    fn drop(&mut self) {
        lock(&self.shared.0).stop = true;
        self.shared.1.notify_one();
        if let Some(thread) = self.thread.take() {
            // A cast that panicked has said so already.
            let _ = thread.join();
        }
    }
}

/// Waits for a request; `None` when it is time to stop.
fn next_request((mailbox, changed): &(Mutex<Mailbox>, Condvar)) -> Option<Request> {
    let mut mailbox = lock(mailbox);
    loop {
        if mailbox.stop {
            return None;
        }
        if let Some(request) = mailbox.request.take() {
            return Some(request);
        }
        mailbox = changed
            .wait(mailbox)
            .unwrap_or_else(PoisonError::into_inner);
    }
}

/// The mailbox holds whole values only, so that a panic elsewhere leaves it usable.
fn lock(mailbox: &Mutex<Mailbox>) -> std::sync::MutexGuard<'_, Mailbox> {
    mailbox.lock().unwrap_or_else(PoisonError::into_inner)
}
