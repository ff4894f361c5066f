//! Rasters in tiles, and places in them.

use super::*;

/// Full slots with items by their places, so many of such a length.
pub(super) fn slots<T: Copy + bytemuck::Zeroable>(
    count: usize,
    len: usize,
    item: impl Fn(usize) -> T,
) -> (Arc<Slab<T>>, Vec<Slot<T>>) {
    let slab = Slab::new(count, len);
    let slots = (0..count).map(|number| {
        let mut slot = slab.take().expect("free");
        for (k, to) in slot.items_mut().iter_mut().enumerate() {
            *to = item(number * len + k);
        }
        slot
    });
    let slots = slots.collect();
    (slab, slots)
}

/// Tiles of so many posts: (columns, rows, tiles).
pub(super) const TILES: [[usize; 3]; 3] = [[2, 2, 1], [5, 4, 3], [9, 9, 2]];

/// Places of cells of tiles: lane by lane, with the very last place in each group, and if
/// `anything`, with lanes that lie nowhere.
pub(super) fn cells(
    random: &mut Random,
    [cols, rows, tiles]: [usize; 3],
    anything: bool,
) -> [i32; LANES] {
    let below = |random: &mut Random, limit: usize| random.below(limit as u32) as usize;
    let mut places = random.lanes(|random| {
        if anything && random.below(4) == 0 {
            return random.int();
        }
        let tile = below(random, tiles);
        let (col, row) = (below(random, cols - 1), below(random, rows - 1));
        (tile * cols * rows + row * cols + col) as i32
    });
    places[below(random, LANES)] = (tiles * cols * rows - cols - 2) as i32;
    places
}

/// Whether a place is that of a cell.
pub(super) fn is_cell(place: i32, [cols, rows, tiles]: [usize; 3]) -> bool {
    let place = place as u32 as usize;
    let (tile, within) = (place / (cols * rows), place % (cols * rows));
    tile < tiles && within % cols < cols - 1 && within / cols < rows - 1
}
