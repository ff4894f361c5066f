//! The simulated Flock on a pseudo-terminal.

use super::{Motion, SimulatedFlock, SimulatorSettings};
use crossbeam_channel::{Receiver, Sender};
use serialport::{SerialPort, TTYPort};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A simulated Flock that runs in a thread of its own until it is stopped or dropped.
#[derive(Debug)]
pub struct Simulator {
    path: PathBuf,
    link: Option<PathBuf>,
    stop: Arc<AtomicBool>,
    moves: Sender<Move>,
    thread: Option<JoinHandle<()>>,
}

/// A bird, how it moves from now on, and whom to tell that it does.
struct Move(u32, Motion, Sender<()>);

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

impl Simulator {
    /// Starts a simulated Flock; `link` becomes a symbolic link to its terminal for as long as it
    /// runs.
    ///
    /// # Errors
    /// Where there is no pseudo-terminal, or the link's place is taken.
    pub fn start(settings: SimulatorSettings, link: Option<&Path>) -> Result<Self, SimulatorError> {
        let (mut host_side, device_side) = TTYPort::pair().map_err(SimulatorError::NoTerminal)?;
        let path = PathBuf::from(device_side.name().unwrap_or_default());
        if let Some(link) = link {
            make_link(&path, link)?;
        }
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let (moves, moved) = crossbeam_channel::bounded(0);
        let thread = std::thread::Builder::new()
            .name("simulated flock".into())
            .spawn(move || {
                let flock = SimulatedFlock::new(settings);
                run(&mut host_side, flock, &moved, &stopped);
                // Held open so that the terminal outlives the hosts that come and go.
                drop(device_side);
            })
            .map_err(SimulatorError::Thread)?;
        Ok(Self {
            path,
            link: link.map(Path::to_owned),
            stop,
            moves,
            thread: Some(thread),
        })
    }

    /// The terminal's path, as `/dev/pts/7`.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Moves bird `bird`, from 1, otherwise: every record that is measured after this returns has
    /// it there. A bird that is not there, or a terminal that is gone, changes nothing.
    pub fn set_motion(&self, bird: u32, motion: Motion) {
        let (done, is_done) = crossbeam_channel::bounded(1);
        if self.moves.send(Move(bird, motion, done)).is_ok() {
            // An error means that the thread has ended.
            let _ = is_done.recv();
        }
    }

    /// Ends the simulation, closes the terminal and removes the link.
    pub fn stop(mut self) {
        self.end();
    }

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

impl Drop for Simulator {
    fn drop(&mut self) {
        self.end();
    }
}

fn run(port: &mut TTYPort, mut flock: SimulatedFlock, moves: &Receiver<Move>, stop: &AtomicBool) {
    let start = Instant::now();
    let mut bytes = [0; 256];
    while !stop.load(Ordering::Relaxed) {
        while let Ok(Move(bird, motion, done)) = moves.try_recv() {
            flock.set_motion(bird, motion);
            // Nobody may wait any more.
            let _ = done.send(());
        }
        let quiet = flock
            .quiet_for(start.elapsed())
            .map_or(Duration::from_millis(20), |quiet| {
                quiet.clamp(Duration::from_millis(1), Duration::from_millis(20))
            });
        let _ = port.set_timeout(quiet);
        match port.read(&mut bytes) {
            Ok(count) => flock.receive(&bytes[..count], start.elapsed()),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            // The terminal is gone; nothing can be simulated on it.
            Err(_) => return,
        }
        let sent = flock.send(start.elapsed());
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
        let link = folder.path().join("flock");
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
