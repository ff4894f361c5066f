//! Places given by satellite navigation, in a terrain's coordinates.

use super::Crs;
use glam::DVec2;
use proj4rs::{Proj, transform::transform};

/// Why a place on Earth has no coordinates in a terrain.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// Nothing says what the terrain's coordinates mean.
    #[error("the terrain does not say where on Earth it lies")]
    NoCrs,
    /// The terrain's system cannot be computed here.
    #[error(
        "the coordinate system {0} is not computed here; gdalwarp brings the terrain to EPSG:4326"
    )]
    NotComputed(String),
    /// The system has no coordinates for the place.
    #[error("{longitude}° east, {latitude}° north has no coordinates in the terrain's system")]
    NoCoordinates {
        /// As asked.
        longitude: String,
        /// As asked.
        latitude: String,
    },
}

impl Crs {
    /// The coordinates, in this system's own units, of a WGS 84 longitude and latitude in degrees.
    ///
    /// # Errors
    /// [`PlaceError`] where the system is not computed or does not reach the place.
    pub fn from_wgs84(&self, degrees: DVec2) -> Result<DVec2, PlaceError> {
        let not_computed = || PlaceError::NotComputed(self.to_string());
        let own = self.proj_string().ok_or_else(not_computed)?;
        let own = Proj::from_proj_string(&own).map_err(|_| not_computed())?;
        let wgs84 = Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs")
            .map_err(|_| not_computed())?;
        let no_coordinates = || PlaceError::NoCoordinates {
            longitude: degrees.x.to_string(),
            latitude: degrees.y.to_string(),
        };
        let mut point = (degrees.x.to_radians(), degrees.y.to_radians(), 0.0);
        transform(&wgs84, &own, &mut point).map_err(|_| no_coordinates())?;
        let unit = self
            .projection
            .as_ref()
            .map_or(1f64.to_radians(), |projection| projection.metres_per_unit);
        let place = DVec2::new(point.0, point.1) / unit;
        if place.is_finite() {
            Ok(place)
        } else {
            Err(no_coordinates())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_has_its_projected_and_its_geographic_coordinates() {
        // As PROJ 9.1.1 gives them: cs2cs EPSG:4326 EPSG:32632.
        let utm = Crs::from_epsg(32632).unwrap();
        let at = utm.from_wgs84(DVec2::new(9.0, 47.0)).unwrap();
        assert!(
            (at - DVec2::new(500_000.0, 5_205_164.110_152)).length() < 1e-3,
            "{at}"
        );
        let at = Crs::wgs84().from_wgs84(DVec2::new(9.0, 47.0)).unwrap();
        assert!((at - DVec2::new(9.0, 47.0)).length() < 1e-9);
    }

    #[test]
    fn nowhere_is_said_to_be_nowhere() {
        let utm = Crs::from_epsg(32632).unwrap();
        assert!(utm.from_wgs84(DVec2::splat(f64::NAN)).is_err());
    }
}
