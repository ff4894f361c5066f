//! PNG and JPEG pictures.

use super::stretch::{Counts, Stretch, covered};
use super::{PhotoFile, Pixel, Place, jpeg};
use crate::TerrainError;
use image::{DynamicImage, GenericImageView, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::path::Path;

/// Most bytes that a decoded picture may take beside the terrain.
const MAX_BYTES: u64 = 256 << 20;

/// A decoded picture.
pub(super) struct Picture {
    image: DynamicImage,
    /// What is shown of 16-bit values.
    stretch: Option<Stretch>,
}

impl Picture {
    pub(super) fn open(path: &Path) -> Result<Self, TerrainError> {
        let reader = ImageReader::open(path)
            .and_then(ImageReader::with_guessed_format)
            .map_err(|error| TerrainError::io(path, error))?;
        if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
            return Err(TerrainError::Picture {
                path: path.to_owned(),
                problem: "it is none of GeoTIFF, PNG and JPEG".into(),
                remedy: format!(
                    "convert it with: gdal_translate {} photo.tif",
                    path.display()
                ),
            });
        }
        let is_jpeg = reader.format() == Some(ImageFormat::Jpeg);
        let damaged = |error: image::ImageError| TerrainError::Picture {
            path: path.to_owned(),
            problem: error.to_string(),
            remedy: "copy or download it again".into(),
        };
        let mut decoder = reader.into_decoder().map_err(damaged)?;
        let (cols, rows) = decoder.dimensions();
        if decoder.total_bytes() > MAX_BYTES {
            return Err(TerrainError::Picture {
                path: path.to_owned(),
                problem: format!(
                    "its {cols} by {rows} pixels need {} MiB, above the limit of {} MiB",
                    decoder.total_bytes() >> 20,
                    MAX_BYTES >> 20
                ),
                remedy: format!(
                    "cut it into tiles with: gdal_translate -co TILED=YES -co COMPRESS=DEFLATE {} photo.tif",
                    path.display()
                ),
            });
        }
        check_compressed_size(path, decoder.total_bytes())?;
        if is_jpeg {
            check_jpeg_end(path)?;
        }
        let mut limits = Limits::default();
        limits.max_alloc = Some(2 * MAX_BYTES);
        decoder.set_limits(limits).map_err(damaged)?;
        DynamicImage::from_decoder(decoder)
            .map(|image| Self {
                stretch: sixteen_bits(&image).map(|samples| samples.stretch()),
                image,
            })
            .map_err(damaged)
    }
}

/// Refuses a picture whose bytes cannot stand for its pixels, before memory is taken for them.
fn check_compressed_size(path: &Path, decoded: u64) -> Result<(), TerrainError> {
    /// Neither deflate nor a JPEG block stands for more than this many bytes a byte.
    const MAX_RATIO: u64 = 1100;
    let length = std::fs::metadata(path)
        .map_err(|error| TerrainError::io(path, error))?
        .len();
    if decoded > length.saturating_mul(MAX_RATIO) {
        return Err(TerrainError::damaged(
            path,
            "its header",
            format!("the file's {length} bytes cannot hold the {decoded} that it announces"),
        ));
    }
    Ok(())
}

/// Refuses a JPEG file that ends before its picture does.
fn check_jpeg_end(path: &Path) -> Result<(), TerrainError> {
    let bytes = std::fs::read(path).map_err(|error| TerrainError::io(path, error))?;
    if jpeg::is_whole(&bytes) {
        return Ok(());
    }
    Err(TerrainError::Picture {
        path: path.to_owned(),
        problem: format!("it breaks off after {} bytes, before its end", bytes.len()),
        remedy: "copy or download it again".into(),
    })
}

/// The samples of a picture of 16 bits: grey or red, green and blue, each with coverage or without.
struct SixteenBits<'a> {
    samples: &'a [u16],
    channels: usize,
}

/// The samples of a picture, if they have 16 bits.
fn sixteen_bits(image: &DynamicImage) -> Option<SixteenBits<'_>> {
    let samples = image.as_flat_samples_u16()?;
    Some(SixteenBits {
        samples: samples.samples,
        channels: usize::from(samples.layout.channels),
    })
}

impl SixteenBits<'_> {
    fn pixels(&self) -> std::slice::ChunksExact<'_, u16> {
        self.samples.chunks_exact(self.channels)
    }

    fn colours(&self, channels: &[u16]) -> [u16; 3] {
        match *channels {
            [red, green, blue, ..] => [red, green, blue],
            _ => [channels[0]; 3],
        }
    }

    fn is_covered(&self, channels: &[u16]) -> bool {
        let has_cover = self.channels.is_multiple_of(2);
        !has_cover || channels[self.channels - 1] >= u16::MAX / 2
    }

    /// What is to be shown, by the measure that photographs in TIFF files have.
    fn stretch(&self) -> Stretch {
        let mut counts = Counts::new();
        for channels in self.pixels().filter(|channels| self.is_covered(channels)) {
            self.colours(channels)
                .iter()
                .for_each(|&colour| counts.add(colour));
        }
        counts.stretch()
    }

    fn pixel(&self, channels: &[u16], stretch: Stretch) -> Pixel {
        if !self.is_covered(channels) {
            return [0; 4];
        }
        let colours = self.colours(channels).map(f32::from);
        covered(colours.map(|colour| stretch.shown(colour)))
    }
}

impl PhotoFile for Picture {
    fn size(&self) -> [u32; 2] {
        self.image.dimensions().into()
    }

    fn read_rows(&mut self, first: u32, into: &mut [Pixel]) -> Result<(), TerrainError> {
        let cols = self.image.width();
        if let (Some(samples), Some(stretch)) = (sixteen_bits(&self.image), self.stretch) {
            let begin = first as usize * cols as usize;
            for (pixel, channels) in into.iter_mut().zip(samples.pixels().skip(begin)) {
                *pixel = samples.pixel(channels, stretch);
            }
            return Ok(());
        }
        for (row, pixels) in into.chunks_mut(cols as usize).enumerate() {
            for (col, pixel) in pixels.iter_mut().enumerate() {
                let [red, green, blue, alpha] =
                    self.image.get_pixel(col as u32, first + row as u32).0;
                // A pixel is there or is not: the ground has no colour to mix in.
                *pixel = [red, green, blue, if alpha >= 128 { 255 } else { 0 }];
            }
        }
        Ok(())
    }

    fn place(&self) -> Place {
        Place::default()
    }

    fn notes(&self) -> Vec<String> {
        self.stretch.map(Stretch::note).into_iter().collect()
    }
}
