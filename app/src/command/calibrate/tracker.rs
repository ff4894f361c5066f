//! `sandtable calibrate tracker`: how a tracker stands at the table, by touched marks.

use super::dialogue::{Answer, Dialogue, quit};
use super::saving::Destination;
use super::station::Station;
use super::touching::{tip, touch, touching_sensor};
use crate::cli::CalibrateTrackerArgs;
use crate::notice::notice;
use crate::rig;
use anyhow::{Context, Result};
use sandtable_calibration::{Registration, Touch, register};
use sandtable_config::{Calibrated, Mark, Rig, load_marks};
use sandtable_pose::Rigid;

pub(crate) fn run(args: &CalibrateTrackerArgs) -> Result<()> {
    let mut rig = rig::open(&args.measuring.rig, &args.measuring.device)?;
    let marks = load_marks(&args.marks)?;
    could_register(&marks).with_context(|| {
        format!(
            "the marks of {} fix no place for a tracker, however they are touched",
            args.marks.display()
        )
    })?;
    let sensor = touching_sensor(&rig, args.measuring.sensor.as_deref())?;
    let destination = Destination::choose(&args.measuring.rig, &args.saving)?;
    let tip = tip(&rig, &sensor);
    measure_in_tracker_frame(&mut rig);
    let station = Station::start(&rig, &sensor, Dialogue::open()?)?;
    let mut touches = Vec::new();
    for (number, mark) in (1..).zip(&marks) {
        let of = format!("{number} of {}", marks.len());
        if let Some(measured) = touch(&station, tip, mark, &of)? {
            let marked = mark.place;
            touches.push((mark, Touch { measured, marked }));
        }
    }
    let dialogue = station.stop();
    let found = agree(&dialogue, touches, &destination)?;
    destination.save(&Calibrated::Tracker {
        device: sensor.device,
        table_from_tracker: found.table_from_tracker,
    })
}

/// Lets every pose come in its tracker's own frame.
pub(super) fn measure_in_tracker_frame(rig: &mut Rig) {
    for device in rig.devices.values_mut() {
        if let Some(table_from_tracker) = device.table_from_tracker_mut() {
            *table_from_tracker = Rigid::IDENTITY;
        }
    }
}

/// Whether touches on these marks could fix the tracker's place: refused before they are touched.
fn could_register(marks: &[Mark]) -> Result<()> {
    let touches: Vec<_> = marks
        .iter()
        .map(|mark| Touch {
            measured: mark.place,
            marked: mark.place,
        })
        .collect();
    register(&touches)?;
    Ok(())
}

/// Registers, shows what came out, and leaves out what the user says until it is agreed on.
fn agree(
    dialogue: &Dialogue,
    mut touches: Vec<(&Mark, Touch)>,
    destination: &Destination,
) -> Result<Registration> {
    loop {
        let points: Vec<Touch> = touches.iter().map(|(_, touch)| *touch).collect();
        let found = register(&points)?;
        show(&touches, &found);
        let prompt = format!(
            "{}; a point's number leaves that point out; q ends without",
            destination.enter()
        );
        loop {
            let words = match dialogue.ask(&prompt)? {
                Answer::Enter => return Ok(found),
                Answer::Quit => return Err(quit()),
                Answer::Words(words) => words,
            };
            match words.parse::<usize>() {
                Ok(number) if (1..=touches.len()).contains(&number) => {
                    let (mark, _) = touches.remove(number - 1);
                    eprintln!("\"{}\" is left out", mark.name);
                    break;
                }
                _ => eprintln!("{words:?} is no point: say 1 to {}", touches.len()),
            }
        }
    }
}

fn show(touches: &[(&Mark, Touch)], found: &Registration) {
    notice("point   off, mm  mark");
    for ((number, residual), (mark, _)) in (1..).zip(&found.residuals.each).zip(touches) {
        notice(format_args!(
            "{number:5}  {:8.2}  {}",
            1e3 * residual,
            mark.name
        ));
    }
    notice(format_args!(
        "  RMS  {:8.2}  over {} points",
        1e3 * found.residuals.rms,
        touches.len()
    ));
    for finding in &found.findings {
        notice(format_args!("note: {finding}"));
    }
}
