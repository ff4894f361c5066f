//! Sound files: the mixer rendered faster or slower than time.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use crate::mixer::{Settings, mixer};
use crate::soundscape::Soundscape;

/// Frames a second of every sound file written here.
pub const WAV_SAMPLE_RATE: u32 = 48_000;

/// Frames between two looks at the soundscape: at most 5.3 ms, less than it takes to follow one.
const STEP: usize = 256;

/// A sound file could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WavError {
    /// The file cannot be created, grown or put in place.
    #[error("cannot write {}: {source}; check that its folder exists, is writable and has room",
        path.display())]
    Write {
        /// The file as asked for.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The sound is longer than the format's 32-bit sizes can say.
    #[error("{} would be longer than the 4 GB (6 hours) that a WAV file can hold", path.display())]
    TooLong {
        /// The file as asked for.
        path: PathBuf,
    },
}

/// Writes stereo frames to a WAV file: 32-bit float, [`WAV_SAMPLE_RATE`].
///
/// The file grows under a temporary name beside its own and takes it in [`WavWriter::finish`]; so
/// a run that breaks off leaves an earlier file as it was. A device is written as it is.
pub struct WavWriter {
    path: PathBuf,
    // Dropped in this order: hound writes once more before the file goes.
    file: hound::WavWriter<BufWriter<File>>,
    /// `None` where no file may take the place of what is there.
    partial: Option<Partial>,
    samples: u32,
}

impl WavWriter {
    /// Begins a file that will be at `path`.
    ///
    /// # Errors
    /// If it cannot be created there.
    pub fn create(path: &Path) -> Result<Self, WavError> {
        let spec = hound::WavSpec {
            channels: 2,
            sample_rate: WAV_SAMPLE_RATE,
            bits_per_sample: 32,
            sample_format: hound::SampleFormat::Float,
        };
        let is_special = path
            .metadata()
            .is_ok_and(|there| !there.is_file() && !there.is_dir());
        let partial = (!is_special).then(|| {
            let mut name = path.file_name().unwrap_or_default().to_owned();
            name.push(".part");
            Partial(path.with_file_name(name))
        });
        let unfinished = partial.as_ref().map_or(path, |partial| &*partial.0);
        let file = hound::WavWriter::create(unfinished, spec).map_err(|e| error(path, e))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            partial,
            samples: 0,
        })
    }

    /// Appends frames, left and right.
    ///
    /// # Errors
    /// If the disk is full or fails, or the file would become too long for its format.
    pub fn write(&mut self, frames: &[[f32; 2]]) -> Result<(), WavError> {
        // Checked here as the format's sizes would wrap around silently; the header needs a little.
        let room = (u32::MAX - 256) / 4 - self.samples;
        let samples = u32::try_from(frames.len() * 2).unwrap_or(u32::MAX);
        if samples > room {
            return Err(WavError::TooLong {
                path: self.path.clone(),
            });
        }
        for &sample in frames.as_flattened() {
            let written = self.file.write_sample(sample);
            written.map_err(|e| error(&self.path, e))?;
        }
        self.samples += samples;
        Ok(())
    }

    /// Completes the file and puts it in its place.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub fn finish(self) -> Result<(), WavError> {
        let Self {
            path,
            file,
            partial,
            ..
        } = self;
        file.finalize().map_err(|e| error(&path, e))?;
        match partial {
            Some(partial) => {
                fs::rename(&partial.0, &path).map_err(|source| WavError::Write { path, source })
            }
            None => Ok(()),
        }
    }
}

/// Renders `frames` frames to a WAV file at `path`; `soundscape` says what there is to hear at a
/// time in seconds from the start, and is asked every few milliseconds.
///
/// # Errors
/// As those of [`WavWriter`].
pub fn render_to_wav(
    path: &Path,
    frames: u64,
    settings: Settings,
    mut soundscape: impl FnMut(f64) -> Soundscape,
) -> Result<(), WavError> {
    let mut writer = WavWriter::create(path)?;
    let (mut control, mut mixer) = mixer(settings, WAV_SAMPLE_RATE);
    let mut block = [[0.0; 2]; STEP];
    for start in (0..frames).step_by(STEP) {
        control.set(soundscape(start as f64 / f64::from(WAV_SAMPLE_RATE)));
        let left = usize::try_from(frames - start).unwrap_or(usize::MAX);
        let block = &mut block[..left.min(STEP)];
        mixer.render(block);
        writer.write(block)?;
    }
    writer.finish()
}

/// The unfinished file, which goes away with its writer.
#[derive(Debug)]
struct Partial(PathBuf);

impl Drop for Partial {
    fn drop(&mut self) {
        // After `finish` there is nothing left to remove.
        let _ = fs::remove_file(&self.0);
    }
}

fn error(path: &Path, error: hound::Error) -> WavError {
    let path = path.to_owned();
    match error {
        hound::Error::IoError(source) => WavError::Write { path, source },
        hound::Error::TooWide | hound::Error::UnfinishedSample => WavError::TooLong { path },
        other => WavError::Write {
            path,
            source: std::io::Error::other(other),
        },
    }
}
