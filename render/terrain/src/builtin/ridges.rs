//! Mountains out of noise, cut by gullies as water would cut them.
//!
//! Broad relief comes from a few octaves of gradient noise, ridged at the broadest. Gullies are
//! stripes laid across the slope: around random centres, waves run along the contour, so that
//! their troughs run downhill; the sum over near centres is smooth. Each octave takes the slope
//! that the coarser ones have left, so that gullies branch. On level ground there are none.
//!
//! All of it is polynomials of place and seed: the same post is the same on every machine.

use super::noise::{cell, hash, noise};

/// Length of the broadest mountains, metres.
const RANGE_LENGTH: f64 = 15_000.0;
/// Length of a wave of the broadest gullies, metres.
const GULLY_LENGTH: f64 = 2_600.0;
const BROAD_OCTAVES: u32 = 4;
const GULLY_OCTAVES: u32 = 5;
/// Height of gullies over their length.
const GULLY_DEPTH: f32 = 0.13;
/// Cosine and sine of the turn from one octave to the next.
const TURN: [f64; 2] = [0.8, 0.6];

/// The cells around a place, filled up to a multiple of four with ones too far to count.
const CELLS: usize = 12;
const NEAR_CELLS: [[i32; 2]; CELLS] = [
    [-1, -1],
    [0, -1],
    [1, -1],
    [-1, 0],
    [0, 0],
    [1, 0],
    [-1, 1],
    [0, 1],
    [1, 1],
    [9, 9],
    [9, 9],
    [9, 9],
];

/// One world of mountains.
pub(super) struct Ridges {
    seed: u32,
}

/// A height and its slope.
#[derive(Clone, Copy)]
struct Relief {
    height: f32,
    slope: [f32; 2],
}

impl Relief {
    fn add(&mut self, height: f32, slope: [f32; 2]) {
        self.height += height;
        self.slope = [self.slope[0] + slope[0], self.slope[1] + slope[1]];
    }
}

impl Ridges {
    pub(super) fn new(seed: u64) -> Self {
        let mixed = (seed ^ (seed >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        Self {
            seed: (mixed >> 32) as u32,
        }
    }

    fn layer(&self, index: u32) -> u32 {
        self.seed.wrapping_add(index.wrapping_mul(0x632b_e5ab))
    }

    /// Height in metres at a place in metres.
    pub(super) fn height(&self, x: f64, y: f64) -> f32 {
        let mut relief = self.broad(x, y);
        // Valley floors and plains are filled; the higher, the deeper the cuts.
        let exposed = smooth_step(150.0, 800.0, relief.height);
        let (mut x, mut y) = (x, y);
        let mut length = GULLY_LENGTH;
        let mut share = GULLY_DEPTH;
        for octave in 0..GULLY_OCTAVES {
            let steepness = relief.slope[0].hypot(relief.slope[1]);
            // Waves run along the contour, at full frequency where it is steep.
            let along = 1.2 / (steepness + 0.05);
            let wave = [-relief.slope[1] * along, relief.slope[0] * along];
            let gully = gully(x / length, y / length, wave, self.layer(50 + octave));
            let slope = share * exposed * (0.2 + 0.8 * smooth_step(0.0, 0.25, steepness));
            let depth = slope * length as f32;
            relief.add(depth * gully.height, gully.slope.map(|along| slope * along));
            share *= 0.78;
            length *= 0.49;
            // Turned, so that no lattice shows through the octaves.
            (x, y) = (TURN[0] * x - TURN[1] * y, TURN[1] * x + TURN[0] * y);
            let [east, north] = relief.slope;
            let turn = TURN.map(|part| part as f32);
            relief.slope = [
                turn[0] * east - turn[1] * north,
                turn[1] * east + turn[0] * north,
            ];
        }
        relief.height
    }

    /// Ranges, valleys and plains.
    fn broad(&self, x: f64, y: f64) -> Relief {
        // Ranges bend, spurs wander. The bend is broad enough to leave its slope out.
        let bend = |layer| f64::from(noise(x / 17_000.0, y / 17_000.0, self.layer(layer)).value);
        let (px, py) = (x + 2_600.0 * bend(100), y + 2_600.0 * bend(101));
        let land = noise(x / 45_000.0, y / 45_000.0, self.layer(102)).value;
        let uplift = 2_400.0 * (0.75 + 0.75 * land).clamp(0.15, 1.3);

        // The broadest octave is a crest, rounded a little.
        let n = noise(px / RANGE_LENGTH, py / RANGE_LENGTH, self.layer(0));
        let rounded = (n.value * n.value + 0.006).sqrt();
        let crest = 1.0 - rounded;
        let per_metre = 2.0 * crest * -n.value / rounded / RANGE_LENGTH as f32 * uplift;
        let mut relief = Relief {
            height: uplift * crest * crest,
            slope: n.slope.map(|slope| slope * per_metre),
        };
        let mut length = RANGE_LENGTH * 0.45;
        let mut height = 0.30 * uplift;
        for octave in 1..BROAD_OCTAVES {
            let n = noise(px / length, py / length, self.layer(octave));
            // Finer hills stand on the flanks rather than in the valleys.
            let gain = height * (0.35 + 0.65 * crest);
            relief.add(
                gain * n.value,
                n.slope.map(|slope| slope * gain / length as f32),
            );
            length *= 0.48;
            height *= 0.46;
        }
        relief.height += 150.0;
        relief
    }
}

/// Waves around random centres near a place, in cells: 1 on crests, −1 in troughs; and the slope
/// of that.
fn gully(x: f64, y: f64, wave: [f32; 2], seed: u32) -> Relief {
    let ((cell_x, u), (cell_y, v)) = (cell(x), cell(y));
    // One loop a step over all cells, so that the compiler takes four at once.
    let mut bits = [0_u32; CELLS];
    for (bits, [dx, dy]) in bits.iter_mut().zip(NEAR_CELLS) {
        *bits = hash(cell_x.wrapping_add(dx), cell_y.wrapping_add(dy), seed);
    }
    let jitter = |bits: u32| 0.2 + (bits & 0xffff) as i32 as f32 * (0.6 / 65_536.0);
    let (mut cosines, mut sines, mut weights) =
        ([0.0_f32; CELLS], [0.0_f32; CELLS], [0.0_f32; CELLS]);
    for lane in 0..CELLS {
        let [dx, dy] = NEAR_CELLS[lane];
        let across = u - dx as f32 - jitter(bits[lane]);
        let up = v - dy as f32 - jitter(bits[lane] >> 16);
        // No centre further than 1.2 cells counts, and none within is left out.
        let near = (1.0 - (across * across + up * up) * (1.0 / (1.2 * 1.2))).max(0.0);
        let weight = near * near * near;
        let (s, c) = sine_cosine(across * wave[0] + up * wave[1]);
        cosines[lane] = weight * c;
        sines[lane] = weight * s;
        weights[lane] = weight;
    }
    let sum = |lanes: [f32; CELLS]| {
        let mut four = [0.0_f32; 4];
        for chunk in lanes.chunks_exact(4) {
            for (sum, lane) in four.iter_mut().zip(chunk) {
                *sum += lane;
            }
        }
        (four[0] + four[1]) + (four[2] + four[3])
    };
    let (cosine, sine, weights) = (sum(cosines), sum(sines), sum(weights) + 1e-6);
    let (cosine, sine) = (cosine / weights, sine / weights);
    // The root of 1 − cos makes crests sharp and leaves troughs round.
    let trough = (0.5 * (1.0 - cosine) + 0.012).max(0.0).sqrt();
    let slope = -std::f32::consts::FRAC_PI_2 * sine / trough;
    Relief {
        height: 1.0 - 2.0 * trough,
        slope: wave.map(|along| slope * along),
    }
}

/// Sine and cosine of an angle in turns, within 1e-3.
fn sine_cosine(turns: f32) -> (f32, f32) {
    let sine = |turns: f32| {
        // Adding and taking 1.5 · 2²³ leaves the nearest whole number; a call of round is slow.
        let t = turns - ((turns + 12_582_912.0) - 12_582_912.0);
        // A parabola through the zeros and extremes, then bent to fit.
        let parabola = 8.0 * t - 16.0 * t * t.abs();
        parabola * (0.776 + 0.224 * parabola.abs())
    };
    (sine(turns), sine(turns + 0.25))
}

fn smooth_step(from: f32, to: f32, at: f32) -> f32 {
    let t = ((at - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_near_the_true_ones() {
        for step in -40..40 {
            let turns = step as f32 * 0.071;
            let (sine, cosine) = sine_cosine(turns);
            let angle = turns * std::f32::consts::TAU;
            assert!((sine - angle.sin()).abs() < 2e-3, "{turns}");
            assert!((cosine - angle.cos()).abs() < 2e-3, "{turns}");
        }
    }

    #[test]
    fn the_surface_has_no_jumps() {
        let ridges = Ridges::new(3);
        for step in 0..4000 {
            let (x, y) = (f64::from(step) * 13.7, f64::from(step) * -7.3);
            let rise = ridges.height(x + 0.5, y) - ridges.height(x, y);
            assert!(rise.abs() < 1.5, "{rise} m within half a metre at {x}, {y}");
        }
    }
}
