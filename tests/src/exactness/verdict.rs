//! What the judge found, in numbers and for a failing test's message.

use std::fmt;

/// How many wrong pixels a verdict keeps.
const KEPT: usize = 5;

/// What is wrong with a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No ray of brute force near the pixel's centre hits where the pixel does.
    Depth,
    /// Some do, but all of them see another colour.
    Colour,
}

/// A pixel that agrees with no ray near its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrongPixel {
    /// Column, and row from the top.
    pub pixel: [u32; 2],
    /// What is wrong with it.
    pub fault: Fault,
    /// The image's depth and that of brute force at the pixel's centre, in cells; +∞ for sky.
    pub cells: [f64; 2],
    /// The image's colour and that of brute force at the pixel's centre.
    pub colours: [[u8; 3]; 2],
}

impl fmt::Display for WrongPixel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [i, j] = self.pixel;
        let [found, exact] = self.cells;
        write!(
            f,
            "pixel ({i}, {j}) at {found:.3} cells, exactly {exact:.3}"
        )?;
        if self.fault == Fault::Colour {
            let [found, exact] = self.colours;
            write!(f, ", of colour {found:?}, exactly {exact:?}")?;
        }
        Ok(())
    }
}

/// What became of an image's pixels before the judge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// How many there are.
    pub pixels: usize,
    /// How many did not agree with the ray through their centre and were searched for another.
    pub searched: usize,
    /// How many of these agree with none in depth.
    pub wrong_in_depth: usize,
    /// How many agree in depth with some, and in colour with none of those.
    pub wrong_in_colour: usize,
    /// The first few of the wrong ones, row by row from the top.
    pub first: Vec<WrongPixel>,
}

impl Verdict {
    /// The verdict on `pixels`, of which `searched` were searched and `wrong` were wrong.
    pub(super) fn new(pixels: usize, searched: usize, wrong: Vec<WrongPixel>) -> Self {
        let count = |fault| wrong.iter().filter(|pixel| pixel.fault == fault).count();
        Self {
            pixels,
            searched,
            wrong_in_depth: count(Fault::Depth),
            wrong_in_colour: count(Fault::Colour),
            first: wrong.into_iter().take(KEPT).collect(),
        }
    }

    /// How many pixels are wrong, in depth or in colour.
    #[must_use]
    pub fn wrong(&self) -> usize {
        self.wrong_in_depth + self.wrong_in_colour
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} pixels wrong in depth and {} in colour, of {} searched",
            self.wrong_in_depth, self.pixels, self.wrong_in_colour, self.searched
        )?;
        for (k, pixel) in self.first.iter().enumerate() {
            write!(f, "{} {pixel}", if k == 0 { ":" } else { ";" })?;
        }
        if self.wrong() > self.first.len() {
            write!(f, "; and more")?;
        }
        Ok(())
    }
}
