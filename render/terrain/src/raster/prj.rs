//! Small files beside a raster: `.prj` says the CRS, a world file says the place.

use super::beside;
use crate::{Crs, TerrainError};
use std::path::{Path, PathBuf};

/// Nothing real is longer.
const MAX_BYTES: u64 = 64 << 10;

fn read(path: &Path) -> Result<String, TerrainError> {
    use std::io::Read;
    let io = |error| TerrainError::io(path, error);
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(io)?;
    file.take(MAX_BYTES).read_to_end(&mut bytes).map_err(io)?;
    let text = String::from_utf8_lossy(&bytes);
    // Some programs put a byte order mark before text in UTF-8.
    Ok(text.trim_start_matches('\u{feff}').to_owned())
}

/// The CRS in the `.prj` beside a raster, where there is one.
pub(crate) fn sidecar(raster: &Path) -> Result<Option<Crs>, TerrainError> {
    let Some(path) = beside(raster, &["prj"]) else {
        return Ok(None);
    };
    let text = read(&path)?;
    Crs::from_wkt(text.trim())
        .map(Some)
        .map_err(|error| TerrainError::Sidecar {
            problem: error.to_string(),
            remedy: format!(
                "write it anew with: gdalsrsinfo -o wkt_esri EPSG:CODE > {}",
                path.display()
            ),
            path,
        })
}

/// Six lines that say where a picture lies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WorldFile {
    pub path: PathBuf,
    /// GDAL's six coefficients, from the outer corner of the north-west pixel.
    pub transform: [f64; 6],
}

impl WorldFile {
    /// The world file beside a picture, by the extensions in use (`.pgw`, `.pngw`, `.wld`).
    pub(crate) fn beside(picture: &Path) -> Result<Option<Self>, TerrainError> {
        let extension = picture
            .extension()
            .and_then(|text| text.to_str())
            .unwrap_or_default();
        let extension = extension.to_ascii_lowercase();
        let short = match (extension.chars().next(), extension.chars().last()) {
            (Some(first), Some(last)) => format!("{first}{last}w"),
            _ => "wld".to_owned(),
        };
        let long = format!("{extension}w");
        match beside(picture, &[&short, &long, "wld"]) {
            None => Ok(None),
            Some(path) => Self::read(path).map(Some),
        }
    }

    fn read(path: PathBuf) -> Result<Self, TerrainError> {
        let text = read(&path)?;
        let numbers: Vec<f64> = text
            .split_whitespace()
            .map_while(|word| word.replace(',', ".").parse().ok())
            .filter(|value: &f64| value.is_finite())
            .collect();
        let &[dx, skew_y, skew_x, dy, x, y] = numbers.as_slice() else {
            return Err(TerrainError::Sidecar {
                problem: format!("{} numbers stand where a world file has 6", numbers.len()),
                remedy: "a world file's lines are: pixel width, row skew, column skew, minus \
                         pixel height, and x and y of the centre of the upper left pixel"
                    .into(),
                path,
            });
        };
        // The file names the centre of the first pixel, the transform its outer corner.
        let transform = [
            x - (dx + skew_x) / 2.0,
            dx,
            skew_x,
            y - (skew_y + dy) / 2.0,
            skew_y,
            dy,
        ];
        Ok(Self { path, transform })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_file_names_the_centre_of_the_first_pixel() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("photo.jpeg");
        assert_eq!(WorldFile::beside(&picture).unwrap(), None);
        std::fs::write(folder.path().join("photo.jgw"), "10\n0\n0\n-20\n105\n190\n").unwrap();
        let world = WorldFile::beside(&picture).unwrap().unwrap();
        assert_eq!(world.transform, [100.0, 10.0, 0.0, 200.0, 0.0, -20.0]);
        std::fs::write(folder.path().join("photo.jgw"), "10\n0\nnorth\n-20\n").unwrap();
        let error = WorldFile::beside(&picture).unwrap_err().to_string();
        assert!(
            error.contains("photo.jgw") && error.contains("2 numbers"),
            "{error}"
        );
    }

    #[test]
    fn a_prj_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let raster = folder.path().join("dem.asc");
        assert_eq!(sidecar(&raster).unwrap(), None);
        std::fs::write(folder.path().join("dem.prj"), "PROJCS[\"half").unwrap();
        let error = sidecar(&raster).unwrap_err().to_string();
        assert!(
            error.contains("dem.prj") && error.contains("byte 8"),
            "{error}"
        );
    }
}
