//! Which glove a USB id is.

use sandtable_config::Side;

/// The maker's USB vendor id.
pub const VENDOR: u16 = 0x5D70;

const LEFT: u16 = 0x0001;
const PORT_A: u16 = 0x0002;
const PORT_B: u16 = 0x0006;
const FIVE_SENSORS: u16 = 0x0010;

/// The USB product ids of a hand's glove of 5 or 14 sensors: by wire, and by the two ports of a
/// wireless receiver. A right glove of 14 sensors by wire has 0.
#[must_use]
pub fn products(side: Side, sensors: usize) -> [u16; 3] {
    let left = match side {
        Side::Left => LEFT,
        Side::Right => 0,
    };
    let five = if sensors == 5 { FIVE_SENSORS } else { 0 };
    [0, PORT_A, PORT_B].map(|port| left | five | port)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_id_is_one_gloves_own() {
        assert_eq!(products(Side::Right, 14), [0x0000, 0x0002, 0x0006]);
        assert_eq!(products(Side::Left, 14), [0x0001, 0x0003, 0x0007]);
        assert_eq!(products(Side::Right, 5), [0x0010, 0x0012, 0x0016]);
        assert_eq!(products(Side::Left, 5), [0x0011, 0x0013, 0x0017]);
        let all: BTreeSet<u16> = [(Side::Left, 5), (Side::Left, 14), (Side::Right, 5)]
            .into_iter()
            .chain([(Side::Right, 14)])
            .flat_map(|(side, sensors)| products(side, sensors))
            .collect();
        assert_eq!(all.len(), 12);
    }
}
