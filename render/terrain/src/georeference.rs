//! From a file's coordinates to world metres and back.

use crate::raster::Header;
use crate::{Crs, Datum, PlaceError, TerrainError};
use glam::DVec2;
use std::path::Path;

/// Where a terrain lies on Earth: world metres to coordinates and back.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// What the coordinates mean; `None` where nothing says so, and they count as metres.
    pub crs: Option<Crs>,
    /// Coordinates of the south-west post, the world's origin.
    pub origin: DVec2,
    /// World metres in one unit of the coordinates, eastwards and northwards.
    pub metres_per_unit: DVec2,
    /// Distance between posts in units of the coordinates.
    pub step: DVec2,
    /// The unit that the source stores heights in; the world's are metres.
    pub vertical_unit: String,
}

impl Georeference {
    /// A georeference for ground that lies nowhere: world metres are the coordinates.
    #[must_use]
    pub fn nowhere(step: DVec2) -> Self {
        Self {
            crs: None,
            origin: DVec2::ZERO,
            metres_per_unit: DVec2::ONE,
            step,
            vertical_unit: "m".into(),
        }
    }

    /// By a file's header: projected coordinates count in their unit, geographic ones by the
    /// length of a degree at the data's middle latitude.
    pub(crate) fn of(path: &Path, header: &Header) -> Result<Self, TerrainError> {
        let [west, south, east, north] = header.extent(path)?;
        let step = DVec2::new(
            (east - west) / f64::from(header.width),
            (north - south) / f64::from(header.height),
        );
        let metres_per_unit = match &header.crs {
            None => DVec2::ONE,
            Some(crs) => match &crs.projection {
                Some(projection) => DVec2::splat(projection.metres_per_unit),
                None => {
                    let middle = (south + north) / 2.0;
                    if middle.abs() > 89.9 || east - west > 361.0 {
                        return Err(TerrainError::unsupported(
                            path,
                            format!("spans {west} to {east}° east, {south} to {north}° north"),
                            format!(
                                "project it with: gdalwarp -t_srs EPSG:CODE {} projected.tif",
                                path.display()
                            ),
                        ));
                    }
                    DVec2::from(crs.datum.metres_per_degree(middle))
                }
            },
        };
        Ok(Self {
            crs: header.crs.clone(),
            origin: DVec2::new(west, south) + step / 2.0,
            metres_per_unit,
            step,
            vertical_unit: header.bands[0].unit.clone().unwrap_or_else(|| "m".into()),
        })
    }

    /// World x and y in metres of a place in coordinates.
    #[must_use]
    pub fn world_from_crs(&self, place: DVec2) -> DVec2 {
        (place - self.origin) * self.metres_per_unit
    }

    /// World x and y in metres of a WGS 84 longitude and latitude in degrees.
    ///
    /// # Errors
    /// [`PlaceError`] where the terrain's system is unknown, not computed or does not reach there.
    pub fn world_from_wgs84(&self, degrees: DVec2) -> Result<DVec2, PlaceError> {
        let crs = self.crs.as_ref().ok_or(PlaceError::NoCrs)?;
        Ok(self.world_from_crs(crs.from_wgs84(degrees)?))
    }

    /// Coordinates of a place in world metres.
    #[must_use]
    pub fn crs_from_world(&self, place: DVec2) -> DVec2 {
        place / self.metres_per_unit + self.origin
    }

    /// Metres of the map to a metre of the ground at a place in coordinates, eastwards and
    /// northwards; `None` where that cannot be computed. Degrees are measured on the ground.
    pub(crate) fn map_scale(&self, place: DVec2) -> Option<DVec2> {
        /// Half of what is measured, in metres of the map: short against any terrain.
        const REACH: f64 = 100.0;
        let crs = self.crs.as_ref().filter(|crs| !crs.is_geographic())?;
        let along = |axis: DVec2| {
            let reach = axis * REACH / self.metres_per_unit;
            let (from, to) = (crs.to_wgs84(place - reach)?, crs.to_wgs84(place + reach)?);
            let metres = DVec2::from(Datum::wgs84().metres_per_degree((from.y + to.y) / 2.0));
            let scale = 2.0 * REACH / ((to - from) * metres).length();
            scale.is_finite().then_some(scale)
        };
        Some(DVec2::new(along(DVec2::X)?, along(DVec2::Y)?))
    }

    /// Metres between posts, eastwards and northwards.
    #[must_use]
    pub fn spacing(&self) -> DVec2 {
        self.step * self.metres_per_unit
    }
}
