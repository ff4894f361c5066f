//! 5DT's Data Glove Ultra: bend sensors over USB.
//!
//! ```text
//! report (64 bytes) --values--> raw, 12 bits --SensorCalibration--> Flexion --Sample--> hub
//! ```
//!
//! The simulator makes reports from a motion, as a glove would.
//!
//! What is known of the reports comes from one open driver that was tested with five sensors, and
//! from the maker's manual; the rig's settings cover where they may be wrong.

mod gesture_code;
mod products;
mod report;
mod simulator;
mod stream;

pub use gesture_code::{gesture_code, gesture_name};
pub use products::{VENDOR, products};
pub use report::{REPORT_LENGTH, VALUES, encode_report, report_values};
pub use simulator::{Motion, SimulatedDataGlove, SimulatorSettings};
pub use stream::DataGloveStream;

use crate::device_thread::DeviceThread;
use crate::hid::{self, SystemBus, Wanted};
use sandtable_config::{DataGlove, Side};

/// Reads a rig's data glove until its thread is to end.
pub(crate) fn run(glove: &DataGlove, thread: DeviceThread) {
    let known = products(glove.side, glove.sensors());
    let side = match glove.side {
        Side::Left => "left",
        Side::Right => "right",
    };
    let wanted = Wanted {
        what: format!("{side} 5DT glove of {} sensors", glove.sensors()),
        vendor: VENDOR,
        products: glove.product.map_or(known.to_vec(), |own| vec![own]),
        address: glove.address.clone(),
    };
    let mut stream = DataGloveStream::new(glove);
    let bus = SystemBus::default();
    hid::driver::run(bus, wanted, glove.silent_after, &mut stream, thread);
}
