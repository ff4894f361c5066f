//! The talk with whoever stands at the table: prompts on standard error, lines from standard input.

use crate::interrupt;
use anyhow::{Context, Result, bail};
use crossbeam_channel::{Receiver, RecvTimeoutError, select};
use std::io::BufRead;
use std::time::Duration;

/// Lines as they are entered, and Ctrl-C.
pub(super) struct Dialogue {
    lines: Receiver<std::io::Result<String>>,
    stop: Receiver<()>,
}

/// What was answered.
pub(super) enum Answer {
    /// Enter alone.
    Enter,
    /// `q`.
    Quit,
    /// Anything else, in lower case and without blanks around it.
    Words(String),
}

impl Dialogue {
    /// Begins to listen; at most once a process.
    pub(super) fn open() -> Result<Self> {
        let (sender, lines) = crossbeam_channel::unbounded();
        std::thread::Builder::new()
            .name("standard input".into())
            .spawn(move || {
                for line in std::io::stdin().lock().lines() {
                    let failed = line.is_err();
                    if sender.send(line).is_err() || failed {
                        break;
                    }
                }
            })
            .context("cannot start the thread that reads standard input")?;
        Ok(Self {
            lines,
            stop: interrupt::channel()?,
        })
    }

    /// Asks, and waits for a line.
    pub(super) fn ask(&self, prompt: &str) -> Result<Answer> {
        eprintln!("{prompt}");
        let line = select! {
            recv(self.lines) -> line => line,
            recv(self.stop) -> _ => bail!(STOPPED),
        };
        let Ok(line) = line else {
            bail!("standard input ended before the calibration did; nothing is written");
        };
        let line = line.context("cannot read standard input; nothing is written")?;
        Ok(match line.trim() {
            "" => Answer::Enter,
            "q" | "Q" => Answer::Quit,
            words => Answer::Words(words.to_lowercase()),
        })
    }

    /// Lets time pass; Ctrl-C ends it.
    pub(super) fn pause(&self, lasting: Duration) -> Result<()> {
        match self.stop.recv_timeout(lasting) {
            Err(RecvTimeoutError::Timeout) => Ok(()),
            _ => bail!(STOPPED),
        }
    }

    /// Whether a line has been entered meanwhile.
    pub(super) fn has_entered(&self) -> bool {
        matches!(self.lines.try_recv(), Ok(Ok(_)))
    }
}

const STOPPED: &str = "ended before the calibration did; nothing is written";

/// The error of whoever ends a calibration with `q`.
pub(super) fn quit() -> anyhow::Error {
    anyhow::anyhow!("ended with q; nothing is written")
}
