//! What becomes of each of a sector's rays.

use super::scratch::{MARGIN, MEMORY, Scratch};
use super::{March, cast_sector};
use crate::canvas::Canvas;
use crate::lanes::{LANES, Portable};
use crate::planes::frame::Frame;
use crate::planes::sectors::Sector;
use crate::planes::steepness::SQUARE;
use crate::tally::Tally;

/// Casts a sector and adds to each pixel's number in `looks` over how many cells and blocks its ray
/// is led.
pub(in crate::planes) fn looks(
    frame: &Frame<'_>,
    sector: &Sector,
    scratch: &mut Scratch,
    canvas: &Canvas<'_>,
    looks: &mut [u32],
) {
    let room = scratch.begin(frame, sector, canvas);
    let mut tally = PixelTally {
        sector,
        width: frame.rays.size[0],
        room,
        pixels: vec![0; room * MEMORY],
        looks,
    };
    cast_sector(Portable, frame, sector, scratch, canvas, &mut tally);
}

/// Tells each look to the pixel whose ray it is.
struct PixelTally<'a> {
    sector: &'a Sector,
    /// The image's.
    width: u32,
    room: usize,
    /// The pixel of each number in the scratch.
    pixels: Vec<usize>,
    looks: &'a mut [u32],
}

impl Tally for PixelTally<'_> {
    fn ray(&mut self) {}

    fn rays(&mut self, step: u32, first: i32, count: i32) {
        let slot = step as usize % MEMORY * self.room + MARGIN;
        for lane in first..first + count {
            let [i, j] = self.sector.pixel(step, lane);
            self.pixels[slot + lane as usize] = (j * self.width + i) as usize;
        }
    }

    fn sample(&mut self) {}

    fn cell(&mut self) {}

    fn cells(&mut self, rays: &[i32]) {
        for &ray in rays {
            self.looks[self.pixels[ray as usize]] += 1;
        }
    }
}

/// How many steps back the ray lies from which each ray of a sector begins, 0 for none; step by
/// step and lane by lane.
pub(in crate::planes) fn begins<'a>(
    frame: &'a Frame<'a>,
    sector: &'a Sector,
) -> impl Iterator<Item = u32> {
    let march = March::new(Portable, frame, sector, 0);
    let mut steepest = Vec::new();
    (0..sector.steps).flat_map(move |step| {
        let [from, to] = sector.lanes(step);
        march.look_around(step, &mut steepest);
        let mut steps = Vec::with_capacity((to - from) as usize);
        for first in (from..to).step_by(LANES) {
            let last = (to - 1).min(first + LANES as i32 - 1);
            let before = march.any_before(step, [first, last], steepest[first as usize >> SQUARE]);
            steps.extend((first..=last).map(|lane| {
                let Some(before) = before else {
                    return 0;
                };
                let lanes = sector.lanes(step - before.steps.get());
                let is_known = (lanes[0]..lanes[1]).contains(&(lane + before.lanes));
                if is_known { before.steps.get() } else { 0 }
            }));
        }
        steps
    })
}
