//! Streams: from a device's bytes and their arrival times to samples.

use crate::Sample;
use crate::data_glove::DataGloveStream;
use crate::dtrack::DtrackStream;
use crate::flock::FlockStream;
use crate::gate::Refusal;
use crate::hid_glove::HidGloveStream;
use crate::pinch::PinchStream;
use crate::vrpn::VrpnStream;
use sandtable_config::Device;
use sandtable_pose::Nanos;
use std::fmt::Debug;

/// Turns one device's bytes into samples. It knows no port and no clock: the bytes bring their
/// times, so that live sessions, replay and tests run the same one and get the same samples.
pub trait Stream: Debug + Send {
    /// Takes the bytes of one read (or datagram, or report), which ended at `arrival`; hands each
    /// sample to `out`. No bytes at all mean that time has passed; see [`Stream::due`].
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample));

    /// Forgets what came before, as after a restart of the device.
    fn restart(&mut self);

    /// When it wants to be told the time by an empty read, should no byte come before: a stream
    /// that believes a sample for a while only has no clock to end that by.
    fn due(&self) -> Option<Nanos> {
        None
    }

    /// Forgets what it has learnt of the device's ranges, for one that learns them.
    fn reset_calibration(&mut self) {}

    /// What it has learnt of the device's ranges, as the rig would have it; `None` where there is
    /// nothing to learn.
    fn calibration(&self) -> Option<String> {
        None
    }

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
    /// Records that jumped, or that came late or twice.
    pub refused: u64,
    /// Records that were the first after a silence, which are believed only with a second one.
    pub alone: u64,
    /// Samples let out.
    pub samples: u64,
}

impl StreamCounts {
    /// What it has seen since it had seen `earlier`.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            records: self.records - earlier.records,
            stray_bytes: self.stray_bytes - earlier.stray_bytes,
            cut_records: self.cut_records - earlier.cut_records,
            overlong_records: self.overlong_records - earlier.overlong_records,
            foreign_records: self.foreign_records - earlier.foreign_records,
            implausible: self.implausible - earlier.implausible,
            refused: self.refused - earlier.refused,
            alone: self.alone - earlier.alone,
            samples: self.samples - earlier.samples,
        }
    }

    pub(crate) fn refuse(&mut self, refusal: Refusal) {
        match refusal {
            Refusal::Jump => self.refused += 1,
            Refusal::Alone => self.alone += 1,
        }
    }
}

/// The stream of a rig's device.
#[must_use]
pub fn stream_of(device: &Device) -> Box<dyn Stream> {
    match device {
        Device::Flock(flock) => Box::new(FlockStream::new(flock)),
        Device::Vrpn(vrpn) => Box::new(VrpnStream::new(vrpn)),
        Device::Dtrack(dtrack) => Box::new(DtrackStream::new(dtrack)),
        Device::Pinch(pinch) => Box::new(PinchStream::new(pinch)),
        Device::DataGlove(glove) => Box::new(DataGloveStream::new(glove)),
        Device::HidGlove(glove) => Box::new(HidGloveStream::new(glove)),
    }
}
