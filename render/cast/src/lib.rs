//! Casters: from views and a scene to colour and depth, on the CPU.
//!
//! ```text
//! Scene (immutable snapshot) --Caster::prepare--> PreparedScene --cast(views)--> Images
//!          | an edit: a new snapshot, changed tiles  ^
//!          +--------------PreparedScene::updated-----+
//! ```
//!
//! One job casts a slice of views (both eyes of a pair, or of several people) over all threads of
//! a [`CastPool`]; a worker that finds nothing left in one job begins on the next. The same scene
//! and views give the same bytes, whatever the number of threads.
//!
//! Depth is the distance from the eye along the ray in world metres, +∞ for sky.

mod background;
mod boundary;
mod brute;
mod canvas;
mod caster;
mod coherent;
mod conventional;
mod difference;
mod error;
mod floating_horizon;
mod grid_track;
mod image;
mod inclined;
mod intersect;
mod lanes;
mod level_window;
mod multiresolution;
mod options;
mod pick;
mod pixel_lines;
mod planes;
mod pool;
mod registry;
mod roll_lines;
mod samples;
mod scheme;
mod shade;
mod slice_depth;
mod slice_march;
mod slice_posts;
mod slice_scene;
mod slices;
pub mod standpoints;
mod tally;
mod units;
mod volume;
mod voxels;

pub use background::{BackgroundCaster, Finished, Request};
pub use boundary::Boundary;
pub use brute::Brute;
pub use caster::{Caster, PreparedScene, Scene};
pub use coherent::Coherent;
pub use conventional::Conventional;
pub use difference::Difference;
pub use error::CastError;
pub use floating_horizon::FloatingHorizon;
pub use image::Image;
pub use inclined::Inclined;
pub use multiresolution::Multiresolution;
pub use options::CasterOption;
pub use pick::{pick, sight};
#[doc(hidden)]
pub use planes::Survey;
pub use planes::{Planes, ShadeFloor};
pub use pool::CastPool;
pub use registry::{CASTERS, CasterKind, caster_by_name, caster_kind};
pub use roll_lines::RollLines;
pub use scheme::Scheme;
pub use shade::Sight;
pub use slice_depth::depth_buffer_table;
pub use tally::Work;
pub use volume::Volume;
pub use voxels::VoxelOptions;
