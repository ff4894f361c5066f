//! What the scenario tests share: where the repository and the real terrain data are, scenes whose
//! pictures can be worked out on paper, random views, and the judge of casters that are exact.

mod data;
pub mod decoders;
pub mod exactness;
pub mod hard_views;
mod markers;
mod random;
pub mod random_views;

pub use data::{data_file, repository};
pub use markers::{Marker, centroid, marked_plane};
pub use random::Random;
