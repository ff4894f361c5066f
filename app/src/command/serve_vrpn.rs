//! `sandtable serve-vrpn`: the rig's devices for other programs.

use crate::cli::ServeVrpnArgs;
use crate::told::Told;
use crate::{interrupt, rig};
use anyhow::{Result, bail};
use sandtable_input::vrpn::{VrpnServer, VrpnServerSettings};
use sandtable_input::{Clock, Devices, Hub};
use std::io::Write;
use std::sync::Arc;
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
    let hub = Arc::new(Hub::for_rig(&rig));
    let clock = Clock::start();
    let settings = VrpnServerSettings {
        bind: args.listen,
        ..VrpnServerSettings::default()
    };
    let server = VrpnServer::start(&settings, &hub, clock)?;
    let devices = Devices::start(&rig, &hub, clock, None)?;
    // The address stands alone on its line, for scripts; it must not wait in a buffer.
    let mut out = std::io::stdout();
    writeln!(out, "{}", server.address())?;
    out.flush()?;
    let names: Vec<_> = rig.devices.keys().map(String::as_str).collect();
    eprintln!("serving {} by VRPN; Ctrl-C ends it", names.join(", "));

    let mut told = Told::default();
    let mut guests = 0;
    while stop.recv_timeout(PERIOD).is_err() {
        told.tell(&devices);
        if server.guests() != guests {
            guests = server.guests();
            eprintln!("{guests} connected");
        }
    }
    server.stop();
    devices.stop();
    Ok(())
}
