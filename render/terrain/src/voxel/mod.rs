//! The voxel model of Wan, Qu and Kaufman (1999, section 3): a volume of densities, one colour a
//! column, and where the surface runs through it.
//!
//! ```text
//!                   VoxelShape (slices)
//!                        |
//! Ground --heights--> DensityFilter --> VoxelVolume --threshold--> BoundaryArray
//!    |  \_____________________________(binary voxels)_______________^
//!    +--colours--> pre_texture
//! ```
//!
//! A *voxel* is a density at post (column, row) on a slice, its *level*: 255 below the surface, 0
//! above it, in between near it. A *cell* is the box between eight voxels, named by its lowest
//! one. A voxel is below the surface where its density is above a threshold; a cell with voxels
//! on both sides is a *boundary cell*.
//!
//! Only what lies near the surface is stored. An edit makes a new snapshot that shares all tiles
//! which the edit does not reach, and equals a model made anew with the same shape.

mod boundary;
mod column;
mod error;
mod filter;
mod gaussian;
mod oriented_box;
mod packed;
mod shape;
pub(crate) mod texture;
mod volume;

pub use boundary::{BoundaryArray, CellFlag};
pub use error::VoxelError;
pub use filter::{DensityFilter, MAX_SIGMA, MAX_WIDTH};
pub use shape::{HIGHEST_LEVEL, LOWEST_LEVEL, MAX_LEVELS, MIN_LEVELS, VoxelShape};
pub use texture::{pre_texture, pre_texture_updated};
pub use volume::VoxelVolume;
