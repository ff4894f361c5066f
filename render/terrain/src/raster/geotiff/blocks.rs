//! The strips or tiles that a TIFF file announces, checked before anything is decoded.

use crate::TerrainError;
use std::ops::Range;
use std::path::Path;
use tiff_reader::Ifd;

/// Largest strip or tile that is decoded, in bytes.
const MAX_BLOCK: usize = 64 << 20;
/// No byte of deflate, LZW or PackBits stands for more than this many.
const MAX_RATIO: u64 = 2600;
/// Bytes that small blocks may have beyond that.
const SLACK: u64 = 64 << 10;

/// Where an image's samples lie in the file.
pub(super) struct Blocks {
    /// Columns of a block.
    pub width: u32,
    /// Rows of a block.
    pub height: u32,
    /// Decoded bytes of one block.
    bytes: usize,
    across: u32,
    /// Blocks (of the first plane) that the file leaves out.
    sparse: Vec<u32>,
}

impl Blocks {
    /// Checks that every block lies within the file and can hold what it must.
    pub(super) fn check(
        path: &Path,
        ifd: &Ifd,
        length: u64,
        sample_bytes: usize,
    ) -> Result<Self, TerrainError> {
        let (cols, rows) = (ifd.width(), ifd.height());
        let tiled = ifd.is_tiled();
        let (name, width, height, offsets, counts) = if tiled {
            let side = |side: Option<u32>| side.unwrap_or(0);
            let size = (side(ifd.tile_width()), side(ifd.tile_height()));
            (
                "tile",
                size.0,
                size.1,
                ifd.tile_offsets(),
                ifd.tile_byte_counts(),
            )
        } else {
            let height = ifd.rows_per_strip().min(rows);
            (
                "strip",
                cols,
                height,
                ifd.strip_offsets(),
                ifd.strip_byte_counts(),
            )
        };
        let damaged =
            |problem: String| TerrainError::damaged(path, format!("its {name}s"), problem);
        let (Some(offsets), Some(counts)) = (offsets, counts) else {
            return Err(damaged(
                "the tags that say where they lie are missing".into(),
            ));
        };
        if width == 0 || height == 0 {
            return Err(damaged(format!(
                "a {name} of {width} by {height} holds nothing"
            )));
        }
        let (across, down) = (cols.div_ceil(width), rows.div_ceil(height));
        let bands = u64::from(ifd.samples_per_pixel());
        let (planes, depth) = if ifd.planar_configuration() == 2 {
            (bands, 1)
        } else {
            (1, bands)
        };
        let expected = u64::from(across) * u64::from(down) * planes;
        if offsets.len() as u64 != expected || counts.len() as u64 != expected {
            return Err(damaged(format!(
                "{expected} are needed, but {} offsets and {} lengths are given",
                offsets.len(),
                counts.len()
            )));
        }
        let bytes = u64::from(width)
            .checked_mul(u64::from(height))
            .and_then(|cells| cells.checked_mul(depth * sample_bytes as u64))
            .unwrap_or(u64::MAX);
        if bytes > MAX_BLOCK as u64 {
            return Err(TerrainError::unsupported(
                path,
                format!("keeps {bytes} bytes in one {name}, above the limit of {MAX_BLOCK}"),
                format!(
                    "cut it into tiles with: gdal_translate -co TILED=YES -co COMPRESS=DEFLATE {} tiled.tif",
                    path.display()
                ),
            ));
        }
        let compression = ifd.compression();
        // Samples of other widths than whole bytes, as of 12 bits, lie side by side, row by row.
        let bits = ifd.bits_per_sample().ok();
        let bits = bits.and_then(|bits| bits.first().copied()).unwrap_or(0);
        let row_bytes = if bits.is_multiple_of(8) {
            bytes / u64::from(height)
        } else {
            (u64::from(width) * depth * u64::from(bits)).div_ceil(8)
        };
        let mut sparse = Vec::new();
        for (index, (&offset, &count)) in offsets.iter().zip(&counts).enumerate() {
            if offset == 0 || count == 0 {
                if (index as u64) < u64::from(across) * u64::from(down) {
                    sparse.push(index as u32);
                }
                continue;
            }
            let place = || format!("{name} {index} (byte offset {offset})");
            if offset.checked_add(count).is_none_or(|end| end > length) {
                return Err(TerrainError::damaged(
                    path,
                    place(),
                    format!("its {count} bytes reach beyond the file's {length}"),
                ));
            }
            // The last strip holds the rows that are left.
            let down_at =
                (index as u64 % (u64::from(across) * u64::from(down))) / u64::from(across);
            let left = u64::from(rows) - down_at * u64::from(height);
            let rows = if tiled {
                u64::from(height)
            } else {
                left.min(u64::from(height))
            };
            let needed = row_bytes * rows;
            let most = match compression {
                1 => count,
                5 | 8 | 32_773 | 32_946 => count.saturating_mul(MAX_RATIO).saturating_add(SLACK),
                _ => u64::MAX,
            };
            if needed > most {
                return Err(TerrainError::damaged(
                    path,
                    place(),
                    format!("its {count} bytes cannot hold the {needed} that it stands for"),
                ));
            }
        }
        Ok(Self {
            width,
            height,
            bytes: bytes as usize,
            across,
            sparse,
        })
    }

    /// Decoded bytes of the blocks across the image.
    pub(super) fn row_bytes(&self) -> usize {
        self.bytes.saturating_mul(self.across as usize)
    }

    /// Rows and columns, cut to `rows` and the image, of each block in `rows` that is left out.
    pub(super) fn left_out(&self, rows: &Range<u32>, cols: u32) -> Vec<(Range<u32>, Range<u32>)> {
        let first = rows.start / self.height * self.across;
        let from = self.sparse.partition_point(|&index| index < first);
        self.sparse[from..]
            .iter()
            .map(|&index| {
                let (top, left) = (
                    index / self.across * self.height,
                    index % self.across * self.width,
                );
                let bottom = top.saturating_add(self.height).min(rows.end);
                let right = left.saturating_add(self.width).min(cols);
                (top.max(rows.start)..bottom, left..right)
            })
            .take_while(|(block_rows, _)| block_rows.start < rows.end)
            .filter(|(block_rows, _)| !block_rows.is_empty())
            .collect()
    }
}
