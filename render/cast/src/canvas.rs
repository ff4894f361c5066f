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
}

fn atomic(words: &mut [u32]) -> &[AtomicU32] {
    <[AtomicU32]>::mut_from_bytes(bytemuck::cast_slice_mut(words))
        .expect("an atomic word has the size and alignment of a word")
}
