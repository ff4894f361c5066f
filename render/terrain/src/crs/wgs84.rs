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
        let (own, wgs84) = self
            .and_wgs84()
            .ok_or_else(|| PlaceError::NotComputed(self.to_string()))?;
        let no_coordinates = || PlaceError::NoCoordinates {
            longitude: degrees.x.to_string(),
            latitude: degrees.y.to_string(),
        };
        let mut point = (degrees.x.to_radians(), degrees.y.to_radians(), 0.0);
        transform(&wgs84, &own, &mut point).map_err(|_| no_coordinates())?;
        let place = DVec2::new(point.0, point.1) / self.unit();
        if place.is_finite() {
            Ok(place)
        } else {
            Err(no_coordinates())
        }
    }

    /// The WGS 84 longitude and latitude in degrees of a place in this system's own units, where
    /// they can be computed.
    pub(crate) fn to_wgs84(&self, place: DVec2) -> Option<DVec2> {
        let (own, wgs84) = self.and_wgs84()?;
        let place = place * self.unit();
        let mut point = (place.x, place.y, 0.0);
        transform(&own, &wgs84, &mut point).ok()?;
        let degrees = DVec2::new(point.0.to_degrees(), point.1.to_degrees());
        degrees.is_finite().then_some(degrees)
    }

    fn and_wgs84(&self) -> Option<(Proj, Proj)> {
        let own = Proj::from_proj_string(&self.proj_string()?).ok()?;
        let wgs84 = Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs").ok()?;
        Some((own, wgs84))
    }

    /// Metres, or radians, in one unit of the coordinates.
    fn unit(&self) -> f64 {
        let projection = self.projection.as_ref();
        projection.map_or(1f64.to_radians(), |projection| projection.metres_per_unit)
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
    fn web_maps_are_a_spheres_whichever_way_they_are_described() {
        let esri = Crs::from_wkt(
            r#"PROJCS["WGS_1984_Web_Mercator_Auxiliary_Sphere",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Mercator_Auxiliary_Sphere"],PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",0.0],PARAMETER["Standard_Parallel_1",0.0],PARAMETER["Auxiliary_Sphere_Type",0.0],UNIT["Meter",1.0]]"#,
        );
        let place = DVec2::new(-105.0, 40.0);
        for crs in [
            esri.unwrap(),
            Crs::from_epsg(3857).unwrap(),
            Crs::from_epsg(3785).unwrap(),
        ] {
            let at = crs.from_wgs84(place).unwrap();
            // As PROJ 9.1.1 gives it: cs2cs EPSG:4326 EPSG:3857.
            let expected = DVec2::new(-11_688_546.533_294, 4_865_942.279_503);
            assert!((at - expected).length() < 1e-3, "{crs}: {at}");
            assert!((crs.to_wgs84(at).unwrap() - place).length() < 1e-9, "{crs}");
        }
        // World Mercator is the ellipsoid's.
        let at = Crs::from_epsg(3395).unwrap().from_wgs84(place).unwrap();
        assert!((at.y - 4_838_471.398).abs() < 1e-2, "{at}");
    }

    #[test]
    fn nowhere_is_said_to_be_nowhere() {
        let utm = Crs::from_epsg(32632).unwrap();
        assert!(utm.from_wgs84(DVec2::splat(f64::NAN)).is_err());
    }
}
