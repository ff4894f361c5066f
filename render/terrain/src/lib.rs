//! Terrain: from elevation files and photographs to the ground that casters see.
//!
//! ```text
//! GeoTIFF | HGT | ASCII grid --rows--> heights in tiles --fill holes--> Ground <-- Photo
//!                 |                                                      ^          ^
//!                 +--> Header (place, CRS) --> Georeference -------------+----------+
//! ```
//!
//! World frame: metres, x east, y north, z up, f64; the origin is the south-west post, z is the
//! stored height. A *post* is an elevation sample, a *cell* the rectangle between four posts. The
//! terrain is solid: all below the bilinear surface over the rectangle of its posts.
//!
//! ```
//! use sandtable_terrain::{TerrainSource, open};
//!
//! let source: TerrainSource = "builtin:jacksboro".parse()?;
//! let terrain = open(&source, None)?;
//! assert_eq!(terrain.ground.range(), [236.0, 1076.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Beside the ground [`open`] holds one row of tiles, never a second copy of a file, but of a
//! photograph in PNG or JPEG all decoded pixels. [`info`] describes a file without keeping it.
//! Limits: north-up rasters of up to 2²⁹ cells, strips and tiles of up to 64 MiB; PNG and JPEG of
//! up to 256 MiB decoded; horizontal datums only.
//!
//! For casters that do not read heights, the ground becomes a [`VoxelVolume`] of densities with
//! its [`BoundaryArray`], or a [`Pyramid`] of resolutions; both follow edits tile by tile, as do
//! the [`HeightPyramid`] and the [`Mipmap`] of colours for casters that choose their level of
//! detail.
//!
//! Nothing here knows an eye: later, paged tiles are asked for by level, row and column.

mod builtin;
mod cells;
mod colour;
mod crs;
mod drape;
mod error;
mod fill;
mod georeference;
mod ground;
mod halving;
mod huge_pages;
mod info;
mod linear_light;
mod memory;
mod mipmap;
mod open;
mod photo;
mod photo_file;
mod pyramid;
mod raster;
mod reach;
mod slab;
mod source;
mod tiled;
mod voxel;

pub use cells::TiledCells;
pub use colour::{Rgb, hypsometric, hypsometric_tints};
pub use crs::{Crs, CrsRelation, Datum, PlaceError, Projection, WktError};
pub use drape::Drape;
pub use error::TerrainError;
pub use georeference::Georeference;
pub use ground::{Grid, Ground, GroundError, Holes};
pub use halving::HeightPyramid;
pub use huge_pages::use_huge_pages;
pub use info::{BandInfo, Extent, FileInfo, Sample, SampleValue, info};
pub use linear_light::LinearLight;
pub use memory::NoMemory;
pub use mipmap::Mipmap;
pub use open::{Terrain, open, open_with_progress};
pub use photo::Photo;
pub use pyramid::{Pyramid, PyramidLevel};
pub use raster::{ColourRole, PixelIs, SampleType};
pub use slab::{Slab, SlabView, Slot};
pub use source::{MAX_RIDGES_SIZE, SourceError, TerrainSource};
pub use tiled::{TILE_CELLS, TileIndex, TiledRaster};
pub use voxel::{
    BoundaryArray, CellFlag, DensityFilter, HIGHEST_LEVEL, LOWEST_LEVEL, MAX_LEVELS, MAX_SIGMA,
    MAX_WIDTH, MIN_LEVELS, VoxelError, VoxelShape, VoxelVolume, pre_texture, pre_texture_updated,
};
