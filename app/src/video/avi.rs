//! Motion-JPEG in AVI: each frame a JPEG, and an index behind them.
//!
//! ```text
//! RIFF 'AVI '
//!   LIST 'hdrl'   avih (56 bytes); LIST 'strl': strh (56 bytes), strf (40 bytes)
//!   LIST 'movi'   one chunk '00dc' a frame
//!   idx1          16 bytes a frame: '00dc', flags, offset from 'movi', size
//! ```
//!
//! Numbers are little-endian, chunks begin at even offsets. The header stands for the count, sizes
//! and rates, which are known only in the end: it is written twice. The layout is that of
//! Microsoft's "AVI RIFF File Reference".

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use super::VideoError;
use crate::partial::Partial;
use std::path::Path;

/// JPEG quality of 100: edges stay clean where stereo colours meet. Chroma is not subsampled.
const QUALITY: u8 = 92;
/// The whole file's bytes before the first frame's chunk.
const HEADER_LENGTH: u32 = 224;
/// Where 'movi' stands: the index counts from there.
const MOVI: u32 = HEADER_LENGTH - 4;

/// An AVI file being written.
pub(super) struct Avi {
    file: BufWriter<File>,
    partial: Partial,
    size: [u32; 2],
    frames_per_second: u32,
    /// Each frame's JPEG: offset from 'movi' to its chunk, and bytes.
    index: Vec<[u32; 2]>,
    /// Where the next chunk begins.
    end: u32,
    rgb: Vec<u8>,
    jpeg: Vec<u8>,
}

impl Avi {
    pub(super) fn create(
        path: &Path,
        size: [u32; 2],
        frames_per_second: u32,
    ) -> Result<Self, VideoError> {
        let partial = Partial::beside(path);
        let file = File::create(partial.unfinished()).map_err(VideoError::write(path))?;
        let mut avi = Self {
            file: BufWriter::new(file),
            partial,
            size,
            frames_per_second,
            index: Vec::new(),
            end: HEADER_LENGTH,
            rgb: Vec::new(),
            jpeg: Vec::new(),
        };
        avi.write(|avi| avi.file.write_all(&avi.header(0)))?;
        Ok(avi)
    }

    pub(super) fn push(&mut self, pixels: &[[u8; 4]]) -> Result<(), VideoError> {
        self.rgb.clear();
        self.rgb
            .extend(pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]));
        self.jpeg.clear();
        JpegEncoder::new_with_quality(&mut self.jpeg, QUALITY)
            .encode(
                &self.rgb,
                self.size[0],
                self.size[1],
                ExtendedColorType::Rgb8,
            )
            .map_err(|source| VideoError::Encode {
                path: self.partial.path().to_owned(),
                source,
            })?;

        // The chunk, and the index as it then would be, must leave all sizes within 32 bits.
        let bytes = self.jpeg.len();
        let chunk = 8 + bytes + bytes % 2;
        let index = 8 + 16 * (self.index.len() + 1);
        if self.end as usize + chunk + index > u32::MAX as usize {
            return Err(VideoError::Full {
                path: self.partial.path().to_owned(),
            });
        }
        let (bytes, chunk) = (bytes as u32, chunk as u32);
        self.write(|avi| {
            avi.file.write_all(b"00dc")?;
            avi.file.write_all(&bytes.to_le_bytes())?;
            avi.file.write_all(&avi.jpeg)?;
            avi.file.write_all(&[0][..avi.jpeg.len() % 2])
        })?;
        self.index.push([self.end - MOVI, bytes]);
        self.end += chunk;
        Ok(())
    }

    pub(super) fn finish(mut self) -> Result<(), VideoError> {
        self.write(|avi| {
            // A push that failed may have left part of a chunk.
            avi.file.seek(SeekFrom::Start(avi.end.into()))?;
            let index_length = 16 * avi.index.len() as u32;
            avi.file.write_all(b"idx1")?;
            avi.file.write_all(&index_length.to_le_bytes())?;
            for [offset, bytes] in &avi.index {
                avi.file.write_all(b"00dc")?;
                // Every frame is a key frame.
                for number in [0x10, *offset, *bytes] {
                    avi.file.write_all(&number.to_le_bytes())?;
                }
            }
            avi.file.seek(SeekFrom::Start(0))?;
            avi.file.write_all(&avi.header(8 + index_length))?;
            avi.file.flush()?;
            avi.file
                .get_ref()
                .set_len(u64::from(avi.end + 8 + index_length))
        })?;
        let Self { file, partial, .. } = self;
        drop(file);
        let path = partial.path().to_owned();
        partial.complete().map_err(VideoError::write(&path))
    }

    /// Does what can fail only in the file.
    fn write(
        &mut self,
        writing: impl FnOnce(&mut Self) -> io::Result<()>,
    ) -> Result<(), VideoError> {
        writing(self).map_err(|source| VideoError::Write {
            path: self.partial.path().to_owned(),
            source,
        })
    }

    /// All up to the first frame, as it is with the frames so far and `index_length` bytes behind.
    fn header(&self, index_length: u32) -> Vec<u8> {
        let [width, height] = self.size;
        let frames = self.index.len() as u32;
        let longest = self
            .index
            .iter()
            .map(|[_, bytes]| *bytes)
            .max()
            .unwrap_or(0);
        let microseconds = 1_000_000_u32.div_ceil(self.frames_per_second);
        let mut header = Header(Vec::with_capacity(HEADER_LENGTH as usize));
        header
            .text(b"RIFF")
            .numbers([self.end + index_length - 8])
            .text(b"AVI ");
        header.text(b"LIST").numbers([192]).text(b"hdrl");
        header.text(b"avih").numbers([56]).numbers([
            microseconds,
            longest.saturating_mul(self.frames_per_second),
            0,    // padding
            0x10, // has an index
            frames,
            0, // initial frames
            1, // streams
            longest.saturating_add(8),
            width,
            height,
            0,
            0,
            0,
            0,
        ]);
        header.text(b"LIST").numbers([116]).text(b"strl");
        header
            .text(b"strh")
            .numbers([56])
            .text(b"vids")
            .text(b"MJPG")
            .numbers([
                0, // flags
                0, // priority and language
                0, // initial frames
                1, // scale: rate / scale is the frames per second
                self.frames_per_second,
                0, // start
                frames,
                longest.saturating_add(8),
                u32::MAX, // quality: unspecified
                0,        // sample size: varies
                0,        // left and top, then right and bottom, 16 bits each
                width | height << 16,
            ]);
        header.text(b"strf").numbers([40]).numbers([
            40,
            width,
            height,
            1 | 24 << 16, // planes and bits a pixel
        ]);
        header.text(b"MJPG").numbers([
            (width * 3).saturating_mul(height),
            0, // pixels per metre
            0,
            0, // palette
            0,
        ]);
        header
            .text(b"LIST")
            .numbers([self.end - MOVI])
            .text(b"movi");
        header.0
    }
}

/// The header's bytes, written by fields.
struct Header(Vec<u8>);

impl Header {
    fn text(&mut self, code: &[u8; 4]) -> &mut Self {
        self.0.extend(code);
        self
    }

    fn numbers<const N: usize>(&mut self, numbers: [u32; N]) -> &mut Self {
        self.0.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        self
    }
}
