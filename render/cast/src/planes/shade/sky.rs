//! The sky's colours.

use super::{Shader, Shading};
use crate::lanes::{LANES, Lanes, groups_mut};
use crate::planes::rows::Directions;
use crate::shade::{DEPTHS, HAZE, HORIZON, ZENITH};

impl Shader<'_> {
    /// Writes the colours and depths of lanes of a step that see nothing but the sky.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "which pixels, and where they go")]
    pub(in crate::planes) fn shade_sky<L: Lanes>(
        &self,
        l: L,
        directions: &Directions,
        step: u32,
        [first, behind]: [i32; 2],
        shading: &mut Shading,
        colours: &mut [i32],
        depths: &mut [f32],
    ) {
        let count = (behind - first) as usize;
        depths[..count].fill(f32::INFINITY);
        shading.sky[..count.div_ceil(LANES)].fill(u16::MAX);
        self.colour_skies(l, directions, step, [first, behind], shading, colours);
    }

    /// Colours those of a step's lanes that see the sky.
    ///
    /// Two loops: all of it is one chain, of which hardly two fit a processor's window.
    #[inline(always)]
    pub(super) fn colour_skies<L: Lanes>(
        &self,
        l: L,
        directions: &Directions,
        step: u32,
        lanes: [i32; 2],
        shading: &mut Shading,
        colours: &mut [i32],
    ) {
        l.vectorize(
            #[inline(always)]
            || self.skies(l, directions, step, lanes, shading, colours),
        );
    }

    #[inline(always)]
    fn skies<L: Lanes>(
        &self,
        l: L,
        directions: &Directions,
        step: u32,
        [first, behind]: [i32; 2],
        shading: &mut Shading,
        colours: &mut [i32],
    ) {
        let count = ((behind - first) as usize).div_ceil(LANES);
        let sky = &shading.sky[..count];
        let up = groups_mut(&mut shading.up, count);
        let colours = groups_mut(colours, count);
        let numbers = l.load(&std::array::from_fn(|k| k as f32));
        let first = directions.at(step, first).as_vec3();
        let lane = directions.lane.as_vec3();
        let major = l.add(l.splat(first.x), l.mul(l.splat(lane.x), numbers));
        let minor = l.add(l.splat(first.y), l.mul(l.splat(lane.y), numbers));
        let height = l.add(l.splat(first.z), l.mul(l.splat(lane.z), numbers));
        for number in 0..count {
            if sky[number] != 0 {
                let further = lane * (number * LANES) as f32;
                let height = l.add(height, l.splat(further.z));
                let direction = [
                    l.add(major, l.splat(further.x)),
                    l.add(minor, l.splat(further.y)),
                    height,
                ];
                l.store(l.div(height, self.metres_of(l, direction)), &mut up[number]);
            }
        }
        for number in 0..count {
            if sky[number] != 0 {
                let colour = sky_colours(l, l.load(&up[number]));
                let ground = l.load_i(&colours[number]);
                let colour = l.select_i(l.mask(sky[number]), colour, ground);
                l.store_i(colour, &mut colours[number]);
            }
        }
    }
}

/// The sky's colours along directions of which the sine of the angle over the horizon is `up`.
#[inline(always)]
pub(in crate::planes) fn sky_colours<L: Lanes>(l: L, up: L::F) -> L::I {
    let zero = l.splat(0.0);
    let over = l.le(zero, up);
    let mut share = l.sqrt(l.max(up, zero));
    let mut far = [l.splat(ZENITH[0]), l.splat(ZENITH[1]), l.splat(ZENITH[2])];
    if l.bits(over) != u16::MAX {
        let below = l.min(l.mul(up, l.splat(-1.0 / HAZE)), l.splat(1.0));
        let haze = l.mul(below, l.sub(l.splat(2.0), below));
        share = l.select(over, share, haze);
        for k in 0..3 {
            far[k] = l.select(over, far[k], l.splat(DEPTHS[k]));
        }
    }
    let mut colour = l.splat_i(255 << 24);
    for k in 0..3 {
        let horizon = l.splat(HORIZON[k]);
        let mixed = l.add(horizon, l.mul(l.sub(far[k], horizon), share));
        let byte = l.to_int(l.add(mixed, l.splat(0.5)));
        colour = l.add_i(colour, l.shl_i(byte, l.splat_i(8 * k as i32)));
    }
    colour
}
