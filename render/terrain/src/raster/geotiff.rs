//! GeoTIFF and plain TIFF: tags to a header, strips and tiles to rows.

mod blocks;
mod metadata;

use super::{
    Band, BandChoice, Header, PixelIs, RasterFile, SampleType, WorldFile, check_size, sidecar,
};
use crate::crs::{VerticalCrs, crs_from_geo_keys};
use crate::{Crs, TerrainError};
use blocks::Blocks;
use geotiff_reader::transform::GeoTransform;
use geotiff_reader::{Error as GeoError, GeoTiffFile};
use std::ops::Range;
use std::path::{Path, PathBuf};
use tiff_reader::{ColorModel, Ifd, OpenOptions, ParseBudgets, TiffFile, TiffSample};

const MIB: usize = 1 << 20;
/// A file with more is not meant to be read as one terrain.
const MAX_IMAGES: usize = 1024;

/// An open TIFF file.
pub(crate) struct GeoTiff {
    path: PathBuf,
    tiff: Tiff,
    /// Which of the file's images is the full one.
    image: usize,
    /// Which is its mask, if any.
    mask: Option<usize>,
    blocks: Blocks,
    header: Header,
}

/// A TIFF file with or without geographic tags.
enum Tiff {
    Geo(Box<GeoTiffFile>),
    Plain(Box<TiffFile>),
}

impl Tiff {
    fn file(&self) -> &TiffFile {
        match self {
            Self::Geo(geo) => geo.tiff(),
            Self::Plain(plain) => plain,
        }
    }

    fn open(path: &Path, bytes: Option<&[u8]>, options: OpenOptions) -> Result<Self, TerrainError> {
        let geo = match bytes {
            None => GeoTiffFile::open_with_options(path, options),
            Some(bytes) => GeoTiffFile::from_bytes_with_options(bytes.to_vec(), options),
        };
        match geo {
            Ok(geo) => Ok(Self::Geo(Box::new(geo))),
            Err(GeoError::NotGeoTiff) if bytes.is_none() => {
                TiffFile::open_with_options(path, options)
                    .map(|plain| Self::Plain(Box::new(plain)))
                    .map_err(|error| tiff_error(path, "its header", &error))
            }
            Err(GeoError::Tiff(error)) => Err(tiff_error(path, "its header", &error)),
            Err(error) => Err(TerrainError::damaged(
                path,
                "its geographic tags",
                error.to_string(),
            )),
        }
    }
}

impl GeoTiff {
    /// Reads the header and checks that what it announces can be there.
    pub(crate) fn open(path: &Path) -> Result<Self, TerrainError> {
        let length = std::fs::metadata(path)
            .map_err(|error| TerrainError::io(path, error))?
            .len();
        Self::new(path, None, length)
    }

    /// Reads a GeoTIFF that is no file; `name` is for messages.
    pub(crate) fn from_bytes(name: &Path, bytes: &[u8]) -> Result<Self, TerrainError> {
        Self::new(name, Some(bytes), bytes.len() as u64)
    }

    fn new(path: &Path, bytes: Option<&[u8]>, length: u64) -> Result<Self, TerrainError> {
        let mut options = options(length);
        let tiff = Tiff::open(path, bytes, options)?;
        let image = match &tiff {
            Tiff::Geo(geo) => geo.base_ifd_index(),
            Tiff::Plain(_) => 0,
        };
        let ifd = tiff
            .file()
            .ifd(image)
            .map_err(|_| TerrainError::damaged(path, "its first directory", "there is no image"))?;
        check_size(path, u64::from(ifd.width()), u64::from(ifd.height()))?;
        let layout = ifd
            .raster_layout()
            .map_err(|error| tiff_error(path, "the image's tags", &error))?;
        let sample =
            sample_type(layout.sample_format, layout.bits_per_sample).ok_or_else(|| {
                TerrainError::unsupported(
                    path,
                    format!(
                        "has samples of {} bits in format {}",
                        layout.bits_per_sample, layout.sample_format
                    ),
                    format!(
                        "convert it with: gdal_translate -ot Float32 {} converted.tif",
                        path.display()
                    ),
                )
            })?;
        let blocks = Blocks::check(path, ifd, length, sample.bytes())?;
        let mask = mask(path, tiff.file(), ifd, length)?;
        let mut header = header(path, &tiff, ifd, sample, &blocks)?;
        if bytes.is_none() {
            if header.transform.is_none() {
                header.transform = WorldFile::beside(path)?.map(|world| world.transform);
            }
            if header.crs.is_none() {
                header.crs = sidecar(path)?;
            }
        }
        // Rows are read in order, so one row of blocks is all that is worth keeping.
        let row_of_blocks = blocks.row_bytes();
        options.block_cache_bytes = (row_of_blocks + row_of_blocks / 8).clamp(MIB, 192 * MIB);
        options.block_cache_slots = 4 * (header.width as usize / blocks.width as usize + 2);
        let tiff = Tiff::open(path, bytes, options)?;
        Ok(Self {
            path: path.to_owned(),
            tiff,
            image,
            mask,
            blocks,
            header,
        })
    }

    /// The kinds of colour that the samples mean.
    pub(crate) fn colour_model(&self) -> Result<ColorModel, TerrainError> {
        self.ifd()?
            .color_model()
            .map_err(|error| tiff_error(&self.path, "its colour tags", &error))
    }

    /// Whether samples are stored in other widths than whole bytes, which colours do not keep.
    pub(crate) fn is_packed(&self) -> bool {
        self.ifd()
            .and_then(|ifd| {
                ifd.bits_per_sample()
                    .map_err(|error| tiff_error(&self.path, "its sample sizes", &error))
            })
            .is_ok_and(|bits| bits.iter().any(|bits| !bits.is_multiple_of(8)))
    }

    /// Reads whole rows as colours: channels a pixel, 16-bit samples as they are.
    pub(crate) fn read_colours(&self, rows: Range<u32>) -> Result<Colours, TerrainError> {
        let ifd = self.ifd()?;
        let layout = ifd
            .decoded_raster_layout()
            .map_err(|error| tiff_error(&self.path, "its colour tags", &error))?;
        let (first, count, width) = (rows.start as usize, rows.len(), layout.width);
        let place = || rows_place(&rows);
        let file = self.tiff.file();
        let samples = match (layout.sample_format, layout.bits_per_sample) {
            (1, ..=8) => file
                .read_decoded_window::<u8>(self.image, first, 0, count, width)
                .map(|array| Samples::Eight(array.into_raw_vec_and_offset().0)),
            (1, ..=16) => file
                .read_decoded_window::<u16>(self.image, first, 0, count, width)
                .map(|array| Samples::Sixteen(array.into_raw_vec_and_offset().0)),
            _ => {
                return Err(TerrainError::unsupported(
                    &self.path,
                    "is no photograph of 8 or 16 bits a channel",
                    format!(
                        "convert it with: gdal_translate -ot Byte -scale {} photo.tif",
                        self.path.display()
                    ),
                ));
            }
        }
        .map_err(|error| tiff_error(&self.path, &place(), &error))?;
        Ok(Colours {
            samples,
            channels: layout.samples_per_pixel,
        })
    }

    /// Column and row of each cell in these rows that the file leaves out or masks.
    pub(crate) fn uncovered(&self, rows: &Range<u32>) -> Result<Vec<(u32, u32)>, TerrainError> {
        let mut cells = Vec::new();
        for (block_rows, block_cols) in self.blocks.left_out(rows, self.header.width) {
            for row in block_rows {
                cells.extend(block_cols.clone().map(|col| (col, row)));
            }
        }
        if let Some(mask) = self.mask {
            let (first, count, width) = (rows.start, rows.len(), self.header.width as usize);
            let cover = self
                .tiff
                .file()
                .read_window::<u8>(mask, first as usize, 0, count, width)
                .map_err(|error| tiff_error(&self.path, "its mask", &error))?;
            let hidden = cover.iter().enumerate().filter(|(_, cover)| **cover == 0);
            cells.extend(hidden.map(|(at, _)| ((at % width) as u32, first + (at / width) as u32)));
        }
        Ok(cells)
    }

    fn ifd(&self) -> Result<&Ifd, TerrainError> {
        self.tiff
            .file()
            .ifd(self.image)
            .map_err(|error| tiff_error(&self.path, "its directory", &error))
    }

    fn read<T: TiffSample + Into<f64>>(
        &self,
        rows: &Range<u32>,
        bands: BandChoice,
        into: &mut Vec<f64>,
    ) -> Result<(), TerrainError> {
        let file = self.tiff.file();
        let (first, count, width) = (rows.start as usize, rows.len(), self.header.width as usize);
        let window = match bands {
            BandChoice::First if self.header.bands.len() > 1 => {
                file.read_band_window::<T>(self.image, 0, first, 0, count, width)
            }
            _ => file.read_window::<T>(self.image, first, 0, count, width),
        }
        .map_err(|error| tiff_error(&self.path, &rows_place(rows), &error))?;
        into.clear();
        into.extend(
            window
                .into_raw_vec_and_offset()
                .0
                .into_iter()
                .map(Into::into),
        );
        Ok(())
    }
}

/// Decoded colours of some rows.
pub(crate) struct Colours {
    pub samples: Samples,
    pub channels: usize,
}

/// Channels one after another, pixel by pixel.
pub(crate) enum Samples {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
}

impl RasterFile for GeoTiff {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read_rows(
        &mut self,
        rows: Range<u32>,
        bands: BandChoice,
        into: &mut Vec<f64>,
    ) -> Result<(), TerrainError> {
        match self.header.sample {
            SampleType::Byte => self.read::<u8>(&rows, bands, into),
            SampleType::Int8 => self.read::<i8>(&rows, bands, into),
            SampleType::UInt16 => self.read::<u16>(&rows, bands, into),
            SampleType::Int16 => self.read::<i16>(&rows, bands, into),
            SampleType::UInt32 => self.read::<u32>(&rows, bands, into),
            SampleType::Int32 => self.read::<i32>(&rows, bands, into),
            SampleType::Float32 => self.read::<f32>(&rows, bands, into),
            SampleType::Float64 => self.read::<f64>(&rows, bands, into),
        }?;
        // What is left out stands for nodata; where the file names no such value, a block left
        // out stands for 0 and a masked cell for nothing.
        let width = self.header.width as usize;
        let depth = into.len() / (rows.len() * width);
        let none = if self.mask.is_some() { f64::NAN } else { 0.0 };
        for (col, row) in self.uncovered(&rows)? {
            let at = ((row - rows.start) as usize * width + col as usize) * depth;
            for (value, band) in into[at..at + depth].iter_mut().zip(&self.header.bands) {
                *value = band.nodata.unwrap_or(none);
            }
        }
        Ok(())
    }
}

/// The mask over the full image, where the file has one.
fn mask(
    path: &Path,
    tiff: &TiffFile,
    image: &Ifd,
    length: u64,
) -> Result<Option<usize>, TerrainError> {
    const NEW_SUBFILE_TYPE: u16 = 254;
    let mask = tiff.ifds().iter().position(|ifd| {
        let flags = ifd
            .tag(NEW_SUBFILE_TYPE)
            .and_then(|tag| tag.value.as_u64())
            .unwrap_or(0);
        flags & 0b101 == 0b100
            && (ifd.width(), ifd.height()) == (image.width(), image.height())
            && ifd.samples_per_pixel() == 1
            && ifd
                .bits_per_sample()
                .is_ok_and(|bits| bits.iter().all(|&bits| bits <= 8))
    });
    if let Some(index) = mask {
        Blocks::check(path, &tiff.ifds()[index], length, 1)?;
    }
    Ok(mask)
}

fn options(length: u64) -> OpenOptions {
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    let metadata = length.saturating_add(MIB).min(512 * MIB);
    OpenOptions {
        block_cache_bytes: MIB,
        block_cache_slots: 16,
        parse_budgets: ParseBudgets {
            max_ifds: MAX_IMAGES,
            max_tag_value_bytes: metadata,
            max_metadata_value_bytes: metadata,
            ..ParseBudgets::default()
        },
        decode_output_bytes: 512 * MIB,
    }
}

fn sample_type(format: u16, bits: u16) -> Option<SampleType> {
    Some(match (format, bits) {
        (1, 1..=8) => SampleType::Byte,
        (1, 9..=16) => SampleType::UInt16,
        (1, 32) => SampleType::UInt32,
        (2, 8) => SampleType::Int8,
        (2, 16) => SampleType::Int16,
        (2, 32) => SampleType::Int32,
        (3, 32) => SampleType::Float32,
        (3, 64) => SampleType::Float64,
        _ => return None,
    })
}

fn header(
    path: &Path,
    tiff: &Tiff,
    ifd: &Ifd,
    sample: SampleType,
    blocks: &Blocks,
) -> Result<Header, TerrainError> {
    let metadata = metadata::Metadata::of(ifd);
    let roles = metadata::colour_roles(ifd);
    let mut header = Header {
        driver: "GTiff",
        width: ifd.width(),
        height: ifd.height(),
        sample,
        bands: Vec::new(),
        crs: None,
        vertical_crs: None,
        transform: None,
        pixel_is: Some(PixelIs::Area),
        compression: metadata::compression_name(ifd),
        block: [blocks.width, blocks.height],
        overviews: 0,
        notes: Vec::new(),
    };
    let text = match tiff {
        Tiff::Geo(geo) => geo.nodata(),
        Tiff::Plain(_) => metadata::nodata_text(ifd),
    };
    let nodata = text.map(|text| metadata::nodata(path, text)).transpose()?;
    if let Tiff::Geo(geo) = tiff {
        header.overviews = geo.overview_count();
        header.transform = geo.transform().map(coefficients);
        if geo.crs().raster_type == 2 {
            header.pixel_is = Some(PixelIs::Point);
        }
        header.crs = crs_from_geo_keys(geo.geokeys()).map_err(|feature| {
            TerrainError::unsupported(
                path,
                feature,
                format!(
                    "warp it with: gdalwarp -t_srs EPSG:CODE {} warped.tif",
                    path.display()
                ),
            )
        })?;
        if let Some(crs) = &header.crs
            && crs.is_geographic()
            && crs.epsg.is_some_and(|code| Crs::from_epsg(code).is_none())
        {
            header.notes.push(format!(
                "{crs} is not in the table of systems; its ellipsoid is taken from the file"
            ));
        }
    }
    header.bands = roles
        .into_iter()
        .enumerate()
        .map(|(index, colour)| Band {
            nodata,
            colour,
            unit: metadata.of_band("unittype", index).map(str::to_owned),
            scale: metadata.number("scale", index),
            offset: metadata.number("offset", index),
        })
        .collect();
    if let Tiff::Geo(geo) = tiff {
        add_vertical_crs(path, &mut header, VerticalCrs::from_geo_keys(geo.geokeys()));
    }
    Ok(header)
}

/// Takes the unit of heights from the vertical CRS where GDAL's metadata names none, and tells
/// what is guessed.
fn add_vertical_crs(path: &Path, header: &mut Header, vertical: VerticalCrs) {
    let Some(band) = header.bands.first_mut() else {
        return;
    };
    if band.unit.is_none() {
        band.unit = vertical.unit;
    }
    if let Some(name) = &vertical.name {
        if band.unit.is_none() {
            header.notes.push(format!(
                "the unit of the vertical CRS, {name}, is not known here; heights are taken for \
                 metres (if they are in feet, say so with: gdal_edit.py -units ft {})",
                path.display()
            ));
        }
        if vertical.is_depth && band.scale.is_none_or(|scale| scale > 0.0) {
            header.notes.push(format!(
                "the vertical CRS, {name}, counts downwards, but values are taken for heights \
                 (turn them with: gdal_edit.py -scale -1 {})",
                path.display()
            ));
        }
    }
    header.vertical_crs = vertical.name;
}

fn coefficients(transform: &GeoTransform) -> [f64; 6] {
    [
        transform.origin_x,
        transform.pixel_width,
        transform.skew_x,
        transform.origin_y,
        transform.skew_y,
        transform.pixel_height,
    ]
}

fn rows_place(rows: &Range<u32>) -> String {
    format!("rows {} to {}", rows.start, rows.end.saturating_sub(1))
}

fn tiff_error(path: &Path, place: &str, error: &tiff_reader::TiffError) -> TerrainError {
    use tiff_reader::TiffError as E;
    match error {
        // Half floats and complex numbers, which stay what they are unless told otherwise.
        E::UnsupportedBitsPerSample(_) | E::UnsupportedSampleFormat(_) => {
            TerrainError::unsupported(
                path,
                format!("has samples of another kind than is built in ({error})"),
                format!(
                    "convert it with: gdal_translate -ot Float32 {} converted.tif",
                    path.display()
                ),
            )
        }
        E::UnsupportedCompression(_)
        | E::UnsupportedPredictor(_)
        | E::UnsupportedPlanarConfiguration(_)
        | E::TypeMismatch { .. }
        | E::UnsupportedVersion(_) => TerrainError::unsupported(
            path,
            format!("needs something else than is built in ({error})"),
            format!(
                "convert it with: gdal_translate -co COMPRESS=DEFLATE {} converted.tif",
                path.display()
            ),
        ),
        other => TerrainError::damaged(path, place, other.to_string()),
    }
}
