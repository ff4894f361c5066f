//! Steering: lines on standard input that say what a simulated device does from now on.

use anyhow::{Context, Result};
use crossbeam_channel::Receiver;
use std::io::BufRead;

/// What is to be done to a device.
pub(super) type Change<D> = Box<dyn FnOnce(&mut D) + Send>;

/// What a line means: its answer once it is done, and what is to be done; or what is wrong with it.
pub(super) type Steering<D> = Box<dyn Fn(&str) -> Result<(String, Change<D>), String>>;

/// The lines of standard input as they come; the channel ends with them.
pub(super) fn lines_of_standard_input() -> Result<Receiver<String>> {
    let (sender, lines) = crossbeam_channel::bounded(1);
    std::thread::Builder::new()
        .name("standard input".into())
        .spawn(move || {
            for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        })
        .context("cannot start the thread that reads standard input")?;
    Ok(lines)
}
