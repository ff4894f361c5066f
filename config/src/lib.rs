//! Config: what stands at this desk or table, in one typed rig file.
//!
//! ```text
//! rig.toml --Rig::load--> Rig { viewing, stereo, head, hand, devices, intents, flight, gamepad }
//! ```
//!
//! Lengths are metres and rotations unit quaternions once read; degrees, inches and axis names end
//! here. Every number is checked against its range, an unknown key is an error, and each error
//! names the file, the line, the key and what would be right. A rig file holds values only: no
//! commands, and of other files only the corrections of bent fields beside it; the addresses in it
//! are those of serial ports and trackers.
//!
//! ```
//! use sandtable_config::{Rig, Viewing};
//!
//! let rig = Rig::builtin("workbench").unwrap();
//! assert!(matches!(rig.viewing, Viewing::Table(_)));
//!
//! let text = "name = 'mine'\n[camera]\nhorizontal_fow = 50\n";
//! let error = Rig::parse(text, "mine.toml").unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "mine.toml, line 3: `camera.horizontal_fow` is unknown; did you mean `horizontal_fov`?"
//! );
//! ```

mod beside;
mod body;
mod calibrated;
mod controls;
mod device;
mod doubt;
mod error;
mod field_correction;
mod fields;
mod intents;
mod marks;
mod rig;
mod rigid;
mod sensor;
mod stylus;
mod text_file;
mod viewing;

pub use body::{Eyes, Hand, Head, SensorName};
pub use calibrated::Calibrated;
pub use controls::{Flight, Gamepad};
pub use device::{
    Addressing, AxisMap, ByteOrder, Confirm, DataGlove, Device, Dtrack, Flock, FlockMode, Gestures,
    Hemisphere, HidAddress, HidBit, HidField, HidFinger, HidGlove, Pinch, QuaternionSign, Range,
    RecordFormat, Side, Tracking, VRPN_PORT, Vrpn, VrpnAddress, VrpnFinger, VrpnGlove, VrpnPart,
};
pub use doubt::Doubt;
pub use error::RigError;
pub use field_correction::FieldCorrection;
pub use intents::{
    GamepadPart, Gesture, Intent, IntentKind, Intents, MouseButton, Part, Source, Touch,
};
pub use keyboard_types::Code as KeyCode;
pub use marks::{Mark, load_marks};
pub use rig::Rig;
pub use sensor::SensorSettings;
pub use stylus::Stylus;
pub use viewing::{Desktop, Measure, Stereo, StereoMode, Table, Viewing};
