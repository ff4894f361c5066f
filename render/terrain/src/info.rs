//! What a raster file holds: size, place, statistics over valid cells, named cells as stored.

mod text;

use crate::raster::{BandChoice, Header, RasterFile, open_raster};
use crate::{ColourRole, Crs, PixelIs, SampleType, TerrainError};
use serde::{Serialize, Serializer};
use std::path::Path;

/// A description of a raster file; serialises with GDAL's names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileInfo {
    /// The format, as GDAL names its driver.
    pub driver: &'static str,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Number of bands.
    pub bands: usize,
    /// Type of each band's samples.
    pub dtype: Vec<SampleType>,
    /// The CRS's name, with its EPSG code where the file names one.
    pub crs: Option<String>,
    /// The CRS's EPSG code, where the file names one.
    pub epsg: Option<u32>,
    /// The vertical CRS's name, with its EPSG code, where the file names one.
    pub vertical_crs: Option<String>,
    /// The CRS's parameters.
    pub crs_parameters: Option<Crs>,
    /// Six coefficients from columns and rows to coordinates, from the first cell's outer corner.
    pub geotransform: Option<[f64; 6]>,
    /// Whether the file's tie point is a cell's corner or the sample itself.
    pub area_or_point: Option<PixelIs>,
    /// The compression.
    pub compression: Option<String>,
    /// Columns and rows that are stored together.
    pub block: [u32; 2],
    /// Number of coarser copies in the file.
    pub overviews: usize,
    /// Outer edges of the outer cells, for a raster that lies along its map's axes.
    pub extent_outer_pixel_edges: Option<Extent>,
    /// Each band.
    pub band_info: Vec<BandInfo>,
    /// The cells that were asked for.
    pub samples: Vec<Sample>,
    /// What the user should know, such as guesses made.
    pub notes: Vec<String>,
}

/// A rectangle in a file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the names are the edges")]
pub struct Extent {
    pub minx: f64,
    pub miny: f64,
    pub maxx: f64,
    pub maxy: f64,
}

/// One band and its statistics over valid cells, of stored values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BandInfo {
    /// The value that stands for none.
    #[serde(serialize_with = "number_or_nan")]
    pub nodata: Option<f64>,
    /// What the band stands for.
    pub color: ColourRole,
    /// The unit of its values.
    pub unit: Option<String>,
    /// What stored values are to be multiplied by.
    pub scale: Option<f64>,
    /// What is to be added then.
    pub offset: Option<f64>,
    /// Number of cells with a value.
    pub valid: u64,
    /// Number of cells without.
    pub invalid: u64,
    /// Smallest valid value.
    pub min: Option<f64>,
    /// Largest valid value.
    pub max: Option<f64>,
    /// Mean of the valid values.
    pub mean: Option<f64>,
}

/// A cell as it is stored.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// Column from the west.
    pub col: u32,
    /// Row from the north.
    pub row: u32,
    /// Coordinates of the cell's centre, where the file says where it lies.
    pub x: Option<f64>,
    /// As `x`.
    pub y: Option<f64>,
    /// What is stored there.
    pub value: SampleValue,
    /// Whether no band has a value there.
    pub nodata: bool,
}

/// The value of a cell: a number, or one a band.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SampleValue {
    /// A whole number.
    Integer(i64),
    /// A number with a fraction; `null` in JSON where it is not finite.
    Real(f64),
    /// One value a band.
    Bands(Vec<SampleValue>),
}

/// Describes a raster file and names the values of `cells` (column, row from the north-west).
///
/// # Errors
/// [`TerrainError`], which names the file, the place in it and the remedy.
pub fn info(path: &Path, cells: &[(u32, u32)]) -> Result<FileInfo, TerrainError> {
    let mut raster = open_raster(path)?;
    let header = raster.header().clone();
    for &(col, row) in cells {
        if col >= header.width || row >= header.height {
            return Err(TerrainError::NoSuchCell {
                path: path.to_owned(),
                col,
                row,
                width: header.width,
                height: header.height,
            });
        }
    }
    let (statistics, values) = read_all(raster.as_mut(), &header, cells)?;
    // An ASCII grid shows only by its values whether they are whole numbers.
    let header = raster.header().clone();
    let samples = cells
        .iter()
        .zip(values)
        .map(|(&(col, row), values)| sample(&header, col, row, &values))
        .collect();
    Ok(describe(path, &header, &statistics, samples))
}

fn describe(
    path: &Path,
    header: &Header,
    statistics: &[Statistics],
    samples: Vec<Sample>,
) -> FileInfo {
    let extent = header
        .extent(path)
        .ok()
        .map(|[minx, miny, maxx, maxy]| Extent {
            minx,
            miny,
            maxx,
            maxy,
        });
    let band_info = header
        .bands
        .iter()
        .zip(statistics)
        .map(|(band, statistics)| {
            let known = |value| (statistics.valid > 0).then_some(value);
            BandInfo {
                nodata: band.nodata,
                color: band.colour,
                unit: band.unit.clone(),
                scale: band.scale,
                offset: band.offset,
                valid: statistics.valid,
                invalid: statistics.invalid,
                min: known(statistics.min),
                max: known(statistics.max),
                mean: known(statistics.mean()),
            }
        })
        .collect();
    FileInfo {
        driver: header.driver,
        width: header.width,
        height: header.height,
        bands: header.bands.len(),
        dtype: vec![header.sample; header.bands.len()],
        crs: header.crs.as_ref().map(ToString::to_string),
        epsg: header.crs.as_ref().and_then(|crs| crs.epsg),
        vertical_crs: header.vertical_crs.clone(),
        crs_parameters: header.crs.clone(),
        geotransform: header.transform,
        area_or_point: header.pixel_is,
        compression: header.compression.clone(),
        block: header.block,
        overviews: header.overviews,
        extent_outer_pixel_edges: extent,
        band_info,
        samples,
        notes: header.notes.clone(),
    }
}

struct Statistics {
    valid: u64,
    invalid: u64,
    min: f64,
    max: f64,
    sum: f64,
    /// What rounding has taken from the sum so far (Neumaier).
    lost: f64,
}

impl Statistics {
    fn add(&mut self, value: f64) {
        self.valid += 1;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        let sum = self.sum + value;
        self.lost += if self.sum.abs() >= value.abs() {
            (self.sum - sum) + value
        } else {
            (value - sum) + self.sum
        };
        self.sum = sum;
    }

    fn mean(&self) -> f64 {
        (self.sum + self.lost) / self.valid as f64
    }
}

/// Statistics of each band, and the stored values of each cell asked for.
fn read_all(
    raster: &mut dyn RasterFile,
    header: &Header,
    cells: &[(u32, u32)],
) -> Result<(Vec<Statistics>, Vec<Vec<f64>>), TerrainError> {
    let depth = header.bands.len();
    let mut statistics: Vec<_> = (0..depth)
        .map(|_| Statistics {
            valid: 0,
            invalid: 0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            sum: 0.0,
            lost: 0.0,
        })
        .collect();
    let mut found = vec![Vec::new(); cells.len()];
    let mut values = Vec::new();
    let at_once = header.rows_at_once();
    for first in (0..header.height).step_by(at_once as usize) {
        let rows = first..header.height.min(first + at_once);
        raster.read_rows(rows.clone(), BandChoice::All, &mut values)?;
        for pixel in values.chunks_exact(depth) {
            for ((&value, band), statistics) in pixel.iter().zip(&header.bands).zip(&mut statistics)
            {
                if header.sample.is_nodata(value, band.nodata) {
                    statistics.invalid += 1;
                } else {
                    statistics.add(value);
                }
            }
        }
        for (&(col, row), found) in cells.iter().zip(&mut found) {
            if rows.contains(&row) {
                let at = ((row - first) as usize * header.width as usize + col as usize) * depth;
                *found = values[at..at + depth].to_vec();
            }
        }
    }
    Ok((statistics, found))
}

fn sample(header: &Header, col: u32, row: u32, values: &[f64]) -> Sample {
    let number = |&value: &f64| {
        if header.sample.is_integer() && value.is_finite() {
            SampleValue::Integer(value as i64)
        } else {
            SampleValue::Real(value)
        }
    };
    let centre = header.transform.map(|[x, dx, skew_x, y, skew_y, dy]| {
        let (col, row) = (f64::from(col) + 0.5, f64::from(row) + 0.5);
        [x + col * dx + row * skew_x, y + col * skew_y + row * dy]
    });
    Sample {
        col,
        row,
        x: centre.map(|centre| centre[0]),
        y: centre.map(|centre| centre[1]),
        value: match values {
            [value] => number(value),
            values => SampleValue::Bands(values.iter().map(number).collect()),
        },
        nodata: values
            .iter()
            .zip(&header.bands)
            .all(|(&value, band)| header.sample.is_nodata(value, band.nodata)),
    }
}

/// JSON has no NaN, which is a common nodata value, so it is written as a text.
fn number_or_nan<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) if value.is_nan() => serializer.serialize_str("nan"),
        value => value.serialize(serializer),
    }
}
