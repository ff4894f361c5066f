//! Terrain: from elevation files and photographs to the ground that casters see.
//!
//! World frame: metres, x east, y north, z up, f64; the origin is the south-west post, z is the
//! stored height. A *post* is an elevation sample, a *cell* the rectangle between four posts. The
//! terrain is solid: all below the bilinear surface over the rectangle of its posts.
//!
//! Nothing here knows an eye: later, paged tiles are asked for by level, row and column.

mod colour;
mod ground;
mod photo;
mod tiled;

pub use colour::{Rgb, hypsometric};
pub use ground::{Grid, Ground, GroundError, Holes};
pub use photo::Photo;
pub use tiled::{TILE_CELLS, TileIndex, TiledRaster};
