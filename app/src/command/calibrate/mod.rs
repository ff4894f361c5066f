//! `sandtable calibrate`: from touches, pivots and sightings to the numbers of a rig, each step by
//! Enter.

mod agreement;
mod check;
mod dialogue;
mod eyes;
mod field;
mod saving;
mod station;
mod stylus;
mod touching;
mod tracker;

use crate::cli::{CalibrateArgs, CalibrationStep};
use anyhow::Result;
use crossbeam_channel::{Receiver, Sender};
use dialogue::Dialogue;
pub(crate) use dialogue::Telling;

/// On the terminal.
pub(crate) fn run(args: &CalibrateArgs) -> Result<()> {
    conduct(&args.step, Dialogue::on_terminal()?)
}

/// A step in a window, which holds the talk by the channels' other ends: it hears `telling`,
/// answers by `lines`, and ends it all by dropping `stop`'s.
pub(crate) fn run_in_window(
    step: &CalibrationStep,
    telling: Sender<Telling>,
    lines: Receiver<std::io::Result<String>>,
    stop: Receiver<()>,
) -> Result<()> {
    conduct(step, Dialogue::in_window(telling, lines, stop))
}

fn conduct(step: &CalibrationStep, dialogue: Dialogue) -> Result<()> {
    match step {
        CalibrationStep::Tracker(args) => tracker::run(args, &dialogue),
        CalibrationStep::Field(args) => field::run(args, &dialogue),
        CalibrationStep::Stylus(args) => stylus::run(args, &dialogue),
        CalibrationStep::Eyes(args) => eyes::run(args, &dialogue),
        CalibrationStep::Check(args) => check::run(args, &dialogue),
    }
}
