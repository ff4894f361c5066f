//! Memory in equal slots: tiles that lie in one piece, however they come and go.

use crate::NoMemory;
use crate::huge_pages::use_huge_pages;
use bytemuck::Zeroable;
use std::cell::UnsafeCell;
use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

/// How many items there are at most.
const MOST: u64 = 1 << 32;

/// Memory for a number of equal slots.
///
/// A slot is written by its only owner and, once shared, never changed: so whoever holds it may
/// read it while others write elsewhere.
pub struct Slab<T> {
    items: Box<[UnsafeCell<T>]>,
    slot_len: usize,
    free: Mutex<Vec<u32>>,
}

// SAFETY: items are reached through slots only. A slot's owner alone changes them, through `&mut`;
// shared slots are read only.
#[allow(unsafe_code, reason = "the module's purpose")]
unsafe impl<T: Send + Sync> Sync for Slab<T> {}

impl<T: Copy + Zeroable> Slab<T> {
    /// Memory for `slots` slots of `slot_len` items. What is not used takes no room yet.
    ///
    /// # Panics
    /// As [`Slab::try_new`] has it, and where the system does not give it.
    #[must_use]
    pub fn new(slots: usize, slot_len: usize) -> Arc<Self> {
        Self::try_new(slots, slot_len).unwrap_or_else(|refused| panic!("{refused}"))
    }

    /// As [`Slab::new`], without a panic where the system does not give it.
    ///
    /// # Errors
    /// [`NoMemory`] where the system does not give it.
    ///
    /// # Panics
    /// Where that is more than 2³² items: places in it are numbers of 32 bits.
    pub fn try_new(slots: usize, slot_len: usize) -> Result<Arc<Self>, NoMemory> {
        let len = slots
            .checked_mul(slot_len)
            .filter(|&len| len as u64 <= MOST);
        let len = len.unwrap_or_else(|| {
            panic!("{slots} slots of {slot_len} items have more than 2³² places");
        });
        let mut items =
            bytemuck::try_zeroed_slice_box::<T>(len).map_err(|()| NoMemory::for_items::<T>(len))?;
        use_huge_pages(&mut items);
        let pointer = Box::into_raw(items) as *mut [UnsafeCell<T>];
        // SAFETY: a cell has the layout of what it holds, and the box is ours.
        #[allow(unsafe_code, reason = "the module's purpose")]
        let items = unsafe { Box::from_raw(pointer) };
        Ok(Arc::new(Self {
            items,
            slot_len,
            // Handed out from the end: in order.
            free: Mutex::new((0..slots as u32).rev().collect()),
        }))
    }

    /// A free slot, or `None` where all are used. It holds zeros or what was there before.
    #[must_use]
    pub fn take(self: &Arc<Self>) -> Option<Slot<T>> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let index = free.pop()?;
        Some(Slot {
            slab: Arc::clone(self),
            index,
        })
    }
}

impl<T> Slab<T> {
    /// Number of slots.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.items.len() / self.slot_len
    }

    /// Items in a slot.
    #[must_use]
    pub fn slot_len(&self) -> usize {
        self.slot_len
    }
}

/// One slot's items. Its memory is free again when it is dropped.
pub struct Slot<T> {
    slab: Arc<Slab<T>>,
    index: u32,
}

impl<T> Slot<T> {
    /// Its number in the slab.
    #[must_use]
    pub fn index(&self) -> u32 {
        self.index
    }

    /// Its items, to be changed.
    pub fn items_mut(&mut self) -> &mut [T] {
        let begin = self.index as usize * self.slab.slot_len;
        let cells = &self.slab.items[begin..begin + self.slab.slot_len];
        // SAFETY: the slot is this one's alone, and it is borrowed alone.
        #[allow(unsafe_code, reason = "the module's purpose")]
        unsafe {
            std::slice::from_raw_parts_mut(UnsafeCell::raw_get(cells.as_ptr()), cells.len())
        }
    }
}

impl<T> Deref for Slot<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        let begin = self.index as usize * self.slab.slot_len;
        let cells = &self.slab.items[begin..begin + self.slab.slot_len];
        // SAFETY: the slot is this one's alone, and nobody changes it while it is borrowed.
        #[allow(unsafe_code, reason = "the module's purpose")]
        unsafe {
            std::slice::from_raw_parts(cells.as_ptr().cast(), cells.len())
        }
    }
}

impl<T> Drop for Slot<T> {
    fn drop(&mut self) {
        let mut free = self
            .slab
            .free
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        free.push(self.index);
    }
}

impl<T> std::fmt::Debug for Slot<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "slot {}", self.index)
    }
}

impl<T> std::fmt::Debug for Slab<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} slots of {}", self.slots(), self.slot_len)
    }
}

/// Some slots of a slab, held while they are read: the tiles of a raster, in their order.
///
/// A place in it is a slot's number times the slots' length, and a place within the slot.
pub struct SlabView<'a, T> {
    slab: &'a Slab<T>,
    /// The slots by their numbers in the slab, empty where they are not of the view.
    slots: Vec<&'a [T]>,
    /// In the view's order: where they begin, and they themselves.
    bases: Vec<u32>,
    ordered: Vec<&'a [T]>,
    /// ⌊(2⁶⁴ − 1) / a slot's length⌋.
    inverse: u64,
}

impl<'a, T> SlabView<'a, T> {
    /// A view of `slots`, which are the slab's.
    pub fn new(slab: &'a Slab<T>, slots: impl IntoIterator<Item = &'a Slot<T>>) -> Self {
        let mut view = Self {
            slab,
            slots: vec![&[]; slab.slots()],
            bases: Vec::new(),
            ordered: Vec::new(),
            inverse: u64::MAX / slab.slot_len as u64,
        };
        for slot in slots {
            assert!(std::ptr::eq(&*slot.slab, slab), "a slot of this slab");
            view.slots[slot.index as usize] = slot;
            view.bases.push(slot.index * slab.slot_len as u32);
            view.ordered.push(slot);
        }
        view
    }

    /// Where each slot of the view begins.
    #[must_use]
    pub fn bases(&self) -> &[u32] {
        &self.bases
    }

    /// The items of the view's slot of a number.
    ///
    /// # Panics
    /// Where there is no such slot.
    #[inline]
    #[must_use]
    pub fn nth(&self, number: usize) -> &'a [T] {
        self.ordered[number]
    }

    /// Where the slots of the view begin, if one begins where the one before it ends: then slot n
    /// begins at n times [`SlabView::slot_len`].
    #[must_use]
    pub fn is_in_order(&self) -> bool {
        let mut places = (0..).step_by(self.slab.slot_len);
        self.bases.iter().all(|&base| places.next() == Some(base))
    }

    /// Items in a slot.
    #[must_use]
    pub fn slot_len(&self) -> usize {
        self.slab.slot_len
    }

    /// The items from `place` on to the end of the slot that it lies in; none where the view has no
    /// such place.
    #[inline]
    #[must_use]
    pub fn from_place(&self, place: u32) -> &'a [T] {
        let (begin, slot) = self.slot_at(place);
        slot.get((place - begin) as usize..).unwrap_or_default()
    }

    /// Where the slot begins that `place` lies in, and its items; none where the view does not have
    /// it.
    #[inline]
    #[must_use]
    pub fn slot_at(&self, place: u32) -> (u32, &'a [T]) {
        // place / len without a division, which is slow: as the inverse is too small by less than 1,
        // the product is less than 2³² below (place + 1) / len · 2⁶⁴, so that whole quotients of
        // place + 1 drop to the one before and no others change.
        let number = (u128::from(u64::from(place) + 1) * u128::from(self.inverse)) >> 64;
        let slot = self.slots.get(number as usize).copied();
        (
            number as u32 * self.slab.slot_len as u32,
            slot.unwrap_or_default(),
        )
    }

    /// Number of items, of the view and others.
    #[must_use]
    pub fn len(&self) -> usize {
        self.slab.items.len()
    }

    /// Whether there is nothing at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.slab.items.is_empty()
    }

    /// Where place 0 lies in memory. Only items of the view's own slots may be read: others may be
    /// changing.
    #[must_use]
    pub fn as_ptr(&self) -> *const T {
        self.slab.items.as_ptr().cast()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_are_apart_and_come_back() {
        let slab = Slab::<u32>::new(3, 10);
        let mut slots: Vec<_> = (0..3).map(|_| slab.take().expect("free")).collect();
        assert!(slab.take().is_none());
        for (k, slot) in slots.iter_mut().enumerate() {
            assert_eq!(slot.index(), k as u32);
            slot.items_mut().fill(k as u32 + 1);
        }
        for (k, slot) in slots.iter().enumerate() {
            assert!(slot.iter().all(|&item| item == k as u32 + 1) && slot.len() == 10);
        }
        slots.remove(1);
        let again = slab.take().expect("it came back");
        assert_eq!(again.index(), 1);
        assert_eq!(slots[0][0], 1);
    }

    #[test]
    #[should_panic(expected = "65537 slots of 65536 items have more than 2³² places")]
    fn no_place_is_beyond_what_numbers_tell_apart() {
        let _ = Slab::<u8>::new(65_537, 65_536);
    }

    #[test]
    fn places_lead_to_the_rest_of_their_slot_or_to_nothing() {
        for len in [1, 2, 3, 10, 257] {
            let slab = Slab::<u32>::new(4, len);
            let mut slots: Vec<_> = (0..4).map(|_| slab.take().expect("free")).collect();
            for (k, slot) in slots.iter_mut().enumerate() {
                for (at, item) in slot.items_mut().iter_mut().enumerate() {
                    *item = (k * len + at) as u32;
                }
            }
            let held = [0, 1, 3];
            let view = SlabView::new(&slab, held.map(|k: usize| &slots[k]));
            for place in 0..4 * len {
                let (slot, rest) = (place / len, len - place % len);
                let found = view.from_place(place as u32);
                if held.contains(&slot) {
                    assert_eq!((found[0], found.len()), (place as u32, rest), "of {len}");
                } else {
                    assert!(found.is_empty(), "slot {slot} is not of the view");
                }
            }
            for place in [4 * len as u32, 1 << 31, u32::MAX - 1, u32::MAX] {
                assert!(view.from_place(place).is_empty(), "{place} of {len}");
            }
        }
    }
}
