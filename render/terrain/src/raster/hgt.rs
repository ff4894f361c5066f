//! SRTM tiles (`N42E001.hgt`): one degree square, big-endian, sampled on the degree lines.

use super::{Band, BandChoice, ColourRole, Header, PixelIs, RasterFile, SampleType};
use crate::{Crs, TerrainError};
use std::io::{BufReader, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};

const VOID: f64 = -32_768.0;
/// Samples along a side: three and one arc seconds apart.
const SIDES: [u32; 2] = [1201, 3601];

pub(super) struct Hgt {
    path: PathBuf,
    header: Header,
    file: BufReader<std::fs::File>,
    bytes: Vec<u8>,
}

impl Hgt {
    pub(super) fn open(path: &Path, length: u64) -> Result<Self, TerrainError> {
        let error = |problem: String, remedy: &str| TerrainError::Hgt {
            path: path.to_owned(),
            problem,
            remedy: remedy.to_owned(),
        };
        let side = SIDES
            .into_iter()
            .find(|&side| u64::from(side) * u64::from(side) * 2 == length)
            .ok_or_else(|| {
                error(
                    format!(
                        "an HGT file has 2884802 bytes (1201 by 1201 samples) or 25934402 bytes \
                         (3601 by 3601), and this one has {length}"
                    ),
                    "unpack or download it again",
                )
            })?;
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or_default();
        let (south, west) = corner(name).ok_or_else(|| {
            error(
                format!("the name {name:?} does not say which degree square this is"),
                "name the file for its south-west corner, as N42E001.hgt or S23W044.hgt",
            )
        })?;
        let step = 1.0 / f64::from(side - 1);
        // Samples lie on the degree lines; the transform names outer edges.
        let transform = [
            west - step / 2.0,
            step,
            0.0,
            south + 1.0 + step / 2.0,
            0.0,
            -step,
        ];
        let header = Header {
            driver: "SRTMHGT",
            width: side,
            height: side,
            sample: SampleType::Int16,
            bands: vec![Band::plain(ColourRole::Undefined, Some(VOID), Some("m"))],
            crs: Some(Crs::wgs84()),
            vertical_crs: None,
            transform: Some(transform),
            pixel_is: Some(PixelIs::Point),
            compression: None,
            block: [side, 1],
            overviews: 0,
            notes: Vec::new(),
        };
        let file = std::fs::File::open(path).map_err(|source| TerrainError::io(path, source))?;
        Ok(Self {
            path: path.to_owned(),
            header,
            file: BufReader::new(file),
            bytes: Vec::new(),
        })
    }
}

impl RasterFile for Hgt {
    fn header(&self) -> &Header {
        &self.header
    }

    fn read_rows(
        &mut self,
        rows: Range<u32>,
        _bands: BandChoice,
        into: &mut Vec<f64>,
    ) -> Result<(), TerrainError> {
        self.bytes
            .resize(rows.len() * self.header.width as usize * 2, 0);
        self.file
            .read_exact(&mut self.bytes)
            .map_err(|source| TerrainError::io(&self.path, source))?;
        into.clear();
        into.extend(
            self.bytes
                .as_chunks()
                .0
                .iter()
                .map(|&bytes| f64::from(i16::from_be_bytes(bytes))),
        );
        Ok(())
    }
}

/// The south-west corner (latitude, longitude in degrees) that a file's name begins with.
fn corner(name: &str) -> Option<(f64, f64)> {
    let name = name
        .get(..7)
        .filter(|name| name.is_ascii())?
        .to_ascii_uppercase();
    let number = |range: Range<usize>| {
        let digits = &name[range];
        digits
            .bytes()
            .all(|byte| byte.is_ascii_digit())
            .then(|| digits.parse::<f64>().ok())?
    };
    let latitude = match &name[..1] {
        "N" => number(1..3)?,
        "S" => -number(1..3)?,
        _ => return None,
    };
    let longitude = match &name[3..4] {
        "E" => number(4..7)?,
        "W" => -number(4..7)?,
        _ => return None,
    };
    let on_earth = (-90.0..90.0).contains(&latitude) && (-180.0..180.0).contains(&longitude);
    on_earth.then_some((latitude, longitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_the_corner() {
        assert_eq!(corner("N42E001.hgt"), Some((42.0, 1.0)));
        assert_eq!(corner("s23w044.SRTMGL1.hgt"), Some((-23.0, -44.0)));
        for name in [
            "N4E001.hgt",
            "Q42E001.hgt",
            "N42E+01.hgt",
            "N95E001.hgt",
            "N4",
            "Ñ42E001é",
        ] {
            assert_eq!(corner(name), None, "{name}");
        }
    }
}
