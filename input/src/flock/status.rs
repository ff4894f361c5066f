//! What a Flock says of itself, in words.

use sandtable_config::Addressing;

/// Bytes in the answer to EXAMINE 36: one a unit that could be there.
#[must_use]
pub fn system_status_length(addressing: Addressing) -> usize {
    match addressing {
        Addressing::Normal => 14,
        Addressing::Expanded => 30,
        Addressing::SuperExpanded => 126,
    }
}

/// One unit's byte in the system status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitStatus(pub u8);

impl UnitStatus {
    /// The unit answers on the bus between the units.
    #[must_use]
    pub fn accessible(self) -> bool {
        self.0 & 0x80 != 0
    }

    /// The unit is running.
    #[must_use]
    pub fn running(self) -> bool {
        self.0 & 0x40 != 0
    }

    /// The unit has a sensor, and so sends records.
    #[must_use]
    pub fn has_sensor(self) -> bool {
        self.0 & 0x20 != 0
    }

    /// The unit is an Extended Range Controller or transmitter driver.
    #[must_use]
    pub fn extended_range(self) -> bool {
        self.0 & 0x10 != 0
    }
}

/// What is wrong in a system status, or `None` where each unit runs and each bird has a sensor.
///
/// `units` are expected from address 1 on, birds at `birds`.
#[must_use]
pub fn system_status_problem(status: &[u8], units: u8, birds: &[u8]) -> Option<String> {
    (1..=units).zip(status).find_map(|(address, &byte)| {
        let unit = UnitStatus(byte);
        if !unit.accessible() {
            Some(format!(
                "unit {address} does not answer (status {byte:02X}); check its power, its bus cable \
                 and its address switches 4 to 7"
            ))
        } else if !unit.running() {
            Some(format!(
                "unit {address} is not running (status {byte:02X}); switch its front panel to FLY"
            ))
        } else if birds.contains(&address) && !unit.has_sensor() {
            Some(format!(
                "unit {address} has no sensor (status {byte:02X}); plug one in, or lower `birds` \
                 in the rig"
            ))
        } else {
            None
        }
    })
}

/// What an error code of EXAMINE 10 means and, where something helps, what.
#[must_use]
pub fn error_in_words(code: u8) -> &'static str {
    match code {
        0 => "no error",
        1 => "the unit's memory failed its test",
        2 => "the unit could not write its settings",
        3 => "the unit's own settings are damaged",
        4 => "the transmitter's settings are damaged, or it is not plugged in",
        5 => "a sensor's settings are damaged, or it is not plugged in",
        6 => "an invalid command on the serial line: check the baud rate",
        7 => "the unit asked is not the master: address 1 must be on the serial line",
        8 => "no unit is active: auto-configuration failed",
        9 => "a unit was not initialised",
        10 => "the bus between the units garbled a bird's data: check its cables",
        11 => "the serial line lost bytes: check the baud rate and the cable",
        12 => "the bus between the units garbled a command: check its cables",
        13 => "a unit did not answer on the bus: check its power and its address switches",
        14 => "an invalid command from the host",
        15 => "a fault on the bus between the units while running",
        16 => "the unit's processor runs at the wrong speed",
        17 => "a slave unit sent no data",
        18 => "the baud switches are set to no known rate",
        19 => "a slave unit did not acknowledge",
        20..=27 => "a fault in the unit's processor: switch it off and on",
        28 => "the screen's synchronisation is missing",
        29 => "the transmitter is not active or cannot be reached",
        30 => "the extended range transmitter is not plugged in",
        31 => "the unit's processor ran out of time",
        32 => "a sensor is saturated: it is too near to the transmitter or to a magnet",
        33 => "a slave unit is configured wrongly",
        34 => "the Extended Range Controller's watchdog went off: switch it off and on",
        35 => "the Extended Range Controller is too hot: let it cool",
        _ => "an unknown error",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(units: &[u8]) -> Vec<u8> {
        let mut status = vec![0; system_status_length(Addressing::Normal)];
        status[..units.len()].copy_from_slice(units);
        status
    }

    #[test]
    fn a_running_flock_has_no_problem() {
        let three = status(&[0xE1, 0xE0, 0xE0]);
        assert_eq!(system_status_problem(&three, 3, &[1, 2, 3]), None);
        // A controller needs no sensor.
        let extended = status(&[0xD1, 0xE0, 0xE0]);
        assert_eq!(system_status_problem(&extended, 3, &[2, 3]), None);
    }

    #[test]
    fn each_missing_bit_is_named_with_its_unit() {
        // As seen on a real installation: the fourth unit does not run yet.
        let cave = status(&[0xE0, 0xD1, 0xE0, 0xA0]);
        let problem = system_status_problem(&cave, 4, &[1, 3, 4]).unwrap();
        assert!(problem.contains("unit 4 is not running"), "{problem}");
        let missing = system_status_problem(&status(&[0xE1]), 2, &[1, 2]).unwrap();
        assert!(missing.contains("unit 2 does not answer"), "{missing}");
        let bare = system_status_problem(&status(&[0xE1, 0xC0]), 2, &[1, 2]).unwrap();
        assert!(bare.contains("unit 2 has no sensor"), "{bare}");
    }
}
