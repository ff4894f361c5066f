//! `sandtable simulate`: be a device. One file a device.

#[cfg(unix)]
mod flock;
mod glove;
#[cfg(unix)]
mod line;
#[cfg(unix)]
mod pinch;
#[cfg(unix)]
mod steering;

use crate::cli::{SimulateArgs, SimulatedDevice};
use anyhow::Result;

pub(crate) fn run(args: &SimulateArgs) -> Result<()> {
    match &args.device {
        #[cfg(unix)]
        SimulatedDevice::Flock(args) => flock::run(args),
        #[cfg(unix)]
        SimulatedDevice::Pinch(args) => pinch::run(args),
        #[cfg(not(unix))]
        SimulatedDevice::Flock(_) | SimulatedDevice::Pinch(_) => anyhow::bail!(
            "devices on a line need pseudo-terminals, which this system does not have"
        ),
        SimulatedDevice::Glove(args) => glove::run(args),
    }
}
