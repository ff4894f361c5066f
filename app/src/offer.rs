//! A rig's sensors offered to other programs: a hub, and the VRPN server that tells of it.

use anyhow::Result;
use sandtable_config::Rig;
use sandtable_input::vrpn::{VrpnServer, VrpnServerSettings};
use sandtable_input::{Clock, Hub};
use std::io::Write;
use std::net::SocketAddr;
use std::sync::Arc;

/// A rig's sensors while they are offered.
pub(crate) struct Offer {
    pub(crate) hub: Arc<Hub>,
    pub(crate) clock: Clock,
    server: VrpnServer,
    /// How many guests have been told of.
    guests: usize,
}

impl Offer {
    /// Offers all sensors of `rig` at `address`, and says where, alone on a line for scripts.
    pub(crate) fn start(rig: &Rig, address: SocketAddr) -> Result<Self> {
        let hub = Arc::new(Hub::for_rig(rig));
        let clock = Clock::start();
        let settings = VrpnServerSettings {
            bind: address,
            ..VrpnServerSettings::default()
        };
        let server = VrpnServer::start(&settings, &hub, clock)?;
        // It must not wait in a buffer.
        let mut out = std::io::stdout();
        writeln!(out, "{}", server.address())?;
        out.flush()?;
        Ok(Self {
            hub,
            clock,
            server,
            guests: 0,
        })
    }

    /// Says how many are connected, where that has changed.
    pub(crate) fn tell_guests(&mut self) {
        if self.server.guests() != self.guests {
            self.guests = self.server.guests();
            eprintln!("{} connected", self.guests);
        }
    }

    /// Ends all connections and stops listening.
    pub(crate) fn stop(self) {
        self.server.stop();
    }
}
