//! Stereo modes: how two eyes' images share one frame.

use std::fmt;
use std::str::FromStr;

/// How the images of two eyes are brought to the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StereoMode {
    /// One image for both eyes.
    #[default]
    Mono,
    /// The left eye's image on the left half, the right eye's on the right half, each squeezed to
    /// half its width; a 3D projector or screen stretches them again.
    SideBySide,
    /// The left eye's image on the upper half, the right eye's on the lower half, each squeezed to
    /// half its height.
    TopBottom,
    /// For red-cyan glasses, red before the left eye.
    Anaglyph,
}

/// A text that names no stereo mode.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no stereo mode is called {0:?}: use mono, side-by-side, top-bottom or anaglyph")]
pub struct UnknownStereoMode(pub String);

impl StereoMode {
    /// All modes, in the order of their keys.
    pub const ALL: [Self; 4] = [
        Self::Mono,
        Self::SideBySide,
        Self::TopBottom,
        Self::Anaglyph,
    ];

    /// The name in rig files, on the command line and in the panel.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mono => "mono",
            Self::SideBySide => "side-by-side",
            Self::TopBottom => "top-bottom",
            Self::Anaglyph => "anaglyph",
        }
    }

    /// Whether it shows two different images.
    #[must_use]
    pub const fn is_stereo(self) -> bool {
        !matches!(self, Self::Mono)
    }

    /// The size in pixels at which each eye is to be cast for a frame of `frame` pixels.
    ///
    /// Only the sampling is squeezed: the view through which an eye looks keeps the window and the
    /// proportions of the full frame. An odd width or height is rounded up. Nothing is smaller
    /// than one pixel.
    #[must_use]
    pub fn eye_size(self, frame: [u32; 2]) -> [u32; 2] {
        let [width, height] = frame.map(|side| side.max(1));
        match self {
            Self::Mono | Self::Anaglyph => [width, height],
            Self::SideBySide => [width.div_ceil(2), height],
            Self::TopBottom => [width, height.div_ceil(2)],
        }
    }
}

impl fmt::Display for StereoMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for StereoMode {
    type Err = UnknownStereoMode;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|mode| mode.name() == name)
            .ok_or_else(|| UnknownStereoMode(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_is_found_by_its_name() {
        for mode in StereoMode::ALL {
            assert_eq!(mode.to_string().parse(), Ok(mode));
        }
        let error = "3d".parse::<StereoMode>().unwrap_err().to_string();
        assert!(error.contains("\"3d\"") && error.contains("side-by-side"));
    }

    #[test]
    fn shared_frames_halve_the_eyes_along_one_side() {
        let sizes = |frame| StereoMode::ALL.map(|mode| mode.eye_size(frame));
        assert_eq!(
            sizes([1280, 800]),
            [[1280, 800], [640, 800], [1280, 400], [1280, 800]]
        );
        assert_eq!(sizes([7, 5]), [[7, 5], [4, 5], [7, 3], [7, 5]]);
        assert_eq!(sizes([0, 0]), [[1, 1]; 4]);
    }
}
