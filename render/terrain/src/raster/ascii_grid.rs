//! ESRI ASCII grids: a header of keys and values, then numbers from the north-west, in any
//! arrangement of white space.

use super::{Band, BandChoice, ColourRole, Header, RasterFile, SampleType, check_size, sidecar};
use crate::{Crs, TerrainError};
use std::io::{BufRead, BufReader};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// No number is written longer.
const MAX_WORD: usize = 400;
const KEYS: &str = "ncols, nrows, xllcorner or xllcenter, yllcorner or yllcenter, cellsize (or dx \
                    and dy), NODATA_value";

/// What some programs put before text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Whether a file's first bytes begin a header.
pub(super) fn looks_like_one(start: &[u8]) -> bool {
    let start = start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start);
    let start = start.trim_ascii_start();
    [
        &b"ncols"[..],
        b"nrows",
        b"xll",
        b"yll",
        b"cellsize",
        b"dx",
        b"dy",
        b"nodata",
    ]
    .iter()
    .any(|key| {
        start
            .get(..key.len())
            .is_some_and(|s| s.eq_ignore_ascii_case(key))
    })
}

pub(super) struct AsciiGrid {
    path: PathBuf,
    header: Header,
    words: Words,
    /// The first value, met where the header ended.
    first: Option<Word>,
    /// Values on the line so far, and the first line that has not a row's number of them.
    line_values: (u64, u64),
    uneven: Option<(u64, u64)>,
}

impl AsciiGrid {
    pub(super) fn open(path: &Path, length: u64) -> Result<Self, TerrainError> {
        let file = std::fs::File::open(path).map_err(|source| TerrainError::io(path, source))?;
        let mut words = Words {
            path: path.to_owned(),
            reader: BufReader::with_capacity(1 << 16, file),
            text: Vec::with_capacity(32),
            line: 1,
            bytes: 0,
        };
        words.pass_byte_order_mark()?;
        let mut keys = Keys::default();
        let first = loop {
            match words.next()? {
                Some(word) if word.is_key() => keys.read(&word, &mut words)?,
                first => break first,
            }
        };
        let mut grid = Self {
            header: keys.header(path, words.line)?,
            path: path.to_owned(),
            words,
            first,
            line_values: (0, 0),
            uneven: None,
        };
        // Each value takes at least a digit and a space.
        let cells = u64::from(grid.header.width) * u64::from(grid.header.height);
        let left = length.saturating_sub(grid.words.bytes) + 2;
        if left < cells.saturating_mul(2) - 1 {
            return Err(grid.error(
                grid.words.line,
                format!(
                    "the header announces {} columns by {} rows, but the {left} bytes behind it \
                     cannot hold as many values",
                    grid.header.width, grid.header.height
                ),
            ));
        }
        grid.header.crs = sidecar(path)?;
        grid.guess_sample_type()?;
        if grid.header.crs.is_none() {
            grid.guess_crs();
        }
        Ok(grid)
    }

    fn error(&self, line: u64, problem: String) -> TerrainError {
        TerrainError::AsciiGrid {
            path: self.path.clone(),
            line,
            problem,
        }
    }

    /// Whole numbers, unless the values at hand are written otherwise.
    fn guess_sample_type(&mut self) -> Result<(), TerrainError> {
        let io = |source| TerrainError::io(&self.path, source);
        let fraction = |byte: &u8| matches!(byte, b'.' | b'e' | b'E' | b'n' | b'N');
        let ahead = self
            .words
            .reader
            .fill_buf()
            .map_err(io)?
            .iter()
            .any(fraction);
        let first = self
            .first
            .as_ref()
            .is_some_and(|word| word.text.as_bytes().iter().any(fraction));
        if ahead || first {
            self.header.sample = SampleType::Float32;
        }
        Ok(())
    }

    /// Without a `.prj`, small cells within the range of degrees are taken for degrees.
    fn guess_crs(&mut self) {
        if let Ok([west, south, east, north]) = self.header.extent(&self.path) {
            let cell = (east - west) / f64::from(self.header.width);
            let degrees = west >= -181.0 && east <= 361.0 && south >= -90.5 && north <= 90.5;
            self.header.notes.push(if degrees && cell < 0.5 {
                self.header.crs = Some(Crs {
                    epsg: None,
                    ..Crs::wgs84()
                });
                "no .prj lies beside the grid; its coordinates are taken for WGS 84 degrees".into()
            } else {
                "no .prj lies beside the grid; its coordinates are taken for metres".into()
            });
        }
    }

    fn value(&mut self) -> Result<f64, TerrainError> {
        let (line, value) = match self.first.take() {
            Some(word) => (word.line, word.number()),
            None if self.words.advance()? => (self.words.line, parse(&self.words.text)),
            None => return Err(self.ended_early()),
        };
        self.count(line);
        let value = value.ok_or_else(|| {
            let text = String::from_utf8_lossy(&self.words.text);
            self.error(line, format!("{text:?} stands where a number should"))
        })?;
        if value.fract() != 0.0 || value.abs() > 2_147_483_648.0 {
            self.header.sample = SampleType::Float32;
        }
        Ok(value)
    }

    fn ended_early(&mut self) -> TerrainError {
        self.count(self.words.line + 1);
        let width = self.header.width;
        match self.uneven {
            Some((line, values)) => self.error(
                line,
                format!("{values} values stand where a row has {width}, and the file ends early"),
            ),
            None => self.error(self.words.line, "the file ends before the last row".into()),
        }
    }

    /// Counts values a line, to name the first that is uneven should their sum be wrong.
    fn count(&mut self, line: u64) {
        let (at, values) = self.line_values;
        if line == at {
            self.line_values.1 += 1;
            return;
        }
        if values != 0 && values != u64::from(self.header.width) && self.uneven.is_none() {
            self.uneven = Some((at, values));
        }
        self.line_values = (line, 1);
    }
}

impl RasterFile for AsciiGrid {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read_rows(
        &mut self,
        rows: Range<u32>,
        _bands: BandChoice,
        into: &mut Vec<f64>,
    ) -> Result<(), TerrainError> {
        into.clear();
        for _ in 0..rows.len() * self.header.width as usize {
            let value = self.value()?;
            into.push(value);
        }
        if rows.end == self.header.height
            && let Some(word) = self.words.next()?
        {
            self.count(word.line);
            let (line, problem) = match self.uneven {
                Some((line, values)) => (
                    line,
                    format!(
                        "{values} values stand where a row has {}, and values are left over",
                        self.header.width
                    ),
                ),
                None => (
                    word.line,
                    format!("{:?} stands behind the last row", word.text),
                ),
            };
            return Err(self.error(line, problem));
        }
        Ok(())
    }
}

#[derive(Default)]
struct Keys {
    cols: Option<f64>,
    rows: Option<f64>,
    /// Lower left, and whether it is a cell's centre.
    x: Option<(f64, bool)>,
    y: Option<(f64, bool)>,
    dx: Option<f64>,
    dy: Option<f64>,
    nodata: Option<f64>,
}

impl Keys {
    fn read(&mut self, key: &Word, words: &mut Words) -> Result<(), TerrainError> {
        let error = |line, problem| TerrainError::AsciiGrid {
            path: words.path.clone(),
            line,
            problem,
        };
        let name = key.text.to_ascii_lowercase();
        let slot: &mut dyn FnMut(f64) = match name.as_str() {
            "ncols" => &mut |value| self.cols = Some(value),
            "nrows" => &mut |value| self.rows = Some(value),
            "xllcorner" => &mut |value| self.x = Some((value, false)),
            "yllcorner" => &mut |value| self.y = Some((value, false)),
            "xllcenter" => &mut |value| self.x = Some((value, true)),
            "yllcenter" => &mut |value| self.y = Some((value, true)),
            "cellsize" => &mut |value| (self.dx, self.dy) = (Some(value), Some(value)),
            "dx" => &mut |value| self.dx = Some(value),
            "dy" => &mut |value| self.dy = Some(value),
            "nodata_value" | "nodata" => &mut |value| self.nodata = Some(value),
            _ => {
                return Err(error(
                    key.line,
                    format!("{:?} is no key of a header; there are {KEYS}", key.text),
                ));
            }
        };
        let path = words.path.clone();
        let value = words.next()?;
        let error = |problem| TerrainError::AsciiGrid {
            path: path.clone(),
            line: key.line,
            problem,
        };
        let Some(value) = value else {
            return Err(error(format!("the file ends behind {:?}", key.text)));
        };
        let number = value
            .number()
            .filter(|number| number.is_finite() || name.starts_with("nodata"));
        let number = number.ok_or_else(|| {
            error(format!(
                "{:?} is not a number, as {} needs",
                value.text, key.text
            ))
        })?;
        let wanted = match name.as_str() {
            "ncols" | "nrows" if number < 1.0 || number.fract() != 0.0 => "a whole number from 1",
            "cellsize" | "dx" | "dy" if number <= 0.0 => "above 0",
            _ => {
                slot(number);
                return Ok(());
            }
        };
        Err(error(format!("{name} is {number}, but must be {wanted}")))
    }

    fn header(&self, path: &Path, line: u64) -> Result<Header, TerrainError> {
        let need = |value: Option<f64>, key: &str| {
            value.ok_or_else(|| TerrainError::AsciiGrid {
                path: path.to_owned(),
                line,
                problem: format!("the header ends without {key}; it needs {KEYS}"),
            })
        };
        let (cols, rows) = (need(self.cols, "ncols")?, need(self.rows, "nrows")?);
        check_size(path, cols as u64, rows as u64)?;
        let (dx, dy) = (need(self.dx, "cellsize")?, need(self.dy, "cellsize or dy")?);
        let corner = |place: Option<(f64, bool)>, step: f64, key| {
            let (value, centre) = (
                place.map(|place| place.0),
                place.is_some_and(|place| place.1),
            );
            Ok::<_, TerrainError>(need(value, key)? - if centre { step / 2.0 } else { 0.0 })
        };
        let west = corner(self.x, dx, "xllcorner")?;
        let south = corner(self.y, dy, "yllcorner")?;
        let (width, height) = (cols as u32, rows as u32);
        Ok(Header {
            driver: "AAIGrid",
            width,
            height,
            sample: SampleType::Int32,
            bands: vec![Band::plain(ColourRole::Undefined, self.nodata, None)],
            crs: None,
            vertical_crs: None,
            transform: Some([west, dx, 0.0, south + rows * dy, 0.0, -dy]),
            pixel_is: None,
            compression: None,
            block: [width, 1],
            overviews: 0,
            notes: Vec::new(),
        })
    }
}

/// Words between white space, each with its line.
struct Words {
    path: PathBuf,
    reader: BufReader<std::fs::File>,
    /// The last word.
    text: Vec<u8>,
    line: u64,
    /// Bytes read so far.
    bytes: u64,
}

struct Word {
    text: String,
    line: u64,
}

impl Words {
    /// Begins behind the mark, where the file begins with one.
    fn pass_byte_order_mark(&mut self) -> Result<(), TerrainError> {
        let start = self
            .reader
            .fill_buf()
            .map_err(|source| TerrainError::io(&self.path, source))?;
        if start.starts_with(BYTE_ORDER_MARK) {
            self.reader.consume(BYTE_ORDER_MARK.len());
            self.bytes += BYTE_ORDER_MARK.len() as u64;
        }
        Ok(())
    }

    fn next(&mut self) -> Result<Option<Word>, TerrainError> {
        let there = self.advance()?;
        Ok(there.then(|| Word {
            text: String::from_utf8_lossy(&self.text).into_owned(),
            line: self.line,
        }))
    }

    /// Reads a word into `text`; false where the file ends.
    fn advance(&mut self) -> Result<bool, TerrainError> {
        self.text.clear();
        loop {
            let buffer = self
                .reader
                .fill_buf()
                .map_err(|source| TerrainError::io(&self.path, source))?;
            let mut used = 0;
            let mut ended = buffer.is_empty();
            for &byte in buffer {
                let space = byte.is_ascii_whitespace() || byte == 0;
                if space && !self.text.is_empty() {
                    ended = true;
                    break;
                }
                used += 1;
                if !space {
                    self.text.push(byte);
                } else if byte == b'\n' {
                    self.line += 1;
                }
                if self.text.len() > MAX_WORD {
                    return Err(TerrainError::AsciiGrid {
                        path: self.path.clone(),
                        line: self.line,
                        problem: format!(
                            "a word of more than {MAX_WORD} bytes stands where a number should"
                        ),
                    });
                }
            }
            self.reader.consume(used);
            self.bytes += used as u64;
            if ended {
                return Ok(!self.text.is_empty());
            }
        }
    }
}

impl Word {
    /// Whether this is a key rather than a value; values may be `nan` or `inf`.
    fn is_key(&self) -> bool {
        self.text.starts_with(|c: char| c.is_alphabetic()) && self.number().is_none()
    }

    fn number(&self) -> Option<f64> {
        parse(self.text.as_bytes())
    }
}

/// The number that a word writes. Most are short and whole, and need no general parser.
fn parse(text: &[u8]) -> Option<f64> {
    let digits = text.strip_prefix(b"-").unwrap_or(text);
    if (1..=9).contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit) {
        let whole = digits
            .iter()
            .fold(0_u32, |sum, digit| sum * 10 + u32::from(digit - b'0'));
        let value = f64::from(whole);
        return Some(if digits.len() < text.len() {
            -value
        } else {
            value
        });
    }
    std::str::from_utf8(text).ok()?.parse().ok()
}
