//! Colours: hypsometric tint and shaded relief, for ground without a photograph.

/// Red, green and blue, sRGB-encoded.
pub type Rgb = [u8; 3];

/// Heights, as shares of the ground's own range, and the colours there: lowland green over tan
/// and brown to snow.
const TINTS: [(f32, [f32; 3]); 7] = [
    (0.00, [86.0, 120.0, 84.0]),
    (0.15, [122.0, 148.0, 94.0]),
    (0.35, [186.0, 180.0, 126.0]),
    (0.55, [178.0, 148.0, 104.0]),
    (0.75, [152.0, 122.0, 100.0]),
    (0.90, [196.0, 190.0, 186.0]),
    (1.00, [246.0, 247.0, 250.0]),
];

/// [`TINTS`] at even steps, so that a colour is one look-up.
static TABLE: [[f32; 3]; 512] = {
    let mut table = [[0.0; 3]; 512];
    let mut at = 0;
    while at < table.len() {
        let share = at as f32 / (table.len() - 1) as f32;
        let mut upper = 1;
        while upper < TINTS.len() - 1 && share > TINTS[upper].0 {
            upper += 1;
        }
        let ((low, from), (high, to)) = (TINTS[upper - 1], TINTS[upper]);
        let mix = (share - low) / (high - low);
        let mut k = 0;
        while k < 3 {
            table[at][k] = from[k] + (to[k] - from[k]) * mix;
            k += 1;
        }
        at += 1;
    }
    table
};

/// The tints of heights from the ground's lowest to its highest, in even steps: red, green and blue
/// up to 255, under light that leaves them as they are.
#[must_use]
pub fn hypsometric_tints() -> &'static [[f32; 3]; 512] {
    &TABLE
}

/// The tint of a height given as its share of the ground's range, shaded by `light` in [0, 1]
/// where ½ leaves the tint as it is.
#[inline]
#[must_use]
pub fn hypsometric(share: f32, light: f32) -> Rgb {
    // A share off the range, or NaN, saturates.
    let at = (share * (TABLE.len() - 1) as f32 + 0.5) as usize;
    let tint = TABLE[at.min(TABLE.len() - 1)];
    let gain = 2.0 * light;
    [
        (tint[0] * gain) as u8,
        (tint[1] * gain) as u8,
        (tint[2] * gain) as u8,
    ]
}

/// Shaded relief as a byte: 128 is level ground. Light comes from the north-west, 45° high, as on
/// printed maps; `east` and `north` are the ground's slopes (metres a metre) there.
#[must_use]
pub(crate) fn relief_light(east: f32, north: f32) -> u8 {
    // The light's direction is (−½, ½, 1/√2); level ground answers with 1/√2.
    let cosine = (0.5 * east - 0.5 * north + std::f32::consts::FRAC_1_SQRT_2)
        / (1.0 + east * east + north * north).sqrt();
    let relative = cosine.max(0.0) * std::f32::consts::SQRT_2;
    // Never wholly black: the sky lights the shadows.
    ((0.25 + 0.75 * relative) * 128.0 + 0.5).clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_towards_the_light_are_brighter() {
        let level = relief_light(0.0, 0.0);
        assert_eq!(level, 128);
        // Rising to the east faces west; rising to the north faces south.
        assert!(relief_light(0.5, 0.0) > level && relief_light(0.0, -0.5) > level);
        assert!(relief_light(-0.5, 0.0) < level && relief_light(0.0, 0.5) < level);
    }

    #[test]
    fn tints_run_from_green_to_snow() {
        let [r, g, b] = hypsometric(0.0, 0.5);
        assert!(g > r && g > b);
        assert!(hypsometric(1.0, 0.5).iter().all(|&c| c > 240));
    }
}
