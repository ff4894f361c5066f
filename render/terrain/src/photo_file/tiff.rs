//! Photographs in TIFF files.

use super::stretch::{Counts, Stretch, covered};
use super::{PhotoFile, Pixel, Place};
use crate::TerrainError;
use crate::raster::{BandChoice, GeoTiff, RasterFile, Samples};
use std::ops::Range;
use std::path::Path;
use tiff_reader::{ColorModel, ExtraSample};

/// Bytes of decoded channels to ask of the reader at once.
const CHUNK_BYTES: u32 = 8 << 20;

pub(super) struct TiffPhoto {
    file: GeoTiff,
    layout: Channels,
    nodata: Nodata,
    /// What is shown of a 16-bit file's values.
    stretch: Option<Stretch>,
    notes: Vec<String>,
}

/// Where a pixel's colours and coverage are among its channels.
#[derive(Clone, Copy)]
struct Channels {
    colours: [usize; 3],
    alpha: Option<(usize, Alpha)>,
}

/// Which value stands for no pixel where all colours have it.
#[derive(Clone, Copy)]
enum Nodata {
    None,
    /// A value of decoded colours, which are as they are stored.
    Decoded(u16),
    /// A value of this many stored samples, of which decoding makes others: a palette's colours,
    /// or 12 bits as 16.
    Stored(f64, usize),
}

#[derive(Clone, Copy, PartialEq)]
enum Alpha {
    Straight,
    Premultiplied,
}

impl TiffPhoto {
    pub(super) fn open(path: &Path) -> Result<Self, TerrainError> {
        let file = GeoTiff::open(path)?;
        let mut notes = Vec::new();
        let model = file.colour_model()?;
        let recoloured = matches!(
            model,
            ColorModel::Palette { .. }
                | ColorModel::Grayscale {
                    white_is_zero: true,
                    ..
                }
        );
        let is_palette = matches!(model, ColorModel::Palette { .. });
        let (coloured, extra) = match model {
            ColorModel::Grayscale { extra_samples, .. } => (1, extra_samples),
            ColorModel::Rgb { extra_samples }
            | ColorModel::Palette { extra_samples, .. }
            | ColorModel::Cmyk { extra_samples }
            | ColorModel::YCbCr { extra_samples, .. }
            | ColorModel::CieLab { extra_samples } => (3, extra_samples),
            ColorModel::Separated { .. } | ColorModel::TransparencyMask => {
                return Err(TerrainError::unsupported(
                    path,
                    "has inks or a mask in place of colours",
                    format!(
                        "convert it with: gdal_translate -expand rgb {} photo.tif",
                        path.display()
                    ),
                ));
            }
        };
        let alpha = extra.iter().position(|sample| {
            matches!(
                sample,
                ExtraSample::AssociatedAlpha | ExtraSample::UnassociatedAlpha
            )
        });
        let colours = if coloured == 3 {
            [0, 1, 2]
        } else if extra.len() >= 2 && alpha.is_none_or(|at| at >= 2) {
            notes.push("the first three bands are taken for red, green and blue".to_owned());
            [0, 1, 2]
        } else {
            [0; 3]
        };
        let alpha = alpha.map(|at| {
            let kind = if matches!(extra[at], ExtraSample::AssociatedAlpha) {
                Alpha::Premultiplied
            } else {
                Alpha::Straight
            };
            (coloured + at, kind)
        });
        let nodata = file.header().bands[0]
            .nodata
            .filter(|value| (0.0..=65_535.0).contains(value) && value.fract() == 0.0);
        let nodata = match nodata {
            None => Nodata::None,
            Some(value) if recoloured || file.is_packed() => {
                let one = is_palette || colours == [0; 3];
                Nodata::Stored(value, if one { 1 } else { 3 })
            }
            Some(value) => Nodata::Decoded(value as u16),
        };
        let layout = Channels { colours, alpha };
        let mut photo = Self {
            file,
            layout,
            nodata,
            stretch: None,
            notes,
        };
        photo.find_stretch()?;
        Ok(photo)
    }

    /// Rows that make up one chunk.
    fn rows_at_once(&self) -> u32 {
        let header = self.file.header();
        (CHUNK_BYTES / (header.width * header.bands.len().max(3) as u32 * 2).max(1)).max(1)
    }

    /// The range that holds nearly all samples of a 16-bit photograph's pixels.
    fn find_stretch(&mut self) -> Result<(), TerrainError> {
        let [_, rows] = self.size();
        let mut counts = Counts::new();
        for first in (0..rows).step_by(self.rows_at_once() as usize) {
            let chunk = first..rows.min(first + self.rows_at_once());
            let colours = self.file.read_colours(chunk.clone())?;
            let Samples::Sixteen(samples) = colours.samples else {
                return Ok(());
            };
            let missing = self.missing(&chunk)?;
            for (pixel, missing) in samples.chunks_exact(colours.channels).zip(missing) {
                if let Some(colours) = self.colours(pixel).filter(|_| !missing) {
                    colours.iter().for_each(|&colour| counts.add(colour as u16));
                }
            }
        }
        let stretch = counts.stretch();
        self.stretch = Some(stretch);
        self.notes.push(stretch.note());
        Ok(())
    }

    /// Which pixels of some rows the file leaves out, masks, or calls none by what it stores.
    fn missing(&mut self, rows: &Range<u32>) -> Result<Vec<bool>, TerrainError> {
        let width = self.file.header().width as usize;
        let mut missing = vec![false; rows.len() * width];
        if let Nodata::Stored(nodata, colours) = self.nodata {
            let mut stored = Vec::new();
            self.file
                .read_rows(rows.clone(), BandChoice::All, &mut stored)?;
            let depth = stored.len() / missing.len();
            for (missing, samples) in missing.iter_mut().zip(stored.chunks_exact(depth)) {
                *missing = samples.iter().take(colours).all(|&value| value == nodata);
            }
        }
        for (col, row) in self.file.uncovered(rows)? {
            missing[(row - rows.start) as usize * width + col as usize] = true;
        }
        Ok(missing)
    }

    /// A pixel's colours by its channels; `None` where these make it transparent or none.
    fn colours<T: Copy + Into<u16>>(&self, channels: &[T]) -> Option<[f32; 3]> {
        let colours = self.layout.colours.map(|channel| channels[channel].into());
        let full = if size_of::<T>() == 1 { 255 } else { u16::MAX };
        let cover = self
            .layout
            .alpha
            .map_or(full, |(channel, _)| channels[channel].into());
        let none = matches!(self.nodata, Nodata::Decoded(none) if colours == [none; 3]);
        if none || cover < full / 2 {
            return None;
        }
        let premultiplied = matches!(self.layout.alpha, Some((_, Alpha::Premultiplied)));
        Some(colours.map(|colour| {
            let colour = f32::from(colour);
            if premultiplied {
                colour * f32::from(full) / f32::from(cover)
            } else {
                colour
            }
        }))
    }

    fn pixel<T: Copy + Into<u16>>(&self, channels: &[T]) -> Pixel {
        let shown = |colour| self.stretch.map_or(colour, |stretch| stretch.shown(colour));
        self.colours(channels)
            .map_or([0; 4], |colours| covered(colours.map(shown)))
    }
}

impl PhotoFile for TiffPhoto {
    fn size(&self) -> [u32; 2] {
        let header = self.file.header();
        [header.width, header.height]
    }

    fn read_rows(&mut self, first: u32, into: &mut [Pixel]) -> Result<(), TerrainError> {
        let width = self.file.header().width as usize;
        let mut row = first;
        for chunk in into.chunks_mut(self.rows_at_once() as usize * width) {
            let rows = row..row + (chunk.len() / width) as u32;
            row = rows.end;
            let colours = self.file.read_colours(rows.clone())?;
            let channels = colours.channels;
            match colours.samples {
                Samples::Eight(samples) => {
                    for (pixel, samples) in chunk.iter_mut().zip(samples.chunks_exact(channels)) {
                        *pixel = self.pixel(samples);
                    }
                }
                Samples::Sixteen(samples) => {
                    for (pixel, samples) in chunk.iter_mut().zip(samples.chunks_exact(channels)) {
                        *pixel = self.pixel(samples);
                    }
                }
            }
            for (pixel, missing) in chunk.iter_mut().zip(self.missing(&rows)?) {
                if missing {
                    *pixel = [0; 4];
                }
            }
        }
        Ok(())
    }

    fn place(&self) -> Place {
        let header = self.file.header();
        Place {
            transform: header.transform,
            crs: header.crs.clone(),
        }
    }

    fn notes(&self) -> Vec<String> {
        self.notes
            .iter()
            .chain(&self.file.header().notes)
            .cloned()
            .collect()
    }
}
