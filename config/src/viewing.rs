//! What the picture is seen through: a desktop's camera or a table's glass, in mono or stereo.

use crate::RigError;
use crate::fields::{Fields, Value};
use crate::rigid::REACH;
use glam::DVec3;

/// What the picture is seen through.
#[derive(Clone, Debug, PartialEq)]
pub enum Viewing {
    /// A camera that flies: a desktop.
    Desktop(Desktop),
    /// A fixed glass that the world lies on: a workbench.
    Table(Table),
}

/// A desktop's camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Desktop {
    /// The field of view across the picture's outer edges, in degrees.
    pub horizontal_fov: f64,
    /// The distance between the eyes; a share is of the screen's distance.
    pub eye_separation: Measure,
    /// From the eyes to the plane without parallax; a share is of the ground's longer side.
    pub screen_distance: Measure,
}

/// A table's glass.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The picture's lower left corner as the user sees it, in table metres.
    pub lower_left: DVec3,
    /// The lower right corner, in table metres.
    pub lower_right: DVec3,
    /// The upper left corner, in table metres.
    pub upper_left: DVec3,
    /// Width and height of one eye's picture, in pixels.
    pub pixels: [u32; 2],
    /// The share of the glass left free on each side when the world is fitted to it.
    pub margin: f64,
    /// How many times relief is stretched when the world is fitted.
    pub exaggeration: f64,
}

impl Table {
    /// How far in metres a place in table metres is before the glass, on the side from which it is seen; negative
    /// behind it.
    #[must_use]
    pub fn before_glass(&self, place: DVec3) -> f64 {
        let across = self.lower_right - self.lower_left;
        let upwards = self.upper_left - self.lower_left;
        (place - self.lower_left).dot(across.cross(upwards).normalize())
    }
}

/// A length, or a share of the one that its owner names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// In world metres.
    Metres(f64),
    /// As a share of another length.
    Share(f64),
}

impl Measure {
    /// The length in metres, where a share is of `whole` metres.
    #[must_use]
    pub fn of(self, whole: f64) -> f64 {
        match self {
            Self::Metres(metres) => metres,
            Self::Share(share) => share * whole,
        }
    }
}

/// How two eyes share one display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StereoMode {
    /// One picture, from the middle of the eyes.
    Mono,
    /// The left eye's picture beside the right eye's.
    SideBySide,
    /// The left eye's picture above the right eye's.
    TopBottom,
    /// The left eye's picture in red, the right eye's in cyan.
    Anaglyph,
}

/// Stereo as it starts; keys change it while running.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stereo {
    /// How the eyes share the display.
    pub mode: StereoMode,
    /// Whether left and right are exchanged, for displays that have them so.
    pub swap_eyes: bool,
}

pub(crate) fn read_viewing(root: &Fields<'_>) -> Result<Viewing, RigError> {
    match (root.get("camera"), root.get("table")) {
        (Some(_), Some(table)) => Err(table.error(
            "stands beside `camera`",
            "keep [camera] for a desktop or [table] for a workbench",
        )),
        (None, None) => Err(root.error(
            "camera",
            "is missing, and so is `table`",
            "write [camera] for a desktop or [table] for a workbench",
        )),
        (Some(camera), None) => Ok(Viewing::Desktop(read_desktop(&camera)?)),
        (None, Some(table)) => Ok(Viewing::Table(read_table(&table)?)),
    }
}

fn read_desktop(value: &Value<'_>) -> Result<Desktop, RigError> {
    let fields = value.fields()?;
    let desktop = Desktop {
        horizontal_fov: match fields.get("horizontal_fov") {
            Some(value) => value.number(1.0..=170.0, "degrees")?,
            None => 60.0,
        },
        eye_separation: match fields.get("eye_separation") {
            Some(value) => read_measure(&value, 0.0..=1e6, 0.0..=1.0)?,
            None => Measure::Share(0.03),
        },
        screen_distance: match fields.get("screen_distance") {
            Some(value) => read_measure(&value, 1e-3..=1e8, 1e-6..=100.0)?,
            None => Measure::Share(0.25),
        },
    };
    fields.finish()?;
    Ok(desktop)
}

fn read_table(value: &Value<'_>) -> Result<Table, RigError> {
    let fields = value.fields()?;
    let corner = |key: &str| -> Result<DVec3, RigError> {
        let value = fields.need(key, "write the corner as [x, y, z] in table metres")?;
        Ok(DVec3::from_array(
            value.numbers::<3>(-REACH..=REACH, "metres")?,
        ))
    };
    let (lower_left, lower_right, upper_left) = (
        corner("lower_left")?,
        corner("lower_right")?,
        corner("upper_left")?,
    );
    let (across, upwards) = (lower_right - lower_left, upper_left - lower_left);
    let area = across.cross(upwards).length();
    // The second side's error is where the eye looks for it: the corner that closes the window.
    if area < 1e-6 {
        return Err(value.error(
            "has its three corners in a line",
            "measure lower_left, lower_right and upper_left anew",
        ));
    }
    if across.dot(upwards).abs() > 0.02 * across.length() * upwards.length() {
        return Err(value.error(
            "is not a rectangle: its sides meet at more than a degree off the right angle",
            "measure lower_left, lower_right and upper_left anew",
        ));
    }
    let [width, height] = fields
        .need("pixels", "write one eye's picture as [width, height]")?
        .array::<2>("[width, height]")?;
    let table = Table {
        lower_left,
        lower_right,
        upper_left,
        pixels: [
            width.integer(1..=16384, "pixels")?,
            height.integer(1..=16384, "pixels")?,
        ],
        margin: match fields.get("margin") {
            Some(value) => value.number(0.0..=0.45, "of the glass")?,
            None => 0.05,
        },
        exaggeration: match fields.get("exaggeration") {
            Some(value) => value.number(0.1..=20.0, "times")?,
            None => 1.0,
        },
    };
    fields.finish()?;
    Ok(table)
}

pub(crate) fn read_stereo(root: &Fields<'_>) -> Result<Stereo, RigError> {
    let mut stereo = Stereo {
        mode: StereoMode::Mono,
        swap_eyes: false,
    };
    let Some(value) = root.get("stereo") else {
        return Ok(stereo);
    };
    let fields = value.fields()?;
    if let Some(value) = fields.get("mode") {
        stereo.mode = value.choice(&[
            ("mono", StereoMode::Mono),
            ("side-by-side", StereoMode::SideBySide),
            ("top-bottom", StereoMode::TopBottom),
            ("anaglyph", StereoMode::Anaglyph),
        ])?;
    }
    if let Some(value) = fields.get("swap_eyes") {
        stereo.swap_eyes = value.boolean()?;
    }
    fields.finish()?;
    Ok(stereo)
}

/// `{ metres = 2.5 }` or `{ share = 0.1 }`.
pub(crate) fn read_measure(
    value: &Value<'_>,
    metres: std::ops::RangeInclusive<f64>,
    share: std::ops::RangeInclusive<f64>,
) -> Result<Measure, RigError> {
    let wanted = "{ metres = M } or { share = S }";
    let fields = value.fields().map_err(|_| value.wrong_type(wanted))?;
    let measure = match (fields.get("metres"), fields.get("share")) {
        (Some(value), None) => Measure::Metres(value.number(metres, "metres")?),
        (None, Some(value)) => Measure::Share(value.number(share, "")?),
        _ => {
            return Err(value.error("needs one length", &format!("write {wanted}")));
        }
    };
    fields.finish()?;
    Ok(measure)
}
