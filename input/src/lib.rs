//! Input: devices to timestamped samples, recordings of them, and their replay.
//!
//! ```text
//! a port --bytes--> driver --+--> Stream --samples--> Hub --pose_at(t)--> viewer
//!                            |      ^                   |
//!                            v      |                   +--> VrpnServer --> others' programs
//!                        Recorder  Replay (virtual clock)
//! Hub + DeskState (keys, mouse, gamepad) --IntentMapper--> IntentState --> whoever acts
//! ```
//!
//! Devices are the Flock of Birds ([`flock`]), PINCH gloves ([`pinch`]), 5DT's data gloves
//! ([`data_glove`]), gloves that the rig describes ([`hid_glove`]), and trackers and gloves of
//! others' programs ([`vrpn`], [`dtrack`]); what hands mean by their fingers is told by [`hand`],
//! whichever glove they are in. What people mean by all of it is told by [`intent`], as the rig says.
//!
//! Poses are in the table's frame, in metres; inches, degrees and devices' own frames end at the
//! drivers. Decoders are pure functions of bytes and times, so that live sessions, replay and tests
//! run the same ones. Devices run in threads of their own and wait for nobody. Nothing here knows a
//! pixel.
//!
//! A session with no device at hand: a simulated Flock, byte for byte, on a clock of its own.
//!
//! ```
//! use sandtable_config::{Device, Rig};
//! use sandtable_input::{Hub, stream_of};
//! use sandtable_input::flock::{ Motion, SimulatedFlock, SimulatorSettings};
//! use sandtable_pose::{Nanos, Validity};
//! use std::time::Duration;
//!
//! let rig = Rig::builtin("workbench").unwrap();
//! let device_in_rig = &rig.devices["flock"];
//! let Device::Flock(flock) = device_in_rig else {
//!     panic!("the workbench has a Flock");
//! };
//! let mut device = SimulatedFlock::new(SimulatorSettings::default());
//! let mut now = Duration::ZERO;
//! for step in sandtable_input::flock::startup(flock) {
//!     if let sandtable_input::flock::Action::Send(bytes) = step.action {
//!         device.receive(&bytes, now);
//!     }
//!     now += step.silence;
//! }
//!
//! let hub = Hub::for_rig(&rig);
//! let mut stream = stream_of(device_in_rig);
//! let read = device.send(now + Duration::from_millis(100));
//! let arrival = Nanos(100_000_000);
//! stream.push(&read, arrival, &mut |sample| hub.push("flock", sample));
//!
//! let head = rig.head.unwrap();
//! let pose = hub.pose_at(&head.sensor.unwrap(), arrival).unwrap();
//! assert_eq!(pose.validity, Validity::Live);
//! // The simulated head rests where the rig's does.
//! let off = pose.frame_from_body.translation - head.rest.translation;
//! assert!(off.length() < 1e-3);
//! ```

mod clock;
pub mod data_glove;
mod device_thread;
mod devices;
pub mod dtrack;
mod flight;
pub mod flock;
mod gamepad;
mod gate;
pub mod hand;
mod hid;
pub mod hid_glove;
mod hub;
pub mod intent;
pub mod pinch;
pub mod recording;
mod sample;
mod serial_line;
mod simulator;
mod stream;
mod tcp_line;
mod track;
mod tracked_sensors;
pub mod vrpn;

pub use clock::Clock;
pub use devices::{Condition, DeviceState, Devices, DevicesError};
pub use flight::FlightAxes;
pub use gamepad::{GamepadError, GamepadState, Gamepads};
pub use hid::{HidError, udev_rule};
pub use hub::Hub;
pub use recording::{Recorder, Replay};
pub use sample::{
    AXES, AxesSample, ButtonsSample, Contacts, Fingers, Flexion, HandSample, HandState, PoseSample,
    Sample,
};
pub use sandtable_motion::Estimate;
pub use serial_line::SerialError;
pub use simulator::SimulatedDevice;
#[cfg(unix)]
pub use simulator::{Simulator, SimulatorError};
pub use stream::{Stream, StreamCounts, stream_of};
pub use tcp_line::TcpError;
