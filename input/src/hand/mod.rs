//! Hands: what all gloves share, from a sensor's raw values to gestures.
//!
//! ```text
//! raw value --SensorCalibration--> flexion --HandSample--> hub
//! hand_at(t) --Posture (open, closed)--> GestureRecogniser --> open, point, pinch, grab
//! ```
//!
//! All of it is pure: the same hands at the same times give the same gestures.
//!
//! ```
//! use sandtable_config::{Gesture, Rig, SensorName};
//! use sandtable_input::hand::GestureRecogniser;
//! use sandtable_input::{Hub, stream_of};
//! use sandtable_pose::Nanos;
//!
//! let text = "name = 'g'\n[camera]\n[devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n";
//! let rig = Rig::parse(text, "g.toml").unwrap();
//! let gloves = &rig.devices["pinch"];
//! let hub = Hub::for_rig(&rig);
//! let mut stream = stream_of(gloves);
//! let mut left = GestureRecogniser::new(gloves.gestures().unwrap().clone());
//!
//! // The left thumb touches the left index finger.
//! let read = [0x80, 0x18, 0x00, 0x8F];
//! stream.push(&read, Nanos(20_000_000), &mut |sample| hub.push("pinch", sample));
//!
//! let sensor = SensorName { device: "pinch".into(), number: 1 };
//! let mut at = |ms: u64| {
//!     let time = Nanos(ms * 1_000_000);
//!     left.update(time, hub.hand_at(&sensor, time).as_ref())
//! };
//! assert_eq!([at(10), at(20), at(70)], [None, None, Some(Gesture::Pinch)]);
//! ```

mod calibration;
mod finger;
mod gesture;
mod posture;
mod settling;

pub use calibration::SensorCalibration;
pub(crate) use finger::BentFinger;
pub use gesture::{GestureRecogniser, gesture_of};
pub use posture::{FingerPosture, Posture};
pub(crate) use settling::Settling;
