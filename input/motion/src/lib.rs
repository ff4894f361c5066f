//! Motion: the noise of trackers smoothed, velocities, and poses predicted to their display time.
//!
//! ```text
//!                TrackerFilter, one a sensor
//!              +------------------------------------------------------+
//!  samples     |                      +--> VelocityWindow --velocity--+--->  Estimate:
//!  (pose,      |                      |                         |     |      pose,
//!  time,   ----+--> Smoothing --pose--+                         v     |      validity,
//!  validity)   |    OneEuro           +----------------> Predictor ---+--->  velocity,
//!              |    DoubleExponential                                 |      age
//!              +------------------------------------------------------+
//! ```
//!
//! Metres, radians, seconds, hertz; right-handed; a velocity is in the frame of its poses. Times
//! are arguments: nothing here knows a device, a thread or a clock, and no setting counts samples,
//! so that a filter does the same for a tracker of another rate. Both smoothing and prediction are
//! off unless they are asked for, and then poses pass to the bit as they are.
//!
//! Limits: an attitude must turn by less than half a turn within a filter's lag, and within the
//! window of a velocity. When a live pose becomes held, its prediction ends at once. There is no
//! Kalman filter. How the filters compare, and how to choose, is in `docs/filters.md`.
//!
//! The papers are Casiez, Roussel and Vogel, "1€ filter", CHI 2012; LaViola, "Double exponential
//! smoothing: an alternative to Kalman filter-based predictive tracking", EGVE 2003; and Hertzberg,
//! Wagner, Frese and Schröder, "Integrating generic sensor fusion algorithms with sound state
//! representations through encapsulation of manifolds", Information Fusion 14, 2013.
//!
//! A head that goes to the right at 0.4 m/s, seen 20 ms ahead:
//!
//! ```
//! use glam::{DQuat, DVec3};
//! use sandtable_motion::{FilterSettings, Prediction, TrackerFilter};
//! use sandtable_pose::{Nanos, Pose, Rigid, Validity};
//!
//! let settings = FilterSettings {
//!     prediction: Prediction::CONSTANT_VELOCITY,
//!     ..FilterSettings::default()
//! };
//! let mut head = TrackerFilter::new(settings).unwrap();
//! for i in 0..10 {
//!     let seconds = 0.01 * f64::from(i);
//!     let place = DVec3::new(0.4 * seconds, 0.0, 0.6);
//!     head.push(&Pose {
//!         frame_from_body: Rigid::new(DQuat::IDENTITY, place),
//!         time: Nanos::from_seconds(seconds),
//!         validity: Validity::Live,
//!     });
//! }
//! let now = Nanos::from_seconds(0.09);
//! let display = Nanos::from_seconds(0.11);
//! let head = head.pose_at(now, display).unwrap();
//! let place = head.pose.frame_from_body.translation;
//! assert!((place - DVec3::new(0.044, 0.0, 0.6)).length() < 1e-12);
//! assert!((head.velocity.unwrap().linear.x - 0.4).abs() < 1e-9);
//! ```

mod arrival;
mod double_exponential;
mod one_euro;
mod prediction;
mod settings;
mod signal;
mod tracker_filter;
mod velocity;

pub use arrival::Arrival;
pub use double_exponential::{DoubleExponential, PoseDoubleExponential, time_constant};
pub use one_euro::{Derivative, OneEuro, OneEuroSettings, PoseOneEuro};
pub use prediction::{HORIZON, Predictor, time_ahead};
pub use settings::{FilterSettings, Prediction, SettingsError, Smoothing};
pub use signal::{LARGEST, Signal};
pub use tracker_filter::{Estimate, TrackerFilter};
pub use velocity::{VELOCITY_WINDOW, Velocity, VelocityWindow};
