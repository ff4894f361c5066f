//! The guide: the steps of the calibration in the window, by the same talk as on the terminal.

use crate::cli::{
    CalibrateCheckArgs, CalibrateEyesArgs, CalibrateFieldArgs, CalibrateStylusArgs,
    CalibrateTrackerArgs, CalibrationStep, MarkSource, MeasuringArgs, SavingArgs,
};
use crate::command::calibrate::{Telling, run_in_window};
use crate::rig;
use crate::window::GuideStep;
use anyhow::{Context, Result, bail};
use crossbeam_channel::{Receiver, Sender};
use glam::DVec3;
use sandtable_config::{Mark, Rig};
use sandtable_input::Devices;
use std::path::PathBuf;
use std::thread::JoinHandle;

/// What a session was opened with, and so what is calibrated.
#[derive(Clone, Debug)]
pub(crate) struct GuideSetup {
    /// The rig, as the command line named it; after a built-in one was calibrated, its new file.
    pub(crate) rig: String,
    /// The devices' ports, as the command line named them.
    pub(crate) device: Vec<String>,
    /// The marks; those on the glass where no file was named.
    pub(crate) marks: MarkSource,
}

/// A step of the calibration while it runs, in a thread of its own.
#[derive(Debug)]
pub(crate) struct Guide {
    step: GuideStep,
    lines: Vec<String>,
    question: Option<(String, Option<DVec3>)>,
    answers: Sender<std::io::Result<String>>,
    /// Dropped to end the step.
    stop: Option<Sender<()>>,
    telling: Receiver<Telling>,
    thread: Option<JoinHandle<Result<()>>>,
    /// The rig's file, should the step end well.
    written: String,
}

/// How many lines are kept: a table of many marks, and what was said around it.
const LINES: usize = 200;

impl GuideSetup {
    /// The step's arguments, and the file that the rig is in afterwards.
    fn arguments(&self, step: GuideStep, rig: &Rig) -> Result<(CalibrationStep, String)> {
        let (output, written) = if rig::is_file(&self.rig) {
            (None, self.rig.clone())
        } else {
            let own = format!("{}.toml", self.rig);
            (Some(PathBuf::from(&own)), own)
        };
        let saving = SavingArgs {
            output,
            dry_run: false,
        };
        let hand = rig.hand.as_ref().and_then(|hand| hand.sensor.as_ref());
        let touching = match (&rig.stylus, hand) {
            (None, Some(hand)) => Some(hand.to_string()),
            _ => None,
        };
        let measuring = |sensor| MeasuringArgs {
            rig: self.rig.clone(),
            device: self.device.clone(),
            sensor,
        };
        let marks = self.marks.clone();
        let arguments = match step {
            GuideStep::Stylus => CalibrationStep::Stylus(CalibrateStylusArgs {
                measuring: measuring(touching),
                seconds: 10.0,
                saving,
            }),
            GuideStep::Tracker => CalibrationStep::Tracker(CalibrateTrackerArgs {
                measuring: measuring(touching),
                marks,
                saving,
            }),
            GuideStep::Field => CalibrationStep::Field(CalibrateFieldArgs {
                measuring: measuring(touching),
                marks,
                saving,
            }),
            GuideStep::Eyes => CalibrationStep::Eyes(CalibrateEyesArgs {
                measuring: measuring(None),
                pair: sighted_pairs(&marks.load(rig)?)?,
                marks,
                sightings: 6,
                saving,
            }),
            GuideStep::Check => CalibrationStep::Check(CalibrateCheckArgs {
                measuring: measuring(touching),
                marks,
                within: 5.0,
            }),
        };
        let written = match step {
            GuideStep::Check => self.rig.clone(),
            _ => written,
        };
        Ok((arguments, written))
    }
}

/// The highest mark before up to three of the lowest ones, as `NEAR=FAR`.
fn sighted_pairs(marks: &[Mark]) -> Result<Vec<String>> {
    /// How much higher a mark has to be to be sighted over, in metres.
    const RAISED: f64 = 0.1;
    let by_height = |a: &&Mark, b: &&Mark| a.place.z.total_cmp(&b.place.z);
    let highest = marks.iter().max_by(by_height);
    let highest = highest.context("there are no marks to sight over")?;
    let mut low: Vec<&Mark> = marks.iter().collect();
    low.retain(|mark| mark.place.z + RAISED <= highest.place.z);
    low.sort_by(by_height);
    if low.is_empty() {
        bail!(
            "eyes are sighted over a raised mark, and none stands {:.0} mm above another; put up a \
             post, measure its top, and name the file of marks with --marks",
            1e3 * RAISED
        );
    }
    let pair = |far: &&Mark| format!("{}={}", highest.name, far.name);
    Ok(low.iter().take(3).map(pair).collect())
}

impl Guide {
    /// Begins a step, for which the session lets go of its devices: the step opens its own.
    pub(crate) fn begin(
        step: GuideStep,
        setup: &GuideSetup,
        rig: &Rig,
        devices: &mut Option<Devices>,
    ) -> Result<Self> {
        let (arguments, written) = setup.arguments(step, rig)?;
        let (answers, lines) = crossbeam_channel::unbounded();
        let (stop, stopped) = crossbeam_channel::bounded(1);
        let (teller, telling) = crossbeam_channel::unbounded();
        let taken = devices.take();
        let thread = std::thread::Builder::new()
            .name("calibration".into())
            .spawn(move || {
                if let Some(devices) = taken {
                    devices.stop();
                }
                run_in_window(&arguments, teller, lines, stopped)
            })
            .context("cannot start the calibration's thread")?;
        Ok(Self {
            step,
            lines: Vec::new(),
            question: None,
            answers,
            stop: Some(stop),
            telling,
            thread: Some(thread),
            written,
        })
    }

    /// Takes in what was said since the last call. When the step has ended just now, gives the
    /// rig's file.
    pub(crate) fn listen(&mut self) -> Option<String> {
        // Asked before what was said is read: nothing is said after the end.
        let ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        for telling in self.telling.try_iter() {
            match telling {
                Telling::Line(line) => self.lines.push(line),
                Telling::Question { prompt, mark } => self.question = Some((prompt, mark)),
            }
        }
        let outcome = self.thread.take_if(|_| ended)?.join();
        self.question = None;
        let well = match outcome {
            Ok(Ok(())) => true,
            Ok(Err(error)) => {
                self.lines.push(format!("{error:#}"));
                false
            }
            Err(_) => {
                self.lines.push(
                    "the calibration broke off; nothing was changed since the last line".into(),
                );
                false
            }
        };
        if well {
            self.lines.push("done".into());
        }
        let surplus = self.lines.len().saturating_sub(LINES);
        self.lines.drain(..surplus);
        Some(if well {
            self.written.clone()
        } else {
            String::new()
        })
    }

    /// Answers the question; a pivoted stylus ends by an answer to none.
    pub(crate) fn answer(&mut self, line: String) {
        if self.thread.is_some() {
            self.question = None;
            // A step that has ended asks nothing.
            let _ = self.answers.send(Ok(line));
        }
    }

    /// Lets the step end without a result; it takes a moment.
    pub(crate) fn end(&mut self) {
        self.stop = None;
    }

    /// Whether the step has ended, well or not.
    pub(crate) fn has_ended(&self) -> bool {
        self.thread.is_none()
    }

    /// Which step it is.
    pub(crate) fn step(&self) -> GuideStep {
        self.step
    }

    /// What was said, the newest last.
    pub(crate) fn lines(&self) -> &[String] {
        &self.lines
    }

    /// What is asked now, and the mark that it is about, in table metres.
    pub(crate) fn question(&self) -> Option<(&str, Option<DVec3>)> {
        let (prompt, mark) = self.question.as_ref()?;
        Some((prompt, *mark))
    }
}

impl Drop for Guide {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A panic in it has been printed.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(name: &str, z: f64) -> Mark {
        Mark {
            name: name.into(),
            place: DVec3::new(0.0, 0.0, z),
        }
    }

    #[test]
    fn eyes_are_sighted_over_the_highest_mark() {
        let marks = [
            mark("a", 0.0),
            mark("post", 0.35),
            mark("b", 0.02),
            mark("lamp", 0.3),
            mark("c", 0.01),
            mark("d", 0.03),
        ];
        let pairs = sighted_pairs(&marks).unwrap();
        assert_eq!(pairs, ["post=a", "post=c", "post=b"]);
        let flat = [mark("a", 0.0), mark("b", 0.05)];
        let error = sighted_pairs(&flat).unwrap_err().to_string();
        assert!(error.contains("--marks"), "{error}");
    }

    #[test]
    fn a_built_in_rig_gets_a_file_of_its_own() {
        let setup = GuideSetup {
            rig: "workbench".into(),
            device: vec!["flock=/dev/ttyS9".into()],
            marks: MarkSource::Glass,
        };
        let rig = Rig::builtin("workbench").unwrap();
        let (step, written) = setup.arguments(GuideStep::Tracker, &rig).unwrap();
        let CalibrationStep::Tracker(args) = step else {
            panic!("it is the tracker's");
        };
        assert_eq!(written, "workbench.toml");
        assert_eq!(args.saving.output, Some("workbench.toml".into()));
        // Without a stylus, the hand touches.
        assert_eq!(args.measuring.sensor.as_deref(), Some("flock/2"));
        let (_, checked) = setup.arguments(GuideStep::Check, &rig).unwrap();
        assert_eq!(checked, "workbench");
    }
}
