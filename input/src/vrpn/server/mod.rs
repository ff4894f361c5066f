//! The server: a hub's sensors for other programs, as VRPN trackers, buttons and analogs.
//!
//! ```text
//! Hub --samples--> Offer --reports--> each guest's Connection --bytes--> its socket
//!                                     guest's ping <-- Inbound <--bytes--
//! ```
//!
//! A device of the rig is a tracker of its own name: `flock/1` is sensor 0 of `flock@host`, poses
//! in the table's frame. Buttons and axes of sensor 1 are the buttons and channels of `flock`,
//! those of sensor 2 of `flock/2`, and so on; how far a hand's fingers are bent are channels 0 to
//! 4, the thumb's first. VRPN has no word for a lost sensor: one that is lost goes silent.
//!
//! One thread serves all guests and waits for none of them.

mod guest;
mod offer;
mod serving;

use crate::{Clock, Hub};
use crossbeam_channel::Sender;
use sandtable_config::VRPN_PORT;
use serving::{Serving, Tally};
use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;

/// How a server is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VrpnServerSettings {
    /// Where it listens. On the loopback, which is the default, programs of this computer alone
    /// can connect; anyone who can connect hears everything.
    pub bind: SocketAddr,
    /// How many guests it takes at once; more are turned away.
    pub most_guests: usize,
}

impl Default for VrpnServerSettings {
    fn default() -> Self {
        Self {
            bind: SocketAddr::from((Ipv4Addr::LOCALHOST, VRPN_PORT)),
            most_guests: 256,
        }
    }
}

/// Why a server cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// Its address cannot be listened at.
    #[error("cannot listen at {address} ({source}); {remedy}")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: io::Error,
        /// What helps.
        remedy: &'static str,
    },
    /// The system gives no thread.
    #[error("cannot start the VRPN server's thread ({0}); end other programs")]
    Thread(io::Error),
}

/// A server while it runs. Dropping it stops it.
#[derive(Debug)]
pub struct VrpnServer {
    address: SocketAddr,
    tally: Arc<Tally>,
    /// Dropped to stop the thread.
    stop: Option<Sender<Infallible>>,
    thread: Option<JoinHandle<()>>,
}

impl VrpnServer {
    /// Begins to offer all sensors of `hub`, whose samples are dated by `clock`.
    ///
    /// # Errors
    /// Where the address cannot be listened at, or the system gives no thread.
    pub fn start(
        settings: &VrpnServerSettings,
        hub: &Arc<Hub>,
        clock: Clock,
    ) -> Result<Self, ServerError> {
        let cannot_bind = |source: io::Error| ServerError::Bind {
            address: settings.bind,
            remedy: remedy(source.kind()),
            source,
        };
        let listener = TcpListener::bind(settings.bind).map_err(cannot_bind)?;
        listener.set_nonblocking(true).map_err(cannot_bind)?;
        let address = listener.local_addr().map_err(cannot_bind)?;
        let tally = Arc::new(Tally::default());
        let (stop, stopped) = crossbeam_channel::bounded(0);
        let counted = Arc::clone(&tally);
        let serving = Serving::new(listener, settings.most_guests, hub, clock, counted);
        let thread = std::thread::Builder::new()
            .name("VRPN server".into())
            .spawn(move || serving.run(&stopped))
            .map_err(ServerError::Thread)?;
        Ok(Self {
            address,
            tally,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Where it listens, with the port that the system chose where 0 was asked for.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many guests it has.
    #[must_use]
    pub fn guests(&self) -> usize {
        self.tally.guests.load(Ordering::Relaxed)
    }

    /// How many guests it has sent away: too slow, too many, or no VRPN programs.
    #[must_use]
    pub fn sent_away(&self) -> u64 {
        self.tally.sent_away.load(Ordering::Relaxed)
    }

    /// Ends all connections and stops listening.
    pub fn stop(mut self) {
        self.end();
    }

    fn end(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A panic in it has been printed, and its sockets are closed.
            let _ = thread.join();
        }
    }
}

impl Drop for VrpnServer {
    fn drop(&mut self) {
        self.end();
    }
}

fn remedy(kind: io::ErrorKind) -> &'static str {
    match kind {
        io::ErrorKind::AddrInUse => "another VRPN server listens there: end it, or name a port",
        io::ErrorKind::AddrNotAvailable => {
            "name an address of this computer, or 0.0.0.0 for all that it has"
        }
        io::ErrorKind::PermissionDenied => "name a port from 1024 on",
        _ => "name another address and port",
    }
}
