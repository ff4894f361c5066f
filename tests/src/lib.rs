//! What the scenario tests share: where the repository and the real terrain data are, and scenes
//! whose pictures can be worked out on paper.

mod data;
pub mod decoders;
mod markers;

pub use data::{data_file, repository};
pub use markers::{Marker, centroid, marked_plane};
