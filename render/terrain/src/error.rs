//! What can go wrong between a file and the ground, said with file, place and remedy.

use crate::{GroundError, NoMemory};
use std::path::{Path, PathBuf};

/// Why a terrain, a photograph or a description of either could not be had.
#[derive(Debug, thiserror::Error)]
pub enum TerrainError {
    /// The name of the terrain makes no sense.
    #[error(transparent)]
    Source(#[from] crate::SourceError),
    /// The operating system refused a read.
    #[error("cannot read {}: {source}; check that the file is there and may be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A folder, or something that cannot be read here and there as a file can.
    #[error("{} is {found} and no file; {remedy}", path.display())]
    NoFile {
        /// What was named.
        path: PathBuf,
        /// What it is.
        found: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The file has no byte.
    #[error("{} is empty (0 bytes); copy or download it again", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file's first bytes and its name fit no format that is read.
    #[error(
        "{} is {found}, none of GeoTIFF, SRTM HGT (.hgt) and ESRI ASCII grid; \
         convert it with: gdal_translate {} terrain.tif", path.display(), path.display()
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// What the file seems to be.
        found: String,
    },
    /// The file contradicts itself or ends early.
    #[error("{} is damaged at {place}: {problem}; copy or download it again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Byte offset, tag, strip or key.
        place: String,
        /// What is wrong there.
        problem: String,
    },
    /// The file is sound, but needs something that is not read.
    #[error("{} {feature}, which is not read; {remedy}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it has or uses.
        feature: String,
        /// What to do instead.
        remedy: String,
    },
    /// Too few columns or rows for what the file is to be.
    #[error(
        "{} has {cols} columns by {rows} rows, but {needed}; take a larger part of what it was cut \
         from", path.display()
    )]
    TooSmall {
        /// The file.
        path: PathBuf,
        /// Columns it has.
        cols: u64,
        /// Rows it has.
        rows: u64,
        /// What it needs.
        needed: &'static str,
    },
    /// A size that no memory here is meant for.
    #[error(
        "{} announces {cols} columns by {rows} rows, but {limit}; \
         check the header, or cut a part out with: gdal_translate -srcwin 0 0 8192 8192 {} part.tif",
        path.display(), path.display()
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// Columns it announces.
        cols: u64,
        /// Rows it announces.
        rows: u64,
        /// The bound that is broken.
        limit: String,
    },
    /// An ASCII grid with something wrong on a line.
    #[error("{}, line {line}: {problem}; correct the line, or write the grid anew", path.display())]
    AsciiGrid {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// What is wrong there.
        problem: String,
    },
    /// An HGT file whose name or length does not say what it covers.
    #[error("{}: {problem}; {remedy}", path.display())]
    Hgt {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
        /// What would be right.
        remedy: String,
    },
    /// The raster's axes are not the map's axes.
    #[error(
        "{} is rotated, sheared or mirrored against its map grid (geotransform {transform:?}); \
         turn it north up with: gdalwarp {} north-up.tif", path.display(), path.display()
    )]
    Rotated {
        /// The file.
        path: PathBuf,
        /// GDAL's six coefficients.
        transform: [f64; 6],
    },
    /// Nothing says where the raster lies.
    #[error(
        "{} does not say where it lies (no tie point, no world file); \
         add that with: gdal_edit.py -a_srs EPSG:CODE -a_ullr WEST NORTH EAST SOUTH {}",
        path.display(), path.display()
    )]
    NoGeoreference {
        /// The file.
        path: PathBuf,
    },
    /// No cell holds a height.
    #[error(
        "{} holds no height at all: each of its {cells} cells is nodata; \
         check the nodata value with: sandtable info {}", path.display(), path.display()
    )]
    AllNodata {
        /// The file.
        path: PathBuf,
        /// Number of cells.
        cells: u64,
    },
    /// A text beside the raster that says where it lies cannot be understood.
    #[error("{}: {problem}; {remedy}", path.display())]
    Sidecar {
        /// The `.prj` or world file.
        path: PathBuf,
        /// What is wrong, with the place.
        problem: String,
        /// What would be right.
        remedy: String,
    },
    /// Photograph and terrain do not share a coordinate reference system.
    #[error(
        "{} has the CRS {photo_crs}, but the terrain has {terrain_crs}: {difference}; \
         warp the photograph with: {command}", path.display()
    )]
    PhotoCrs {
        /// The photograph.
        path: PathBuf,
        /// Its CRS.
        photo_crs: String,
        /// The terrain's CRS.
        terrain_crs: String,
        /// How they differ.
        difference: String,
        /// What warps it.
        command: String,
    },
    /// Photograph and terrain lie apart.
    #[error(
        "{} lies wholly outside the terrain (photograph {photo:?}, terrain {terrain:?}, each west, \
         south, east, north); {remedy}", path.display()
    )]
    PhotoElsewhere {
        /// The photograph.
        path: PathBuf,
        /// West, south, east, north edge of the photograph: in the terrain's coordinates, or in
        /// WGS 84 degrees where the two have different ones.
        photo: [f64; 4],
        /// The terrain's edges, likewise.
        terrain: [f64; 4],
        /// What to do.
        remedy: String,
    },
    /// A picture that could not be decoded.
    #[error("{} cannot be decoded as a picture: {problem}; {remedy}", path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What the decoder said.
        problem: String,
        /// What to do.
        remedy: String,
    },
    /// A cell was asked for that is not there.
    #[error(
        "{} has {width} columns by {height} rows, so there is no cell {col},{row}; \
         columns run from 0 to {}, rows from 0 to {}", path.display(), width - 1, height - 1
    )]
    NoSuchCell {
        /// The file.
        path: PathBuf,
        /// Column asked for.
        col: u32,
        /// Row asked for.
        row: u32,
        /// Columns there are.
        width: u32,
        /// Rows there are.
        height: u32,
    },
    /// There is not the memory for a file's heights or pixels.
    #[error(
        "{}: {source}; cut a part out with: gdal_translate -srcwin 0 0 4096 4096 {} part.tif",
        path.display(), path.display()
    )]
    NoMemory {
        /// The file.
        path: PathBuf,
        /// How much it needs.
        source: NoMemory,
    },
    /// The heights make no ground.
    #[error("{name}: {source}")]
    Ground {
        /// The terrain.
        name: String,
        /// Why not.
        source: GroundError,
    },
}

impl TerrainError {
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }

    /// What becomes of memory that is not given for a file's content.
    pub(crate) fn no_memory(path: &Path) -> impl FnOnce(NoMemory) -> Self {
        |source| Self::NoMemory {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn damaged(
        path: &Path,
        place: impl Into<String>,
        problem: impl Into<String>,
    ) -> Self {
        Self::Damaged {
            path: path.to_owned(),
            place: place.into(),
            problem: problem.into(),
        }
    }

    pub(crate) fn unsupported(
        path: &Path,
        feature: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Unsupported {
            path: path.to_owned(),
            feature: feature.into(),
            remedy: remedy.into(),
        }
    }
}
