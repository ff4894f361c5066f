//! Gloves that are HID devices and that the rig describes, so that another one needs no code.
//!
//! ```text
//! report --field_value--> raw --SensorCalibration--> Flexion, buttons --Sample--> hub
//! ```

mod field;
mod stream;

pub use field::field_value;
pub use stream::HidGloveStream;

use crate::device_thread::DeviceThread;
use crate::hid::{self, SystemBus, Wanted};
use sandtable_config::HidGlove;

/// Reads a rig's HID glove until its thread is to end.
pub(crate) fn run(glove: &HidGlove, thread: DeviceThread) {
    let wanted = Wanted {
        what: "glove".to_owned(),
        vendor: glove.vendor,
        products: vec![glove.product],
        address: glove.address.clone(),
    };
    let mut stream = HidGloveStream::new(glove);
    let bus = SystemBus::default();
    hid::driver::run(bus, wanted, glove.silent_after, &mut stream, thread);
}
