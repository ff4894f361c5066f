//! The stage: how the casters' images reach the glass.
//!
//! ```text
//! Finished images --compose----------------------------> frame (CPU: files, machines with no GPU)
//!        |
//!        +--FramePainter (wgpu: stereo pass, then panel)--+--> Presenter --> the window
//!                                                         +--> capture ----> a screenshot
//! ```
//!
//! Colours are the casters' sRGB-encoded bytes all the way; both compositions copy them unchanged
//! where an eye was cast at the size that [`StereoMode::eye_size`] names. One thread owns the GPU:
//! casting hands over images, never wgpu objects. Nothing here knows a window system, a device or
//! what is shown.
//!
//! ```
//! use sandtable_cast::Image;
//! use sandtable_stage::{StereoMode, compose};
//!
//! let mode: StereoMode = "side-by-side".parse().unwrap();
//! assert_eq!(mode.eye_size([1280, 800]), [640, 800]);
//! let frame = compose(&Image::default(), &Image::default(), mode, false, [1280, 800]);
//! assert_eq!(frame.dimensions(), (1280, 800));
//! ```

mod compose;
mod compositor;
mod device;
mod frame;
mod mode;
mod presenter;
mod reaction;
mod screenshot;

pub use compose::{compose, compose_into};
pub use device::{Gpu, GpuError};
pub use frame::{Composing, FramePainter, Panel};
pub use mode::{StereoMode, UnknownStereoMode};
pub use presenter::{Presented, Presenter, SurfaceSource};
pub use reaction::{Reaction, SurfaceState, react};
pub use screenshot::{ScreenshotError, save_screenshot, save_screenshot_in_background};
