//! Simulated PINCH gloves: the other side of the line.

mod device;
mod motion;

pub use device::SimulatedPinch;
pub use motion::Motion;

/// Simulated gloves on a pseudo-terminal.
#[cfg(unix)]
pub type Simulator = crate::simulator::Simulator<SimulatedPinch>;

use std::time::Duration;

/// What is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatorSettings {
    /// Bits a second: messages are no faster than this line would carry them.
    pub baud: u32,
    /// Whether there is a left and a right glove.
    pub gloves: [bool; 2],
    /// What the fingers do, from the first command on that the box obeys.
    pub motion: Motion,
    /// The timer's unit.
    pub tick: Duration,
    /// What goes wrong.
    pub faults: Faults,
}

impl Default for SimulatorSettings {
    /// Two gloves that play, on a line of the usual speed.
    fn default() -> Self {
        Self {
            baud: 9600,
            gloves: [true; 2],
            motion: Motion::Seeded(0),
            tick: Duration::from_millis(1),
            faults: Faults::default(),
        }
    }
}

/// What goes wrong on the line, by the motion's own time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// Every Nth byte of the contacts is lost.
    pub drop_every: Option<u64>,
    /// From when and for how long the box neither hears nor says anything.
    pub stalls: Vec<(Duration, Duration)>,
}

impl Faults {
    fn stalled(&self, time: Duration) -> bool {
        let during =
            |(from, lasting): &(Duration, Duration)| time >= *from && time < *from + *lasting;
        self.stalls.iter().any(during)
    }
}
