//! A simulated Flock of Birds: the other side of the line.
//!
//! [`SimulatedFlock`] answers commands and streams records as a pure state machine; [`Simulator`]
//! runs it on a pseudo-terminal, so that the real driver can open it as it would a serial port.

mod device;
mod motion;
mod recorded;

pub use device::SimulatedFlock;
pub use motion::Motion;
pub use recorded::RecordedMotion;

/// A simulated Flock of Birds on a pseudo-terminal.
#[cfg(unix)]
pub type Simulator = crate::simulator::Simulator<SimulatedFlock>;

#[cfg(unix)]
impl Simulator {
    /// Moves bird `bird`, from 1, otherwise: every record that is measured after this returns has
    /// it there. A bird that is not there changes nothing.
    pub fn set_motion(&self, bird: u32, motion: Motion) {
        self.change(move |flock| flock.set_motion(bird, motion));
    }
}

use super::record::PHASE;
use sandtable_config::Addressing;
use sandtable_pose::Rigid;
use std::sync::Arc;
use std::time::Duration;

/// What is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatorSettings {
    /// How many birds, 1 to 14.
    pub birds: u32,
    /// The address of an Extended Range Controller, if there is one; the birds take the others.
    pub erc_address: Option<u32>,
    /// How units are addressed.
    pub addressing: Addressing,
    /// What the button byte says where the host has asked for it: 0x10, 0x30 or 0x70.
    pub buttons: u8,
    /// Bits a second: the stream is no faster than this line would carry it.
    pub baud: u32,
    /// Measuring cycles a second, 1 to 1000.
    pub cycle_rate: f64,
    /// How each bird moves, bird 1 first; where there are fewer, the last one serves the rest.
    pub motions: Vec<Motion>,
    /// A recorded motion, which those birds have that it knows.
    pub recorded: Option<Arc<RecordedMotion>>,
    /// How long auto-configuration takes; what arrives in it is lost.
    pub auto_configuration: Duration,
    /// What goes wrong.
    pub faults: Faults,
}

impl Default for SimulatorSettings {
    /// Two birds at rest on a fast line.
    fn default() -> Self {
        Self {
            birds: 2,
            erc_address: None,
            addressing: Addressing::Normal,
            buttons: 0,
            baud: 115_200,
            cycle_rate: 103.3,
            motions: vec![Motion::Still],
            recorded: None,
            auto_configuration: Duration::from_millis(300),
            faults: Faults::default(),
        }
    }
}

impl SimulatorSettings {
    /// How bird `bird` (from 1) moves.
    #[must_use]
    pub fn motion(&self, bird: u32) -> Motion {
        let index = (bird as usize).saturating_sub(1);
        let motion = self.motions.get(index).or(self.motions.last());
        motion.copied().unwrap_or(Motion::Still)
    }

    /// `tracker_from_sensor` of bird `bird` (from 1), `seconds` after the first stream began.
    #[must_use]
    pub fn pose(&self, bird: u32, seconds: f64) -> Rigid {
        let recorded = self.recorded.as_ref();
        recorded
            .and_then(|motion| motion.pose(bird, seconds))
            .unwrap_or_else(|| self.motion(bird).pose(bird, seconds))
    }
}

/// What goes wrong on the line, by the stream's own time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// Every Nth byte of the stream is lost.
    pub drop_every: Option<u64>,
    /// Every Nth record of the stream is damaged: its first byte is lost, the next time its
    /// second, and so on, and then one byte's phase bit after the other is the wrong way round.
    pub damage_every: Option<u64>,
    /// Silences: from when, and for how long.
    pub stalls: Vec<(Duration, Duration)>,
    /// From here on every record is the same to the bit.
    pub freeze_at: Option<Duration>,
    /// Birds keep the format that they power up with, as when the command for it was lost.
    pub keep_format: bool,
}

impl Faults {
    /// Does to the stream's record `number`, from 1, what is asked for.
    fn damage(&self, number: u64, record: &mut Vec<u8>) {
        let Some(every) = self.damage_every.filter(|&every| every > 0) else {
            return;
        };
        if number.is_multiple_of(every) && !record.is_empty() {
            let damage = (number / every - 1) as usize % (2 * record.len());
            match damage.checked_sub(record.len()) {
                None => {
                    record.remove(damage);
                }
                Some(place) => record[place] ^= PHASE,
            }
        }
    }

    fn stalled(&self, time: Duration) -> bool {
        self.stalls
            .iter()
            .any(|(from, lasting)| time >= *from && time < *from + *lasting)
    }
}
