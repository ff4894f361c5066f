//! An image that several threads fill at once.

use crate::Image;
use crate::lanes::{LANES, Lanes};
use std::sync::atomic::{AtomicU32, Ordering};
use zerocopy::FromBytes;

/// The pixels of an image being cast.
///
/// Units of work own pixels that lie anywhere in the image (a column, a slanted line), which plain
/// slices cannot express. Relaxed atomic stores compile to plain ones, and as each pixel belongs to
/// one unit, the image does not depend on who came first.
pub(crate) struct Canvas<'a> {
    colour: &'a [AtomicU32],
    depth: &'a [AtomicU32],
    width: usize,
}

impl<'a> Canvas<'a> {
    /// The canvas of an image that has its size already.
    pub(crate) fn new(image: &'a mut Image) -> Self {
        let width = image.view.size[0] as usize;
        let (colour, depth) = image.words_mut();
        Self {
            colour: atomic(colour),
            depth: atomic(bytemuck::cast_slice_mut(depth)),
            width,
        }
    }

    /// Sets pixel (i, j), j down from the top.
    #[inline]
    pub(crate) fn set(&self, [i, j]: [u32; 2], [r, g, b]: [u8; 3], depth: f32) {
        let at = j as usize * self.width + i as usize;
        self.colour[at].store(u32::from_ne_bytes([r, g, b, 255]), Ordering::Relaxed);
        self.depth[at].store(depth.to_bits(), Ordering::Relaxed);
    }

    /// The first pixel of the first row with which a cache line of colours begins.
    pub(crate) fn line_begin(&self) -> u32 {
        let past = self.colour.as_ptr().addr() / size_of::<u32>() % LANES;
        ((LANES - past) % LANES) as u32
    }

    /// Where pixel (i, j) lies.
    pub(crate) fn place(&self, [i, j]: [u32; 2]) -> usize {
        j as usize * self.width + i as usize
    }

    /// Asks for the memory of the pixel at a place, and of those of its cache line, to be written
    /// soon.
    #[inline(always)]
    pub(crate) fn prefetch<L: Lanes>(&self, l: L, at: usize) {
        l.prefetch_write(self.colour, at);
        l.prefetch_write(self.depth, at);
    }

    /// Sets pixels side by side, from (i, j) on: as many as there are depths.
    ///
    /// # Safety
    /// No other thread touches these pixels meanwhile.
    #[allow(unsafe_code, reason = "many pixels a store, where `set` has one")]
    #[inline]
    pub(crate) unsafe fn set_row(&self, [i, j]: [u32; 2], colours: &[i32], depths: &[f32]) {
        let from = j as usize * self.width + i as usize;
        let count = depths.len().min(colours.len());
        let colour = &self.colour[from..from + count];
        let depth = &self.depth[from..from + count];
        // SAFETY: the cells can be changed through a shared reference, both sides have `count`
        // items of four bytes, and by the caller's promise there is no race.
        unsafe {
            let to = colour.as_ptr().cast_mut().cast::<i32>();
            to.copy_from_nonoverlapping(colours.as_ptr(), count);
            let to = depth.as_ptr().cast_mut().cast::<f32>();
            to.copy_from_nonoverlapping(depths.as_ptr(), count);
        }
    }

    /// Sets the pixels of a square of which the upper left one is (i, j), a row in each group of
    /// lanes; depths as bits.
    ///
    /// # Safety
    /// As `set_row`.
    #[allow(unsafe_code, reason = "many pixels a store, where `set` has one")]
    #[inline(always)]
    pub(crate) unsafe fn set_square<L: Lanes>(
        &self,
        l: L,
        pixel: [u32; 2],
        colours: [L::I; LANES],
        depths: [L::I; LANES],
    ) {
        let from = self.place(pixel);
        let numbers = from..from + (LANES - 1) * self.width + LANES;
        for (pixels, rows) in [(self.colour, colours), (self.depth, depths)] {
            let first = pixels[numbers.clone()].as_ptr();
            for (k, row) in rows.into_iter().enumerate() {
                // SAFETY: the row lies within `numbers`, its cells can be changed through a shared
                // reference, and by the caller's promise there is no race.
                let to = unsafe { &mut *first.add(k * self.width).cast_mut().cast() };
                l.store_i(row, to);
            }
        }
    }

    /// As `set_square`, of those pixels only that are `there`: for each row the bits of its columns. The others
    /// need not be pixels of the image.
    ///
    /// # Safety
    /// Those that are there are pixels of the image, each in its own row, and no other thread touches them meanwhile.
    #[allow(unsafe_code, reason = "many pixels a store, where `set` has one")]
    #[inline(always)]
    pub(crate) unsafe fn set_part_of_square<L: Lanes>(
        &self,
        l: L,
        [i, j]: [i32; 2],
        there: [i32; LANES],
        colours: [L::I; LANES],
        depths: [L::I; LANES],
    ) {
        let Some(first) = there.iter().position(|&there| there != 0) else {
            return;
        };
        let last = LANES - 1 - there.iter().rev().take_while(|&&there| there == 0).count();
        let at = j as isize * self.width as isize + i as isize;
        let place = |row: usize, column: u32| at + (row * self.width) as isize + column as isize;
        let begin = place(first, there[first].trailing_zeros());
        let end = place(last, there[last].ilog2());
        let is_in_image = 0 <= begin && end < self.colour.len() as isize;
        assert!(is_in_image, "a square that reaches out of the image");
        for (pixels, rows) in [(self.colour, colours), (self.depth, depths)] {
            let first: *mut i32 = pixels.as_ptr().wrapping_offset(at).cast_mut().cast();
            for (k, row) in rows.into_iter().enumerate() {
                // SAFETY: by the caller's promise each row's pixels lie within it, and so between the first and
                // the last of all, which are some of `pixels`; their cells can be changed through a shared
                // reference, and there is no race.
                unsafe { l.store_those(there[k] as u16, row, first.wrapping_add(k * self.width)) };
            }
        }
    }
}

fn atomic(words: &mut [u32]) -> &[AtomicU32] {
    <[AtomicU32]>::mut_from_bytes(bytemuck::cast_slice_mut(words))
        .expect("an atomic word has the size and alignment of a word")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;

    const COLOURS: [[i32; LANES]; LANES] = {
        let mut rows = [[0; LANES]; LANES];
        let mut k = 0;
        while k < LANES * LANES {
            rows[k / LANES][k % LANES] = 1 + k as i32;
            k += 1;
        }
        rows
    };

    fn image(size: [u32; 2]) -> Image {
        let mut image = Image::default();
        image.reset(sandtable_view::View { size, ..image.view });
        image.colour_mut().fill([0; 4]);
        image
    }

    /// Squares that reach out of the image to the left and to the right, above and below, each with a slanted
    /// side.
    #[test]
    fn parts_of_squares_leave_other_pixels_alone() {
        let size = [37, 29];
        for [i, j] in [[-5, -3], [30, -9], [-1, 20], [33, 25], [11, 7], [21, 13]] {
            let is_there = |row: i32, col: i32| {
                let [x, y] = [i + col, j + row];
                (0..size[0]).contains(&x) && (0..size[1]).contains(&y) && row + 2 * col > 9
            };
            let there = std::array::from_fn(|row| {
                let bits = (0..LANES as i32).map(|col| i32::from(is_there(row as i32, col)) << col);
                bits.sum()
            });
            let mut image = image(size.map(|n| n as u32));
            let depths = COLOURS.map(|row| row.map(|n| (n as f32).to_bits() as i32));
            let canvas = Canvas::new(&mut image);
            #[allow(unsafe_code, reason = "what is tested")]
            // SAFETY: these are pixels of the image, and there is one thread.
            unsafe {
                canvas.set_part_of_square(Portable, [i, j], there, COLOURS, depths);
            }
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let [row, col] = [y - j, x - i];
                    let square = 0..LANES as i32;
                    let set = square.contains(&row) && square.contains(&col) && is_there(row, col);
                    let expected = if set {
                        COLOURS[row as usize][col as usize]
                    } else {
                        0
                    };
                    let at = (y * size[0] + x) as usize;
                    let found = i32::from_ne_bytes(image.colour()[at]);
                    assert_eq!(found, expected, "{x} {y} of a square at {i} {j}");
                    let depth = if set { expected as f32 } else { f32::INFINITY };
                    assert_eq!(image.depth[at], depth);
                }
            }
        }
    }

    #[test]
    #[should_panic(expected = "a square that reaches out of the image")]
    fn squares_must_not_reach_out_of_the_image() {
        let mut image = image([20, 20]);
        let canvas = Canvas::new(&mut image);
        #[allow(unsafe_code, reason = "what is tested")]
        // SAFETY: it is found out before anything is written.
        unsafe {
            canvas.set_part_of_square(Portable, [10, 10], [1 << 12; LANES], COLOURS, COLOURS);
        }
    }
}
