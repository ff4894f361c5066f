//! Numbers that look random and are not: each is a function of its seed.

/// A number that seems unlike its neighbours' (SplitMix64: Steele, Lea, Flood 2014).
pub(crate) fn mixed(mut number: u64) -> u64 {
    number = (number ^ number >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    number = (number ^ number >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    number ^ number >> 31
}
