//! Ctrl-C, and the system's request to end.

use anyhow::{Context, Result};
use crossbeam_channel::Receiver;

/// A channel that gets a message at each Ctrl-C or SIGTERM from now on. At most once a process.
pub(crate) fn channel() -> Result<Receiver<()>> {
    let (sender, receiver) = crossbeam_channel::bounded(4);
    ctrlc::set_handler(move || {
        // A full channel holds the wish already.
        let _ = sender.try_send(());
    })
    .context("cannot listen for Ctrl-C")?;
    Ok(receiver)
}
