//! `sandtable calibrate stylus`: where the stylus has its tip, by pivoting it on one spot.

use super::dialogue::{Answer, Dialogue, quit};
use super::saving::Destination;
use super::station::Station;
use super::touching::touching_sensor;
use crate::cli::CalibrateStylusArgs;
use crate::exit::usage;
use crate::rig;
use anyhow::Result;
use sandtable_calibration::{Pivot, pivot};
use sandtable_config::Calibrated;
use std::time::Duration;

/// A minute of the fastest tracker is as many poses as are read.
const LONGEST: f64 = 60.0;

pub(super) fn run(args: &CalibrateStylusArgs, dialogue: &Dialogue) -> Result<()> {
    if !(args.seconds >= 1.0 && args.seconds <= LONGEST) {
        return Err(usage("--seconds must be from 1 to 60"));
    }
    let rig = rig::open(&args.measuring.rig, &args.measuring.device)?;
    let sensor = touching_sensor(&rig, args.measuring.sensor.as_deref())?;
    let destination = Destination::choose(&args.measuring.rig, &args.saving, &rig, dialogue)?;
    let station = Station::start(&rig, &sensor, dialogue.clone())?;
    let found = measure(
        &station,
        Duration::from_secs_f64(args.seconds),
        &destination,
    )?;
    station.stop();
    destination.save(&Calibrated::Stylus {
        sensor,
        tip: found.tip,
    })
}

/// Pivots until a result is agreed on.
fn measure(station: &Station, lasting: Duration, destination: &Destination) -> Result<Pivot> {
    let begin = format!(
        "stand the tip in a small hole, Enter, then tilt the stylus to all sides and turn it for \
         {:.0} s; Enter ends it earlier; q ends all",
        lasting.as_secs_f64()
    );
    let dialogue = &station.dialogue;
    loop {
        ask_for_enter(dialogue, &begin)?;
        dialogue.remark("now");
        let (poses, problem) = station.moving(lasting)?;
        dialogue.remark(format_args!("{} poses", poses.len()));
        if let Some(problem) = problem {
            dialogue.remark(format_args!("meanwhile: {problem}"));
        }
        let found = match pivot(&poses) {
            Ok(found) => found,
            Err(problem) => {
                dialogue.remark(format_args!("again: {problem}"));
                continue;
            }
        };
        show(&found, dialogue);
        let prompt = format!(
            "{}; again measures again; q ends without",
            destination.enter()
        );
        loop {
            match dialogue.ask(&prompt)? {
                Answer::Enter => return Ok(found),
                Answer::Quit => return Err(quit()),
                Answer::Words(words) if words == "again" => break,
                Answer::Words(words) => {
                    dialogue.remark(format_args!("{words:?} means nothing here"))
                }
            }
        }
    }
}

fn ask_for_enter(dialogue: &Dialogue, prompt: &str) -> Result<()> {
    loop {
        match dialogue.ask(prompt)? {
            Answer::Enter => return Ok(()),
            Answer::Quit => return Err(quit()),
            Answer::Words(words) => dialogue.remark(format_args!("{words:?} means nothing here")),
        }
    }
}

fn show(found: &Pivot, dialogue: &Dialogue) {
    let [x, y, z] = (1e3 * found.tip).to_array();
    dialogue.result(format_args!(
        "tip: {x:.1}, {y:.1}, {z:.1} mm in the sensor's axes, ± {:.2} mm",
        1e3 * found.standard_error
    ));
    dialogue.result(format_args!(
        "tilted by up to {:.0} degrees; the spot stayed within {:.2} mm RMS, {:.2} mm at worst",
        found.spread.to_degrees(),
        1e3 * found.residuals.rms,
        1e3 * found.residuals.each[found.residuals.worst]
    ));
    if !found.outliers.is_empty() {
        dialogue.result(format_args!(
            "note: {} of the poses disagree with all others: the tip slipped, or the field is \
             disturbed; measure again if the RMS is high",
            found.outliers.len()
        ));
    }
}
