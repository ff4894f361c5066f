//! `sandtable calibrate check`: how far off three marks are.

use super::dialogue::Dialogue;
use super::station::Station;
use super::touching::{tip, touch, touching_sensor};
use crate::cli::CalibrateCheckArgs;
use crate::exit::usage;
use crate::rig;
use anyhow::{Result, bail};

/// How many marks are touched: enough to see a tracker that was moved or turned.
const MARKS: usize = 3;

pub(super) fn run(args: &CalibrateCheckArgs, dialogue: &Dialogue) -> Result<()> {
    if !(args.within > 0.0 && args.within.is_finite()) {
        return Err(usage("--within must be above 0 mm"));
    }
    let rig = rig::open(&args.measuring.rig, &args.measuring.device)?;
    let marks = args.marks.load(&rig)?;
    let sensor = touching_sensor(&rig, args.measuring.sensor.as_deref())?;
    let tip = tip(&rig, &sensor, dialogue);
    let station = Station::start(&rig, &sensor, dialogue.clone())?;
    let count = marks.len().min(MARKS);
    let (mut touched, mut far) = (0, 0);
    for (number, mark) in (1..).zip(&marks[..count]) {
        let Some(still) = touch(&station, tip, mark, &format!("{number} of {count}"))? else {
            continue;
        };
        let off = 1e3 * (still.point - mark.place);
        let is_far = off.length() > args.within;
        touched += 1;
        far += u32::from(is_far);
        dialogue.result(format_args!(
            "{}: {:.1} mm off ({:+.1} right, {:+.1} away, {:+.1} up){}",
            mark.name,
            off.length(),
            off.x,
            off.y,
            off.z,
            if is_far { ", too far" } else { "" }
        ));
    }
    station.stop();
    if touched == 0 {
        bail!("no mark was touched, so nothing is known");
    }
    if far > 0 {
        bail!(
            "{far} of {touched} marks are more than {} mm off; see that nothing was moved, then \
             `sandtable calibrate tracker`, and `field` after it where metal is near",
            args.within
        );
    }
    dialogue.result(format_args!("all {touched} are within {} mm", args.within));
    Ok(())
}
