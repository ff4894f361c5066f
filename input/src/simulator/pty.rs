//! A simulated device on a pseudo-terminal.

use super::SimulatedDevice;
use crossbeam_channel::{Receiver, Sender};
use serialport::{SerialPort, TTYPort};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A simulated device that runs in a thread of its own until it is stopped or dropped.
#[derive(Debug)]
pub struct Simulator<D> {
    path: PathBuf,
    link: Option<PathBuf>,
    stop: Arc<AtomicBool>,
    changes: Sender<Change<D>>,
    thread: Option<JoinHandle<()>>,
}

/// What is to be done to the device by its own thread.
type Change<D> = Box<dyn FnOnce(&mut D) + Send>;

/// Why a simulator cannot start.
#[derive(Debug, thiserror::Error)]
pub enum SimulatorError {
    /// The system gives no pseudo-terminal.
    #[error("cannot open a pseudo-terminal ({0}); check that /dev/ptmx and /dev/pts are there")]
    NoTerminal(#[source] serialport::Error),
    /// The link's place is taken.
    #[error(
        "{path:?} exists and is not a link of an ended simulator; remove it or name another path"
    )]
    LinkTaken {
        /// Where the link should be.
        path: PathBuf,
    },
    /// The link cannot be made.
    #[error(
        "cannot make the link {path:?} ({source}); name a path in a folder that you may write to"
    )]
    Link {
        /// Where the link should be.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// No thread can be started.
    #[error("cannot start the simulator's thread ({0}); end other programs")]
    Thread(#[source] std::io::Error),
}

impl<D: SimulatedDevice + 'static> Simulator<D> {
    /// Starts a simulated device, as from its kind's settings; `link` becomes a symbolic link to
    /// its terminal for as long as it runs.
    ///
    /// # Errors
    /// Where there is no pseudo-terminal, or the link's place is taken.
    pub fn start(device: impl Into<D>, link: Option<&Path>) -> Result<Self, SimulatorError> {
        let mut device = device.into();
        let (mut host_side, device_side) = TTYPort::pair().map_err(SimulatorError::NoTerminal)?;
        let path = PathBuf::from(device_side.name().unwrap_or_default());
        if let Some(link) = link {
            make_link(&path, link)?;
        }
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let (changes, changed) = crossbeam_channel::bounded::<Change<D>>(0);
        let thread = std::thread::Builder::new()
            .name("simulated device".into())
            .spawn(move || {
                run(&mut host_side, &mut device, &changed, &stopped);
                // Held open so that the terminal outlives the hosts that come and go.
                drop(device_side);
            })
            .map_err(SimulatorError::Thread)?;
        Ok(Self {
            path,
            link: link.map(Path::to_owned),
            stop,
            changes,
            thread: Some(thread),
        })
    }

    /// The terminal's path, as `/dev/pts/7`.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Changes the device while it runs; when this returns, it is changed. Where the terminal is
    /// gone, nothing is left to change.
    pub fn change(&self, change: impl FnOnce(&mut D) + Send + 'static) {
        let (done, is_done) = crossbeam_channel::bounded(1);
        let change = Box::new(move |device: &mut D| {
            change(device);
            // Nobody may wait any more.
            let _ = done.send(());
        });
        if self.changes.send(change).is_ok() {
            // An error means that the thread has ended.
            let _ = is_done.recv();
        }
    }

    /// Ends the simulation, closes the terminal and removes the link.
    pub fn stop(mut self) {
        self.end();
    }
}

impl<D> Simulator<D> {
    fn end(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic in it has been printed; there is nothing left to clean up.
            let _ = thread.join();
        }
        if let Some(link) = self.link.take()
            && std::fs::read_link(&link).is_ok_and(|target| target == self.path)
        {
            let _ = std::fs::remove_file(&link);
        }
    }
}

impl<D> Drop for Simulator<D> {
    fn drop(&mut self) {
        self.end();
    }
}

fn run<D: SimulatedDevice>(
    port: &mut TTYPort,
    device: &mut D,
    changes: &Receiver<Change<D>>,
    stop: &AtomicBool,
) {
    let start = Instant::now();
    let mut bytes = [0; 256];
    while !stop.load(Ordering::Relaxed) {
        while let Ok(change) = changes.try_recv() {
            change(device);
        }
        let quiet = device
            .quiet_for(start.elapsed())
            .map_or(Duration::from_millis(20), |quiet| {
                quiet.clamp(Duration::from_millis(1), Duration::from_millis(20))
            });
        let _ = port.set_timeout(quiet);
        match port.read(&mut bytes) {
            Ok(count) => device.receive(&bytes[..count], start.elapsed()),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            // The terminal is gone; nothing can be simulated on it.
            Err(_) => return,
        }
        let sent = device.send(start.elapsed());
        // A terminal that nobody reads fills up; as on a real line, what does not fit is lost.
        let _ = port.set_timeout(Duration::from_millis(1));
        let _ = port.write_all(&sent);
    }
}

fn make_link(target: &Path, link: &Path) -> Result<(), SimulatorError> {
    if let Ok(metadata) = std::fs::symlink_metadata(link) {
        // A simulator that was killed leaves its link behind, to a terminal that is gone; or whose
        // number is free again, and then it may be the very number that ours has got.
        let stale = metadata.is_symlink()
            && std::fs::read_link(link)
                .is_ok_and(|old| old.starts_with("/dev/pts") && (!old.exists() || old == target));
        if !stale {
            return Err(SimulatorError::LinkTaken {
                path: link.to_owned(),
            });
        }
        let _ = std::fs::remove_file(link);
    }
    std::os::unix::fs::symlink(target, link).map_err(|source| SimulatorError::Link {
        path: link.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_left_to_the_terminal_that_is_now_ours_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("device");
        // A terminal that is there, as one whose number was free again; this one always is.
        let ours = Path::new("/dev/pts/ptmx");
        std::os::unix::fs::symlink(ours, &link).unwrap();
        make_link(ours, &link).unwrap();
        assert_eq!(std::fs::read_link(&link).unwrap(), ours);
        let others = make_link(Path::new("/dev/pts/0"), &link);
        // Where there is no /dev/pts, any link is one to a terminal that is gone.
        assert!(others.is_err() || !ours.exists());
    }
}
