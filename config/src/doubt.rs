//! What a rig says that can hardly be meant, though each of its numbers may be.

use crate::{Rig, Viewing};
use std::fmt;

/// Something that can hardly be meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// The eyes of the head at rest are behind the glass, by so many metres.
    EyesBehindGlass(f64),
    /// The eyes of the head at rest have the glass's right on their left.
    LeftForRight,
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EyesBehindGlass(metres) => write!(
                f,
                "the eyes of the head at rest are {metres:.2} m behind the glass: `table.lower_left` and \
                 `table.lower_right` may be exchanged; corners are named as the user sees them"
            ),
            Self::LeftForRight => f.write_str(
                "the head at rest has the glass's right on its left: name the corners of `table` as the user sees them, \
                 or see which way `head.rest` and `head.eyes.rightwards` point",
            ),
        }
    }
}

impl Rig {
    /// Which of what it says can hardly be meant: a glass that its user would see from behind, or upside down.
    ///
    /// Eyes count that are more than a millimetre behind the glass, and heads turned by more than 120°: a user may
    /// stand beside the table.
    #[must_use]
    pub fn doubts(&self) -> Vec<Doubt> {
        let (Viewing::Table(table), Some(head)) = (&self.viewing, &self.head) else {
            return Vec::new();
        };
        let mut doubts = Vec::new();
        let before = table.before_glass(head.rest.point(head.eyes.middle));
        if before < -1e-3 {
            doubts.push(Doubt::EyesBehindGlass(-before));
        }
        let across = (table.lower_right - table.lower_left).normalize();
        if (head.rest.rotation * head.eyes.rightwards).dot(across) < -0.5 {
            doubts.push(Doubt::LeftForRight);
        }
        doubts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The workbench with some of its words replaced.
    fn doubts(words: &[[&str; 2]]) -> Vec<Doubt> {
        let mut text = Rig::builtin_text("workbench").unwrap().to_owned();
        for [old, new] in words {
            assert!(text.contains(old), "{old}");
            text = text.replace(old, new);
        }
        Rig::parse(&text, "lab.toml").unwrap().doubts()
    }

    #[test]
    fn corners_left_for_right_are_doubted() {
        assert_eq!(doubts(&[]), []);
        // From the other side of the frame, by someone under the glass.
        let exchanged = doubts(&[
            ["lower_left = [-0.90, -0.55", "lower_left = [0.90, -0.55"],
            ["lower_right = [0.90, -0.55", "lower_right = [-0.90, -0.55"],
            ["upper_left = [-0.90, 0.55", "upper_left = [0.90, 0.55"],
        ]);
        let [Doubt::EyesBehindGlass(metres), Doubt::LeftForRight] = exchanged[..] else {
            panic!("{exchanged:?}");
        };
        // The sensor rests 60 cm over the glass, 3 cm over the eyes.
        assert!((metres - 0.57).abs() < 1e-9, "{metres}");
        // From the table's far side: the picture is upside down for the user.
        let turned = [
            ["lower_left = [-0.90, -0.55", "lower_left = [0.90, 0.55"],
            ["lower_right = [0.90, -0.55", "lower_right = [-0.90, 0.55"],
            ["upper_left = [-0.90, 0.55", "upper_left = [0.90, -0.55"],
        ];
        assert_eq!(doubts(&turned), [Doubt::LeftForRight]);
        // Unless the user stands there.
        let there = [
            "rest = { position = [0.0, -0.75, 0.60], axes = [\"+y\", \"+x\", \"-z\"] }",
            "rest = { position = [0.0, 0.75, 0.60], axes = [\"-y\", \"-x\", \"-z\"] }",
        ];
        assert_eq!(doubts(&[turned[0], turned[1], turned[2], there]), []);
        assert_eq!(Rig::builtin("desktop").unwrap().doubts(), []);
    }
}
