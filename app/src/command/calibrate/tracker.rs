//! `sandtable calibrate tracker`: how a tracker stands at the table, by touched marks.

use super::agreement::{Offer, agree};
use super::dialogue::Dialogue;
use super::saving::Destination;
use super::station::Station;
use super::touching::{Touched, tip, touch, touch_all, touching_sensor};
use crate::cli::CalibrateTrackerArgs;
use crate::rig;
use anyhow::{Context, Result};
use sandtable_calibration::{Registration, Touch, register};
use sandtable_config::{Calibrated, Mark, Rig};
use sandtable_pose::Rigid;

pub(super) fn run(args: &CalibrateTrackerArgs, dialogue: &Dialogue) -> Result<()> {
    let mut rig = rig::open(&args.measuring.rig, &args.measuring.device)?;
    let marks = args.marks.load(&rig)?;
    could_register(&marks).with_context(|| {
        format!(
            "the marks of {} fix no place for a tracker, however they are touched",
            args.marks
        )
    })?;
    let sensor = touching_sensor(&rig, args.measuring.sensor.as_deref())?;
    let destination = Destination::choose(&args.measuring.rig, &args.saving, &rig, dialogue)?;
    let tip = tip(&rig, &sensor, dialogue);
    let device = rig.devices.get(&sensor.device);
    let correction = device.and_then(|device| device.correction());
    let outdated = correction.map(|correction| correction.file().to_owned());
    measure_in_tracker_frame(&mut rig);
    let station = Station::start(&rig, &sensor, dialogue.clone())?;
    let touched = touch_all(&station, tip, &marks)?;
    let again = |mark: &Mark| touch(&station, tip, mark, "again");
    let found = agree(dialogue, "point", touched, again, fit, |touched, found| {
        show(touched, found, dialogue);
        Offer::Enter(destination.enter())
    })?;
    station.stop();
    destination.save(&Calibrated::Tracker {
        device: sensor.device,
        table_from_tracker: found.table_from_tracker,
    })?;
    if let Some(file) = outdated {
        dialogue.result(format_args!(
            "the rig no longer names {file}: that correction was for where the tracker stood before; \
             `sandtable calibrate field` measures the field anew"
        ));
    }
    Ok(())
}

/// Lets every pose come in its tracker's own frame, as its field bends it.
fn measure_in_tracker_frame(rig: &mut Rig) {
    for device in rig.devices.values_mut() {
        device.leave_field_bent();
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

fn fit(touched: &[Touched<'_>]) -> Result<Registration> {
    let touches: Vec<_> = touched
        .iter()
        .map(|touched| Touch {
            measured: touched.still.point,
            marked: touched.mark.place,
        })
        .collect();
    Ok(register(&touches)?)
}

fn show(touched: &[Touched<'_>], found: &Registration, dialogue: &Dialogue) {
    dialogue.result("point   off, mm  mark");
    for ((number, residual), touched) in (1..).zip(&found.residuals.each).zip(touched) {
        dialogue.result(format_args!(
            "{number:5}  {:8.2}  {}",
            1e3 * residual,
            touched.mark.name
        ));
    }
    dialogue.result(format_args!(
        "  RMS  {:8.2}  over {} points",
        1e3 * found.residuals.rms,
        touched.len()
    ));
    for finding in &found.findings {
        dialogue.result(format_args!("note: {finding}"));
    }
}
