//! Marks, and the tip that touches them.

use super::dialogue::{Answer, Dialogue, quit};
use super::station::{Station, Steadiness, Still};
use crate::exit::usage;
use anyhow::Result;
use glam::DVec3;
use sandtable_config::{Mark, Rig, SensorName};

/// The sensor that marks are touched with: the one that was asked for, or else the rig's stylus.
pub(super) fn touching_sensor(rig: &Rig, asked: Option<&str>) -> Result<SensorName> {
    match (asked, &rig.stylus) {
        (Some(name), _) => rig.sensor(name).map_err(usage),
        (None, Some(stylus)) => Ok(stylus.sensor.clone()),
        (None, None) => Err(usage(
            "the rig has no [stylus] that says which sensor touches; name it with --sensor, as flock/2",
        )),
    }
}

/// The tip in `sensor`'s own axes and metres; says so where it is the sensor itself.
pub(super) fn tip(rig: &Rig, sensor: &SensorName, dialogue: &Dialogue) -> DVec3 {
    match &rig.stylus {
        Some(stylus) if stylus.sensor == *sensor => stylus.tip,
        _ => {
            dialogue.remark(format_args!(
                "the rig knows no stylus tip on {sensor}: the sensor's own origin is what touches; \
                 `sandtable calibrate stylus` finds the tip"
            ));
            DVec3::ZERO
        }
    }
}

/// A mark, and the sensor while the tip was on it; its point is the tip's place in the frame of the
/// poses.
#[derive(Clone)]
pub(super) struct Touched<'m> {
    pub(super) mark: &'m Mark,
    pub(super) still: Still,
}

/// Has every mark touched; those that are left out are missing.
pub(super) fn touch_all<'m>(
    station: &Station,
    tip: DVec3,
    marks: &'m [Mark],
) -> Result<Vec<Touched<'m>>> {
    let mut touched = Vec::new();
    for (number, mark) in (1..).zip(marks) {
        let of = format!("{number} of {}", marks.len());
        if let Some(still) = touch(station, tip, mark, &of)? {
            touched.push(Touched { mark, still });
        }
    }
    Ok(touched)
}

/// Has a mark touched, until the touch can be used; none where the mark is left out.
pub(super) fn touch(station: &Station, tip: DVec3, mark: &Mark, of: &str) -> Result<Option<Still>> {
    let dialogue = &station.dialogue;
    let [x, y, z] = (1e3 * mark.place).to_array();
    let prompt = format!(
        "{of}: touch \"{}\" (at {x:.0}, {y:.0}, {z:.0} mm), hold still, Enter; s leaves it out, q ends",
        mark.name
    );
    loop {
        match dialogue.ask_at(&prompt, Some(mark.place))? {
            Answer::Enter => {}
            Answer::Quit => return Err(quit()),
            Answer::Words(words) if words == "s" => return Ok(None),
            Answer::Words(words) => {
                dialogue.remark(format_args!("{words:?} means nothing here"));
                continue;
            }
        }
        match station.still(tip, Steadiness::TIP)? {
            Ok(still) => {
                dialogue.remark("got it");
                return Ok(Some(still));
            }
            Err(problem) => dialogue.remark(format_args!("again: {problem}")),
        }
    }
}
