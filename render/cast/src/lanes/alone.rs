//! Places of lanes, one by one.

use super::LANES;

/// The place of lane `k`, read by itself: a compiler that sees all of them would load them at once
/// and take them out of a register one by one, which is slower.
#[inline(always)]
pub(super) fn place_alone(places: &[i32; LANES], k: usize) -> usize {
    // SAFETY: a reference can be read.
    unsafe { std::ptr::from_ref(&places[k]).read_volatile() as u32 as usize }
}
