//! Films: a session written to a video, frame by frame, with its sound beside it.

use crate::exit::usage;
use crate::files::make_folder;
use crate::interrupt;
use crate::partial::behind_links;
use crate::session::{Session, summit};
use crate::video::{VideoError, VideoWriter};
use anyhow::{Context, Result, bail};
use bytemuck::cast_slice;
use sandtable_audio::{Soundscape, WAV_SAMPLE_RATE, render_to_wav};
use sandtable_cast::{CastPool, Image};
use sandtable_stage::{StereoMode, compose};
use std::path::PathBuf;

/// How a film is made.
#[derive(Clone, Debug)]
pub(crate) struct Film {
    /// Where it goes; the ending says in which form.
    pub(crate) output: PathBuf,
    /// Where its sound goes.
    pub(crate) audio: Option<PathBuf>,
    /// One eye's image in pixels.
    pub(crate) eye_size: [u32; 2],
    /// How the eyes share a frame; each keeps its full size.
    pub(crate) stereo: StereoMode,
    /// Whether the eyes are exchanged.
    pub(crate) swap_eyes: bool,
    /// Frames a second.
    pub(crate) rate: u32,
    /// How many frames.
    pub(crate) frames: u32,
}

/// The size of a frame in which each eye keeps `eye` pixels.
pub(crate) fn whole_frame(stereo: StereoMode, eye: [u32; 2]) -> [u32; 2] {
    let [width, height] = eye;
    match stereo {
        StereoMode::Mono | StereoMode::Anaglyph => [width, height],
        StereoMode::SideBySide => [2 * width, height],
        StereoMode::TopBottom => [width, 2 * height],
    }
}

impl Film {
    /// Shoots the film: `direct` puts the session where it is at each frame.
    ///
    /// # Errors
    /// Where a file cannot be written, or at Ctrl-C; what was there before is then left as it was.
    pub(crate) fn shoot(
        &self,
        session: &mut Session,
        pool: &CastPool,
        mut direct: impl FnMut(&mut Session, u32),
    ) -> Result<()> {
        let frame_size = whole_frame(self.stereo, self.eye_size);
        // Listened to before anything is begun that would be left behind.
        let stop = interrupt::channel()?;
        make_folder(&self.output)?;
        let video = VideoWriter::create(&self.output, frame_size, self.rate);
        let mut video = video.map_err(|error| match error {
            VideoError::Form { .. } => usage(error),
            error => error.into(),
        })?;
        let progress = progress(self.frames);
        let mut images = Vec::new();
        let mut soundscapes = Vec::new();
        let summit = summit(session.ground());
        for frame in 0..self.frames {
            if stop.try_recv().is_ok() {
                progress.finish_and_clear();
                bail!(
                    "interrupted after {frame} of {} frames; {} is not written",
                    self.frames,
                    self.output.display()
                );
            }
            direct(session, frame);
            let views = session.views(self.eye_size, self.stereo.is_stereo());
            images.resize_with(views.len(), Image::default);
            pool.cast(&**session.prepared(), &views, &mut images)?;
            let right = images.last().unwrap_or(&images[0]);
            let picture = compose(&images[0], right, self.stereo, self.swap_eyes, frame_size);
            video.push(cast_slice(picture.as_raw()))?;
            soundscapes.push(session.soundscape(summit));
            progress.inc(1);
        }
        video.finish()?;
        progress.finish_and_clear();
        if let Some(path) = &self.audio {
            self.write_sound(path, session, &soundscapes)?;
        }
        Ok(())
    }

    fn write_sound(
        &self,
        path: &std::path::Path,
        session: &Session,
        soundscapes: &[Soundscape],
    ) -> Result<()> {
        let seconds = f64::from(self.frames) / f64::from(self.rate);
        let frames = (seconds * f64::from(WAV_SAMPLE_RATE)).round() as u64;
        let at = |seconds: f64| {
            let frame = (seconds * f64::from(self.rate)) as usize;
            soundscapes
                .get(frame)
                .or(soundscapes.last())
                .copied()
                .unwrap_or_default()
        };
        render_to_wav(&behind_links(path), frames, session.sound_settings(), at)
            .with_context(|| format!("the film {} itself is done", self.output.display()))
    }
}

/// A bar on a terminal; nothing elsewhere.
fn progress(frames: u32) -> indicatif::ProgressBar {
    let bar = indicatif::ProgressBar::new(u64::from(frames));
    let style =
        indicatif::ProgressStyle::with_template("{bar:40} {pos} of {len} frames, {eta} left");
    bar.with_style(style.unwrap_or_else(|_| indicatif::ProgressStyle::default_bar()))
}
