//! Serving: the server's thread, which waits for samples and looks at its guests' sockets between.

use super::guest::{Farewell, Guest};
use super::offer::Offer;
use crate::hub::Heard;
use crate::vrpn::Stamp;
use crate::{Clock, Hub};
use crossbeam_channel::{Receiver, select};
use sandtable_pose::Nanos;
use std::convert::Infallible;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How often the sockets are looked at: the longest that a ping waits for its pong.
const TURN: Duration = Duration::from_millis(5);

/// How often the door is looked at while there is no guest.
const IDLE_TURN: Duration = Duration::from_millis(25);

/// Samples that may wait for the thread: seconds of several devices.
const ROOM: usize = 4096;

/// How many samples are told before the sockets are written to.
const BATCH: usize = 64;

/// How many guests are taken in one turn.
const GREETINGS: usize = 64;

/// The least time between two lines of the log.
const LOG_PAUSE: Duration = Duration::from_secs(10);

/// What its owner may know of the thread.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub(super) guests: AtomicUsize,
    pub(super) sent_away: AtomicU64,
}

pub(super) struct Serving {
    listener: TcpListener,
    most_guests: usize,
    guests: Vec<(SocketAddr, Guest)>,
    heard: Receiver<Heard>,
    offer: Offer,
    /// Kept so that what is heard never ends before the thread.
    _hub: Arc<Hub>,
    clock: Clock,
    /// The time of day at the clock's start, since 1970.
    clock_start: Duration,
    tally: Arc<Tally>,
    logged: Option<Instant>,
}

impl Serving {
    pub(super) fn new(
        listener: TcpListener,
        most_guests: usize,
        hub: &Arc<Hub>,
        clock: Clock,
        tally: Arc<Tally>,
    ) -> Self {
        // First listened, then looked: what is pressed between the two is told twice, not never.
        let heard = hub.listen(ROOM);
        let day = SystemTime::now().duration_since(UNIX_EPOCH);
        let since_start = clock.now().since(Nanos(0));
        Self {
            listener,
            most_guests,
            guests: Vec::new(),
            heard,
            offer: Offer::of(hub),
            _hub: Arc::clone(hub),
            clock,
            clock_start: day.unwrap_or_default().saturating_sub(since_start),
            tally,
            logged: None,
        }
    }

    pub(super) fn run(mut self, stop: &Receiver<Infallible>) {
        let heard = self.heard.clone();
        let mut looked = Instant::now();
        loop {
            let turn = if self.guests.is_empty() {
                IDLE_TURN
            } else {
                TURN
            };
            select! {
                recv(heard) -> sample => {
                    for sample in sample.iter().cloned().chain(heard.try_iter().take(BATCH)) {
                        self.tell(&sample);
                    }
                }
                recv(stop) -> _ => return,
                default(turn) => {}
            }
            if looked.elapsed() >= turn {
                looked = Instant::now();
                self.greet();
                let (offer, stamp) = (&self.offer, self.stamp(self.clock.now()));
                let read = |guest: &mut Guest| guest.read(offer, stamp);
                let gone = part_with(&mut self.guests, read);
                self.report(gone);
            }
            let gone = part_with(&mut self.guests, Guest::write);
            self.report(gone);
        }
    }

    /// Takes in who waits at the door.
    fn greet(&mut self) {
        for _ in 0..GREETINGS {
            // Whatever else an error is, it will be there or gone at the next turn.
            let Ok((socket, address)) = self.listener.accept() else {
                return;
            };
            if self.guests.len() >= self.most_guests {
                self.send_away(address, &"there are too many guests");
                continue;
            }
            match Guest::new(socket, &self.offer) {
                Ok(guest) => {
                    tracing::debug!("the VRPN client {address} has connected");
                    self.guests.push((address, guest));
                    self.count();
                }
                Err(error) => self.send_away(address, &error),
            }
        }
    }

    /// Queues what a sample says for all guests.
    fn tell(&mut self, (device, sample): &Heard) {
        let stamp = self.stamp(sample.time());
        let guests = &mut self.guests;
        let mut gone = Vec::new();
        self.offer.tell(device, sample, &mut |sender, report| {
            gone.extend(part_with(guests, |guest| guest.tell(sender, stamp, report)));
        });
        self.report(gone);
    }

    /// A time of the session as a time of day.
    fn stamp(&self, time: Nanos) -> Stamp {
        Stamp::since_1970(self.clock_start + time.since(Nanos(0)))
    }

    fn report(&mut self, gone: Vec<(SocketAddr, Farewell)>) {
        for (address, farewell) in gone {
            self.count();
            if farewell.is_its_own() {
                tracing::debug!("the VRPN client {address} is gone: {farewell}");
            } else {
                self.send_away(address, &farewell);
            }
        }
    }

    /// Counts one that was sent away, and logs it where that floods nothing.
    fn send_away(&mut self, address: SocketAddr, reason: &dyn std::fmt::Display) {
        let count = 1 + self.tally.sent_away.fetch_add(1, Ordering::Relaxed);
        if self
            .logged
            .is_none_or(|logged| logged.elapsed() >= LOG_PAUSE)
        {
            self.logged = Some(Instant::now());
            tracing::warn!("the VRPN client {address} was sent away, number {count}: {reason}");
        }
    }

    fn count(&self) {
        self.tally
            .guests
            .store(self.guests.len(), Ordering::Relaxed);
    }
}

/// Lets each guest do something, and gives those for whom that was the last.
fn part_with(
    guests: &mut Vec<(SocketAddr, Guest)>,
    mut act: impl FnMut(&mut Guest) -> Result<(), Farewell>,
) -> Vec<(SocketAddr, Farewell)> {
    let mut gone = Vec::new();
    guests.retain_mut(|(address, guest)| match act(guest) {
        Ok(()) => true,
        Err(farewell) => {
            gone.push((*address, farewell));
            false
        }
    });
    gone
}
