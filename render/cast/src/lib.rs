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
mod brute;
mod canvas;
mod caster;
mod coherent;
mod difference;
mod error;
mod floating_horizon;
mod floor;
mod image;
mod inclined;
mod intersect;
mod level_window;
mod options;
mod pool;
mod registry;
mod scheme;
mod shade;
mod slice_depth;
mod slice_march;
mod slice_posts;
mod slices;
pub mod standpoints;
mod tally;
mod units;

pub use background::{BackgroundCaster, Finished, Request};
pub use brute::Brute;
pub use caster::{Caster, PreparedScene, Scene};
pub use coherent::Coherent;
pub use difference::Difference;
pub use error::CastError;
pub use floating_horizon::FloatingHorizon;
pub use floor::ShadeFloor;
pub use image::Image;
pub use inclined::Inclined;
pub use options::CasterOption;
pub use pool::CastPool;
pub use registry::{CASTERS, CasterKind, caster_by_name, caster_kind};
pub use scheme::Scheme;
pub use slice_depth::depth_buffer_table;
pub use tally::Work;
