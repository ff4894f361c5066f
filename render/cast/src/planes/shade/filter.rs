//! Colours at the resolution of pixels' footprints.

use super::{Chunk, Shader, Shading};
use crate::lanes::{LANES, Lanes, Texels, group, group_mut};
use crate::planes::footprint::{Sampling, are_small, filters, most_small};
use crate::planes::texture::{Halves, Located, Mipmapped};
use crate::planes::wave::{CAPACITY, Column};

/// Where colours lie in a texture, and the weights of eastern and northern texels in fixed point.
#[repr(align(64))]
pub(super) struct Half {
    pub(super) at: Column<i32>,
    pub(super) east: Column<i32>,
    pub(super) north: Column<i32>,
}

impl Default for Half {
    fn default() -> Self {
        Self {
            at: [0; CAPACITY],
            east: [0; CAPACITY],
            north: [0; CAPACITY],
        }
    }
}

impl Half {
    #[inline(always)]
    fn put<L: Lanes>(&mut self, l: L, at: usize, located: &Located<L>) {
        l.store_i(located.at, group_mut(&mut self.at, at));
        l.store_i(located.east, group_mut(&mut self.east, at));
        l.store_i(located.north, group_mut(&mut self.north, at));
    }

    #[inline(always)]
    pub(super) fn texels<L: Lanes>(&self, l: L, at: usize) -> Texels<'_, L> {
        Texels {
            at: group(&self.at, at),
            east: l.load_i(group(&self.east, at)),
            north: l.load_i(group(&self.north, at)),
        }
    }
}

/// For how many chunks it is not looked whether footprints are small where few groups' were.
const REST: u32 = 31;

impl Shader<'_> {
    /// Colours the pixels of `shading.rest` from a texture, each by the filter of its footprint,
    /// and leaves those there that it has no colours for.
    ///
    /// A footprint's colour is that of its two halves, in the texture's level of their width. Where
    /// a tinted pixel covers no more than a post, the tint of its own height is as good.
    #[inline(always)]
    pub(super) fn filter<L: Lanes>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        texture: &Mipmapped<'_>,
        shading: &mut Shading,
        colours: &mut [i32],
    ) {
        let groups = chunk.count.div_ceil(LANES);
        let is_photo = self.textures[0]
            .as_ref()
            .is_some_and(|photo| std::ptr::eq(photo, texture));
        l.vectorize(
            #[inline(always)]
            || self.locate_small(l, chunk, texture, is_photo, shading),
        );
        if shading.filtered[..groups].iter().any(|&wanted| wanted != 0) {
            l.vectorize(
                #[inline(always)]
                || {
                    let [major, minor] = texture.scale;
                    let to_pixels = |[along, aside]: [f32; 2]| [along * major, aside * minor];
                    let sampling = Sampling {
                        levels: texture.frame.levels,
                        scale: texture.scale,
                        begins: self.begins.map(to_pixels),
                        blur: self.blur,
                    };
                    filters(
                        l,
                        &sampling,
                        &chunk.around,
                        &shading.filtered[..groups],
                        &mut shading.filters,
                    );
                },
            );
            l.vectorize(
                #[inline(always)]
                || self.locate_halves(l, chunk, texture, is_photo, shading),
            );
        }
        l.vectorize(
            #[inline(always)]
            || {
                if self.large {
                    let tiles = &texture.frame.tiles;
                    for at in (0..chunk.count).step_by(LANES) {
                        if shading.on[at / LANES] & shading.rest[at / LANES] != 0 {
                            let halves = 1 + usize::from(shading.filters.two[at / LANES] != 0);
                            for half in &shading.halves[..halves] {
                                let place = group(&half.at, at);
                                l.prefetch::<_, 1>(&tiles.items, place, 0);
                                l.prefetch::<_, 1>(&tiles.items, place, tiles.stride as i32);
                            }
                        }
                    }
                }
                for at in (0..chunk.count).step_by(LANES) {
                    let number = at / LANES;
                    let on = shading.on[number] & shading.rest[number];
                    if on == 0 {
                        continue;
                    }
                    let tiles = &texture.frame.tiles;
                    let [first, second] = &shading.halves;
                    let first = first.texels(l, at);
                    let texels = if shading.filters.two[number] & on != 0 {
                        let places = [first, second.texels(l, at)];
                        l.mean_texels(&tiles.items, tiles.stride, places)
                    } else {
                        // Magnified, colours change by little from pixel to pixel. Weights have been
                        // rounded down, by half a part on average.
                        let share = |weight: L::I| {
                            let parts = l.add(l.to_float(weight), l.splat(0.5));
                            l.mul(parts, l.splat(1.0 / 32768.0))
                        };
                        let (east, north) = (share(first.east), share(first.north));
                        l.texels(&tiles.items, first.at, tiles.stride, east, north)
                    };
                    // The mean of coverage is 255 where both have 255, or one 254: none has.
                    let whole = l.eq_i(l.shr_i(texels, l.splat_i(24)), l.splat_i(-1));
                    let on = l.and(l.mask(on), whole);
                    let colours = group_mut(colours, at);
                    l.store_i(l.select_i(on, texels, l.load_i(colours)), colours);
                    shading.rest[number] &= !l.bits(on);
                }
            },
        );
    }

    /// Locates the colours of groups of which all footprints are small: there one place is enough, and
    /// most near ground is like that. The others are left to be filtered.
    #[inline(always)]
    fn locate_small<L: Lanes>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        texture: &Mipmapped<'_>,
        is_photo: bool,
        shading: &mut Shading,
    ) {
        let groups = chunk.count.div_ceil(LANES);
        shading.on[..groups].fill(0);
        if shading.all_filtered > 0 {
            shading.all_filtered -= 1;
            shading.filtered[..groups].copy_from_slice(&shading.rest[..groups]);
            return;
        }
        let most = most_small(self.blur);
        let (mut all, mut filtered) = (0, 0);
        for at in (0..chunk.count).step_by(LANES) {
            let number = at / LANES;
            let wanted = shading.rest[number];
            shading.filtered[number] = 0;
            if wanted == 0 {
                continue;
            }
            all += 1;
            let small = are_small(l, texture.scale, most, &chunk.around, wanted, at);
            if l.bits(small) & wanted != wanted {
                shading.filtered[number] = wanted;
                filtered += 1;
            } else if is_photo {
                let reached = l.load(group(chunk.reached, at));
                let advance = l.load(group(chunk.advance, at));
                let middle = texture.pixels_to(l, reached, advance);
                let (located, on) = texture.locate_small(l, l.mask(wanted), middle);
                shading.on[number] = l.bits(on);
                shading.filters.two[number] = 0;
                shading.halves[0].put(l, at, &located);
            }
        }
        if 2 * filtered > all {
            shading.all_filtered = REST;
        }
    }

    /// Locates the halves of footprints that are filtered.
    #[inline(always)]
    fn locate_halves<L: Lanes>(
        &self,
        l: L,
        chunk: &Chunk<'_>,
        texture: &Mipmapped<'_>,
        is_photo: bool,
        shading: &mut Shading,
    ) {
        for at in (0..chunk.count).step_by(LANES) {
            let number = at / LANES;
            let mut wanted = shading.filtered[number];
            if wanted == 0 {
                continue;
            }
            let filters = &mut shading.filters;
            let halves = Halves {
                aside: [
                    l.load(group(&filters.major, at)),
                    l.load(group(&filters.minor, at)),
                ],
                levels: [
                    l.load_i(group(&filters.levels[0], at)),
                    l.load_i(group(&filters.levels[1], at)),
                ],
            };
            if !is_photo {
                wanted &= l.bits(l.gt_i(halves.levels[0], l.splat_i(0)));
            }
            let reached = l.load(group(chunk.reached, at));
            let advance = l.load(group(chunk.advance, at));
            let middle = texture.pixels_to(l, reached, advance);
            let (located, on) = texture.locate(l, l.mask(wanted), middle, &halves);
            shading.on[number] = l.bits(on);
            for (to, half) in shading.halves.iter_mut().zip(&located) {
                to.put(l, at, half);
            }
        }
    }
}
