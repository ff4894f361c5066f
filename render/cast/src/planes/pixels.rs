//! Pixels on their way into the image, which lies in rows whichever way steps run.

use super::numbers::Numbers;
use super::sectors::Sector;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group};

/// Steps that are kept until their pixels are written, where steps are columns of the image: its
/// rows get whole runs of pixels then, instead of one here and one there.
const STEPS: usize = LANES;

/// Colours and depths of some steps, a number a lane.
#[derive(Default)]
pub(super) struct PixelBlock {
    width: usize,
    colours: Numbers<i32>,
    depths: Numbers<f32>,
    /// The lanes of the steps kept, and the first of these steps.
    lanes: Vec<[i32; 2]>,
    first_step: u32,
    /// What to add to a step for the slot that it is kept in: the last slot is the last that a
    /// cache line of the image has.
    shift: u32,
}

/// A step's way of asking for the memory of pixels: a line of the processor's cache for each sixteen
/// lanes.
#[derive(Clone, Copy)]
pub(super) struct Asked {
    /// The place of the one for lane 0, and how much further the next lane's lies.
    first: usize,
    pitch: usize,
}

impl Asked {
    /// Asks for the line of the sixteen lanes from `lane` on.
    #[inline(always)]
    pub(super) fn prefetch<L: Lanes>(&self, l: L, canvas: &Canvas<'_>, lane: i32) {
        canvas.prefetch(l, self.first + lane as usize * self.pitch);
    }
}

impl PixelBlock {
    /// Makes ready for a sector with so many lanes.
    pub(super) fn begin(&mut self, canvas: &Canvas<'_>, sector: &Sector, width: usize) {
        self.width = width;
        let column = sector.image_step(0).wrapping_sub(canvas.line_begin());
        self.shift = if sector.direction > 0 {
            column
        } else {
            !column
        } % STEPS as u32;
        self.colours.grow(width * STEPS);
        self.depths.grow(width * STEPS);
        self.lanes.clear();
    }

    /// Where among the steps kept at once a step lies.
    fn slot(&self, step: u32) -> usize {
        (step + self.shift) as usize % STEPS
    }

    /// What memory a step asks for when its rays set out: that of its own pixels, or of a sixteenth
    /// of the rows of sixteen steps.
    #[inline(always)]
    pub(super) fn asked(&self, canvas: &Canvas<'_>, sector: &Sector, step: u32) -> Asked {
        let at = sector.image_step(step);
        if sector.step_axis == 1 {
            Asked {
                first: canvas.place([0, at]),
                pitch: 1,
            }
        } else {
            Asked {
                first: canvas.place([at, self.slot(step) as u32]),
                pitch: canvas.place([0, 1]),
            }
        }
    }

    /// Where a step's numbers go, from lane `first` on.
    pub(super) fn lanes_mut(&mut self, step: u32, first: i32) -> (&mut [i32], &mut [f32]) {
        let begin = self.slot(step) * self.width;
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
                let begin = self.slot(step) * self.width;
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
        if self.slot(step) == STEPS - 1 {
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
        for lane in (from..to).step_by(LANES) {
            let last = lane + LANES as i32 - 1;
            let whole = |lanes: &[i32; 2]| lanes[0] <= lane && last < lanes[1];
            if self.lanes.len() == STEPS {
                // What was asked for steps ago lies in the second cache by now: there was more than
                // the first one holds.
                let left = self.left(sector, 0, STEPS);
                for row in lane + LANES as i32..to.min(lane + 2 * LANES as i32) {
                    canvas.prefetch(l, canvas.place([left, row as u32]));
                }
            }
            let [colours, depths] = self.rows(l, sector, lane);
            if self.lanes.len() == STEPS && self.lanes.iter().all(whole) {
                let corner = [self.left(sector, 0, STEPS), lane as u32];
                // SAFETY: each pixel belongs to one sector, and a sector to one thread.
                #[allow(unsafe_code, reason = "as `Canvas::set_square` says")]
                unsafe {
                    canvas.set_square(l, corner, colours, depths);
                }
            } else {
                let mut rows = [[[0; STEPS]; 2]; LANES];
                for (k, [colour, depth]) in rows.iter_mut().enumerate() {
                    l.store_i(colours[k], colour);
                    l.store_i(depths[k], depth);
                }
                self.write_part(l, canvas, sector, lane, &rows);
            }
        }
    }

    /// Colours and depths of all steps' pixels in as many lanes from `lane` on: a row of the image
    /// for each lane, whether its pixels are there or not.
    #[inline(always)]
    fn rows<L: Lanes>(&self, l: L, sector: &Sector, lane: i32) -> [[L::I; LANES]; 2] {
        let (mut colours, mut depths) = ([l.splat_i(0); STEPS], [l.splat_i(0); STEPS]);
        for k in 0..STEPS {
            let slot = if sector.direction > 0 {
                k
            } else {
                STEPS - 1 - k
            };
            let at = slot * self.width + lane as usize;
            colours[k] = l.load_i(group(&self.colours, at));
            depths[k] = l.load_i(group(bytemuck::cast_slice(&self.depths), at));
        }
        [l.transpose(colours), l.transpose(depths)]
    }

    /// Writes those of a square's pixels that are there.
    #[inline(always)]
    fn write_part<L: Lanes>(
        &self,
        l: L,
        canvas: &Canvas<'_>,
        sector: &Sector,
        lane: i32,
        rows: &[[[i32; STEPS]; 2]; LANES],
    ) {
        let numbers = l.load_i(&std::array::from_fn(|k| lane + k as i32));
        // The steps that have each lane: one run, as a sector is convex.
        let (mut begins, mut ends) = (l.splat_i(STEPS as i32), l.splat_i(0));
        for (k, lanes) in self.lanes.iter().enumerate() {
            let off = l.or(
                l.gt_i(l.splat_i(lanes[0]), numbers),
                l.gt_i(numbers, l.splat_i(lanes[1] - 1)),
            );
            let step = l.splat_i(k as i32);
            begins = l.min_i(begins, l.select_i(off, begins, step));
            ends = l.select_i(off, ends, l.splat_i(k as i32 + 1));
        }
        let (mut first, mut behind) = ([0; LANES], [0; LANES]);
        l.store_i(begins, &mut first);
        l.store_i(ends, &mut behind);
        let before = self.slot(self.first_step);
        for (k, [colours, depths]) in rows.iter().enumerate() {
            let (first, behind) = (first[k] as usize, behind[k] as usize);
            if first >= behind {
                continue;
            }
            let pixels = if sector.direction > 0 {
                before + first..before + behind
            } else {
                STEPS - before - behind..STEPS - before - first
            };
            let pixel = [self.left(sector, first, behind), lane as u32 + k as u32];
            // SAFETY: each pixel belongs to one sector, and a sector to one thread.
            #[allow(unsafe_code, reason = "as `Canvas::set_row` says")]
            unsafe {
                canvas.set_row(
                    pixel,
                    &colours[pixels.clone()],
                    bytemuck::cast_slice(&depths[pixels]),
                );
            }
        }
    }

    /// The image's leftmost column among the kept steps from the `first`-th to before another.
    fn left(&self, sector: &Sector, first: usize, behind: usize) -> u32 {
        let leftmost = if sector.direction > 0 {
            first
        } else {
            behind - 1
        };
        sector.image_step(self.first_step + leftmost as u32)
    }
}
