//! Conventions of axes: which way a tracker's x, y and z point.

use crate::RigError;
use crate::fields::Value;
use crate::rigid::read_axes;
use glam::{DMat3, DQuat, DVec3};
use sandtable_pose::Rigid;

/// Another convention of axes for the same poses, such as z up in place of y up.
///
/// Each axis of the source becomes an axis of the target, with a sign. The sensors' own axes are
/// renamed with it, so that a sensor that is aligned with the source stays aligned. Unlike a
/// rotation it may be a mirror, for a source whose axes are left-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMap {
    /// The columns say where the source's x, y and z point.
    target_from_source: DMat3,
    /// 1, or −1 for a mirror.
    determinant: f64,
}

impl AxisMap {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self {
        target_from_source: DMat3::IDENTITY,
        determinant: 1.0,
    };

    /// A pose in the target's convention.
    #[must_use]
    pub fn apply(&self, source: &Rigid) -> Rigid {
        // M R Mᵀ turns about the mapped axis; in a mirror it turns the other way.
        let axis = DVec3::new(source.rotation.x, source.rotation.y, source.rotation.z);
        let mapped = self.target_from_source * axis * self.determinant;
        Rigid::new(
            DQuat::from_xyzw(mapped.x, mapped.y, mapped.z, source.rotation.w),
            self.target_from_source * source.translation,
        )
    }
}

pub(super) fn read_axis_map(value: &Value<'_>) -> Result<AxisMap, RigError> {
    let (target_from_source, determinant) = read_axes(value)?;
    Ok(AxisMap {
        target_from_source,
        determinant,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(columns: [DVec3; 3]) -> AxisMap {
        let matrix = DMat3::from_cols(columns[0], columns[1], columns[2]);
        AxisMap {
            target_from_source: matrix,
            determinant: matrix.determinant(),
        }
    }

    #[test]
    fn y_up_becomes_z_up_and_an_aligned_sensor_stays_aligned() {
        // x stays, y points up, z towards the user.
        let map = map([DVec3::X, DVec3::Z, DVec3::NEG_Y]);
        let aligned = map.apply(&Rigid::new(DQuat::IDENTITY, DVec3::new(1.0, 2.0, 3.0)));
        assert_eq!(aligned.translation, DVec3::new(1.0, -3.0, 2.0));
        assert_eq!(aligned.rotation, DQuat::IDENTITY);
        // A turn about the vertical is one about the vertical.
        let turned = map.apply(&Rigid::new(DQuat::from_rotation_y(0.3), DVec3::ZERO));
        assert!(turned.rotation.angle_between(DQuat::from_rotation_z(0.3)) < 1e-7);
    }

    #[test]
    fn a_mirror_keeps_rotations_rotations() {
        let map = map([DVec3::X, DVec3::Y, DVec3::NEG_Z]);
        let turn = DQuat::from_xyzw(0.1, -0.2, 0.3, 0.9).normalize();
        let source = Rigid::new(turn, DVec3::new(1.0, 2.0, 3.0));
        let mapped = map.apply(&source);
        let m = map.target_from_source;
        let expected = m * DMat3::from_quat(turn) * m.transpose();
        let off = (DMat3::from_quat(mapped.rotation) - expected).to_cols_array();
        assert!(off.iter().all(|x| x.abs() < 1e-12), "{off:?}");
        assert_eq!(mapped.translation, DVec3::new(1.0, 2.0, -3.0));
    }
}
