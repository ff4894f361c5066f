//! Gradient noise, a pure function of place and seed.

/// Thirty-two bits of a lattice point's own.
pub(super) fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let mut bits = (x as u32)
        .wrapping_mul(0x8da6_b343)
        .wrapping_add((y as u32).wrapping_mul(0xd816_3841))
        .wrapping_add(seed.wrapping_mul(0xcb1a_b31f));
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x846c_a68b);
    bits ^ (bits >> 16)
}

/// Noise of wavelength 1 at a place, in about [−½, ½].
pub(super) fn noise(x: f64, y: f64, seed: u32) -> f32 {
    let (west, south) = (x.floor(), y.floor());
    let (u, v) = ((x - west) as f32, (y - south) as f32);
    // A lattice point's gradient has both components in [−1, 1), and rises to (dx, dy) from it.
    let rise = |i: i32, j: i32| {
        let bits = hash(west as i32 + i, south as i32 + j, seed);
        let component = |bits: u32| (bits & 0xffff) as f32 / 32_768.0 - 1.0;
        component(bits) * (u - i as f32) + component(bits >> 16) * (v - j as f32)
    };
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mix = |from: f32, to: f32, share: f32| from + (to - from) * share;
    let across = fade(u);
    mix(
        mix(rise(0, 0), rise(1, 0), across),
        mix(rise(0, 1), rise(1, 1), across),
        fade(v),
    )
}
