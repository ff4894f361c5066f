//! The ground's own colours: the tint of its height, in its shaded relief.

use super::Shader;
use crate::lanes::{LANES, Lanes};
use crate::planes::field::Tiles;
use sandtable_terrain::{Ground, hypsometric_tints};
use std::sync::LazyLock;

/// The ground's own colours, where there is no photo.
pub(super) struct Tints<'a> {
    light: Tiles<'a, u8>,
    low: f32,
    /// Tints for each metre.
    steps: f32,
    /// Red, green and blue of each tint, as bits of floats.
    channels: &'static [[u32; 512]; 3],
}

impl<'a> Tints<'a> {
    pub(super) fn new(ground: &'a Ground) -> Option<Self> {
        let light = ground.light()?;
        static CHANNELS: LazyLock<[[u32; 512]; 3]> =
            LazyLock::new(|| [0, 1, 2].map(|k| hypsometric_tints().map(|tint| tint[k].to_bits())));
        let [low, high] = ground.range();
        let steps = (hypsometric_tints().len() - 1) as f32;
        Some(Self {
            light: Tiles::new(light.view(), light.tiles_across(), light.tile_stride()),
            low,
            steps: if high > low {
                steps / (high - low)
            } else {
                0.0
            },
            channels: &CHANNELS,
        })
    }
}

impl Shader<'_> {
    /// The ground's own colours where rays reached it: hypsometric tints in shaded relief, as
    /// [`Ground::colour_at`](sandtable_terrain::Ground::colour_at) has them without a photo.
    #[inline(always)]
    pub(super) fn tints<L: Lanes>(
        &self,
        l: L,
        mask: L::M,
        tints: &Tints<'_>,
        reached: L::F,
        advance: L::F,
    ) -> L::I {
        let field = self.field;
        // How far into its cell each place lies, eastwards and northwards.
        let cell = field.cell_at(l, reached, advance);
        let aside = l.mul(reached, advance);
        let major = field.major.inside(l, reached, cell[0]);
        let minor = field.minor.inside(l, aside, cell[1]);
        let [east, north] = if field.major_axis == 0 {
            [major, minor]
        } else {
            [minor, major]
        };
        let [x, y] = field.cells(l, cell[0], cell[1]);
        let place = tints.light.only(l, mask, tints.light.place(l, x, y));
        let light = l.byte_cells(&tints.light.items, place, tints.light.stride);
        let light = bilinear(l, light, east, north);
        // The ground's height, not the hit's: a wall has the colours of the columns behind it.
        let place = field.heights.only(l, mask, field.heights.place(l, x, y));
        let mut places = [0; LANES];
        l.store_i(place, &mut places);
        let height = l.cells(&field.heights.items, &places, field.heights.stride);
        let height = bilinear(l, height, east, north);
        let share = l.mul(l.sub(height, l.splat(tints.low)), l.splat(tints.steps));
        let step = l.to_int(l.max(l.add(share, l.splat(0.5)), l.splat(0.0)));
        let gain = l.mul(light, l.splat(2.0 / 256.0));
        let mut colour = l.splat_i(255 << 24);
        for (k, channel) in tints.channels.iter().enumerate() {
            let tint = l.float_of_bits(l.look_up(channel, step));
            let byte = l.to_int(l.min(l.mul(tint, gain), l.splat(255.0)));
            colour = l.add_i(colour, l.shl_i(byte, l.splat_i(8 * k as i32)));
        }
        colour
    }
}

/// Blends a cell's corners (south-west, south-east, north-west, north-east) at a place in it.
#[inline(always)]
fn bilinear<L: Lanes>(l: L, [sw, se, nw, ne]: [L::F; 4], east: L::F, north: L::F) -> L::F {
    let south = l.add(sw, l.mul(l.sub(se, sw), east));
    let north_row = l.add(nw, l.mul(l.sub(ne, nw), east));
    l.add(south, l.mul(l.sub(north_row, south), north))
}
