//! Streams: from a device's bytes and their arrival times to samples.

use crate::Sample;
use crate::dtrack::DtrackStream;
use crate::flock::FlockStream;
use crate::vrpn::VrpnStream;
use sandtable_config::Device;
use sandtable_pose::Nanos;
use std::fmt::Debug;

/// Turns one device's bytes into samples. It knows no port and no clock: the bytes bring their
/// times, so that live sessions, replay and tests run the same one and get the same samples.
pub trait Stream: Debug + Send {
    /// Takes the bytes of one read (or datagram), which ended at `arrival`; hands each sample to
    /// `out`.
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample));

    /// Forgets what came before, as after a restart of the device.
    fn restart(&mut self);

    /// What it has seen.
    fn counts(&self) -> StreamCounts;
}

/// What a stream has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StreamCounts {
    /// Whole records or messages.
    pub records: u64,
    /// Bytes that belonged to no whole record.
    pub stray_bytes: u64,
    /// Records cut short by the next one's mark.
    pub cut_records: u64,
    /// Records with a byte too many, where the next one's mark is waited for.
    pub overlong_records: u64,
    /// Whole records under an address that nobody has.
    pub foreign_records: u64,
    /// Records that are none: a quaternion that is not of length 1, a count that is not so.
    pub implausible: u64,
    /// Records that jumped, or that no other record vouched for.
    pub refused: u64,
    /// Samples let out.
    pub samples: u64,
}

/// The stream of a rig's device.
#[must_use]
pub fn stream_of(device: &Device) -> Box<dyn Stream> {
    match device {
        Device::Flock(flock) => Box::new(FlockStream::new(flock)),
        Device::Vrpn(vrpn) => Box::new(VrpnStream::new(vrpn)),
        Device::Dtrack(dtrack) => Box::new(DtrackStream::new(dtrack)),
    }
}
