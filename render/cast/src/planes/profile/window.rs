//! Neighbouring posts of one line, read at once.

use super::PlaneGroup;
use crate::lanes::{LANES, Lanes, group};
use crate::planes::field::{Field, Tiles};

/// Posts that are read at once.
const ROOM: i32 = 2 * LANES as i32;

/// The same where they are columns: as many as there are in a line of the processor's cache.
const COLUMNS_AHEAD: i32 = 16;

/// How many lines of posts ahead memory is asked for, where lines are rows.
pub(super) const ROWS_AHEAD: i32 = 3;

/// Neighbouring posts of one line, as many as there is [`ROOM`] for: heights and colours alike, which
/// lie in the same places of their tiles.
#[derive(Clone, Copy)]
pub(super) struct Window {
    /// The number of the tile that has the first post, and where in it that lies.
    tile: usize,
    first: usize,
    /// Where in a tile its line begins, if that is a row; else how far into one it lies.
    line: usize,
    /// Posts of this tile, of which the last one is the next tile's first.
    left: i32,
    /// How many posts count.
    pub(super) count: i32,
}

impl Window {
    /// The posts of a mirrored line that mirrored cells from the first to the last of `cells` have.
    #[inline(always)]
    pub(super) fn around(field: &Field<'_>, line: i32, [first, last]: [i32; 2]) -> Option<Self> {
        let count = last - first + 2;
        if count > ROOM {
            return None;
        }
        let minor = &field.minor;
        let minor = minor.post(first).min(minor.post(last + 1));
        let major = field.major.post(line);
        // The last post of an axis belongs to the cell before it.
        let tile = major.min(field.major.last_post() - 1) >> 8;
        let (along, aside) = (major - (tile << 8), minor & 255);
        let stride = field.heights.stride as usize;
        let (tile, line, first) = if field.major_axis == 0 {
            let tile = field.heights.number(tile, minor >> 8);
            (tile, along as usize, aside as usize * stride)
        } else {
            let tile = field.heights.number(minor >> 8, tile);
            (tile, along as usize * stride, aside as usize)
        };
        Some(Self {
            tile,
            first: line + first,
            line,
            left: 256 - aside,
            count,
        })
    }

    /// The posts' numbers in a raster on the field's grid; `None` where there is no room behind
    /// them to read as many. Asks for the memory of those that `planes` cross some lines later.
    #[inline(always)]
    pub(super) fn read<L: Lanes, T: bytemuck::Pod>(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        tiles: &Tiles<'_, T>,
    ) -> Option<[L::I; 2]> {
        if field.major_axis == 0 {
            Some(self.read_column(l, field, tiles))
        } else {
            self.read_row(l, field, planes, tiles)
        }
    }

    #[inline(always)]
    fn read_row<L: Lanes, T: bytemuck::Pod>(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        tiles: &Tiles<'_, T>,
    ) -> Option<[L::I; 2]> {
        let tile = tiles.items.nth(self.tile);
        let crosses = self.count > self.left + 1;
        if field.ahead.is_some() {
            let further = field.major.sign * ROWS_AHEAD * tiles.stride as i32
                + field.minor.sign * planes.drift;
            let at = self.first.wrapping_add_signed(further as isize);
            l.prefetch_read(tile, at);
            l.prefetch_read(tile, at.wrapping_add(15));
            if crosses {
                let at = self.line.wrapping_add_signed(further as isize);
                l.prefetch_read(tiles.items.nth(self.tile + 1), at);
            } else {
                l.prefetch_read(tile, at.wrapping_add(ROOM as usize - 1));
            }
        }
        let posts = line(l, tile, self.first)?;
        if !crosses {
            return Some(posts);
        }
        let next = tiles.items.nth(self.tile + 1);
        let next = line(l, next, self.line.checked_sub(self.left as usize)?)?;
        let numbers = l.load_i(&NUMBERS);
        let left = l.splat_i(self.left);
        let is_low = l.gt_i(left, numbers);
        let is_high = l.gt_i(left, l.add_i(numbers, l.splat_i(LANES as i32)));
        Some([
            l.select_i(is_low, posts[0], next[0]),
            l.select_i(is_high, posts[1], next[1]),
        ])
    }

    #[inline(always)]
    fn read_column<L: Lanes, T: bytemuck::Pod>(
        &self,
        l: L,
        field: &Field<'_>,
        tiles: &Tiles<'_, T>,
    ) -> [L::I; 2] {
        let stride = tiles.stride as usize;
        let tile = tiles.items.nth(self.tile);
        if field.ahead.is_some() {
            // A third of the lines that the next sixteen columns lie in.
            let row = 3 * (self.line & 7);
            let further = (field.major.sign * COLUMNS_AHEAD) as isize;
            for row in row..row + 3 {
                let at = self.first + row.min(self.count as usize) * stride;
                l.prefetch_read(tile, at.wrapping_add_signed(further));
            }
        }
        let items: &[i32] = bytemuck::cast_slice(tile.get(self.first..).unwrap_or_default());
        let mut posts = [0; ROOM as usize];
        if self.count <= self.left + 1 && items.len() > (ROOM as usize - 1) * stride {
            for k in 0..LANES {
                posts[k] = items[k * stride];
            }
            if self.count > LANES as i32 {
                for k in LANES..ROOM as usize {
                    posts[k] = items[k * stride];
                }
            }
        } else {
            let here = self.count.min(self.left + 1) as usize;
            for (post, &item) in posts[..here].iter_mut().zip(items.iter().step_by(stride)) {
                *post = item;
            }
            if here < self.count as usize {
                let next = tiles.items.nth(tiles.above(self.tile));
                let items: &[i32] = bytemuck::cast_slice(next.get(self.line..).unwrap_or_default());
                let posts = &mut posts[self.left as usize..self.count as usize];
                for (post, &item) in posts.iter_mut().zip(items.iter().step_by(stride)) {
                    *post = item;
                }
            }
        }
        [l.load_i(group(&posts, 0)), l.load_i(group(&posts, LANES))]
    }
}

const NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The numbers in a tile from a place on, as many as there is [`ROOM`] for.
#[inline(always)]
fn line<L: Lanes, T: bytemuck::Pod>(l: L, tile: &[T], from: usize) -> Option<[L::I; 2]> {
    let posts: &[T; ROOM as usize] = tile.get(from..)?.first_chunk()?;
    let posts: &[i32] = bytemuck::cast_slice(posts);
    Some([l.load_i(group(posts, 0)), l.load_i(group(posts, LANES))])
}
