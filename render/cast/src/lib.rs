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
mod caster;
mod coherent;
mod difference;
mod floor;
mod image;
mod intersect;
mod pool;
mod shade;
pub mod standpoints;

pub use background::{BackgroundCaster, Finished, Request};
pub use brute::Brute;
pub use caster::{CASTERS, Caster, PreparedScene, Scene, caster_by_name};
pub use coherent::Coherent;
pub use difference::Difference;
pub use floor::ShadeFloor;
pub use image::{ColumnStrip, Image};
pub use pool::CastPool;
