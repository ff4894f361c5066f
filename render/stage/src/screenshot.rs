//! Screenshots: numbered PNG files, written beside the display thread, none over another.

use image::RgbaImage;
use std::fs::OpenOptions;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Why a screenshot was not written.
#[derive(Debug, thiserror::Error)]
pub enum ScreenshotError {
    /// The file could not be made or written.
    #[error("cannot write the screenshot {path:?}: {source}; is the folder there and writable?")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The image could not be encoded or written.
    #[error("cannot write the screenshot {path:?}: {source}")]
    Encode {
        /// The file, which has been removed again.
        path: PathBuf,
        /// What the encoder says.
        source: image::ImageError,
    },
    /// All numbers are taken.
    #[error("{0:?} holds 9999 screenshots already: move some away")]
    Full(PathBuf),
    /// The system gave no thread to write on.
    #[error("cannot start a thread to write the screenshot: {0}")]
    NoThread(std::io::Error),
}

/// Writes `image` to `folder` as `sandtable-NNNN.png`, with the first number that is free, and
/// returns the path.
///
/// # Errors
/// [`ScreenshotError`]; nothing is left behind then.
pub fn save_screenshot(image: &RgbaImage, folder: &Path) -> Result<PathBuf, ScreenshotError> {
    for number in 1..=9999 {
        let path = folder.join(format!("sandtable-{number:04}.png"));
        let file = match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
            Err(source) => return Err(ScreenshotError::Write { path, source }),
        };
        let mut out = BufWriter::new(file);
        let written = image
            .write_with_encoder(image::codecs::png::PngEncoder::new(&mut out))
            .and_then(|()| out.flush().map_err(image::ImageError::IoError));
        return match written {
            Ok(()) => Ok(path),
            Err(source) => {
                // Half a picture helps nobody; should this fail too, the first error tells more.
                let _ = std::fs::remove_file(&path);
                Err(ScreenshotError::Encode { path, source })
            }
        };
    }
    Err(ScreenshotError::Full(folder.to_owned()))
}

/// As [`save_screenshot`], on a thread of its own, which then calls `done`.
pub fn save_screenshot_in_background(
    image: RgbaImage,
    folder: PathBuf,
    done: impl Fn(Result<PathBuf, ScreenshotError>) + Send + Clone + 'static,
) {
    let report = done.clone();
    let started = std::thread::Builder::new()
        .name("screenshot".into())
        .spawn(move || done(save_screenshot(&image, &folder)));
    if let Err(error) = started {
        report(Err(ScreenshotError::NoThread(error)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgba;

    #[test]
    fn earlier_files_are_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("sandtable-0002.png");
        std::fs::write(&taken, "mine").unwrap();
        let image = |value| RgbaImage::from_pixel(3, 2, Rgba([value, 0, 0, 255]));
        let first = save_screenshot(&image(1), folder.path()).unwrap();
        let second = save_screenshot(&image(2), folder.path()).unwrap();
        assert_eq!(first, folder.path().join("sandtable-0001.png"));
        assert_eq!(second, folder.path().join("sandtable-0003.png"));
        assert_eq!(std::fs::read(&taken).unwrap(), b"mine");
        let read = image::open(second).unwrap().into_rgba8();
        assert_eq!(read, image(2));
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("nowhere");
        let error = save_screenshot(&RgbaImage::new(1, 1), &missing).unwrap_err();
        assert!(error.to_string().contains("nowhere/sandtable-0001.png"));
    }

    #[test]
    fn the_background_thread_reports_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let (sender, receiver) = crossbeam_channel::bounded(1);
        save_screenshot_in_background(RgbaImage::new(2, 2), folder.path().into(), move |done| {
            sender.send(done).unwrap();
        });
        assert!(receiver.recv().unwrap().unwrap().exists());
    }
}
