//! Photographs in TIFF files.

use super::stretch::{Counts, Stretch, covered};
use super::{PhotoFile, Pixel, Place};
use crate::TerrainError;
use crate::raster::{GeoTiff, RasterFile, Samples};
use std::path::Path;
use tiff_reader::{ColorModel, ExtraSample};

/// Bytes of decoded channels to ask of the reader at once.
const CHUNK_BYTES: u32 = 8 << 20;

pub(super) struct TiffPhoto {
    file: GeoTiff,
    layout: Channels,
    /// The sample value that stands for no pixel where all colours have it.
    nodata: Option<u16>,
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

#[derive(Clone, Copy, PartialEq)]
enum Alpha {
    Straight,
    Premultiplied,
}

impl TiffPhoto {
    pub(super) fn open(path: &Path) -> Result<Self, TerrainError> {
        let file = GeoTiff::open(path)?;
        let mut notes = Vec::new();
        let (coloured, extra) = match file.colour_model()? {
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
            .filter(|value| (0.0..=65_535.0).contains(value) && value.fract() == 0.0)
            .map(|value| value as u16);
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

    /// The range that holds nearly all samples of a 16-bit photograph.
    fn find_stretch(&mut self) -> Result<(), TerrainError> {
        let [_, rows] = self.size();
        let mut counts = Counts::new();
        for first in (0..rows).step_by(self.rows_at_once() as usize) {
            let chunk = first..rows.min(first + self.rows_at_once());
            let colours = self.file.read_colours(chunk)?;
            let Samples::Sixteen(samples) = colours.samples else {
                return Ok(());
            };
            for pixel in samples.chunks_exact(colours.channels) {
                let colours = self.layout.colours.map(|channel| pixel[channel]);
                if !colours.iter().all(|&colour| Some(colour) == self.nodata) {
                    colours.iter().for_each(|&colour| counts.add(colour));
                }
            }
        }
        let stretch = counts.stretch();
        self.stretch = Some(stretch);
        self.notes.push(stretch.note());
        Ok(())
    }

    fn pixel<T: Copy + Into<u16>>(&self, channels: &[T]) -> Pixel {
        let colours = self.layout.colours.map(|channel| channels[channel].into());
        let full = if self.stretch.is_some() {
            u16::MAX
        } else {
            255
        };
        let cover = self
            .layout
            .alpha
            .map_or(full, |(channel, _)| channels[channel].into());
        let missing = self.nodata.is_some() && colours.iter().all(|&c| Some(c) == self.nodata);
        if missing || cover < full / 2 {
            return [0; 4];
        }
        let premultiplied = matches!(self.layout.alpha, Some((_, Alpha::Premultiplied)));
        covered(colours.map(|colour| {
            let mut colour = f32::from(colour);
            if premultiplied {
                colour *= f32::from(full) / f32::from(cover);
            }
            self.stretch.map_or(colour, |stretch| stretch.shown(colour))
        }))
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
            for (col, at) in self.file.uncovered(&rows)? {
                chunk[(at - rows.start) as usize * width + col as usize] = [0; 4];
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
