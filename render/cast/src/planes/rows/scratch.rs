//! What a thread needs to cast a sector: the last steps' rays and those on their way.

use super::extrapolate::Foretold;
use super::left::Left;
use super::look_back::Before;
use super::predecessor::Steep;
use super::sky::SkyLanes;
use super::strips::StripsKept;
use crate::canvas::Canvas;
use crate::lanes::LANES;
use crate::planes::depart::Departure;
use crate::planes::frame::Frame;
use crate::planes::numbers::Numbers;
use crate::planes::patches::Patches;
use crate::planes::pixels::PixelBlock;
use crate::planes::sectors::Sector;
use crate::planes::shade::Shading;
use crate::planes::steepness::SQUARE;
use crate::planes::walk::Passage;
use crate::planes::wave::{CHUNK, Waves};
use sandtable_terrain::use_huge_pages;

/// How many steps back the ray may lie from which one begins.
pub(super) const MEMORY: usize = 8;

/// What a thread needs to cast a sector, kept from one sector to the next.
#[derive(Default)]
pub(in crate::planes) struct Scratch {
    /// For the last steps, how far each lane's ray came: to its hit, or (negative) to where it left
    /// the ground or, while it is on its way, to where it is clear.
    pub(super) reached: Numbers<f32>,
    pub(super) lanes: [[i32; 2]; MEMORY],
    /// Where rays keep their strips: up to where no ground inside them is over the rays, as far as these have
    /// come.
    pub(super) clear: Numbers<f32>,
    pub(super) strips: StripsKept,
    /// How steep the ground is at most around a step's lanes: a number for each 2 ^ [`SQUARE`] of them, which
    /// holds for those of the next two squares, too.
    pub(super) steepest: Vec<Steep>,
    /// The rays of these steps, for their colours.
    pub(super) advance: Numbers<f32>,
    pub(super) slope: Numbers<f32>,
    /// And the ground that they met, where it is of use.
    pub(super) patches: Patches,
    pub(super) keeps_patches: bool,
    /// A step's rays for whose ends it takes more than that.
    pub(super) left: Box<Left>,
    pub(super) foretold: Box<Foretold>,
    /// What the planes of a fan see, in a row for each step: colours (of which the fourth byte tells
    /// the ground's share, and the others the light of that share) and, as the bits of a float, one
    /// over how many of its direction's lengths away the ground is (0 where it is sky).
    pub(super) seen: Vec<[i32; 2]>,
    /// The rays of the last steps that see the sky.
    pub(super) sky: [SkyLanes; MEMORY],
    /// For each chunk of a step, from which rays its rays begin.
    pub(super) befores: Vec<Before>,
    /// For each chunk of the last steps, which of its lanes are led over the ground.
    led: Vec<[i32; 2]>,
    /// For each few planes that go together, the step of a fan from which on they see the sky alone.
    pub(super) skies: Vec<u32>,
    /// From this step on rays lie between planes.
    pub(super) far_from: u32,
    /// The rays on their way over each of the ground's resolutions.
    pub(super) waves: Vec<Waves>,
    pub(super) departure: Box<Departure>,
    pub(super) passage: Box<Passage>,
    pub(super) shading: Box<Shading>,
    /// Colours and depths of the last steps.
    pub(super) pixels: PixelBlock,
    #[cfg(debug_assertions)]
    left_sky: bool,
    /// How many sectors have been begun.
    #[cfg(debug_assertions)]
    begun: usize,
}

impl Scratch {
    /// Takes out [`Scratch::seen`], with room for at least so many pixels.
    pub(super) fn take_seen(&mut self, room: usize) -> Vec<[i32; 2]> {
        let mut seen = std::mem::take(&mut self.seen);
        if seen.len() < room {
            seen = Vec::with_capacity(room);
            use_huge_pages(seen.spare_capacity_mut());
            seen.resize(room, [0; 2]);
        }
        #[cfg(debug_assertions)]
        seen[..room].fill(self.left_over());
        seen
    }

    /// Takes out [`Scratch::befores`], made ready for a sector.
    pub(super) fn take_befores(&mut self, frame: &Frame<'_>, sector: &Sector) -> Vec<Before> {
        let mut befores = std::mem::take(&mut self.befores);
        let width = frame.rays.size[1 - sector.step_axis] as usize;
        befores.clear();
        befores.resize(width.div_ceil(CHUNK), Before::new());
        befores
    }

    /// What stands for pixels that have been left of other casts: sky, and next time no number, so that
    /// tests see the difference where they are read.
    #[cfg(debug_assertions)]
    fn left_over(&mut self) -> [i32; 2] {
        self.left_sky = !self.left_sky;
        if self.left_sky {
            [0; 2]
        } else {
            [f32::NAN.to_bits() as i32; 2]
        }
    }

    /// Which lanes are led over the ground of the chunk of a step that begins `lanes` behind its first
    /// lane.
    pub(super) fn led(&mut self, step: u32, lanes: i32) -> &mut [i32; 2] {
        let chunks = self.led.len() / MEMORY;
        &mut self.led[step as usize % MEMORY * chunks + lanes as usize / CHUNK]
    }

    /// How steep the ground is at most around a lane and the [`BLOCK`] behind it.
    #[inline(always)]
    pub(super) fn steepest_around(&self, lane: i32) -> Steep {
        self.steepest[lane as usize >> SQUARE]
    }

    /// How steep it is from the first to the last of `lanes`, of which there may be none at either end.
    #[inline(always)]
    pub(super) fn steepest_over(&self, lanes: [i32; 2]) -> Steep {
        let squares = lanes.map(|lane| lane.max(0) as usize >> SQUARE);
        let [first, last] = squares.map(|square| square.min(self.steepest.len() - 1));
        // Each number holds for two more squares.
        let others = first + 1..(last + 1).saturating_sub(2);
        others.fold(self.steepest[first], |most, other| {
            let other = self.steepest[other];
            Steep {
                aside: most.aside.max(other.aside),
                gradient: most.gradient.max(other.gradient),
            }
        })
    }

    /// How steep it is around lanes from the first to the last of `ends`.
    pub(super) fn steepest_along(&self, ends: [i32; 2]) -> f64 {
        let [first, last] = ends.map(|lane| lane as usize >> SQUARE);
        let steepest = self.steepest[first..=last].iter();
        steepest.map(|steep| steep.aside).fold(0.0, f64::max)
    }

    /// Makes ready for a sector; gives the numbers a step.
    pub(super) fn begin(
        &mut self,
        frame: &Frame<'_>,
        sector: &Sector,
        canvas: &Canvas<'_>,
    ) -> usize {
        let width = frame.rays.size[1 - sector.step_axis] as usize;
        // A power of two, so that the step of a ray is quickly told from where its number lies.
        let room = (width + 2 * MARGIN + BLOCK).next_power_of_two();
        self.lanes = [[0, 0]; MEMORY];
        self.far_from = u32::MAX;
        let levels = self.waves.len().max(frame.levels.len());
        self.waves.resize_with(levels, Waves::default);
        // A cast that panicked may have left some behind.
        for waves in &mut self.waves {
            waves.low.truncate(0);
            waves.high.truncate(0);
        }
        for numbers in [
            &mut self.reached,
            &mut self.clear,
            &mut self.advance,
            &mut self.slope,
        ] {
            numbers.grow(room * MEMORY + BLOCK);
            // What stands for numbers that have been left of other casts. Three, as sectors are often so many that each
            // would have the same one of two in every cast.
            #[cfg(debug_assertions)]
            numbers.fill([0.0, f32::NAN, 2.5][self.begun % 3]);
        }
        #[cfg(debug_assertions)]
        {
            self.begun += 1;
        }
        for sky in &mut self.sky {
            if sky.room() < room {
                *sky = SkyLanes::with_room(room);
            }
        }
        self.led.clear();
        self.led
            .resize(MEMORY * room.div_ceil(CHUNK), [i32::MIN, i32::MAX]);
        self.keeps_patches = false;
        self.strips = StripsKept::default();
        self.shading.begin();
        self.pixels.begin(canvas, sector, width + MARGIN);
        room
    }
}

/// Neighbours that are looked at together.
pub(in crate::planes) const BLOCK: usize = 4 * LANES;

/// Room before lane 0, so that neighbours of a step's first rays can be read.
pub(super) const MARGIN: usize = 2 * LANES;

/// How many lanes aside a ray's predecessor lies at most: so few that there is room.
pub(super) const FARTHEST: f64 = MARGIN as f64 - LANES as f64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_steepest_over_lanes_is_as_steep_as_each_of_their_squares() {
        const SQUARES: usize = 12;
        let own: [f64; SQUARES] = std::array::from_fn(|square| (7 * square % SQUARES) as f64);
        let steepest = (0..SQUARES).map(|first| {
            let three = &own[first..SQUARES.min(first + 3)];
            let most = three.iter().copied().fold(0.0, f64::max);
            Steep {
                aside: most,
                gradient: 2.0 * most,
            }
        });
        let scratch = Scratch {
            steepest: steepest.collect(),
            ..Scratch::default()
        };
        let lanes = (SQUARES << SQUARE) as i32;
        for first in -40..lanes {
            for length in [1, 63, 64, 96, 97, 130, 200] {
                let squares = [first, first + length - 1].map(|lane| lane.clamp(0, lanes - 1));
                let [from, to] = squares.map(|lane| lane as usize >> SQUARE);
                let most = own[from..=to].iter().copied().fold(0.0, f64::max);
                let found = scratch.steepest_over([first, first + length - 1]);
                assert!(found.aside >= most, "{length} from {first}");
                assert_eq!(found.gradient, 2.0 * found.aside);
            }
        }
    }
}
