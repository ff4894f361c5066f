//! Rigid transforms as people write them.

use crate::RigError;
use crate::fields::{Fields, Value};
use glam::{DMat3, DQuat, DVec3, EulerRot};
use sandtable_pose::Rigid;
use time::Date;

/// The farthest that anything of a rig stands from its frame's origin, in metres.
pub(crate) const REACH: f64 = 100.0;

/// A transform in a table of its own: `translation` (or `position`) and at most one way to write
/// its rotation, all under the names that people know them by.
pub(crate) fn read_rigid(value: &Value<'_>, translation_key: &str) -> Result<Rigid, RigError> {
    let fields = value.fields()?;
    let rigid = rigid_among(&fields, translation_key)?;
    fields.finish()?;
    Ok(rigid)
}

/// The same with the date on which it was measured, `calibrated`, where there is one.
pub(crate) fn read_measured_rigid(
    value: &Value<'_>,
    translation_key: &str,
) -> Result<(Rigid, Option<Date>), RigError> {
    let fields = value.fields()?;
    let rigid = rigid_among(&fields, translation_key)?;
    let calibrated = fields.date("calibrated")?;
    fields.finish()?;
    Ok((rigid, calibrated))
}

fn rigid_among(fields: &Fields<'_>, translation_key: &str) -> Result<Rigid, RigError> {
    let translation = fields
        .need(translation_key, "write it as [x, y, z] in metres")?
        .numbers::<3>(-REACH..=REACH, "metres")?;
    let rotation = read_rotation(fields)?;
    Ok(Rigid::new(rotation, DVec3::from_array(translation)))
}

/// A rotation by `axes`, `quaternion` or `angles`, or none at all.
fn read_rotation(fields: &Fields<'_>) -> Result<DQuat, RigError> {
    let axes = fields.get("axes");
    let quaternion = fields.get("quaternion");
    let angles = fields.get("angles");
    let given: Vec<&Value<'_>> = [&axes, &quaternion, &angles]
        .into_iter()
        .flatten()
        .collect();
    if let [_, second, ..] = given.as_slice() {
        return Err(second.error(
            "is a second way to write the same rotation",
            "keep one of axes, quaternion or angles",
        ));
    }
    if let Some(axes) = axes {
        return axis_map(&axes);
    }
    if let Some(quaternion) = quaternion {
        let [w, x, y, z] = quaternion.numbers::<4>(-1.0..=1.0, "[w, x, y, z]")?;
        let q = DQuat::from_xyzw(x, y, z, w);
        if (q.length() - 1.0).abs() > 1e-3 {
            return Err(quaternion.error(
                &format!("has length {:.6}", q.length()),
                "write a unit quaternion [w, x, y, z]",
            ));
        }
        return Ok(q.normalize());
    }
    if let Some(angles) = angles {
        let [azimuth, elevation, roll] =
            angles.numbers::<3>(-360.0..=360.0, "degrees [azimuth, elevation, roll]")?;
        return Ok(from_angles(azimuth, elevation, roll));
    }
    Ok(DQuat::IDENTITY)
}

/// Turns about z by `azimuth`, then about the new y by `elevation`, then about the new x by
/// `roll`, all in degrees: the Flock's own order.
fn from_angles(azimuth: f64, elevation: f64, roll: f64) -> DQuat {
    DQuat::from_euler(
        EulerRot::ZYX,
        azimuth.to_radians(),
        elevation.to_radians(),
        roll.to_radians(),
    )
}

/// Where the source's x, y and z point in the target, as a rotation.
fn axis_map(value: &Value<'_>) -> Result<DQuat, RigError> {
    let (map, determinant) = read_axes(value)?;
    if determinant < 0.0 {
        return Err(value.error(
            "is a mirror, not a rotation",
            "change the sign of one axis, or swap two",
        ));
    }
    Ok(DQuat::from_mat3(&map).normalize())
}

/// Where the source's x, y and z point in the target, each an axis with its sign, as the columns
/// of a matrix; and its determinant, 1 or −1.
pub(crate) fn read_axes(value: &Value<'_>) -> Result<(DMat3, f64), RigError> {
    const AXES: [(&str, DVec3); 9] = [
        ("+x", DVec3::X),
        ("-x", DVec3::NEG_X),
        ("+y", DVec3::Y),
        ("-y", DVec3::NEG_Y),
        ("+z", DVec3::Z),
        ("-z", DVec3::NEG_Z),
        ("x", DVec3::X),
        ("y", DVec3::Y),
        ("z", DVec3::Z),
    ];
    let wanted = "three axes such as [\"+y\", \"+x\", \"-z\"]: where x, y and z point";
    let [x, y, z] = value.array::<3>(wanted)?;
    let columns = [x.choice(&AXES)?, y.choice(&AXES)?, z.choice(&AXES)?];
    let map = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let determinant = map.determinant();
    if determinant == 0.0 {
        return Err(value.error(
            "names one axis twice",
            "name each of x, y and z once, with its sign",
        ));
    }
    Ok((map, determinant))
}
