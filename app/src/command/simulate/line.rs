//! Simulated devices on a serial line: on a pseudo-terminal, or read by their driver and offered.

use super::steering::{Steering, lines_of_standard_input};
use crate::cli::SimulatedLineArgs;
use crate::interrupt;
use crate::offer::Offer;
use crate::told::Told;
use anyhow::Result;
use crossbeam_channel::{Receiver, never, select};
use sandtable_config::Rig;
use sandtable_input::{Devices, SimulatedDevice, Simulator};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// How often devices and guests are looked at.
const PERIOD: Duration = Duration::from_millis(200);

/// Lets `device` run until Ctrl-C; `what` says for people what it is.
///
/// Its first line is where it is to be had: the terminal's path, or its link's, or the VRPN
/// server's address. For VRPN it is read by the driver that `rig` has for it, given its port.
pub(super) fn run<D: SimulatedDevice + 'static>(
    device: D,
    args: &SimulatedLineArgs,
    what: &str,
    rig: impl FnOnce(&Path) -> Result<Rig>,
    steering: Option<Steering<D>>,
) -> Result<()> {
    // Listened to from the start: no signal may end the program with its link still there.
    let stop = interrupt::channel()?;
    let simulator = Simulator::start(device, args.link.as_deref())?;
    let offered = match args.vrpn {
        Some(address) => {
            let rig = rig(simulator.path())?;
            let offer = Offer::start(&rig, address)?;
            let devices = Devices::start(&rig, &offer.hub, offer.clock, None)?;
            Some((offer, devices))
        }
        None => {
            // The path stands alone on its line, for scripts; it must not wait in a buffer.
            let path = args.link.as_deref().unwrap_or(simulator.path());
            say(path.display())?;
            None
        }
    };
    eprintln!("{what}; Ctrl-C ends it");
    wait(&simulator, offered, steering, &stop)?;
    simulator.stop();
    Ok(())
}

/// Obeys lines on standard input where it is steered, until Ctrl-C.
fn wait<D: SimulatedDevice + 'static>(
    simulator: &Simulator<D>,
    mut offered: Option<(Offer, Devices)>,
    steering: Option<Steering<D>>,
    stop: &Receiver<()>,
) -> Result<()> {
    let mut lines = match steering {
        Some(_) => lines_of_standard_input()?,
        None => never(),
    };
    let mut told = Told::default();
    loop {
        select! {
            recv(lines) -> line => match (line, &steering) {
                (Ok(line), Some(order)) => match order(&line) {
                    Ok((answer, change)) => {
                        simulator.change(change);
                        say(answer)?;
                    }
                    Err(problem) => eprintln!("{problem}"),
                },
                // The last order holds on.
                _ => lines = never(),
            },
            // An error means that the handler is gone, and then so is the wish to go on.
            recv(stop) -> _ => break,
            default(PERIOD) => {}
        }
        if let Some((offer, devices)) = &mut offered {
            told.tell(devices);
            offer.tell_guests();
        }
    }
    if let Some((offer, devices)) = offered {
        offer.stop();
        devices.stop();
    }
    Ok(())
}

fn say(line: impl std::fmt::Display) -> Result<()> {
    let mut out = std::io::stdout();
    writeln!(out, "{line}")?;
    out.flush()?;
    Ok(())
}
