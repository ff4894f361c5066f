//! A simulated Data Glove Ultra: reports as a glove would send them, by a motion and a seed.
//!
//! It is pure: a report is a function of its number. A HID device cannot be made up without the
//! system's help, so there is no port to it; its reports go straight into a stream.

mod device;
mod motion;

pub use device::SimulatedDataGlove;
pub use motion::Motion;

use sandtable_config::Side;

/// What is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatorSettings {
    /// The hand that it is for.
    pub side: Side,
    /// What the fingers do.
    pub motion: Motion,
    /// The most that noise adds to a raw value or takes from it.
    pub noise: u16,
    /// The noise's seed.
    pub seed: u64,
    /// Reports a second, 1 to 1000; a real one sends 60 at the least.
    pub rate: u16,
}

impl Default for SimulatorSettings {
    /// A right glove that plays, with a little noise.
    fn default() -> Self {
        Self {
            side: Side::Right,
            motion: Motion::Played(0),
            noise: 2,
            seed: 0,
            rate: 75,
        }
    }
}
