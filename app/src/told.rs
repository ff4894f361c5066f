//! What commands without a window say of their devices, each thing once.

use sandtable_input::{Condition, Devices};

/// What has been said so far.
#[derive(Default)]
pub(crate) struct Told(Vec<(String, Condition)>);

impl Told {
    /// Says what has become of each device since the last time.
    pub(crate) fn tell(&mut self, devices: &Devices) {
        let states = devices.states().into_iter();
        let conditions: Vec<_> = states.map(|state| (state.name, state.condition)).collect();
        for told in &conditions {
            if !self.0.contains(told) {
                let (name, condition) = told;
                match condition {
                    Condition::Starting => eprintln!("{name}: starting"),
                    Condition::Streaming => eprintln!("{name}: streaming"),
                    // Why it waits the driver has logged.
                    Condition::Waiting(_) => eprintln!("{name}: waiting"),
                }
            }
        }
        self.0 = conditions;
    }
}
