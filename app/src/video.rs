//! Videos: a flight's frames, written to be played.
//!
//! The path says the form: `.avi` is Motion-JPEG and needs nothing else; `.mp4` and `.webm` are
//! made by ffmpeg, if it is on the path; a folder (no extension, or a slash at the end) takes
//! numbered PNGs.
//!
//! Whatever the form, it grows under a temporary name beside its own and takes that in
//! [`VideoWriter::finish`]; so a run that breaks off leaves an earlier video as it was.

mod avi;
mod ffmpeg;
mod stills;

use std::io;
use std::path::{Path, PathBuf};

use avi::Avi;
use ffmpeg::{Codec, Ffmpeg};
use stills::Stills;

/// Writes frames to a video or to a folder of images.
pub(crate) struct VideoWriter {
    path: PathBuf,
    size: [u32; 2],
    frames: u64,
    form: Form,
}

enum Form {
    Avi(Avi),
    Ffmpeg(Ffmpeg),
    Stills(Stills),
}

impl VideoWriter {
    /// Begins a video of `size` (width and height in pixels, odd ones too) that will be at `path`
    /// and play at `frames_per_second`.
    ///
    /// # Errors
    /// If the path asks for a form that is unknown, whose program is not there or that cannot hold
    /// the size, or if it cannot be written.
    pub(crate) fn create(
        path: &Path,
        size: [u32; 2],
        frames_per_second: u32,
    ) -> Result<Self, VideoError> {
        if size.iter().any(|s| !(1..=65_535).contains(s)) || frames_per_second == 0 {
            return Err(VideoError::Size {
                path: path.to_owned(),
                size,
                frames_per_second,
            });
        }
        let kind = form_of(path)?;
        if kind != Kind::Stills && path.is_dir() {
            return Err(VideoError::write(path)(io::ErrorKind::IsADirectory.into()));
        }
        let form = match kind {
            Kind::Avi => Form::Avi(Avi::create(path, size, frames_per_second)?),
            Kind::Ffmpeg(codec) => {
                Form::Ffmpeg(Ffmpeg::create(path, size, frames_per_second, codec)?)
            }
            Kind::Stills => Form::Stills(Stills::create(path, size)?),
        };
        Ok(Self {
            path: path.to_owned(),
            size,
            frames: 0,
            form,
        })
    }

    /// Appends a frame: sRGB, rows from the top, left to right. The fourth byte, alpha, is not
    /// looked at.
    ///
    /// # Errors
    /// If the frame has not the video's size, the disk is full or fails, the encoder fails, or the
    /// form cannot hold more. What was pushed before can still be finished.
    pub(crate) fn push(&mut self, pixels: &[[u8; 4]]) -> Result<(), VideoError> {
        if pixels.len() as u64 != u64::from(self.size[0]) * u64::from(self.size[1]) {
            return Err(VideoError::Frame {
                path: self.path.clone(),
                size: self.size,
                found: pixels.len(),
            });
        }
        match &mut self.form {
            Form::Avi(avi) => avi.push(pixels),
            Form::Ffmpeg(ffmpeg) => ffmpeg.push(pixels),
            Form::Stills(stills) => stills.push(pixels),
        }?;
        self.frames += 1;
        Ok(())
    }

    /// Completes the video and puts it in its place.
    ///
    /// # Errors
    /// If no frame was pushed, the disk is full or fails, or the encoder fails.
    pub(crate) fn finish(self) -> Result<(), VideoError> {
        if self.frames == 0 {
            return Err(VideoError::NoFrames { path: self.path });
        }
        match self.form {
            Form::Avi(avi) => avi.finish(),
            Form::Ffmpeg(ffmpeg) => ffmpeg.finish(),
            Form::Stills(stills) => stills.finish(),
        }
    }
}

/// A video could not be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum VideoError {
    #[error(
        "cannot tell from its ending .{extension} how to write {}; endings are .avi, .mp4 and \
         .webm, and a folder takes PNGs", path.display()
    )]
    Form { path: PathBuf, extension: String },
    #[error(
        "{} cannot be {} x {} pixels at {frames_per_second} frames per second; width and height \
         go from 1 to 65535, frames per second from 1", path.display(), size[0], size[1]
    )]
    Size {
        path: PathBuf,
        size: [u32; 2],
        frames_per_second: u32,
    },
    #[error(
        "a frame of {found} pixels does not fit {}, which has {} x {}", path.display(), size[0],
        size[1]
    )]
    Frame {
        path: PathBuf,
        size: [u32; 2],
        found: usize,
    },
    #[error(
        "cannot write {}: {source}; check that its folder exists, is writable and has room",
        path.display()
    )]
    Write { path: PathBuf, source: io::Error },
    #[error("cannot encode a frame of {}: {source}", path.display())]
    Encode {
        path: PathBuf,
        source: image::ImageError,
    },
    #[error(
        "{} is full: an AVI file holds 4 GB; write an .mp4 or a folder of PNGs instead",
        path.display()
    )]
    Full { path: PathBuf },
    #[error(
        "{} needs ffmpeg, which cannot be started: {source}; install it (Debian: sudo apt install \
         ffmpeg) or write an .avi, which needs nothing", path.display()
    )]
    NoFfmpeg { path: PathBuf, source: io::Error },
    #[error(
        "ffmpeg did not write {}: {said}; an .avi needs no ffmpeg", path.display()
    )]
    Ffmpeg { path: PathBuf, said: String },
    #[error(
        "the folder {} holds more than an earlier flight's frames ({other}); name a new folder",
        path.display()
    )]
    Occupied { path: PathBuf, other: String },
    #[error("there is no frame to write to {}", path.display())]
    NoFrames { path: PathBuf },
}

impl VideoError {
    /// Makes an error of the system one of the file at `path`.
    fn write(path: &Path) -> impl Fn(io::Error) -> Self + '_ {
        |source| Self::Write {
            path: path.to_owned(),
            source,
        }
    }
}

/// The form that a path asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Avi,
    Ffmpeg(Codec),
    Stills,
}

fn form_of(path: &Path) -> Result<Kind, VideoError> {
    let ends_in_slash = path
        .as_os_str()
        .as_encoded_bytes()
        .last()
        .is_some_and(|&last| std::path::is_separator(char::from(last)));
    let extension = match path.extension() {
        Some(extension) if !ends_in_slash => extension.to_string_lossy().to_ascii_lowercase(),
        _ => return Ok(Kind::Stills),
    };
    match extension.as_str() {
        "avi" => Ok(Kind::Avi),
        "mp4" => Ok(Kind::Ffmpeg(Codec::H264)),
        "webm" => Ok(Kind::Ffmpeg(Codec::Vp9)),
        _ => Err(VideoError::Form {
            path: path.to_owned(),
            extension,
        }),
    }
}

#[cfg(test)]
mod tests;
