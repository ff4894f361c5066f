//! Photographs in files, and where they lie over a terrain.

mod jpeg;
mod picture;
mod stretch;
mod tiff;

use crate::raster::{WorldFile, check_size, first_bytes, is_tiff, sidecar};
use crate::{
    Crs, CrsRelation, Georeference, Grid, Photo, TerrainError, TerrainSource, TiledRaster,
};
use glam::DVec2;
use std::path::Path;

/// A pixel: red, green, blue and coverage.
type Pixel = [u8; 4];

/// An open photograph, its pixels still in the file.
trait PhotoFile {
    fn size(&self) -> [u32; 2];

    /// Fills whole rows, counted from the north, in order and each once.
    fn read_rows(&mut self, first: u32, into: &mut [Pixel]) -> Result<(), TerrainError>;

    /// Where the file itself says that it lies.
    fn place(&self) -> Place;

    fn notes(&self) -> Vec<String>;
}

/// What a photograph's file says about where it lies.
#[derive(Default)]
struct Place {
    /// GDAL's six coefficients.
    transform: Option<[f64; 6]>,
    crs: Option<Crs>,
}

/// Reads a photograph and lays it over the terrain of a source; the second part is what the user should know.
pub(crate) fn read_photo(
    path: &Path,
    source: &TerrainSource,
    terrain: &Georeference,
    grid: &Grid,
) -> Result<(Photo, Vec<String>), TerrainError> {
    let (start, _) = first_bytes(path)?;
    let mut file: Box<dyn PhotoFile> = if is_tiff(&start) {
        Box::new(tiff::TiffPhoto::open(path)?)
    } else {
        Box::new(picture::Picture::open(path)?)
    };
    let [cols, rows] = file.size();
    check_size(path, cols.into(), rows.into())?;
    if cols < 2 || rows < 2 {
        return Err(TerrainError::TooSmall {
            path: path.to_owned(),
            cols: cols.into(),
            rows: rows.into(),
            needed: "a photograph needs at least 2 by 2 pixels",
        });
    }
    let mut notes = file.notes();
    let mut place = file.place();
    if place.transform.is_none()
        && let Some(world) = WorldFile::beside(path)?
    {
        place.transform = Some(world.transform);
    }
    if place.crs.is_none() {
        place.crs = sidecar(path)?;
    }
    let edges = edges(path, &place, terrain, grid, [cols, rows], &mut notes)?;
    // Coordinates can be compared once they are known to mean the same.
    compare_crs(
        path,
        source,
        place.crs.as_ref(),
        terrain,
        edges,
        grid,
        &mut notes,
    )?;
    check_overlap(path, edges, terrain, grid)?;
    let refused = TerrainError::no_memory(path);
    let mut is_seen = false;
    let pixels = TiledRaster::try_from_northern_rows(cols, rows, refused, |first, into| {
        file.read_rows(first, into)?;
        is_seen |= into.iter().any(|pixel| pixel[3] != 0);
        Ok::<(), TerrainError>(())
    })?;
    if !is_seen {
        notes.push(format!(
            "nothing is seen of the photograph: each of its pixels is transparent, masked or \
             nodata (without the last band, where that is a wrong alpha: gdal_translate -b 1 -b 2 \
             -b 3 {} photo.tif)",
            path.display()
        ));
    }
    let [west, south, east, north] = edges;
    let south_west = terrain.world_from_crs(DVec2::new(west, south));
    let extent = terrain.world_from_crs(DVec2::new(east, north)) - south_west;
    let spacing = extent / DVec2::new(cols.into(), rows.into());
    Ok((
        Photo {
            pixels,
            origin: south_west + spacing / 2.0,
            spacing,
        },
        notes,
    ))
}

/// What warps a photograph into the terrain's system: where no words say what that is, the
/// terrain's own file does.
fn warp_command(path: &Path, source: &TerrainSource, ground: &Crs) -> String {
    let path = path.display();
    ground.target().map_or_else(
        || {
            format!(
                "gdalsrsinfo -o wkt2 {source} > terrain.wkt && \
                 gdalwarp -t_srs terrain.wkt {path} photo.tif"
            )
        },
        |target| format!("gdalwarp -t_srs {target} {path} photo.tif"),
    )
}

/// West, south, east and north edges of the photograph in the terrain's coordinates.
fn edges(
    path: &Path,
    place: &Place,
    terrain: &Georeference,
    grid: &Grid,
    [cols, rows]: [u32; 2],
    notes: &mut Vec<String>,
) -> Result<[f64; 4], TerrainError> {
    let Some(transform) = place.transform else {
        notes.push(
            "the photograph does not say where it lies; it is stretched over the whole terrain"
                .into(),
        );
        return Ok(terrain_edges(terrain, grid));
    };
    let [west, dx, skew_x, north, skew_y, dy] = transform;
    let (east, south) = (west + dx * f64::from(cols), north + dy * f64::from(rows));
    let finite = transform.iter().all(|value| value.is_finite());
    let upright = dx > 0.0 && dy < 0.0 && skew_x == 0.0 && skew_y == 0.0;
    if !(finite && upright && east > west && north > south) {
        return Err(TerrainError::Rotated {
            path: path.to_owned(),
            transform,
        });
    }
    Ok([west, south, east, north])
}

/// West, south, east and north edges of the terrain in its coordinates.
fn terrain_edges(terrain: &Georeference, grid: &Grid) -> [f64; 4] {
    let posts = DVec2::new(grid.cols.into(), grid.rows.into());
    let south_west = terrain.origin - terrain.step / 2.0;
    let north_east = south_west + terrain.step * posts;
    [south_west.x, south_west.y, north_east.x, north_east.y]
}

/// Whether two rectangles, each by its west, south, east and north edges, share no place.
fn apart(a: [f64; 4], b: [f64; 4]) -> bool {
    a[2] <= b[0] || a[0] >= b[2] || a[3] <= b[1] || a[1] >= b[3]
}

/// Refuses a photograph in the terrain's coordinates that shares no place with it.
fn check_overlap(
    path: &Path,
    photo: [f64; 4],
    terrain: &Georeference,
    grid: &Grid,
) -> Result<(), TerrainError> {
    let ground = terrain_edges(terrain, grid);
    if !apart(photo, ground) {
        return Ok(());
    }
    let [west, south, east, north] = photo;
    // Some programs count longitudes from 0 to 360, others from -180 to 180.
    let is_geographic = terrain.crs.as_ref().is_some_and(Crs::is_geographic);
    let turned = [-360.0, 360.0]
        .map(|turn| [west + turn, south, east + turn, north])
        .into_iter()
        .find(|turned| is_geographic && !apart(*turned, ground));
    Err(TerrainError::PhotoElsewhere {
        path: path.to_owned(),
        photo,
        terrain: ground,
        remedy: match turned {
            Some([west, south, east, north]) => format!(
                "its longitudes count from another meridian; turn them by 360 degrees with: \
                 gdal_translate -a_ullr {west} {north} {east} {south} {} photo.tif",
                path.display()
            ),
            None => "take a photograph of the same place".into(),
        },
    })
}

/// Refuses a photograph in another CRS that shares no longitude and latitude with the terrain,
/// where that can be computed: to warp it would not help.
fn check_overlap_on_earth(
    path: &Path,
    photo: (&Crs, [f64; 4]),
    ground: (&Crs, [f64; 4]),
) -> Result<(), TerrainError> {
    /// More, in degrees, than a rectangle's sides are bent by between its corners.
    const MARGIN: f64 = 1.0;
    let (Some(photo), Some(ground)) = (degrees(photo), degrees(ground)) else {
        return Ok(());
    };
    let [west, south, east, north] = photo;
    let wide = [west - MARGIN, south - MARGIN, east + MARGIN, north + MARGIN];
    if apart(wide, ground) {
        return Err(TerrainError::PhotoElsewhere {
            path: path.to_owned(),
            photo,
            terrain: ground,
            remedy: "take a photograph of the same place".into(),
        });
    }
    Ok(())
}

/// The rectangle of longitudes and latitudes around the corners of one in coordinates, where they
/// can be computed and do not reach around the Earth.
fn degrees((crs, [west, south, east, north]): (&Crs, [f64; 4])) -> Option<[f64; 4]> {
    let mut edges = [
        f64::INFINITY,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NEG_INFINITY,
    ];
    for corner in [[west, south], [east, south], [west, north], [east, north]] {
        let at = crs.to_wgs84(DVec2::from(corner))?;
        edges[0] = edges[0].min(at.x);
        edges[1] = edges[1].min(at.y);
        edges[2] = edges[2].max(at.x);
        edges[3] = edges[3].max(at.y);
    }
    (edges[2] - edges[0] < 180.0).then_some(edges)
}

/// Accepts a photograph whose coordinates mean what the terrain's do, within one cell.
fn compare_crs(
    path: &Path,
    source: &TerrainSource,
    photo: Option<&Crs>,
    terrain: &Georeference,
    [west, south, east, north]: [f64; 4],
    grid: &Grid,
    notes: &mut Vec<String>,
) -> Result<(), TerrainError> {
    let (Some(photo), Some(ground)) = (photo, terrain.crs.as_ref()) else {
        match (photo, &terrain.crs) {
            (None, Some(ground)) => {
                notes.push(format!(
                    "the photograph names no CRS; the terrain's is assumed: {ground}"
                ));
            }
            (Some(photo), None) => {
                notes.push(format!(
                    "the terrain names no CRS; the photograph's is {photo}"
                ));
            }
            _ => {}
        }
        return Ok(());
    };
    let (x, y) = ((west + east) / 2.0, (south + north) / 2.0);
    let places = [
        [west, south],
        [east, south],
        [west, north],
        [east, north],
        [x, y],
    ];
    let cell = grid.cell_length();
    let difference = match photo.relation_to(ground, &places) {
        CrsRelation::Same => return Ok(()),
        CrsRelation::NameOnly => {
            notes.push(format!(
                "the photograph's CRS {photo} differs from the terrain's {ground} in name only"
            ));
            return Ok(());
        }
        CrsRelation::Shifted(metres) if metres < cell => {
            notes.push(format!(
                "the photograph's CRS {photo} differs from the terrain's {ground}; that shifts it \
                 by at most {metres:.1} m, less than a cell ({cell:.1} m), and is left so"
            ));
            return Ok(());
        }
        CrsRelation::Shifted(metres) => {
            format!("that would shift it by {metres:.0} m, and a cell is {cell:.1} m")
        }
        CrsRelation::Unrelated(why) => why,
    };
    let edges = [west, south, east, north];
    check_overlap_on_earth(path, (photo, edges), (ground, terrain_edges(terrain, grid)))?;
    Err(TerrainError::PhotoCrs {
        path: path.to_owned(),
        photo_crs: photo.to_string(),
        terrain_crs: ground.to_string(),
        difference,
        command: warp_command(path, source, ground),
    })
}
