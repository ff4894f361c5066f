//! Pixels on their way into the image, which lies in rows whichever way steps run.

use super::sectors::Sector;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes};
use std::ops::Range;

/// Steps that are kept until their pixels are written, where steps are columns of the image: its
/// rows get whole runs of pixels then, instead of one here and one there.
const STEPS: usize = LANES;

/// Colours and depths of some steps, a number a lane.
#[derive(Default)]
pub(super) struct PixelBlock {
    width: usize,
    colours: Vec<i32>,
    depths: Vec<f32>,
    /// The lanes of the steps kept, and the first of these steps.
    lanes: Vec<[i32; 2]>,
    first_step: u32,
}

impl PixelBlock {
    /// Makes ready for a sector with so many lanes.
    pub(super) fn begin(&mut self, width: usize) {
        self.width = width;
        let size = self.colours.len().max(width * STEPS);
        self.colours.resize(size, 0);
        self.depths.resize(size, 0.0);
        self.lanes.clear();
    }

    /// Asks for the memory of the pixels of a step, or of a sixteenth of the rows of sixteen.
    #[inline(always)]
    pub(super) fn prefetch<L: Lanes>(
        l: L,
        canvas: &Canvas<'_>,
        sector: &Sector,
        step: u32,
        lanes: [i32; 2],
    ) {
        let at = sector.image_step(step);
        if sector.step_axis == 1 {
            canvas.prefetch(l, [lanes[0] as u32, at], (lanes[1] - lanes[0]) as usize);
            return;
        }
        let first = lanes[0] + step as i32 % STEPS as i32;
        for lane in (first..lanes[1]).step_by(STEPS) {
            canvas.prefetch(l, [at, lane as u32], 1);
        }
    }

    /// Where a step's numbers go, from lane `first` on.
    pub(super) fn lanes_mut(&mut self, step: u32, first: i32) -> (&mut [i32], &mut [f32]) {
        let begin = step as usize % STEPS * self.width;
        let lanes = begin + first as usize..begin + self.width;
        (&mut self.colours[lanes.clone()], &mut self.depths[lanes])
    }

    /// Takes note that the pixels of a step are there.
    pub(super) fn finish_step<L: Lanes>(
        &mut self,
        l: L,
        canvas: &Canvas<'_>,
        sector: &Sector,
        step: u32,
        lanes: [i32; 2],
    ) {
        if sector.step_axis == 1 {
            if lanes[0] < lanes[1] {
                let begin = step as usize % STEPS * self.width;
                let numbers = begin + lanes[0] as usize..begin + lanes[1] as usize;
                let pixel = [lanes[0] as u32, sector.image_step(step)];
                // SAFETY: each pixel belongs to one sector, and a sector to one thread.
                #[allow(unsafe_code, reason = "as `Canvas::set_row` says")]
                unsafe {
                    canvas.set_row(pixel, &self.colours[numbers.clone()], &self.depths[numbers]);
                }
            }
            return;
        }
        if self.lanes.is_empty() {
            self.first_step = step;
        }
        self.lanes.push(lanes);
        if step as usize % STEPS == STEPS - 1 {
            self.finish(l, canvas, sector);
        }
    }

    /// Writes what is left.
    pub(super) fn finish<L: Lanes>(&mut self, l: L, canvas: &Canvas<'_>, sector: &Sector) {
        l.vectorize(
            #[inline(always)]
            || self.write(l, canvas, sector),
        );
        self.lanes.clear();
    }

    #[inline(always)]
    fn write<L: Lanes>(&self, l: L, canvas: &Canvas<'_>, sector: &Sector) {
        let from = self.lanes.iter().map(|lanes| lanes[0]).min().unwrap_or(0);
        let to = self.lanes.iter().map(|lanes| lanes[1]).max().unwrap_or(0);
        let count = self.lanes.len();
        let has = |lane: i32| move |lanes: &[i32; 2]| (lanes[0]..lanes[1]).contains(&lane);
        let mut lane = from;
        while lane < to {
            let last = lane + LANES as i32 - 1;
            let whole = |lanes: &[i32; 2]| has(lane)(lanes) && has(last)(lanes);
            if count == STEPS && self.lanes.iter().all(whole) {
                self.write_square(l, canvas, sector, lane);
                lane = last + 1;
                continue;
            }
            // The steps that have this lane: one run, as a sector is convex.
            let begin = self.lanes.iter().position(has(lane)).unwrap_or(count);
            let end = count - self.lanes.iter().rev().position(has(lane)).unwrap_or(count);
            if begin < end {
                self.write_row(canvas, sector, lane, begin..end);
            }
            lane += 1;
        }
    }

    /// Where the numbers of the k-th step kept, counted in the image's order from `steps.start`
    /// on, lie for `lane`.
    fn place(&self, sector: &Sector, lane: i32, steps: &Range<usize>, k: usize) -> usize {
        let k = if sector.direction > 0 {
            steps.start + k
        } else {
            steps.end - 1 - k
        };
        (self.first_step as usize + k) % STEPS * self.width + lane as usize
    }

    /// Writes one row's pixels of some steps.
    fn write_row(&self, canvas: &Canvas<'_>, sector: &Sector, lane: i32, steps: Range<usize>) {
        let mut colours = [0; STEPS];
        let mut depths = [0.0; STEPS];
        let count = steps.len();
        for k in 0..count {
            let at = self.place(sector, lane, &steps, k);
            colours[k] = self.colours[at];
            depths[k] = self.depths[at];
        }
        let pixel = [self.left(sector, &steps), lane as u32];
        // SAFETY: each pixel belongs to one sector, and a sector to one thread.
        #[allow(unsafe_code, reason = "as `Canvas::set_row` says")]
        unsafe {
            canvas.set_row(pixel, &colours[..count], &depths[..count]);
        }
    }

    /// The image's leftmost column among some steps.
    fn left(&self, sector: &Sector, steps: &Range<usize>) -> u32 {
        let leftmost = if sector.direction > 0 {
            steps.start
        } else {
            steps.end - 1
        };
        sector.image_step(self.first_step + leftmost as u32)
    }

    /// Writes the pixels of all steps in as many lanes.
    #[inline(always)]
    fn write_square<L: Lanes>(&self, l: L, canvas: &Canvas<'_>, sector: &Sector, lane: i32) {
        let steps = 0..STEPS;
        let left = self.left(sector, &steps);
        let (mut colours, mut depths) = ([l.splat_i(0); STEPS], [l.splat_i(0); STEPS]);
        for k in 0..STEPS {
            let at = self.place(sector, lane, &steps, k);
            colours[k] = l.load_i(group(&self.colours, at));
            depths[k] = l.load_i(group(bytemuck::cast_slice(&self.depths), at));
        }
        let (colours, depths) = (l.transpose(colours), l.transpose(depths));
        for k in 0..LANES {
            let (mut colour, mut depth) = ([0; LANES], [0; LANES]);
            l.store_i(colours[k], &mut colour);
            l.store_i(depths[k], &mut depth);
            // SAFETY: each pixel belongs to one sector, and a sector to one thread.
            #[allow(unsafe_code, reason = "as `Canvas::set_group` says")]
            unsafe {
                canvas.set_group([left, lane as u32 + k as u32], &colour, &depth);
            }
        }
    }
}

fn group<T>(numbers: &[T], at: usize) -> &[T; LANES] {
    numbers[at..].first_chunk().expect("room was made")
}
