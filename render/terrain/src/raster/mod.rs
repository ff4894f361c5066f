//! Rasters in files: what their headers say and their rows, whatever the format.

mod ascii_grid;
mod geotiff;
mod hgt;
mod prj;

pub(crate) use geotiff::{GeoTiff, Samples};
pub(crate) use prj::{WorldFile, sidecar};

use crate::{Crs, TerrainError};
use serde::Serialize;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Largest side that is read, in cells.
const MAX_SIDE: u64 = 1 << 17;
/// Largest number of cells that is read: two GiB of heights.
const MAX_CELLS: u64 = 1 << 29;
/// Bytes of decoded values to ask of a reader at once.
const CHUNK_BYTES: usize = 8 << 20;

/// The type of a file's samples, named as GDAL does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum SampleType {
    /// 8 bits, unsigned.
    Byte,
    /// 8 bits, signed.
    Int8,
    /// 16 bits, unsigned.
    UInt16,
    /// 16 bits, signed.
    Int16,
    /// 32 bits, unsigned.
    UInt32,
    /// 32 bits, signed.
    Int32,
    /// 32 bits, floating point.
    Float32,
    /// 64 bits, floating point.
    Float64,
}

impl SampleType {
    /// Whether samples are whole numbers.
    #[must_use]
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::Float32 | Self::Float64)
    }

    /// Bytes of one sample.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Byte | Self::Int8 => 1,
            Self::UInt16 | Self::Int16 => 2,
            Self::UInt32 | Self::Int32 | Self::Float32 => 4,
            Self::Float64 => 8,
        }
    }

    /// Whether a stored value is the value that stands for "none".
    pub(crate) fn is_nodata(self, value: f64, nodata: Option<f64>) -> bool {
        match (self, nodata) {
            (_, _) if !value.is_finite() => true,
            (_, None) => false,
            // The value was written in decimal, so the last bits may differ.
            (Self::Float32, Some(nodata)) => {
                let nodata = (nodata as f32).clamp(f32::MIN, f32::MAX);
                let value = value as f32;
                value == nodata || (value.to_bits().abs_diff(nodata.to_bits())) <= 2
            }
            (_, Some(nodata)) => value == nodata,
        }
    }
}

/// What a sample's value stands for, named as GDAL does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[expect(missing_docs, reason = "the names are the colours")]
pub enum ColourRole {
    Undefined,
    Gray,
    Red,
    Green,
    Blue,
    Alpha,
    Palette,
}

/// Whether a file's coordinates name the cell's corner or the sample itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum PixelIs {
    /// The value holds for an area; the tie point is its corner.
    Area,
    /// The value is a sample; the tie point is the sample's.
    Point,
}

/// One band, as its file describes it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Band {
    pub nodata: Option<f64>,
    pub colour: ColourRole,
    pub unit: Option<String>,
    /// Stored value to real value, where the file says: real = stored · scale + offset.
    pub scale: Option<f64>,
    pub offset: Option<f64>,
}

impl Band {
    fn plain(colour: ColourRole, nodata: Option<f64>, unit: Option<&str>) -> Self {
        Self {
            nodata,
            colour,
            unit: unit.map(str::to_owned),
            scale: None,
            offset: None,
        }
    }
}

/// What a file says about its raster, in GDAL's terms.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    pub driver: &'static str,
    pub width: u32,
    pub height: u32,
    pub sample: SampleType,
    pub bands: Vec<Band>,
    pub crs: Option<Crs>,
    /// Name and code of the vertical CRS, where the file names one.
    pub vertical_crs: Option<String>,
    /// GDAL's six coefficients, from the outer corner of the north-west cell; `None` where the
    /// file does not say where it lies.
    pub transform: Option<[f64; 6]>,
    pub pixel_is: Option<PixelIs>,
    pub compression: Option<String>,
    pub block: [u32; 2],
    pub overviews: usize,
    /// What a reader should tell the user.
    pub notes: Vec<String>,
}

impl Header {
    /// West, south, east, north outer edges of a north-up raster.
    pub(crate) fn extent(&self, path: &Path) -> Result<[f64; 4], TerrainError> {
        let transform = self.transform.ok_or_else(|| TerrainError::NoGeoreference {
            path: path.to_owned(),
        })?;
        let [west, dx, skew_x, north, skew_y, dy] = transform;
        let sound = dx > 0.0 && dy < 0.0 && skew_x == 0.0 && skew_y == 0.0;
        if !sound || !transform.iter().all(|value| value.is_finite()) {
            return Err(TerrainError::Rotated {
                path: path.to_owned(),
                transform,
            });
        }
        let (east, south) = (
            west + dx * f64::from(self.width),
            north + dy * f64::from(self.height),
        );
        if !(east > west && south < north && east.is_finite() && south.is_finite()) {
            return Err(TerrainError::damaged(
                path,
                "the georeference",
                format!("cells of {dx} by {dy} at {west}, {north} have no extent"),
            ));
        }
        Ok([west, south, east, north])
    }

    /// Rows to read at once, given `bytes` for one.
    pub(crate) fn rows_at_once(&self) -> u32 {
        let row = self.width as usize * self.bands.len() * size_of::<f64>();
        ((CHUNK_BYTES / row.max(1)) as u32).clamp(1, self.height)
    }
}

/// A raster in a file.
pub(crate) trait RasterFile {
    /// What the file says about it.
    fn header(&self) -> &Header;

    /// Reads whole rows, counted from the north, into `into`: `bands` samples a cell, as stored.
    ///
    /// Rows must be asked for in order and at most once.
    fn read_rows(
        &mut self,
        rows: Range<u32>,
        bands: BandChoice,
        into: &mut Vec<f64>,
    ) -> Result<(), TerrainError>;
}

/// Which bands of a raster to read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BandChoice {
    First,
    All,
}

/// Opens a raster of any format that is read.
pub(crate) fn open_raster(path: &Path) -> Result<Box<dyn RasterFile>, TerrainError> {
    let (start, length) = first_bytes(path)?;
    if is_tiff(&start) {
        return Ok(Box::new(GeoTiff::open(path)?));
    }
    let extension = path
        .extension()
        .and_then(|text| text.to_str())
        .unwrap_or_default();
    if extension.eq_ignore_ascii_case("hgt") {
        return Ok(Box::new(hgt::Hgt::open(path, length)?));
    }
    if ascii_grid::looks_like_one(&start) {
        return Ok(Box::new(ascii_grid::AsciiGrid::open(path, length)?));
    }
    let found = match start.as_slice() {
        [0x89, b'P', b'N', b'G', ..] => "a PNG picture",
        [0xff, 0xd8, 0xff, ..] => "a JPEG picture",
        [b'P', b'K', ..] => "a zip archive (unpack it first)",
        [0x1f, 0x8b, ..] => "a gzip file (unpack it first)",
        _ => "of an unknown format",
    };
    Err(TerrainError::UnknownFormat {
        path: path.to_owned(),
        found: found.to_owned(),
    })
}

/// Whether a file starts as TIFF or BigTIFF in either byte order does.
pub(crate) fn is_tiff(start: &[u8]) -> bool {
    matches!(
        start,
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..]
    )
}

/// The first bytes of a file that has any, and its length.
pub(crate) fn first_bytes(path: &Path) -> Result<(Vec<u8>, u64), TerrainError> {
    let io = |error| TerrainError::io(path, error);
    // Looked at before it is opened: that would wait for a pipe's other end.
    let metadata = std::fs::metadata(path).map_err(io)?;
    if !metadata.is_file() {
        let (found, remedy) = if metadata.is_dir() {
            ("a folder", "name a file in it")
        } else {
            (
                "a pipe or a device",
                "write what comes out of it to a file first",
            )
        };
        return Err(TerrainError::NoFile {
            path: path.to_owned(),
            found,
            remedy,
        });
    }
    let file = std::fs::File::open(path).map_err(io)?;
    let mut start = Vec::new();
    file.take(4096).read_to_end(&mut start).map_err(io)?;
    if start.is_empty() {
        return Err(TerrainError::Empty {
            path: path.to_owned(),
        });
    }
    Ok((start, metadata.len()))
}

/// Refuses sizes that are no terrain or that no memory here is meant for.
pub(crate) fn check_size(path: &Path, cols: u64, rows: u64) -> Result<(), TerrainError> {
    if cols < 1 || rows < 1 {
        return Err(TerrainError::TooSmall {
            path: path.to_owned(),
            cols,
            rows,
            needed: "there must be at least one of each",
        });
    }
    let limit = if cols > MAX_SIDE || rows > MAX_SIDE {
        format!("a side of at most {MAX_SIDE} is read")
    } else if cols * rows > MAX_CELLS {
        format!("at most {MAX_CELLS} cells are read")
    } else {
        return Ok(());
    };
    Err(TerrainError::Size {
        path: path.to_owned(),
        cols,
        rows,
        limit,
    })
}

/// A path with another extension, in the case in which it is there, or `None`.
fn beside(path: &Path, extensions: &[&str]) -> Option<PathBuf> {
    extensions
        .iter()
        .flat_map(|extension| [(*extension).to_owned(), extension.to_ascii_uppercase()])
        .map(|extension| path.with_extension(extension))
        .find(|candidate| candidate.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodata_is_recognised_within_the_rounding_of_its_text() {
        let float = SampleType::Float32;
        let lowest = f64::from(f32::MIN);
        assert!(float.is_nodata(lowest, Some(-3.402_823_4e38)));
        assert!(float.is_nodata(lowest, Some(-3.402_824e38)));
        assert!(!float.is_nodata(-32_766.0, Some(-32_767.0)));
        assert!(float.is_nodata(f64::NAN, None) && float.is_nodata(f64::INFINITY, Some(0.0)));
        assert!(SampleType::Int16.is_nodata(-32_768.0, Some(-32_768.0)));
        assert!(!SampleType::Byte.is_nodata(255.0, Some(-1.0)));
        assert!(!SampleType::Byte.is_nodata(0.0, None));
        // Neighbouring whole numbers are not within rounding of each other.
        assert!(
            !float.is_nodata(1.0, Some(0.0))
                && !float.is_nodata(f64::from(f32::MIN_POSITIVE), Some(0.0))
        );
    }

    #[test]
    fn absurd_sizes_are_refused() {
        let path = Path::new("x.tif");
        for (cols, rows) in [
            (0, 5),
            (1_000_000, 1_000_000),
            (u64::MAX, 1),
            (131_072, 131_072),
        ] {
            assert!(check_size(path, cols, rows).is_err(), "{cols} by {rows}");
        }
        assert!(check_size(path, 16_385, 16_385).is_ok());
    }
}
