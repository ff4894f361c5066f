//! The correction of a tracker's bent field: a file of its own beside the rig, whose numbers would
//! be too many for it.

use crate::RigError;
use crate::beside::is_beside;
use crate::calibrated::{METRE_DECIMALS, ROTATION_DECIMALS, rounded};
use crate::fields::{Fields, Value, day_of};
use crate::rigid::REACH;
use glam::{DQuat, DVec3};
use sandtable_field::Correction;
use sandtable_pose::Rigid;
use serde::Deserialize;
use std::fmt::Write;
use std::sync::Arc;
use time::Date;
use toml::value::Datetime;

/// No tracker is believed to be off by more, in metres, however bent its field is.
const FARTHEST: f64 = 0.5;

/// A tracker that stood as the rig says is at the same place, and turned the same way, within
/// this: metres, and parts of a unit quaternion.
const SAME: f64 = 1e-6;

/// How a tracker's field is bent, `correction = "lab.flock-field.toml"` of its device.
///
/// It belongs to the `table_from_tracker` that it was measured with, and the rig is refused where
/// the two do not go together. Cloning it copies no numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldCorrection {
    file: Arc<str>,
    text: Arc<str>,
    calibrated: Date,
    table_from_tracker: Rigid,
    grid: Arc<Correction>,
}

/// The file, as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FieldFile {
    calibrated: Datetime,
    table_from_tracker: WrittenRigid,
    correction: Correction,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenRigid {
    translation: [f64; 3],
    quaternion: [f64; 4],
}

impl FieldCorrection {
    /// What to write into the file of a correction that was measured on `date`, at the tracker
    /// `device` that stood at `table_from_tracker`. Displacements are rounded to a micrometre.
    #[must_use]
    pub fn compose(
        device: &str,
        correction: &Correction,
        table_from_tracker: &Rigid,
        date: Date,
    ) -> String {
        let numbers = |numbers: &[f64], decimals| {
            let numbers: Vec<String> = numbers
                .iter()
                .map(|&number| format!("{:?}", rounded(number, decimals)))
                .collect();
            format!("[{}]", numbers.join(", "))
        };
        let place = |place: DVec3| numbers(&place.to_array(), ROTATION_DECIMALS);
        let q = table_from_tracker.rotation;
        let mut text = format!(
            "# How the field of the tracker `{device}` is bent, as `sandtable calibrate field` measured it.\n\
             calibrated = {date}\n\
             # Where the tracker stood, as the rig said: the correction holds for nowhere else.\n\
             table_from_tracker = {{ translation = {}, quaternion = {} }}\n\
             \n\
             # What to add to a measured place to have the true one, at the nodes of a grid: metres, in\n\
             # the table's frame; x runs fastest, then y.\n\
             [correction]\n\
             origin = {}\n\
             spacing = {}\n\
             counts = {:?}\n\
             displacements = [\n",
            place(table_from_tracker.translation),
            numbers(&[q.w, q.x, q.y, q.z], ROTATION_DECIMALS),
            place(correction.origin()),
            place(correction.spacing()),
            correction.counts().to_array(),
        );
        for displacement in correction.displacements() {
            let displacement = numbers(&displacement.to_array(), METRE_DECIMALS);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "    {displacement},");
        }
        text + "]\n"
    }

    /// The pose with its place corrected and its attitude as measured; both in the table's frame.
    /// Neither allocates nor locks.
    #[must_use]
    pub fn apply(&self, table_from_sensor: &Rigid) -> Rigid {
        Rigid::new(
            table_from_sensor.rotation,
            self.grid.correct(table_from_sensor.translation),
        )
    }

    /// The grid of displacements.
    #[must_use]
    pub fn grid(&self) -> &Correction {
        &self.grid
    }

    /// The file's name as the rig has it, from the rig's own folder.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// What is in the file, as recordings keep it.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The day on which it was measured.
    #[must_use]
    pub fn calibrated(&self) -> Date {
        self.calibrated
    }

    /// What a file says, or the line and what is wrong there.
    fn parse(file: &str, text: String) -> Result<Self, String> {
        let found: FieldFile = toml::from_str(&text).map_err(|error| {
            let until = error.span().map_or(0, |span| span.start.min(text.len()));
            let lines = text.as_bytes()[..until].iter().filter(|&&b| b == b'\n');
            format!("line {}: {}", 1 + lines.count(), error.message().trim_end())
        })?;
        let WrittenRigid {
            translation,
            quaternion: [w, x, y, z],
        } = found.table_from_tracker;
        let grid = found.correction;
        let farthest = grid.displacements().iter().map(|d| d.length());
        let farthest = farthest.fold(0.0, f64::max);
        if farthest > FARTHEST {
            return Err(format!(
                "it moves places by up to {farthest:.2} m, where no field is bent by more than {FARTHEST} m"
            ));
        }
        let corner = grid.origin() + grid.spacing() * (grid.counts() - 1).as_dvec3();
        if grid.origin().abs().max(corner.abs()).max_element() > REACH {
            return Err(format!(
                "its grid reaches beyond {REACH} m; it is in metres"
            ));
        }
        Ok(Self {
            calibrated: day_of(&found.calibrated)
                .ok_or("`calibrated` is no day such as 2026-11-21")?,
            table_from_tracker: Rigid::new(
                DQuat::from_xyzw(x, y, z, w),
                DVec3::from_array(translation),
            ),
            grid: Arc::new(grid),
            file: file.into(),
            text: text.into(),
        })
    }

    /// Whether it was measured with the tracker where the rig has it.
    fn is_for(&self, table_from_tracker: &Rigid) -> bool {
        let (own, rigs) = (&self.table_from_tracker, table_from_tracker);
        let moved = own.translation.distance(rigs.translation);
        // q and -q are the same attitude.
        let turned = f64::min(
            (own.rotation - rigs.rotation).length(),
            (own.rotation + rigs.rotation).length(),
        );
        moved <= SAME && turned <= SAME
    }
}

/// `correction`: a file beside the rig, for a tracker that stands at `table_from_tracker`.
pub(crate) fn read_correction(
    fields: &Fields<'_>,
    table_from_tracker: &Rigid,
) -> Result<Option<FieldCorrection>, RigError> {
    let Some(value) = fields.get("correction") else {
        return Ok(None);
    };
    let name = value.text("the correction's file")?;
    if !is_beside(name) {
        return Err(value.error(
            &format!("is {name:?}"),
            "write the name of a file in the rig's folder, as \"lab.flock-field.toml\"",
        ));
    }
    let text = value
        .beside()
        .read(name)
        .map_err(|error| unusable(&value, name, &format!("cannot be read ({error})")))?;
    let Some(text) = text else {
        return Ok(None);
    };
    let correction = FieldCorrection::parse(name, text)
        .map_err(|problem| unusable(&value, name, &format!("cannot be used ({problem})")))?;
    if !correction.is_for(table_from_tracker) {
        return Err(unusable(
            &value,
            name,
            "was measured with another `table_from_tracker` than stands here",
        ));
    }
    Ok(Some(correction))
}

fn unusable(value: &Value<'_>, name: &str, why: &str) -> RigError {
    value.error(
        &format!("names {name:?}, which {why}"),
        "bring back the file that `sandtable calibrate field` wrote for this tracker, or remove this \
         line and measure the field anew",
    )
}
