//! A path read from a file of poses.

use glam::{DQuat, DVec3};
use sandtable_motion::Signal;
use sandtable_pose::Rigid;
use std::error::Error;
use std::path::Path;

/// Poses at times, in seconds from the first one's, between which the path is even.
pub(crate) struct RecordedPath {
    poses: Vec<(f64, Rigid)>,
}

impl RecordedPath {
    /// Reads lines of `seconds,x,y,z,qx,qy,qz,qw`: times that rise, metres, and a unit quaternion
    /// that turns the body's axes into the frame's. A first line that is no numbers is a heading.
    pub(crate) fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
        Self::parse(&text).map_err(|error| format!("{shown}: {error}").into())
    }

    fn parse(text: &str) -> Result<Self, String> {
        let mut poses: Vec<(f64, Rigid)> = Vec::new();
        let mut first = 0.0;
        for (line, row) in (1..).zip(text.lines()) {
            let cells: Result<Vec<f64>, _> =
                row.split(',').map(|cell| cell.trim().parse()).collect();
            let cells = match cells {
                Ok(cells) => cells,
                Err(_) if line == 1 || row.trim().is_empty() => continue,
                Err(error) => return Err(format!("line {line}: {error}")),
            };
            let [seconds, x, y, z, qx, qy, qz, qw] = cells[..] else {
                return Err(format!(
                    "line {line} has {} numbers: write seconds,x,y,z,qx,qy,qz,qw",
                    cells.len()
                ));
            };
            let (Some(rotation), Some(translation), Some(seconds)) = (
                DQuat::from_xyzw(qx, qy, qz, qw).usable(),
                DVec3::new(x, y, z).usable(),
                seconds.usable(),
            ) else {
                return Err(format!(
                    "line {line}: give finite numbers and a quaternion of length 1"
                ));
            };
            let seconds = match poses.last() {
                None => {
                    first = seconds;
                    0.0
                }
                Some((before, _)) if seconds - first <= *before => {
                    return Err(format!(
                        "line {line}: give a time after that of the pose before"
                    ));
                }
                Some(_) => seconds - first,
            };
            poses.push((seconds, Rigid::new(rotation, translation)));
        }
        if poses.len() < 2 {
            return Err("give two poses or more".to_owned());
        }
        Ok(Self { poses })
    }

    /// The last pose's time.
    pub(crate) fn seconds(&self) -> f64 {
        self.poses[self.poses.len() - 1].0
    }

    /// The pose at a time in seconds; after the last one, that one.
    pub(crate) fn at(&self, seconds: f64) -> Rigid {
        let later = self.poses.partition_point(|(time, _)| *time <= seconds);
        let (start, from) = &self.poses[later.saturating_sub(1)];
        let Some((end, to)) = self.poses.get(later) else {
            return *from;
        };
        let share = ((seconds - start) / (end - start)).clamp(0.0, 1.0);
        let turn = to.rotation.difference_from(from.rotation);
        Rigid::new(
            from.rotation.moved_by(turn * share),
            from.translation.lerp(to.translation, share),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_even_between_its_poses() {
        let path =
            RecordedPath::parse("seconds,x,y,z,qx,qy,qz,qw\n10,0,0,0,0,0,0,1\n12,1,0,0,0,0,1,0\n")
                .unwrap();
        assert_eq!(path.seconds(), 2.0);
        let half = path.at(1.0);
        assert!((half.translation.x - 0.5).abs() < 1e-15);
        assert!((half.rotation.z - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-15);
        assert_eq!(path.at(9.0).translation, DVec3::X);
    }

    #[test]
    fn a_line_that_is_no_pose_is_named() {
        let error = |text: &str| RecordedPath::parse(text).err().unwrap();
        let good = "0,0,0,0,0,0,0,1\n";
        assert!(error(&format!("{good}1,2,3\n")).starts_with("line 2 has 3 numbers"));
        assert!(error(&format!("{good}1,0,0,0,0,0,0,x\n")).starts_with("line 2: invalid"));
        assert!(error(&format!("{good}1,0,0,0,0,0,0,2\n")).starts_with("line 2: give finite"));
        assert!(error(&format!("{good}{good}")).starts_with("line 2: give a time"));
        assert!(error(good).starts_with("give two poses"));
    }
}
