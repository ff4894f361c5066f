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

pub(crate) fn run(args: &CalibrateArgs) -> Result<()> {
    match &args.step {
        CalibrationStep::Tracker(args) => tracker::run(args),
        CalibrationStep::Field(args) => field::run(args),
        CalibrationStep::Stylus(args) => stylus::run(args),
        CalibrationStep::Eyes(args) => eyes::run(args),
        CalibrationStep::Check(args) => check::run(args),
    }
}
