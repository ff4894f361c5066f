//! `sandtable calibrate field`: how a tracker's field is bent, by touched marks.

use super::agreement::{Offer, agree};
use super::dialogue::Dialogue;
use super::saving::Destination;
use super::station::Station;
use super::touching::{Touched, tip, touch, touch_all, touching_sensor};
use crate::cli::CalibrateFieldArgs;
use crate::rig;
use anyhow::{Context, Result, bail};
use glam::DVec3;
use sandtable_calibration::{DistortionFit, FieldSample, admit_field_marks, fit_distortion};
use sandtable_config::Mark;

/// Marks that are farther off, RMS in metres, tell of a tracker that stands elsewhere than the rig
/// says, and not of its field.
const ELSEWHERE: f64 = 0.15;

pub(super) fn run(args: &CalibrateFieldArgs, dialogue: &Dialogue) -> Result<()> {
    let mut rig = rig::open(&args.measuring.rig, &args.measuring.device)?;
    let marks = args.marks.load(&rig)?;
    admit_field_marks(&marks.iter().map(|mark| mark.place).collect::<Vec<_>>()).with_context(
        || {
            format!(
                "the marks of {} tell no field, however they are touched",
                args.marks
            )
        },
    )?;
    let sensor = touching_sensor(&rig, args.measuring.sensor.as_deref())?;
    let destination = Destination::choose(&args.measuring.rig, &args.saving, &rig, dialogue)?;
    let file = destination.field_file(&sensor.device)?;
    let tip = tip(&rig, &sensor, dialogue);
    let Some(device) = rig.devices.get_mut(&sensor.device) else {
        bail!("the rig {:?} has no device {}", rig.name, sensor.device);
    };
    if device.calibrated().is_none() {
        dialogue.remark(format_args!(
            "where {} stands was never measured; `sandtable calibrate tracker` comes before this",
            sensor.device
        ));
    }
    // Else what is left of the old correction would be measured, and not the field.
    device.leave_field_bent();
    let table_from_tracker = device.table_from_tracker_mut().copied();
    let table_from_tracker = table_from_tracker
        .with_context(|| format!("{} is no tracker, so it has no field", sensor.device))?;
    let station = Station::start(&rig, &sensor, dialogue.clone())?;
    let touched = touch_all(&station, tip, &marks)?;
    let again = |mark: &Mark| touch(&station, tip, mark, "again");
    let found = agree(
        dialogue,
        "sample",
        touched,
        again,
        |touched| fit(touched, tip),
        |touched, found| show(touched, found, &destination, dialogue),
    )?;
    station.stop();
    destination.save_field(
        &sensor.device,
        &file,
        &found.correction,
        &table_from_tracker,
    )
}

fn fit(touched: &[Touched<'_>], tip: DVec3) -> Result<DistortionFit> {
    let marks: Vec<_> = touched.iter().map(|touched| touched.mark.place).collect();
    admit_field_marks(&marks)?;
    let samples: Vec<_> = touched
        .iter()
        .map(|touched| FieldSample::of_stylus(&touched.still.pose, tip, touched.mark.place))
        .collect();
    let found = fit_distortion(&samples)?;
    if found.before.rms > ELSEWHERE {
        bail!(
            "the marks are {:.0} mm off, RMS, which is no bent field: the tracker or the tip is not \
             where the rig says; do `sandtable calibrate stylus` and `tracker` first",
            1e3 * found.before.rms
        );
    }
    Ok(found)
}

fn show(
    touched: &[Touched<'_>],
    found: &DistortionFit,
    destination: &Destination,
    dialogue: &Dialogue,
) -> Offer {
    let DistortionFit {
        before,
        after,
        left_out,
        ..
    } = found;
    dialogue.result("sample  before, mm  after, mm  unseen, mm  mark");
    let each = before.each.iter().zip(&after.each).zip(&left_out.each);
    for ((number, ((before, after), left_out)), touched) in (1..).zip(each).zip(touched) {
        dialogue.result(format_args!(
            "{number:6}  {:10.2}  {:9.2}  {:10.2}  {}",
            1e3 * before,
            1e3 * after,
            1e3 * left_out,
            touched.mark.name
        ));
    }
    dialogue.result(format_args!(
        "   RMS  {:10.2}  {:9.2}  {:10.2}  over {} samples",
        1e3 * before.rms,
        1e3 * after.rms,
        1e3 * left_out.rms,
        touched.len()
    ));
    dialogue.result(
        "unseen: corrected by all other samples alone, as places between the marks will be",
    );
    for outlier in &found.outliers {
        dialogue.result(format_args!("note: {outlier}"));
    }
    if found.smoothing.is_none() {
        dialogue.result(format_args!(
            "note: no correction helps at marks that it has not seen: what is left, {:.1} mm RMS, is \
             noise, or bent more than so few marks can tell; there is nothing to write",
            1e3 * before.rms
        ));
        return Offer::Nothing;
    }
    let grid = &found.correction;
    let most = grid.displacements().iter().map(|d| d.length());
    let [x, y, z] = grid.counts().to_array();
    dialogue.result(format_args!(
        "the correction moves places by up to {:.1} mm, on a grid of {x} x {y} x {z} nodes",
        1e3 * most.fold(0.0, f64::max)
    ));
    if found.helps() {
        Offer::Enter(destination.enter())
    } else {
        dialogue.result(
            "note: at marks that it has not seen it takes away less than a fifth, or less than 0.5 mm; \
             better do not write it: the field is straight, or more marks must tell how it is bent",
        );
        Offer::Discouraged
    }
}
