//! Datagrams: the lines of one frame, and the bodies and Flysticks in them.

use crate::AXES;
use glam::{DMat3, DVec3};

/// The most buttons of a Flystick that are taken.
const MOST_BUTTONS: u32 = u64::BITS;

/// One frame's datagram, read. One is filled anew for each, so that its room is used again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Datagram {
    /// The frame's number, of the line `fr`.
    pub frame: Option<u32>,
    /// Seconds since midnight UTC, of the line `ts`.
    pub time_of_day: Option<f64>,
    /// How many bodies are calibrated, of the line `6dcal`.
    pub calibrated: Option<u32>,
    /// The standard bodies that are seen just now, of the line `6d`.
    pub bodies: Vec<DtrackBody>,
    /// All Flysticks, of the line `6df2`.
    pub flysticks: Vec<Flystick>,
    /// How many lines of bodies or Flysticks there were, be it that none of them is seen.
    pub body_lines: u32,
    /// How many lines were dropped because they are not what they promise.
    pub malformed: u64,
}

/// A body that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DtrackBody {
    /// Its number, from 0.
    pub id: u32,
    /// Where it is, in metres in the room's frame.
    pub position: DVec3,
    /// Turns the body's axes into the room's, as it was written.
    pub rotation: DMat3,
}

/// A Flystick: a body where it is seen, and its controls, which are told by radio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flystick {
    /// Its number, from 0.
    pub id: u32,
    /// Where it is, while it is seen.
    pub body: Option<DtrackBody>,
    /// How its controls are.
    pub controls: FlystickControls,
}

/// A Flystick's buttons and joystick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlystickControls {
    /// Bit n is set while button n, from 0, is pressed.
    pub pressed: u64,
    /// The joystick's axes, from −1 to 1; 0 from `count` on.
    pub values: [f64; AXES],
    /// How many axes there are.
    pub count: usize,
}

impl Datagram {
    /// Reads a datagram. Lines of other kinds are passed over; a line that is not what its first
    /// word promises is dropped as a whole and counted, and the others stand.
    pub fn read(&mut self, bytes: &[u8]) {
        self.bodies.clear();
        self.flysticks.clear();
        *self = Self {
            bodies: std::mem::take(&mut self.bodies),
            flysticks: std::mem::take(&mut self.flysticks),
            ..Self::default()
        };
        for line in bytes.split(|&byte| byte == b'\n') {
            self.malformed += u64::from(self.line(Line { rest: line }).is_none());
        }
    }

    /// Takes one line, or nothing of it.
    fn line(&mut self, mut line: Line<'_>) -> Option<()> {
        match line.word() {
            b"fr" => self.frame = Some(line.only_number()?),
            b"ts" => self.time_of_day = Some(line.only_decimal()?),
            b"6dcal" => self.calibrated = Some(line.only_number()?),
            b"6d" => {
                let before = self.bodies.len();
                let read = line.bodies(&mut self.bodies);
                self.body_lines += u32::from(read.is_some());
                read.or_else(|| {
                    self.bodies.truncate(before);
                    None
                })?;
            }
            b"6df2" => {
                let before = self.flysticks.len();
                let read = line.flysticks(&mut self.flysticks);
                self.body_lines += u32::from(read.is_some());
                read.or_else(|| {
                    self.flysticks.truncate(before);
                    None
                })?;
            }
            _ => {}
        }
        Some(())
    }
}

/// What is left of a line.
struct Line<'a> {
    rest: &'a [u8],
}

impl<'a> Line<'a> {
    fn skip_blanks(&mut self) {
        self.rest = self.rest.trim_ascii_start();
    }

    /// The next word, up to a blank or a bracket; empty at the line's end.
    fn word(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let ends = |byte: &u8| byte.is_ascii_whitespace() || matches!(byte, b'[' | b']');
        let end = self.rest.iter().position(ends).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }

    fn number<N: std::str::FromStr>(&mut self) -> Option<N> {
        std::str::from_utf8(self.word()).ok()?.parse().ok()
    }

    fn decimal(&mut self) -> Option<f64> {
        self.number::<f64>().filter(|number| number.is_finite())
    }

    fn only_number(&mut self) -> Option<u32> {
        let number = self.number()?;
        self.end(number)
    }

    fn only_decimal(&mut self) -> Option<f64> {
        let number = self.decimal()?;
        self.end(number)
    }

    /// `value`, where nothing but blanks is left.
    fn end<T>(&mut self, value: T) -> Option<T> {
        self.skip_blanks();
        self.rest.is_empty().then_some(value)
    }

    /// What `read` makes of the numbers between two brackets, all of them.
    fn block<T>(&mut self, read: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        self.skip_blanks();
        self.rest = self.rest.strip_prefix(b"[")?;
        let value = read(self)?;
        self.skip_blanks();
        self.rest = self.rest.strip_prefix(b"]")?;
        Some(value)
    }

    fn decimals<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.decimal()?;
        }
        Some(numbers)
    }

    /// `n [id q][x y z eta theta phi][b0 .. b8] ...`
    fn bodies(&mut self, bodies: &mut Vec<DtrackBody>) -> Option<()> {
        let count: u32 = self.number()?;
        for _ in 0..count {
            let (id, quality) = self.block(|line| Some((line.number()?, line.decimal()?)))?;
            let [x, y, z, _, _, _] = self.block(Self::decimals)?;
            let columns: [f64; 9] = self.block(Self::decimals)?;
            if quality >= 0.0 {
                bodies.push(body(id, [x, y, z], &columns));
            }
        }
        self.end(())
    }

    /// `n m [id q buttons controllers][x y z][b0 .. b8][button words, controllers] ...`, of which n
    /// are calibrated and m follow.
    fn flysticks(&mut self, flysticks: &mut Vec<Flystick>) -> Option<()> {
        let _calibrated: u32 = self.number()?;
        let count: u32 = self.number()?;
        for _ in 0..count {
            let head = |line: &mut Self| {
                let (id, quality) = (line.number()?, line.decimal()?);
                Some((id, quality, line.number()?, line.number()?))
            };
            let (id, quality, buttons, axes): (u32, f64, u32, usize) = self.block(head)?;
            let place: [f64; 3] = self.block(Self::decimals)?;
            let columns: [f64; 9] = self.block(Self::decimals)?;
            if buttons > MOST_BUTTONS || axes > AXES {
                return None;
            }
            flysticks.push(Flystick {
                id,
                body: (quality >= 0.0).then(|| body(id, place, &columns)),
                controls: self.block(|line| line.controls(buttons, axes))?,
            });
        }
        self.end(())
    }

    /// A word for each 32 buttons, the first in its lowest bit, then the axes.
    fn controls(&mut self, buttons: u32, axes: usize) -> Option<FlystickControls> {
        let mut pressed = 0;
        for word in 0..buttons.div_ceil(32) {
            // Written with a sign by some, where the highest bit is set.
            let bits: i64 = self.number()?;
            let bits = u32::try_from(bits).ok().or_else(|| {
                let signed = i32::try_from(bits).ok()?;
                Some(signed.cast_unsigned())
            })?;
            pressed |= u64::from(bits) << (32 * word);
        }
        let there = u64::MAX.checked_shr(MOST_BUTTONS - buttons).unwrap_or(0);
        let mut values = [0.0; AXES];
        for value in &mut values[..axes] {
            *value = self.decimal()?;
        }
        Some(FlystickControls {
            pressed: pressed & there,
            values,
            count: axes,
        })
    }
}

fn body(id: u32, millimetres: [f64; 3], columns: &[f64; 9]) -> DtrackBody {
    DtrackBody {
        id,
        position: DVec3::from_array(millimetres) * 1e-3,
        rotation: DMat3::from_cols_array(columns),
    }
}
