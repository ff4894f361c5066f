//! `sandtable serve-vrpn`: the rig's devices for other programs.

use crate::cli::ServeVrpnArgs;
use crate::offer::Offer;
use crate::told::Told;
use crate::{interrupt, rig};
use anyhow::{Result, bail};
use sandtable_input::Devices;
use std::time::Duration;

/// How often devices and guests are looked at.
const PERIOD: Duration = Duration::from_millis(200);

pub(crate) fn run(args: &ServeVrpnArgs) -> Result<()> {
    let rig = rig::open(&args.rig, &args.device)?;
    if rig.devices.is_empty() {
        bail!("the rig {:?} has no devices to serve", rig.name);
    }
    // Listened to from the start: no signal may end the program with its devices still sending.
    let stop = interrupt::channel()?;
    let mut offer = Offer::start(&rig, args.listen)?;
    let devices = Devices::start(&rig, &offer.hub, offer.clock, None)?;
    let names: Vec<_> = rig.devices.keys().map(String::as_str).collect();
    eprintln!("serving {} by VRPN; Ctrl-C ends it", names.join(", "));

    let mut told = Told::default();
    while stop.recv_timeout(PERIOD).is_err() {
        told.tell(&devices);
        offer.tell_guests();
    }
    offer.stop();
    devices.stop();
    Ok(())
}
