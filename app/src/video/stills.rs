//! Image sequences: a folder of numbered PNGs.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::VideoError;
use crate::partial::Partial;

/// A folder that is being filled with `frame_00000.png` and so on.
pub(super) struct Stills {
    folder: Folder,
    partial: Partial,
    size: [u32; 2],
    frames: usize,
    rgb: Vec<u8>,
}

impl Stills {
    pub(super) fn create(path: &Path, size: [u32; 2]) -> Result<Self, VideoError> {
        // Without the slash that a folder's name may end in.
        let path: PathBuf = path.components().collect();
        let partial = Partial::beside(&path);
        for folder in [&path, partial.unfinished()] {
            if let Some(other) = other_than_frames(folder).map_err(VideoError::write(&path))? {
                return Err(VideoError::Occupied {
                    path: folder.to_owned(),
                    other,
                });
            }
        }
        remove_frames(partial.unfinished()).map_err(VideoError::write(&path))?;
        fs::create_dir(partial.unfinished()).map_err(VideoError::write(&path))?;
        Ok(Self {
            folder: Folder(partial.unfinished().to_owned()),
            partial,
            size,
            frames: 0,
            rgb: Vec::new(),
        })
    }

    pub(super) fn push(&mut self, pixels: &[[u8; 4]]) -> Result<(), VideoError> {
        self.rgb.clear();
        self.rgb
            .extend(pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]));
        let path = self.folder.0.join(format!("frame_{:05}.png", self.frames));
        let mut file = BufWriter::new(File::create(&path).map_err(VideoError::write(&path))?);
        // Fast compression: a sequence is an intermediate, and its writing should not cost more
        // than its casting.
        PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive)
            .write_image(
                &self.rgb,
                self.size[0],
                self.size[1],
                ExtendedColorType::Rgb8,
            )
            .map_err(|source| match source {
                image::ImageError::IoError(source) => VideoError::Write {
                    path: path.clone(),
                    source,
                },
                source => VideoError::Encode {
                    path: path.clone(),
                    source,
                },
            })?;
        file.flush().map_err(VideoError::write(&path))?;
        self.frames += 1;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<(), VideoError> {
        let Self {
            folder, partial, ..
        } = self;
        let path = partial.path().to_owned();
        let replace = || {
            // No folder can take the name of one that is not empty, so the earlier one steps aside
            // first; at every moment one of the two is complete.
            let mut earlier = path.clone().into_os_string();
            earlier.push(".earlier");
            let earlier = PathBuf::from(earlier);
            remove_frames(&earlier)?;
            if path.exists() {
                fs::rename(&path, &earlier)?;
            }
            partial.complete()?;
            remove_frames(&earlier)
        };
        let replaced = replace().map_err(VideoError::write(&path));
        drop(folder);
        replaced
    }
}

/// The unfinished folder, which goes away with its owner.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        // Once complete there is no such folder.
        let _ = remove_frames(&self.0);
    }
}

/// Removes a folder of frames if there is one; anything else in it stays, and so does it.
fn remove_frames(folder: &Path) -> io::Result<()> {
    if !folder.exists() {
        return Ok(());
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if is_frame(&entry.file_name()) {
            fs::remove_file(entry.path())?;
        }
    }
    fs::remove_dir(folder)
}

/// The name of something in a folder that is not a frame; none if there is no folder.
fn other_than_frames(folder: &Path) -> io::Result<Option<String>> {
    if !folder.exists() {
        return Ok(None);
    }
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        if !is_frame(&name) {
            return Ok(Some(name.to_string_lossy().into_owned()));
        }
    }
    Ok(None)
}

fn is_frame(name: &OsStr) -> bool {
    name.to_str()
        .and_then(|name| name.strip_prefix("frame_")?.strip_suffix(".png"))
        .is_some_and(|number| number.len() >= 5 && number.bytes().all(|b| b.is_ascii_digit()))
}
