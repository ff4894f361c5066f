//! Videos by ffmpeg: the frames go to it through a pipe.

use std::ffi::OsString;
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use super::VideoError;
use crate::partial::Partial;

/// How the frames are compressed, and in which container.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codec {
    /// In MP4: plays everywhere.
    H264,
    /// In WebM: free of patents, slower to make.
    Vp9,
}

impl Codec {
    fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::H264 => &[
                "-c:v",
                "libx264",
                "-preset",
                "fast",
                "-crf",
                "18",
                "-movflags",
                "+faststart",
                "-f",
                "mp4",
            ],
            Self::Vp9 => &[
                "-c:v",
                "libvpx-vp9",
                "-crf",
                "28",
                "-b:v",
                "0",
                "-deadline",
                "good",
                "-cpu-used",
                "5",
                "-row-mt",
                "1",
                "-f",
                "webm",
            ],
        }
    }
}

/// An ffmpeg that is being fed.
pub(super) struct Ffmpeg {
    // Dropped in this order: the process ends before its file goes.
    process: Process,
    partial: Partial,
}

impl Ffmpeg {
    pub(super) fn create(
        path: &Path,
        [width, height]: [u32; 2],
        frames_per_second: u32,
        codec: Codec,
    ) -> Result<Self, VideoError> {
        Self::create_with("ffmpeg", path, [width, height], frames_per_second, codec)
    }

    /// As [`Self::create`], by the given program.
    pub(super) fn create_with(
        program: &str,
        path: &Path,
        [width, height]: [u32; 2],
        frames_per_second: u32,
        codec: Codec,
    ) -> Result<Self, VideoError> {
        let partial = Partial::beside(path);
        // ffmpeg tells a missing folder in its own words; ours name the remedy.
        std::fs::File::create(partial.unfinished()).map_err(VideoError::write(path))?;
        // A name that looks like an option or an address is still a file's.
        let mut file = OsString::from("file:");
        file.push(partial.unfinished());
        let mut command = Command::new(program);
        command
            .args([
                "-v",
                "error",
                "-y",
                "-f",
                "rawvideo",
                "-pixel_format",
                "rgb0",
            ])
            .args(["-video_size", &format!("{width}x{height}")])
            .args(["-framerate", &frames_per_second.to_string(), "-i", "pipe:0"])
            // Players take such a small video to have the colours of television in high definition;
            // halved chroma needs even sizes, so odd ones get a black line right or below.
            .args([
                "-vf",
                "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,\
                 format=yuv420p",
            ])
            .args(["-colorspace", "bt709", "-color_primaries", "bt709"])
            .args(["-color_trc", "bt709", "-color_range", "tv"])
            .args(codec.arguments())
            .arg(file)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let process = Process::start(&mut command).map_err(|source| VideoError::NoFfmpeg {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self { process, partial })
    }

    pub(super) fn push(&mut self, pixels: &[[u8; 4]]) -> Result<(), VideoError> {
        match self.process.feed(pixels.as_flattened()) {
            Ok(()) => Ok(()),
            // It has gone away; why, it has said itself.
            Err(error) => {
                let said = self
                    .process
                    .end()
                    .map_or_else(|said| said, |()| error.to_string());
                Err(self.failure(said))
            }
        }
    }

    pub(super) fn finish(mut self) -> Result<(), VideoError> {
        if let Err(said) = self.process.end() {
            return Err(self.failure(said));
        }
        let path = self.partial.path().to_owned();
        self.partial.complete().map_err(VideoError::write(&path))
    }

    fn failure(&self, said: String) -> VideoError {
        VideoError::Ffmpeg {
            path: self.partial.path().to_owned(),
            said,
        }
    }
}

/// The running program; killed if it is dropped before its end.
struct Process {
    child: Child,
    /// None once all is fed.
    input: Option<ChildStdin>,
    /// Reads along what it says, lest it wait for a reader.
    listener: Option<JoinHandle<String>>,
}

impl Process {
    fn start(command: &mut Command) -> io::Result<Self> {
        let mut child = command.spawn()?;
        let input = child.stdin.take();
        let listener = child.stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut said = Vec::new();
                // What cannot be read was not said.
                let _ = stderr.read_to_end(&mut said);
                String::from_utf8_lossy(&said).trim().to_owned()
            })
        });
        Ok(Self {
            child,
            input,
            listener,
        })
    }

    fn feed(&mut self, bytes: &[u8]) -> io::Result<()> {
        match &mut self.input {
            Some(input) => input.write_all(bytes),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    /// Lets it come to its end; if that is a failure, returns what it said.
    fn end(&mut self) -> Result<(), String> {
        drop(self.input.take());
        let status = self.child.wait().map_err(|error| error.to_string())?;
        let said = self
            .listener
            .take()
            .and_then(|listener| listener.join().ok());
        match said.filter(|said| !said.is_empty()) {
            _ if status.success() => Ok(()),
            Some(said) => Err(said),
            None => Err(format!("it ended with {status}")),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // After its end both do nothing.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
