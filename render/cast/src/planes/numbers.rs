//! Numbers that lie where it is told, not where there happens to be room.

use bytemuck::{Pod, Zeroable};
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

/// Numbers in whole pages of memory. What is used together lies in the processor's caches in the same way then,
/// whatever else a program has asked for: that is worth up to 5 % of a cast.
#[derive(Default)]
pub(super) struct Numbers<T> {
    pages: Vec<Page>,
    of: PhantomData<T>,
}

/// As many bytes as addresses differ by at least that share places in the nearest cache.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(4096))]
struct Page([u8; 4096]);

impl<T: Pod> Numbers<T> {
    /// Makes room for so many at least; new ones are 0.
    pub(super) fn grow(&mut self, count: usize) {
        let pages = (count * size_of::<T>()).div_ceil(size_of::<Page>());
        let pages = pages.max(self.pages.len());
        self.pages.resize(pages, Zeroable::zeroed());
    }
}

impl<T: Pod> Deref for Numbers<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        bytemuck::cast_slice(&self.pages)
    }
}

impl<T: Pod> DerefMut for Numbers<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.pages)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_begin_with_a_page_and_stay_when_there_come_more() {
        let mut numbers = Numbers::<f32>::default();
        assert!(numbers.is_empty());
        numbers.grow(5);
        numbers[4] = 7.0;
        numbers.grow(5000);
        assert!(numbers.len() >= 5000);
        assert_eq!(numbers.as_ptr().addr() % 4096, 0);
        assert_eq!([numbers[4], numbers[4999]], [7.0, 0.0]);
        numbers.grow(3);
        assert_eq!(numbers[4], 7.0);
    }
}
