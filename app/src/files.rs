//! Writing results: images, depth, whole or not at all.

use crate::partial::Partial;
use anyhow::{Context, Result};
use image::RgbaImage;
use sandtable_cast::Image;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Makes the folder that `path` is to lie in.
pub(crate) fn make_folder(path: &Path) -> Result<()> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display())),
        _ => Ok(()),
    }
}

/// Writes a text file.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<()> {
    write_whole(path, |file| Ok(file.write_all(text.as_bytes())?))
}

/// Writes a file through `write`, under a temporary name beside it that takes its place at the
/// end: what was there before survives a failure.
fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<std::fs::File>) -> Result<()>,
) -> Result<()> {
    make_folder(path)?;
    let partial = Partial::beside(path);
    let result = (|| {
        let mut file = BufWriter::new(std::fs::File::create(partial.unfinished())?);
        write(&mut file)?;
        file.flush()?;
        drop(file);
        Ok(partial.complete()?)
    })();
    result.map_err(|error: anyhow::Error| {
        error.context(format!(
            "cannot write {}; is the folder there, writable and not full?",
            path.display()
        ))
    })
}

/// The forms that images are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ImageForm {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

/// The form of image that a name asks for by its ending.
pub(crate) fn image_form(path: &Path) -> Result<ImageForm> {
    match ending(path).as_deref() {
        Some("png") => Ok(ImageForm::Png),
        Some("jpg" | "jpeg") => Ok(ImageForm::Jpeg),
        _ => Err(crate::exit::usage(format!(
            "{} does not say which kind of image: let it end in .png or .jpg",
            path.display()
        ))),
    }
}

/// Refuses a name for depth that ends as something else does.
pub(crate) fn check_depth_name(path: &Path) -> Result<()> {
    match ending(path).as_deref() {
        Some("tif" | "tiff") => Ok(()),
        _ => Err(crate::exit::usage(format!(
            "{} does not say that depth is a TIFF file: let it end in .tif",
            path.display()
        ))),
    }
}

/// Refuses a name for a plot that ends as something else does.
pub(crate) fn check_plot_name(path: &Path) -> Result<()> {
    match ending(path).as_deref() {
        Some("svg") => Ok(()),
        _ => Err(crate::exit::usage(format!(
            "{} does not say that a plot is an SVG file: let it end in .svg",
            path.display()
        ))),
    }
}

/// What a name ends in, in small letters.
fn ending(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_str()?;
    Some(ending.to_ascii_lowercase())
}

/// Writes an image as PNG or JPEG, by the name's ending.
pub(crate) fn write_image(path: &Path, image: &RgbaImage) -> Result<()> {
    match image_form(path)? {
        ImageForm::Png => write_whole(path, |file| {
            let encoder = image::codecs::png::PngEncoder::new(file);
            Ok(image.write_with_encoder(encoder)?)
        }),
        ImageForm::Jpeg => write_whole(path, |file| {
            let rgb: image::RgbImage = image::buffer::ConvertBuffer::convert(image);
            let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(file, 92);
            Ok(rgb.write_with_encoder(encoder)?)
        }),
    }
}

/// Writes depth in metres as a float32 TIFF of one band, infinite for sky.
pub(crate) fn write_depth(path: &Path, image: &Image) -> Result<()> {
    write_whole(path, |file| {
        let mut encoder = tiff::encoder::TiffEncoder::new(file)?;
        Ok(
            encoder.write_image::<tiff::encoder::colortype::Gray32Float>(
                image.width(),
                image.height(),
                &image.depth,
            )?,
        )
    })
}
