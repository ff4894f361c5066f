//! Bodies of the fuzz targets: one a decoder of what devices send, or of a file.
//!
//! Each takes any bytes and asserts what holds of whatever a decoder makes of them. `fuzz/` feeds
//! them from a fuzzer, `tests/seeded_decoders.rs` from a seeded generator.

mod flock;
mod gloves;
mod network;
mod recording;

pub use flock::{flock, flock_simulator};
pub use gloves::{data_glove, hid_glove, pinch};
pub use network::{dtrack, vrpn};
pub use recording::recording;

use sandtable_config::{Device, Rig};
use sandtable_input::HandState;

/// A fuzz target's body.
pub type Decoder = fn(&[u8]);

/// All of them by name.
pub const DECODERS: [(&str, Decoder); 9] = [
    ("flock", flock),
    ("flock_simulator", flock_simulator),
    ("pinch", pinch),
    ("data_glove", data_glove),
    ("hid_glove", hid_glove),
    ("vrpn", vrpn),
    ("dtrack", dtrack),
    ("recording", recording),
    ("rig", rig),
];

/// Rig files.
///
/// # Panics
/// Where an error does not name the file.
pub fn rig(data: &[u8]) {
    if let Err(error) = Rig::parse(&String::from_utf8_lossy(data), "the fuzzer's rig") {
        assert!(error.to_string().contains("the fuzzer's rig"), "{error}");
    }
}

/// The device that these lines describe, in a rig with no other.
fn device(lines: &str) -> Device {
    let text = format!("name = 'fuzz'\n[camera]\n[devices.d]\n{lines}\n");
    let mut rig = Rig::parse(&text, "the decoders' rig").expect("a rig");
    rig.devices.remove("d").expect("it is there")
}

/// Whether every finger of which something is known is bent from 0 to 1.
fn is_bent_within_its_range(hand: &HandState) -> bool {
    let joints = hand.flexion.iter().flatten().flat_map(|f| [f.near, f.far]);
    joints.into_iter().all(|joint| (0.0..=1.0).contains(&joint))
}
