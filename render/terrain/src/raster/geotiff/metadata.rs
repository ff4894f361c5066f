//! What TIFF's and GDAL's tags say about bands.

use crate::TerrainError;
use crate::raster::ColourRole;
use std::path::Path;
use tiff_reader::Ifd;

const GDAL_METADATA: u16 = 42_112;
const GDAL_NODATA: u16 = 42_113;

/// GDAL's metadata: an XML text whose items have a role and a band.
pub(super) struct Metadata<'a> {
    /// Role, band, value.
    items: Vec<(&'a str, usize, &'a str)>,
}

impl<'a> Metadata<'a> {
    pub(super) fn of(ifd: &'a Ifd) -> Self {
        let text = ifd
            .tag(GDAL_METADATA)
            .and_then(|tag| tag.value.as_str())
            .unwrap_or_default();
        Self {
            items: text.split("<Item ").skip(1).filter_map(item).collect(),
        }
    }

    pub(super) fn of_band(&self, role: &str, band: usize) -> Option<&'a str> {
        self.items
            .iter()
            .find(|(found, sample, _)| found.eq_ignore_ascii_case(role) && *sample == band)
            .map(|(.., value)| *value)
    }

    pub(super) fn number(&self, role: &str, band: usize) -> Option<f64> {
        self.of_band(role, band)?
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    }
}

/// `name="UNITTYPE" sample="0" role="unittype">m</Item>`.
fn item(text: &str) -> Option<(&str, usize, &str)> {
    let (attributes, rest) = text.split_once('>')?;
    let value = rest.split_once("</Item>")?.0;
    let attribute = |name: &str| {
        let behind = attributes.split_once(&format!("{name}=\""))?.1;
        behind.split_once('"').map(|(value, _)| value)
    };
    Some((
        attribute("role")?,
        attribute("sample")?.parse().ok()?,
        value.trim(),
    ))
}

/// What the tag for the value that stands for none says, be there geographic tags or not.
pub(super) fn nodata_text(ifd: &Ifd) -> Option<&str> {
    ifd.tag(GDAL_NODATA)?.value.as_str()
}

/// The value that stands for none.
pub(super) fn nodata(path: &Path, text: &str) -> Result<f64, TerrainError> {
    let text = text.trim_matches(['\0', ' ', '\n', '\r']);
    text.replace(',', ".").parse().map_err(|_| {
        TerrainError::damaged(
            path,
            "its nodata tag (42113)",
            format!(
                "{:?} is not a number",
                text.chars().take(40).collect::<String>()
            ),
        )
    })
}

/// What each band stands for.
pub(super) fn colour_roles(ifd: &Ifd) -> Vec<ColourRole> {
    let photometric = ifd.photometric_interpretation().unwrap_or(1);
    let colours: &[ColourRole] = match photometric {
        2 | 6 => &[ColourRole::Red, ColourRole::Green, ColourRole::Blue],
        3 => &[ColourRole::Palette],
        _ => &[ColourRole::Gray],
    };
    let extra = ifd.tag(tiff_reader::constants::TAG_EXTRA_SAMPLES);
    let extra = extra
        .and_then(|tag| tag.value.as_u64_vec())
        .unwrap_or_default();
    let bands = usize::from(ifd.samples_per_pixel());
    (0..bands)
        .map(|band| match colours.get(band) {
            Some(role) => *role,
            None => match extra.get(band - colours.len()) {
                Some(1 | 2) => ColourRole::Alpha,
                _ => ColourRole::Undefined,
            },
        })
        .collect()
}

/// The compression as GDAL names it; `None` where there is none.
pub(super) fn compression_name(ifd: &Ifd) -> Option<String> {
    let name = match ifd.compression() {
        1 => return None,
        5 => "LZW",
        7 => "JPEG",
        8 | 32_946 => "DEFLATE",
        32_773 => "PACKBITS",
        34_887 => "LERC",
        34_925 => "LZMA",
        50_000 => "ZSTD",
        50_001 => "WEBP",
        other => return Some(format!("TIFF compression {other}")),
    };
    Some(name.to_owned())
}
