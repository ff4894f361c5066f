//! Views: through what the terrain is seen.
//!
//! ```text
//! head pose --Eyes--> two eyes (m, table) --+
//!                                           +--Placement--> View: eye + window (m, world)
//! rig --Screen (m, table)-------------------+                  |
//! Camera (yaw, pitch, roll, fov) ------------------------------+--> a ray per pixel
//! ```
//!
//! Right-handed, metres, f64. The *world* has x east, y north, z up; the *table* has its origin at
//! the glass's centre, x right, y away from the user, z up out of the glass. A view is always an
//! eye and three corners of a window: camera and table are two ways to build one. Nothing here
//! knows a device, a terrain or a GPU.
//!
//! ```
//! use glam::{DVec2, DVec3};
//! use sandtable_view::{Screen, View};
//!
//! // An eye above and before a table of 1.8 by 1.1 m, in the table's own frame.
//! let view = View {
//!     eye: DVec3::new(0.1, -0.95, 0.62),
//!     window: Screen::horizontal(1.8, 1.1),
//!     size: [1920, 1080],
//! };
//! // The glass's centre falls on the image's centre, wherever the eye is.
//! let pixel = view.pixel_of(DVec3::ZERO).unwrap();
//! assert!((pixel - DVec2::new(960.0, 540.0)).length() < 1e-9);
//! ```

mod camera;
mod eyes;
mod file;
mod placement;
mod screen;
mod view;

pub use camera::{Attitude, Camera, Stereo};
pub use eyes::{Eyes, EyesInHead, StereoPair};
pub use file::{ViewFile, ViewFileError};
pub use placement::Placement;
pub use screen::Screen;
pub use view::{Ray, Rays, View};
