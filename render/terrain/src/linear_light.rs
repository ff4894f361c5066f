//! sRGB to linear light and back, by table.
//!
//! Means of colours are means of light, so they are taken on decoded values. Both ways are as
//! exact as the formula of IEC 61966-2-1, without a power a pixel.

use std::sync::LazyLock;

/// Steps of the table that leads from light to a code. The codes' thresholds lie at least 1/3295
/// apart, so no step holds more than one.
const STEPS: usize = 4096;

/// Tables between sRGB codes and linear light in [0, 1].
#[derive(Debug)]
pub struct LinearLight {
    decoded: [f32; 256],
    /// The least light that is encoded as this code or a higher one.
    thresholds: [f32; 256],
    /// The code of the least light in each step.
    first: [u8; STEPS + 1],
}

static TABLES: LazyLock<LinearLight> = LazyLock::new(LinearLight::new);

impl LinearLight {
    /// The tables; computed once.
    #[must_use]
    pub fn tables() -> &'static Self {
        &TABLES
    }

    fn new() -> Self {
        let mut thresholds = [0.0; 256];
        for (code, threshold) in thresholds.iter_mut().enumerate().skip(1) {
            let exact = light((code as f64 - 0.5) / 255.0);
            let near = exact as f32;
            // The first value on or above the exact threshold, so that comparing `f32`s is exact.
            *threshold = if f64::from(near) < exact {
                near.next_up()
            } else {
                near
            };
        }
        let mut first = [0; STEPS + 1];
        for (step, first) in first.iter_mut().enumerate() {
            let least = step as f32 / STEPS as f32;
            *first = (thresholds.partition_point(|&threshold| threshold <= least) - 1) as u8;
        }
        Self {
            decoded: std::array::from_fn(|code| light(code as f64 / 255.0) as f32),
            thresholds,
            first,
        }
    }

    /// The linear light of an sRGB code: 0 for 0, 1 for 255.
    #[inline]
    #[must_use]
    pub fn decode(&self, code: u8) -> f32 {
        self.decoded[usize::from(code)]
    }

    /// The nearest sRGB code to a linear light. Light off [0, 1] saturates; NaN gives 0.
    #[inline]
    #[must_use]
    pub fn encode(&self, light: f32) -> u8 {
        let light = light.clamp(0.0, 1.0);
        let code = self.first[(light * STEPS as f32) as usize];
        if code < 255 && light >= self.thresholds[usize::from(code) + 1] {
            code + 1
        } else {
            code
        }
    }
}

/// The light of an encoded value in [0, 1].
fn light(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The encoding as the standard writes it.
    fn formula(light: f32) -> u8 {
        let light = f64::from(light);
        let encoded = if light <= 0.003_130_8 {
            12.92 * light
        } else {
            1.055 * light.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * encoded).round() as u8
    }

    #[test]
    fn codes_survive_the_way_there_and_back() {
        let tables = LinearLight::tables();
        for code in 0..=255 {
            assert_eq!(tables.encode(tables.decode(code)), code);
        }
        assert_eq!((tables.decode(0), tables.decode(255)), (0.0, 1.0));
        // Known: middle grey of half the light is code 188.
        assert_eq!(tables.encode(0.5), 188);
    }

    #[test]
    fn encoding_is_the_formula_to_the_last_bit() {
        let tables = LinearLight::tables();
        for step in 0..=1_000_000 {
            let light = step as f32 / 1e6;
            assert_eq!(tables.encode(light), formula(light), "{light}");
        }
        // Around each threshold, where a search could be off by one.
        for code in 1..=255 {
            let exact = super::light((f64::from(code) - 0.5) / 255.0) as f32;
            for light in [exact.next_down().next_down(), exact.next_up().next_up()] {
                assert_eq!(tables.encode(light), formula(light), "{light}");
            }
        }
    }

    #[test]
    fn light_out_of_range_saturates() {
        let tables = LinearLight::tables();
        assert_eq!(tables.encode(-1.0), 0);
        assert_eq!(tables.encode(2.0), 255);
        assert_eq!(tables.encode(f32::INFINITY), 255);
        assert_eq!(tables.encode(f32::NAN), 0);
    }
}
