//! A sector's colours again, where it is known how far its rays reach.

use super::March;
use super::directions::{Aim, Directions, STEEP};
use super::scratch::{MARGIN, MEMORY, Scratch};
use crate::Image;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group, group_mut};
use crate::planes::frame::Frame;
use crate::planes::sectors::Sector;
use crate::planes::shade::Shader;

/// How far a sector's rays reach in a finished image: in cells along the major axis, negative for
/// sky, step by step, each with room for a whole last group of lanes.
pub(in crate::planes) fn reaches(frame: &Frame<'_>, sector: &Sector, image: &Image) -> Vec<f32> {
    let directions = Directions::new(frame, sector);
    let spacing = frame.ground.grid().spacing.to_array();
    let metres = [spacing[sector.major], spacing[1 - sector.major]];
    let steep = STEEP * frame.rays.first.length();
    // Rays that hit nothing leave the ground, at its far end at the latest.
    let nothing = -f64::from(frame.levels[0].cells[sector.major]);
    let mut reaches = Vec::new();
    for step in 0..sector.steps {
        let [from, to] = sector.lanes(step);
        for lane in from..to {
            let [i, j] = sector.pixel(step, lane);
            let depth = f64::from(image.depth[(j * image.width() + i) as usize]);
            let d = directions.at(step, lane);
            let major = d.x.max(steep);
            let aside = metres[1] * d.y.max(0.0) / major;
            let length = (metres[0].powi(2) + aside.powi(2) + (d.z / major).powi(2)).sqrt();
            let reach = if depth.is_finite() {
                depth / length
            } else {
                nothing
            };
            reaches.push(reach as f32);
        }
        reaches.resize(reaches.len().next_multiple_of(LANES), -1.0);
    }
    reaches
}

/// Casts a sector's pixels as [`cast_sector`](super::cast_sector) does, without its rays' ways.
#[inline(always)]
pub(in crate::planes) fn recolour_sector<L: Lanes>(
    l: L,
    frame: &Frame<'_>,
    sector: &Sector,
    mut reaches: &[f32],
    scratch: &mut Scratch,
    canvas: &Canvas<'_>,
) {
    let room = scratch.begin(frame, sector, canvas);
    let march = March::new(l, frame, sector, room);
    let shader = Shader::new(frame, sector, &march.fields[0]);
    for step in 0..sector.steps {
        let lanes = sector.lanes(step);
        scratch.lanes[step as usize % MEMORY] = lanes;
        let count = ((lanes[1] - lanes[0]) as usize).next_multiple_of(LANES);
        let known;
        (known, reaches) = reaches.split_at(count);
        l.vectorize(
            #[inline(always)]
            || march.aim(step, lanes, known, canvas, scratch),
        );
        march.shade(&shader, canvas, scratch, step, step + 1);
    }
    scratch.pixels.finish(l, canvas, sector);
}

impl<L: Lanes> March<'_, L> {
    /// Sets up the directions of a step's rays and lets them reach as far as is known.
    #[inline(always)]
    fn aim(
        &self,
        step: u32,
        lanes: [i32; 2],
        reaches: &[f32],
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
    ) {
        let l = self.l;
        let aim = Aim::new(l, self.frame, self.directions.lane);
        let asked = scratch.pixels.asked(canvas, self.sector, step);
        for (k, first) in (lanes[0]..lanes[1]).step_by(LANES).enumerate() {
            let at = self.slot(step) + MARGIN + first as usize;
            asked.prefetch(l, canvas, first);
            let aimed = aim.at(l, self.directions.at(step, first));
            l.store(aimed.advance, group_mut(&mut scratch.advance, at));
            l.store(aimed.slope, group_mut(&mut scratch.slope, at));
            let reached = l.load(group(reaches, k * LANES));
            l.store(reached, group_mut(&mut scratch.reached, at));
        }
    }
}
