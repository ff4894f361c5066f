//! Ctrl-C, and the system's request to end.

use anyhow::{Context, Result};
use crossbeam_channel::Receiver;

/// A channel that gets a message at each Ctrl-C, SIGTERM or SIGHUP from now on. At most once a
/// process, and so is [`call`].
pub(crate) fn channel() -> Result<Receiver<()>> {
    let (sender, receiver) = crossbeam_channel::bounded(4);
    call(move || {
        // A full channel holds the wish already.
        let _ = sender.try_send(());
    })?;
    Ok(receiver)
}

/// Calls `end` at each Ctrl-C, SIGTERM or SIGHUP from now on, on a thread of its own.
pub(crate) fn call(end: impl Fn() + Send + 'static) -> Result<()> {
    ctrlc::set_handler(end).context("cannot listen for Ctrl-C")
}
