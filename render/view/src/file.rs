//! View files: one view in TOML, as experts exchange and bench them.

use crate::{Attitude, Camera, Screen, Stereo, StereoPair, View};
use glam::DVec3;
use serde::Deserialize;

/// Why a view file cannot be used. Messages name line and key; the caller adds the file's name.
#[derive(Debug, thiserror::Error)]
pub enum ViewFileError {
    /// Not TOML, an unknown or missing key, or a value of the wrong type.
    #[error("{0}")]
    Toml(#[from] toml::de::Error),
    /// `camera` and `screen` exclude each other, and one of them is needed.
    #[error("a view has either `camera` or `screen`, and this one has {0}")]
    CameraOrScreen(&'static str),
    /// A number outside its range.
    #[error("`{key}` is {found}, but must be {wanted}")]
    OutOfRange {
        /// The key, as a dotted path.
        key: &'static str,
        /// What stands there.
        found: String,
        /// What would be right.
        wanted: &'static str,
    },
    /// Two eyes were asked for and the file has no `stereo`.
    #[error(
        "the view has no `stereo`; add e.g. stereo = {{ separation = 65.0, screen_distance = 2000.0 }}"
    )]
    NoStereo,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    #[serde(default)]
    yaw: f64,
    #[serde(default)]
    pitch: f64,
    #[serde(default)]
    roll: f64,
    horizontal_fov: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StereoTable {
    separation: f64,
    screen_distance: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewTable {
    size: [u32; 2],
    eye: DVec3,
    camera: Option<CameraTable>,
    screen: Option<Screen>,
    stereo: Option<StereoTable>,
}

/// A checked view file. Angles in the file are degrees, lengths world metres.
#[derive(Clone, Debug)]
pub struct ViewFile {
    table: ViewTable,
}

/// The widest image side that a view may ask for.
const LARGEST_SIDE: u32 = 32_768;

impl ViewFile {
    /// Reads and checks the text of a view file.
    ///
    /// # Errors
    /// [`ViewFileError`] says which key is wrong and what would be right.
    pub fn parse(text: &str) -> Result<Self, ViewFileError> {
        let file = Self {
            table: toml::from_str(text)?,
        };
        file.check()?;
        Ok(file)
    }

    fn check(&self) -> Result<(), ViewFileError> {
        let range =
            |key, found: String, wanted| Err(ViewFileError::OutOfRange { key, found, wanted });
        let table = &self.table;
        if table
            .size
            .iter()
            .any(|&side| side == 0 || side > LARGEST_SIDE)
        {
            return range(
                "size",
                format!("{:?}", table.size),
                "two sides from 1 to 32768 pixels",
            );
        }
        if !table.eye.is_finite() {
            return range("eye", table.eye.to_string(), "three finite numbers");
        }
        match (&table.camera, &table.screen) {
            (Some(_), Some(_)) => return Err(ViewFileError::CameraOrScreen("both")),
            (None, None) => return Err(ViewFileError::CameraOrScreen("neither")),
            (Some(camera), None) => {
                if !(camera.horizontal_fov > 0.0 && camera.horizontal_fov < 180.0) {
                    let found = camera.horizontal_fov.to_string();
                    return range("camera.horizontal_fov", found, "between 0 and 180 degrees");
                }
                if ![camera.yaw, camera.pitch, camera.roll]
                    .iter()
                    .all(|angle| angle.is_finite())
                {
                    let found = format!("{camera:?}");
                    return range("camera", found, "finite angles in degrees");
                }
            }
            (None, Some(_)) => {
                if !self.mono().is_proper() {
                    return range(
                        "screen",
                        "flat against the eye".into(),
                        "a window with an area, off the eye's plane",
                    );
                }
            }
        }
        if let Some(stereo) = &table.stereo {
            if !(stereo.separation.is_finite() && stereo.separation >= 0.0) {
                return range(
                    "stereo.separation",
                    stereo.separation.to_string(),
                    "zero or more metres",
                );
            }
            match (stereo.screen_distance, &table.camera) {
                (None, Some(_)) => {
                    return range(
                        "stereo.screen_distance",
                        "missing".into(),
                        "given beside `camera`",
                    );
                }
                (Some(d), Some(_)) if !(d.is_finite() && d > 0.0) => {
                    return range(
                        "stereo.screen_distance",
                        d.to_string(),
                        "more than zero metres",
                    );
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The image's width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.table.size
    }

    /// The same view with another image size.
    #[must_use]
    pub fn with_size(mut self, size: [u32; 2]) -> Self {
        self.table.size = size;
        self
    }

    /// The camera's field of view in radians, where the file has a camera.
    #[must_use]
    pub fn horizontal_fov(&self) -> Option<f64> {
        self.camera().map(|camera| camera.horizontal_fov)
    }

    /// The camera's eyes, where the file has a camera and `stereo`.
    #[must_use]
    pub fn camera_stereo(&self) -> Option<Stereo> {
        let stereo = self.table.stereo.as_ref()?;
        let screen_distance = stereo.screen_distance?;
        self.table.camera.as_ref()?;
        Some(Stereo {
            separation: stereo.separation,
            screen_distance,
        })
    }

    fn camera(&self) -> Option<Camera> {
        self.table.camera.as_ref().map(|camera| Camera {
            eye: self.table.eye,
            attitude: Attitude {
                yaw: camera.yaw.to_radians(),
                pitch: camera.pitch.to_radians(),
                roll: camera.roll.to_radians(),
            },
            horizontal_fov: camera.horizontal_fov.to_radians(),
        })
    }

    fn window(&self) -> Screen {
        self.table.screen.unwrap_or(Screen {
            lower_left: DVec3::ZERO,
            lower_right: DVec3::ZERO,
            upper_left: DVec3::ZERO,
        })
    }

    /// The view from the middle of the eyes.
    #[must_use]
    pub fn mono(&self) -> View {
        let size = self.table.size;
        match self.camera() {
            Some(camera) => camera.view(size),
            None => View {
                eye: self.table.eye,
                window: self.window(),
                size,
            },
        }
    }

    /// The two eyes' views.
    ///
    /// # Errors
    /// [`ViewFileError::NoStereo`] where the file has no `stereo`.
    pub fn stereo(&self) -> Result<StereoPair<View>, ViewFileError> {
        let stereo = self.table.stereo.as_ref().ok_or(ViewFileError::NoStereo)?;
        let size = self.table.size;
        if let (Some(camera), Some(eyes)) = (self.camera(), self.camera_stereo()) {
            return Ok(camera.stereo_views(eyes, size));
        }
        // The screen itself is the plane without parallax; the eyes stand along its rows.
        let window = self.window();
        let half = 0.5 * stereo.separation * window.across().normalize_or_zero();
        Ok(StereoPair {
            left: View {
                eye: self.table.eye - half,
                window,
                size,
            },
            right: View {
                eye: self.table.eye + half,
                window,
                size,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: &str = "size = [64, 36]\neye = [1.0, 2.0, 3.0]\n\
        camera = { yaw = 90.0, pitch = -30.0, roll = 0.0, horizontal_fov = 60.0 }\n";

    #[test]
    fn a_camera_file_gives_its_view() {
        let file = ViewFile::parse(CAMERA).unwrap();
        let view = file.mono();
        let d = view.direction(32.0, 18.0);
        assert!((d - DVec3::new(30f64.to_radians().cos(), 0.0, -0.5)).length() < 1e-12);
        assert!(matches!(file.stereo(), Err(ViewFileError::NoStereo)));
    }

    #[test]
    fn errors_name_the_key_and_what_would_be_right() {
        let unknown = format!("{CAMERA}fov = 3\n");
        let text = ViewFile::parse(&unknown).unwrap_err().to_string();
        assert!(text.contains("fov") && text.contains("line 4"), "{text}");
        let text = ViewFile::parse(&CAMERA.replace("60.0", "190.0"))
            .unwrap_err()
            .to_string();
        assert!(
            text.contains("camera.horizontal_fov") && text.contains("180"),
            "{text}"
        );
        let both = format!(
            "{CAMERA}screen = {{ lower_left=[0,0,0], lower_right=[1,0,0], upper_left=[0,1,0] }}\n"
        );
        assert!(matches!(
            ViewFile::parse(&both),
            Err(ViewFileError::CameraOrScreen("both"))
        ));
        assert!(ViewFile::parse(&CAMERA.replace("[64, 36]", "[0, 36]")).is_err());
    }

    #[test]
    fn a_screens_eyes_stand_along_its_rows() {
        let text = "size = [64, 36]\neye = [0.0, -1.0, 2.0]\nstereo = { separation = 0.5 }\n\
            screen = { lower_left = [-1, -1, 0], lower_right = [1, -1, 0], upper_left = [-1, 1, 0] }";
        let pair = ViewFile::parse(text).unwrap().stereo().unwrap();
        assert!((pair.right.eye - pair.left.eye - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-12);
    }
}
