//! Pixels on their way into the image, which lies in rows whichever way steps run.

use super::numbers::Numbers;
use super::sectors::Sector;
use super::wave::same_lanes;
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
                let left = self.first_column(sector) as u32;
                for row in lane + LANES as i32..to.min(lane + 2 * LANES as i32) {
                    canvas.prefetch(l, canvas.place([left, row as u32]));
                }
            }
            let colours = self.rows(l, sector, &self.colours, lane);
            let depths = self.rows(l, sector, bytemuck::cast_slice(&self.depths), lane);
            // SAFETY: each pixel belongs to one sector, and a sector to one thread.
            #[allow(unsafe_code, reason = "as `Canvas::set_square` says")]
            unsafe {
                if self.lanes.len() == STEPS && self.lanes.iter().all(whole) {
                    let corner = [self.first_column(sector) as u32, lane as u32];
                    canvas.set_square(l, corner, colours, depths);
                } else {
                    let there = self.there(l, sector, lane);
                    let corner = [self.first_column(sector), lane];
                    canvas.set_part_of_square(l, corner, there, colours, depths);
                }
            }
        }
    }

    /// Numbers of all steps' pixels in as many lanes from `lane` on: a row of the image for each lane, whether
    /// its pixels are there or not.
    #[inline(always)]
    fn rows<L: Lanes>(&self, l: L, sector: &Sector, numbers: &[i32], lane: i32) -> [L::I; LANES] {
        let mut columns = [l.splat_i(0); STEPS];
        let mut rest = &numbers[lane as usize..];
        for column in &mut columns {
            *column = l.load_i(group(rest, 0));
            rest = &rest[self.width.min(rest.len())..];
        }
        if sector.direction < 0 {
            columns.reverse();
        }
        l.transpose(columns)
    }

    /// Which of a square's pixels are there: for each row the bits of its columns.
    #[inline(always)]
    fn there<L: Lanes>(&self, l: L, sector: &Sector, lane: i32) -> [i32; LANES] {
        let first = self.slot(self.first_step);
        let mut there = l.splat_i(0);
        for (k, &lanes) in self.lanes.iter().enumerate() {
            let column = if sector.direction > 0 {
                first + k
            } else {
                STEPS - 1 - first - k
            };
            let rows = l.mask(same_lanes(lanes, lane));
            there = l.add_i_where(rows, there, l.splat_i(1 << column));
        }
        let mut rows = [0; LANES];
        l.store_i(there, &mut rows);
        rows
    }

    /// The column of the image with which the kept steps' squares begin: it may lie before the first one.
    fn first_column(&self, sector: &Sector) -> i32 {
        let first = self.slot(self.first_step) as i32;
        let column = sector.image_step(self.first_step) as i32;
        if sector.direction > 0 {
            column - first
        } else {
            column - (STEPS as i32 - 1 - first)
        }
    }
}
