//! A tile of columns with only their runs stored.

use super::column::Run;

/// Where a column's run begins: its lowest level, and its place among its row's densities, in
/// units of the tile.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Column {
    first: i16,
    start: u16,
}

/// The columns of one tile, row by row from the south-west, and their densities.
///
/// A column takes four bytes and its run. Starts are counted from the row's start, in units of
/// 2^`shift` bytes: 1 but for tiles with walls of hundreds of levels, whose runs are padded with
/// zeros, so that 16 bits are always enough.
#[derive(Debug, PartialEq)]
pub(super) struct PackedTile {
    /// Columns a row, and one more whose start is the row's end.
    pitch: usize,
    shift: u32,
    rows: Box<[u32]>,
    columns: Box<[Column]>,
    /// The runs, and one byte more so that a run's end can be read.
    densities: Box<[u8]>,
}

impl PackedTile {
    /// Packs `cols` by `rows` columns that `column` fills in turn, from the south-west.
    pub(super) fn new(
        cols: usize,
        rows: usize,
        mut column: impl FnMut(usize, usize, &mut Run),
    ) -> Self {
        let mut run = Run::default();
        let mut starts = Vec::with_capacity(cols * rows + 1);
        let mut firsts = Vec::with_capacity(cols * rows);
        let mut densities = Vec::new();
        for row in 0..rows {
            for col in 0..cols {
                column(col, row, &mut run);
                firsts.push(run.first as i16);
                starts.push(densities.len());
                densities.extend_from_slice(&run.densities);
            }
        }
        starts.push(densities.len());
        let units = |shift: u32, row: usize| -> usize {
            let starts = &starts[row * cols..=(row + 1) * cols];
            let runs = starts.windows(2).map(|ends| ends[1] - ends[0]);
            runs.map(|length| length.div_ceil(1 << shift)).sum()
        };
        let fits = |shift: u32| (0..rows).all(|row| units(shift, row) <= usize::from(u16::MAX));
        let shift = (0..).find(|&shift| fits(shift)).expect("long units fit");
        if shift == 0 {
            densities.push(0);
            return Self::index(cols, rows, shift, &firsts, &starts, densities);
        }
        let mut padded = Vec::new();
        let mut padded_starts = Vec::with_capacity(starts.len());
        for ends in starts.windows(2) {
            padded_starts.push(padded.len());
            padded.extend_from_slice(&densities[ends[0]..ends[1]]);
            padded.resize(padded.len().next_multiple_of(1 << shift), 0);
        }
        padded_starts.push(padded.len());
        padded.push(0);
        Self::index(cols, rows, shift, &firsts, &padded_starts, padded)
    }

    fn index(
        cols: usize,
        rows: usize,
        shift: u32,
        firsts: &[i16],
        starts: &[usize],
        densities: Vec<u8>,
    ) -> Self {
        let mut columns = Vec::with_capacity((cols + 1) * rows);
        let row_starts: Box<[_]> = (0..rows).map(|row| starts[row * cols]).collect();
        for (row, &row_start) in row_starts.iter().enumerate() {
            columns.extend((0..=cols).map(|col| Column {
                first: if col < cols {
                    firsts[row * cols + col]
                } else {
                    0
                },
                start: ((starts[row * cols + col] - row_start) >> shift) as u16,
            }));
        }
        Self {
            pitch: cols + 1,
            shift,
            // At most 257² columns of some thousand levels: 32 bits are enough.
            rows: row_starts.iter().map(|&start| start as u32).collect(),
            columns: columns.into_boxed_slice(),
            densities: densities.into_boxed_slice(),
        }
    }

    /// The densities of four neighbouring columns at `level`, then at `level` + 1; each time
    /// south-west, south-east, north-west, north-east.
    #[inline]
    pub(super) fn cell(&self, col: usize, row: usize, level: i32) -> [u8; 8] {
        // No run is anywhere near; held so that sums of levels fit.
        let level = level.clamp(-0x8000, 0x7fff);
        let at = row * self.pitch + col;
        let rows = &self.rows[row..row + 2];
        let south = &self.columns[at..at + 3];
        let north = &self.columns[at + self.pitch..at + self.pitch + 3];
        let sw = self.pair(rows[0], south[0], south[1], level);
        let se = self.pair(rows[0], south[1], south[2], level);
        let nw = self.pair(rows[1], north[0], north[1], level);
        let ne = self.pair(rows[1], north[1], north[2], level);
        [sw[0], se[0], nw[0], ne[0], sw[1], se[1], nw[1], ne[1]]
    }

    /// A column's densities at a level and the next.
    #[inline]
    fn pair(&self, row_start: u32, column: Column, next: Column, level: i32) -> [u8; 2] {
        let start = row_start as usize + (usize::from(column.start) << self.shift);
        let length = u32::from(next.start - column.start) << self.shift;
        let at = level - i32::from(column.first);
        [at, at + 1].map(|at| {
            // Without branches, as rays come upon runs in no order: past a run is its end, whose
            // byte counts for nothing; under it all bits are set.
            let inside = (at as u32) < length;
            let stored = self.densities[start + (at as u32).min(length) as usize];
            (stored & 0_u8.wrapping_sub(u8::from(inside))) | (at >> 31) as u8
        })
    }

    /// The density of one voxel.
    pub(super) fn density(&self, col: usize, row: usize, level: i32) -> u8 {
        let at = row * self.pitch + col;
        let level = level.clamp(-0x8000, 0x7fff);
        self.pair(
            self.rows[row],
            self.columns[at],
            self.columns[at + 1],
            level,
        )[0]
    }

    /// The lowest level of a column whose density is not above `threshold`, below 255.
    pub(super) fn first_above(&self, col: usize, row: usize, threshold: u8) -> i16 {
        let at = row * self.pitch + col;
        let [start, end] = [at, at + 1].map(|at| {
            self.rows[row] as usize + (usize::from(self.columns[at].start) << self.shift)
        });
        let run = &self.densities[start..end];
        self.columns[at].first + run.partition_point(|&density| density > threshold) as i16
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.rows) + size_of_val(&*self.columns) + size_of_val(&*self.densities)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns with runs of `length(col)` falling densities from level `col` − 4 on.
    fn tile(cols: usize, length: impl Fn(usize) -> usize) -> PackedTile {
        PackedTile::new(cols, 2, |col, _, run| {
            let densities = (0..length(col)).map(|at| (254 - at.min(253)) as u8);
            run.set(col as i32 - 4, densities);
        })
    }

    #[test]
    fn short_and_long_runs_read_the_same() {
        // Rows of up to 257 · 3000 bytes cannot be counted by 16 bits a byte.
        for (cols, longest, shift) in [(5, 3, 0), (257, 255, 0), (257, 300, 1), (257, 3000, 4)] {
            let length = |col: usize| longest - col % 2;
            let tile = tile(cols, length);
            assert_eq!(tile.shift, shift);
            for col in 0..cols {
                let first = col as i32 - 4;
                let density = |level: i32| match level - first {
                    ..0 => 255,
                    at if (at as usize) < length(col) => (254 - at.min(253)) as u8,
                    _ => 0,
                };
                for level in -20..longest as i32 + 300 {
                    assert_eq!(tile.density(col, 1, level), density(level));
                    if col + 1 < cols {
                        let cell = tile.cell(col, 0, level);
                        let column = [cell[0], cell[4], cell[2], cell[6]];
                        let [here, up] = [density(level), density(level + 1)];
                        assert_eq!(column, [here, up, here, up], "column {col}, level {level}");
                    }
                }
                let above = i32::from(tile.first_above(col, 1, 100));
                assert!(density(above) <= 100 && density(above - 1) > 100);
            }
        }
    }

    #[test]
    fn levels_without_end_read_as_below_and_above() {
        let tile = tile(3, |_| 2);
        assert_eq!(tile.cell(0, 0, i32::MIN), [255; 8]);
        assert_eq!(tile.cell(0, 0, i32::MAX), [0; 8]);
    }
}
