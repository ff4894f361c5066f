//! The talk with whoever stands at the table: what is asked and told, and what is answered.
//!
//! On the terminal prompts go to standard error, results to standard output, and lines come from
//! standard input. A window holds the same talk by two channels: see [`Telling`].

use crate::interrupt;
use crate::notice::notice;
use anyhow::{Context, Result, bail};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, select};
use glam::DVec3;
use std::fmt::Display;
use std::io::BufRead;
use std::time::Duration;

/// What a step of the calibration says and asks.
#[derive(Clone, Debug)]
pub(super) struct Dialogue {
    lines: Receiver<std::io::Result<String>>,
    stop: Receiver<()>,
    listener: Listener,
}

/// Who hears what is told.
#[derive(Clone, Debug)]
enum Listener {
    Terminal,
    Window(Sender<Telling>),
}

/// What a window is told.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Telling {
    /// A line to read.
    Line(String),
    /// A question, which waits for a line.
    Question {
        /// What is asked.
        prompt: String,
        /// The mark that is to be touched for it, in table metres.
        mark: Option<DVec3>,
    },
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
    /// Begins to listen to the terminal; at most once a process.
    pub(super) fn on_terminal() -> Result<Self> {
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
            listener: Listener::Terminal,
        })
    }

    /// The talk with a window, which hears `telling`, answers by `lines`, and ends it all by `stop`
    /// or by dropping that.
    pub(super) fn in_window(
        telling: Sender<Telling>,
        lines: Receiver<std::io::Result<String>>,
        stop: Receiver<()>,
    ) -> Self {
        Self {
            lines,
            stop,
            listener: Listener::Window(telling),
        }
    }

    /// Says how things stand.
    pub(super) fn remark(&self, line: impl Display) {
        match &self.listener {
            Listener::Terminal => eprintln!("{line}"),
            Listener::Window(_) => self.tell(Telling::Line(line.to_string())),
        }
    }

    /// Says what came out.
    pub(super) fn result(&self, line: impl Display) {
        match &self.listener {
            Listener::Terminal => notice(line),
            Listener::Window(_) => self.tell(Telling::Line(line.to_string())),
        }
    }

    /// Asks, and waits for a line.
    pub(super) fn ask(&self, prompt: &str) -> Result<Answer> {
        self.ask_at(prompt, None)
    }

    /// Asks for something to be done at a mark, in table metres, and waits for a line.
    pub(super) fn ask_at(&self, prompt: &str, mark: Option<DVec3>) -> Result<Answer> {
        match &self.listener {
            Listener::Terminal => eprintln!("{prompt}"),
            Listener::Window(_) => {
                // A button pressed twice must not answer what was not asked yet.
                while self.lines.try_recv().is_ok() {}
                self.tell(Telling::Question {
                    prompt: prompt.to_owned(),
                    mark,
                });
            }
        }
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

    fn tell(&self, telling: Telling) {
        if let Listener::Window(sender) = &self.listener {
            // A window that is gone has dropped `stop`, too, which ends this.
            let _ = sender.send(telling);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_button_pressed_twice_answers_one_question() {
        let (telling, told) = crossbeam_channel::unbounded();
        let (answers, lines) = crossbeam_channel::unbounded();
        let (stop, stopped) = crossbeam_channel::bounded(1);
        let dialogue = Dialogue::in_window(telling, lines, stopped);
        let asking = std::thread::spawn(move || {
            let first = dialogue.ask("first").is_ok();
            // The second press falls into what is done for the first answer.
            std::thread::sleep(Duration::from_millis(100));
            (first, dialogue.ask("second"))
        });
        let question = |prompt: &str| Telling::Question {
            prompt: prompt.into(),
            mark: None,
        };
        assert_eq!(told.recv().unwrap(), question("first"));
        answers.send(Ok(String::new())).unwrap();
        answers.send(Ok(String::new())).unwrap();
        assert_eq!(told.recv().unwrap(), question("second"));
        answers.send(Ok("t 3".into())).unwrap();
        let (first, second) = asking.join().unwrap();
        assert!(first && matches!(second, Ok(Answer::Words(words)) if words == "t 3"));
        drop(stop);
    }
}
