//! Gradient noise with its slope, a pure function of place and seed.

/// A value in about [−1, 1], and its slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    pub value: f32,
    pub slope: [f32; 2],
}

const DIAGONAL: f32 = std::f32::consts::FRAC_1_SQRT_2;
const FLAT: f32 = 0.382_683_43;
const STEEP: f32 = 0.923_879_5;
/// Sixteen directions.
const GRADIENTS: [[f32; 2]; 16] = [
    [1.0, 0.0],
    [STEEP, FLAT],
    [DIAGONAL, DIAGONAL],
    [FLAT, STEEP],
    [0.0, 1.0],
    [-FLAT, STEEP],
    [-DIAGONAL, DIAGONAL],
    [-STEEP, FLAT],
    [-1.0, 0.0],
    [-STEEP, -FLAT],
    [-DIAGONAL, -DIAGONAL],
    [-FLAT, -STEEP],
    [0.0, -1.0],
    [FLAT, -STEEP],
    [DIAGONAL, -DIAGONAL],
    [STEEP, -FLAT],
];

/// Thirty-two bits of a lattice point's own.
pub(super) fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let mut hash =
        (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77) ^ seed;
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    hash = (hash ^ (hash >> 12)).wrapping_mul(0x297a_2d39);
    hash ^ (hash >> 15)
}

fn gradient(x: i32, y: i32, seed: u32) -> [f32; 2] {
    GRADIENTS[(hash(x, y, seed) >> 28) as usize]
}

/// The whole number at or below a coordinate, and what is left. A call of floor is slow where the
/// processor has no word for it.
pub(super) fn cell(at: f64) -> (i32, f32) {
    let towards_zero = at as i32;
    let whole = towards_zero - i32::from(at < f64::from(towards_zero));
    (whole, (at - f64::from(whole)) as f32)
}

/// Noise of wavelength 1 at a place.
pub(super) fn noise(x: f64, y: f64, seed: u32) -> Noise {
    let ((cx, u), (cy, v)) = (cell(x), cell(y));
    let corner = |dx: i32, dy: i32| {
        let [gx, gy] = gradient(cx.wrapping_add(dx), cy.wrapping_add(dy), seed);
        (gx, gy, gx * (u - dx as f32) + gy * (v - dy as f32))
    };
    let (sw, se, nw, ne) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
    // Quintic fades and their slopes.
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let fade_slope = |t: f32| 30.0 * t * t * (t * (t - 2.0) + 1.0);
    let (s, t) = (fade(u), fade(v));
    let (ds, dt) = (fade_slope(u), fade_slope(v));
    let (k1, k2, k3) = (se.2 - sw.2, nw.2 - sw.2, sw.2 - se.2 - nw.2 + ne.2);
    let blend =
        |a: f32, b: f32, c: f32, d: f32| a + s * (b - a) + t * (c - a) + s * t * (a - b - c + d);
    // Gradient noise reaches ±1/√2.
    let scale = std::f32::consts::SQRT_2;
    Noise {
        value: scale * blend(sw.2, se.2, nw.2, ne.2),
        slope: [
            scale * (blend(sw.0, se.0, nw.0, ne.0) + ds * (k1 + t * k3)),
            scale * (blend(sw.1, se.1, nw.1, ne.1) + dt * (k2 + s * k3)),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_the_value() {
        for step in 0..200 {
            let (x, y) = (f64::from(step) * 0.37 - 20.0, f64::from(step) * -0.61 + 7.0);
            let here = noise(x, y, 9);
            let by = 1e-3;
            let east = (noise(x + by, y, 9).value - noise(x - by, y, 9).value) / (2.0 * by as f32);
            let north = (noise(x, y + by, 9).value - noise(x, y - by, 9).value) / (2.0 * by as f32);
            assert!(
                (here.slope[0] - east).abs() < 5e-3,
                "{here:?} against {east}"
            );
            assert!(
                (here.slope[1] - north).abs() < 5e-3,
                "{here:?} against {north}"
            );
            assert!(here.value.abs() <= 1.001);
        }
    }
}
