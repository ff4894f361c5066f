//! `sandtable calibrate stylus`: where the stylus has its tip, by pivoting it on one spot.

use super::dialogue::{Answer, Dialogue, quit};
use super::saving::Destination;
use super::station::Station;
use super::touching::touching_sensor;
use crate::cli::CalibrateStylusArgs;
use crate::exit::usage;
use crate::notice::notice;
use crate::rig;
use anyhow::Result;
use sandtable_calibration::{Pivot, pivot};
use sandtable_config::Calibrated;
use std::time::Duration;

/// A minute of the fastest tracker is as many poses as are read.
const LONGEST: f64 = 60.0;

pub(crate) fn run(args: &CalibrateStylusArgs) -> Result<()> {
    if !(args.seconds >= 1.0 && args.seconds <= LONGEST) {
        return Err(usage("--seconds must be from 1 to 60"));
    }
    let rig = rig::open(&args.measuring.rig, &args.measuring.device)?;
    let sensor = touching_sensor(&rig, args.measuring.sensor.as_deref())?;
    let destination = Destination::choose(&args.measuring.rig, &args.saving, &rig)?;
    let station = Station::start(&rig, &sensor, Dialogue::open()?)?;
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
    loop {
        ask_for_enter(station, &begin)?;
        eprintln!("now");
        let (poses, problem) = station.moving(lasting)?;
        eprintln!("{} poses", poses.len());
        if let Some(problem) = problem {
            eprintln!("meanwhile: {problem}");
        }
        let found = match pivot(&poses) {
            Ok(found) => found,
            Err(problem) => {
                eprintln!("again: {problem}");
                continue;
            }
        };
        show(&found);
        let prompt = format!(
            "{}; again measures again; q ends without",
            destination.enter()
        );
        loop {
            match station.dialogue.ask(&prompt)? {
                Answer::Enter => return Ok(found),
                Answer::Quit => return Err(quit()),
                Answer::Words(words) if words == "again" => break,
                Answer::Words(words) => eprintln!("{words:?} means nothing here"),
            }
        }
    }
}

fn ask_for_enter(station: &Station, prompt: &str) -> Result<()> {
    loop {
        match station.dialogue.ask(prompt)? {
            Answer::Enter => return Ok(()),
            Answer::Quit => return Err(quit()),
            Answer::Words(words) => eprintln!("{words:?} means nothing here"),
        }
    }
}

fn show(found: &Pivot) {
    let [x, y, z] = (1e3 * found.tip).to_array();
    notice(format_args!(
        "tip: {x:.1}, {y:.1}, {z:.1} mm in the sensor's axes, ± {:.2} mm",
        1e3 * found.standard_error
    ));
    notice(format_args!(
        "tilted by up to {:.0} degrees; the spot stayed within {:.2} mm RMS, {:.2} mm at worst",
        found.spread.to_degrees(),
        1e3 * found.residuals.rms,
        1e3 * found.residuals.each[found.residuals.worst]
    ));
    if !found.outliers.is_empty() {
        notice(format_args!(
            "note: {} of the poses disagree with all others: the tip slipped, or the field is \
             disturbed; measure again if the RMS is high",
            found.outliers.len()
        ));
    }
}
