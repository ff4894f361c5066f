//! From a source to the ground.

use crate::fill::fill_holes;
use crate::photo_file::read_photo;
use crate::raster::{BandChoice, Header, RasterFile, open_raster};
use crate::{Georeference, Ground, Holes, TerrainError, TerrainSource, TiledRaster, builtin};
use glam::DVec2;
use std::path::Path;

/// Ground, and where it comes from.
#[derive(Debug)]
pub struct Terrain {
    /// What to call it: the file's name or the built-in's.
    pub name: String,
    /// The ground, as casters read it.
    pub ground: Ground,
    /// Where it lies on Earth.
    pub georeference: Georeference,
    /// What the user should know: assumptions made, holes filled.
    pub notes: Vec<String>,
}

/// Opens a terrain, with a photograph over it where one is given, on the current rayon pool.
///
/// # Errors
/// [`TerrainError`], which names the file, the place in it and the remedy.
pub fn open(source: &TerrainSource, photo: Option<&Path>) -> Result<Terrain, TerrainError> {
    open_with_progress(source, photo, &|_| ())
}

/// As [`open`], telling the share of heights read so far, in [0, 1], from time to time.
///
/// # Errors
/// As [`open`].
pub fn open_with_progress(
    source: &TerrainSource,
    photo: Option<&Path>,
    progress: &dyn Fn(f32),
) -> Result<Terrain, TerrainError> {
    let mut terrain = match source {
        TerrainSource::File(path) => open_file(path, progress)?,
        TerrainSource::Ridges { size, seed } => builtin::ridges(*size, *seed)?,
        TerrainSource::Jacksboro => builtin::jacksboro()?,
    };
    if let Some(path) = photo {
        let grid = terrain.ground.grid();
        let (photo, notes) = read_photo(path, source, &terrain.georeference, &grid)?;
        terrain.ground = terrain.ground.with_photo(photo);
        terrain.notes.extend(notes);
    }
    progress(1.0);
    Ok(terrain)
}

fn open_file(path: &Path, progress: &dyn Fn(f32)) -> Result<Terrain, TerrainError> {
    let name = path
        .file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned();
    terrain_from_raster(path, name, open_raster(path)?.as_mut(), progress)
}

/// Reads a raster's first band as heights.
pub(crate) fn terrain_from_raster(
    path: &Path,
    name: String,
    raster: &mut dyn RasterFile,
    progress: &dyn Fn(f32),
) -> Result<Terrain, TerrainError> {
    let header = raster.header().clone();
    if header.width < 2 || header.height < 2 {
        return Err(TerrainError::TooSmall {
            path: path.to_owned(),
            cols: header.width.into(),
            rows: header.height.into(),
            needed: "a terrain needs at least 2 by 2 posts",
        });
    }
    let georeference = Georeference::of(path, &header)?;
    let mut notes = header.notes.clone();
    if header.crs.is_none() && !notes.iter().any(|note| note.contains("coordinates")) {
        notes.push("the file names no CRS; its coordinates are taken for metres".into());
    }
    notes.extend(scale_note(path, &header, &georeference));
    if header.bands.len() > 1 {
        notes.push(format!(
            "heights are read from the first of {} bands",
            header.bands.len()
        ));
    }
    let scaling = Scaling::of(path, &header, &mut notes)?;
    let Heights {
        mut heights,
        holes,
        stored,
    } = read_heights(path, raster, &header, &scaling, progress)?;
    let cells = u64::from(header.width) * u64::from(header.height);
    if holes == cells {
        return Err(TerrainError::AllNodata {
            path: path.to_owned(),
            cells,
        });
    }
    notes.extend(unlikely_height(path, &header, &scaling, stored));
    let holes = if holes == 0 {
        None
    } else {
        notes.push(format!(
            "{holes} posts without a height were filled in smoothly"
        ));
        let holes = Holes::collect(header.width, header.height, |col, row| {
            heights.post(col, row).is_nan()
        });
        if let Some(holes) = &holes {
            fill_holes(&mut heights, holes);
        }
        holes
    };
    let ground = Ground::new(heights, georeference.spacing())
        .map_err(|source| TerrainError::Ground {
            name: name.clone(),
            source,
        })?
        .with_holes(holes);
    Ok(Terrain {
        name,
        ground,
        georeference,
        notes,
    })
}

/// Says where a map's metres are far from the ground's, which makes relief too flat or too steep.
fn scale_note(path: &Path, header: &Header, georeference: &Georeference) -> Option<String> {
    /// Systems made for a country stay well within.
    const TOLERANCE: f64 = 0.05;
    let posts = DVec2::new(header.width.into(), header.height.into());
    let middle = georeference.origin + georeference.step * (posts - 1.0) / 2.0;
    let scale = georeference.map_scale(middle)?;
    if (scale - 1.0).abs().max_element() <= TOLERANCE {
        return None;
    }
    let crs = georeference.crs.as_ref()?;
    let degrees = crs.to_wgs84(middle)?;
    let zone = ((degrees.x + 180.0) / 6.0).floor().rem_euclid(60.0) + 1.0;
    let code = if degrees.y < 0.0 { 32_700.0 } else { 32_600.0 } + zone;
    Some(format!(
        "{crs} is not true to scale here: {:.2} m of the map eastwards and {:.2} m northwards are \
         1 m of ground, but heights are not stretched; for true slopes, bring it to UTM with: \
         gdalwarp -t_srs EPSG:{code} {} utm.tif",
        scale.x,
        scale.y,
        path.display()
    ))
}

/// From stored values to metres: stored · scale + offset.
struct Scaling {
    scale: f64,
    offset: f64,
}

impl Scaling {
    fn of(path: &Path, header: &Header, notes: &mut Vec<String>) -> Result<Self, TerrainError> {
        let band = &header.bands[0];
        let unit = band.unit.as_deref().unwrap_or("m");
        let map_unit = header.crs.as_ref().and_then(|crs| crs.projection.as_ref());
        if let Some(length) = map_unit.map(|projection| projection.metres_per_unit)
            && length != 1.0
            && band.unit.is_none()
        {
            notes.push(format!(
                "the map's unit is {length:.4} m long, but nothing names that of heights, which \
                 are taken for metres (if they are in feet, say so with: gdal_edit.py -units ft {})",
                path.display()
            ));
        }
        let metres = metres_per_height_unit(unit).ok_or_else(|| {
            TerrainError::unsupported(
                path,
                format!("has heights in {unit:?}"),
                format!(
                    "say how many metres it has, as FACTOR, with: gdal_edit.py -scale FACTOR \
                     -units m {}",
                    path.display()
                ),
            )
        })?;
        if metres != 1.0 {
            notes.push(format!("heights in {unit:?} are converted to metres"));
        }
        let (scale, offset) = (band.scale.unwrap_or(1.0), band.offset.unwrap_or(0.0));
        if (scale, offset) != (1.0, 0.0) {
            notes.push(format!(
                "stored values are multiplied by {scale}, then {offset} is added"
            ));
        }
        Ok(Self {
            scale: scale * metres,
            offset: offset * metres,
        })
    }
}

/// Metres in a unit of heights, however programs spell it: `foot (US)`, `US_survey_foot`.
fn metres_per_height_unit(unit: &str) -> Option<f64> {
    let words: Vec<_> = unit
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    Some(match words.join(" ").to_lowercase().as_str() {
        "" | "m" | "metre" | "meter" | "metres" | "meters" => 1.0,
        "dm" | "decimetre" | "decimeter" => 0.1,
        "cm" | "centimetre" | "centimeter" => 0.01,
        "mm" | "millimetre" | "millimeter" => 0.001,
        "km" | "kilometre" | "kilometer" => 1000.0,
        "in" | "inch" | "inches" => 0.0254,
        "ft" | "foot" | "feet" | "foot international" | "feet international"
        | "ft international" | "international foot" | "international feet" | "ft int"
        | "foot int" | "ft intl" | "foot intl" => 0.3048,
        "us ft" | "ft us" | "ftus" | "usft" | "sfoot" | "sft" | "us foot" | "us feet"
        | "foot us" | "feet us" | "survey foot" | "survey feet" | "us survey foot"
        | "us survey feet" | "foot us survey" | "feet us survey" | "u s survey foot"
        | "u s survey feet" => 1200.0 / 3937.0,
        "british foot 1936" | "ft br36" => 0.304_800_749_1,
        "yd" | "yard" | "yards" => 0.9144,
        "fathom" | "fathoms" | "fath" | "ftm" => 1.8288,
        _ => return None,
    })
}

/// What a raster's first band holds.
struct Heights {
    /// Metres, NaN where there is none.
    heights: TiledRaster<f32>,
    /// How many there are of those.
    holes: u64,
    /// Lowest and highest of the others, as stored.
    stored: [f64; 2],
}

/// Remarks on a lowest or highest value that marks missing heights in many files, or that no place
/// on Earth has.
fn unlikely_height(
    path: &Path,
    header: &Header,
    scaling: &Scaling,
    [low, high]: [f64; 2],
) -> Option<String> {
    const MARKS: [f64; 4] = [-9999.0, -99_999.0, -32_767.0, -32_768.0];
    /// Beyond any mountain and any trench.
    const METRES: f64 = 12_000.0;
    let unlikely = |value: f64| {
        MARKS.contains(&value) || (value * scaling.scale + scaling.offset).abs() > METRES
    };
    let (end, value) = [("lowest", low), ("highest", high)]
        .into_iter()
        .find(|&(_, value)| unlikely(value))?;
    let value = if value.abs() < 1e15 {
        value.to_string()
    } else {
        format!("{value:e}")
    };
    let path = path.display();
    let remedy = match header.bands[0].nodata {
        None if header.driver == "AAIGrid" => {
            format!("add the line NODATA_value {value} to the header of {path}")
        }
        None => format!("say so with: gdal_edit.py -a_nodata {value} {path}"),
        Some(nodata) => format!(
            "bring both together with: gdalwarp -srcnodata {value} -dstnodata {nodata} {path} \
             terrain.tif"
        ),
    };
    Some(format!(
        "the {end} value, {value}, is taken for a height, but is unlikely to be one; if it stands \
         for none, {remedy}"
    ))
}

fn read_heights(
    path: &Path,
    raster: &mut dyn RasterFile,
    header: &Header,
    scaling: &Scaling,
    progress: &dyn Fn(f32),
) -> Result<Heights, TerrainError> {
    let nodata = header.bands[0].nodata;
    let at_once = header.rows_at_once();
    let width = header.width as usize;
    let mut stored = Vec::new();
    let mut holes = 0;
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let refused = TerrainError::no_memory(path);
    let heights = TiledRaster::try_from_northern_rows(
        header.width,
        header.height,
        refused,
        |first, into| {
            let mut row = first;
            for chunk in into.chunks_mut(at_once as usize * width) {
                let rows = (chunk.len() / width) as u32;
                raster.read_rows(row..row + rows, BandChoice::First, &mut stored)?;
                for (height, &value) in chunk.iter_mut().zip(&stored) {
                    *height = (value * scaling.scale + scaling.offset) as f32;
                    if header.sample.is_nodata(value, nodata) || !height.is_finite() {
                        *height = f32::NAN;
                        holes += 1;
                    } else {
                        range = [range[0].min(value), range[1].max(value)];
                    }
                }
                row += rows;
                progress(row as f32 / header.height as f32);
            }
            Ok::<(), TerrainError>(())
        },
    )?;
    Ok(Heights {
        heights,
        holes,
        stored: range,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_height_are_known_in_every_spelling() {
        for (metres, spellings) in [
            (1.0, &["", "m", " Metre", "meters"][..]),
            (
                0.3048,
                &["ft", "Foot", "feet (international)", "foot (intl)"],
            ),
            (
                1200.0 / 3937.0,
                &[
                    "US_survey_foot",
                    "US survey foot",
                    "Foot_US",
                    "foot (US)",
                    "us-ft",
                    "ftUS",
                ],
            ),
            (0.9144, &["yd", "Yard"]),
            (1.8288, &["fathom", "FATHOMS"]),
        ] {
            for spelling in spellings {
                assert_eq!(metres_per_height_unit(spelling), Some(metres), "{spelling}");
            }
        }
        assert_eq!(metres_per_height_unit("furlong"), None);
    }
}
