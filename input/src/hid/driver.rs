//! The driver: one thread that reads a HID device, whatever happens to its cable.
//!
//! It looks for the device, opens it, hands on its reports as they came, and begins anew after a
//! silence, an error or an unplugged cable, for ever and with a pause in between.

use super::bus::HidBus;
use super::choice::{Wanted, choose};
use super::error::HidError;
use crate::Stream;
use crate::device_thread::{DeviceThread, Stopped};
use crate::recording::DeviceEvent;
use std::time::{Duration, Instant};

/// The most bytes that a report has.
const LONGEST_REPORT: usize = 1024;

/// How long reports may come that are none.
const PATIENCE: Duration = Duration::from_secs(2);

/// Reads the device that is meant until its thread is to end.
pub(crate) fn run(
    mut bus: impl HidBus,
    wanted: Wanted,
    silent_after: Option<Duration>,
    stream: &mut dyn Stream,
    thread: DeviceThread,
) {
    thread.run(|thread| {
        let before = stream.counts().records;
        let result = session(&mut bus, &wanted, silent_after, stream, thread);
        if stream.counts().records > before {
            thread.outlet.tell_calibration(stream);
        }
        result
    });
}

/// From looking for the device to losing it.
fn session(
    bus: &mut impl HidBus,
    wanted: &Wanted,
    silent_after: Option<Duration>,
    stream: &mut dyn Stream,
    thread: &mut DeviceThread,
) -> Result<Stopped, HidError> {
    let found = bus.list()?;
    let found = choose(wanted, &found)?;
    let mut device = bus.open(found)?;
    stream.restart();
    thread.outlet.event(DeviceEvent::Started);
    let mut buffer = [0; LONGEST_REPORT];
    let mut heard = Instant::now();
    let mut counts = stream.counts();
    let mut streaming = false;
    // Since when reports come that are none.
    let mut refused: Option<Instant> = None;
    loop {
        if thread.pause(Duration::ZERO).is_err() {
            return Ok(Stopped);
        }
        thread.outlet.reset_where_asked(stream);
        let length = device.read(&mut buffer)?;
        if length > 0 {
            heard = Instant::now();
            let arrival = thread.outlet.now();
            thread.outlet.bytes(&buffer[..length], arrival, stream);
        }
        thread.outlet.pass_time(stream);
        let now = stream.counts();
        if now.records > counts.records {
            refused = None;
            if !streaming {
                streaming = true;
                thread.streaming(&found.path);
            }
        } else if now.implausible > counts.implausible
            && refused.get_or_insert(heard).elapsed() >= PATIENCE
        {
            return Err(HidError::NotUnderstood {
                path: found.path.clone(),
                what: wanted.what.clone(),
                length,
            });
        }
        counts = now;
        if let Some(silence) = silent_after
            && heard.elapsed() >= silence
        {
            return Err(HidError::Silent {
                path: found.path.clone(),
                seconds: silence.as_secs_f64(),
            });
        }
    }
}

#[cfg(test)]
mod tests;
