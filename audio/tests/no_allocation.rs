//! The sound card's callback must neither allocate nor free memory, as either may wait for a lock.

#![expect(
    unsafe_code,
    reason = "only a global allocator sees every allocation, and implementing one is unsafe"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use glam::DVec3;
use sandtable_audio::{Listener, Settings, Soundscape, Source, mixer};

/// The system's allocator, counting what each thread asks of it.
struct Counting;

thread_local! {
    /// Constant and without a destructor, so that reading it never allocates itself.
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    CALLS.with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: each call goes to `System` with the caller's own arguments, so its promises are kept as
// `System` keeps them; counting touches no memory but this thread's cell.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise on `layout`, passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller's promise on `memory` and `layout`; `memory` came from `System`.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as for `dealloc`, and the caller's promise on `size`.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn rendering_and_steering_never_touch_the_allocator() {
    let before = CALLS.get();
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert_eq!(CALLS.get() - before, 2, "the allocator counts");

    let (mut control, mut mixer) = mixer(Settings::default(), 48_000);
    let mut out = [[0.0; 2]; 512];
    let before = CALLS.get();
    for block in 0..200 {
        let t = f64::from(block) * 0.01;
        // All that can change does: on and off, past the head, out of range, no number at all.
        let position = DVec3::new(
            t.cos(),
            t.sin(),
            if block % 50 == 7 { f64::NAN } else { 0.1 },
        );
        control.set(Soundscape {
            listener: Listener::at_table(DVec3::new(0.0, -0.9, t)),
            source: (block % 3 != 0).then_some(Source::at(position)),
            airspeed: 100.0 * t.sin(),
        });
        mixer.render(&mut out[..(block as usize * 37) % 513]);
    }
    assert_eq!(CALLS.get() - before, 0);
}
