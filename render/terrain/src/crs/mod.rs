//! Coordinate reference systems: what a raster's coordinates mean.

mod datum;
mod geo_keys;
mod relation;
mod vertical;
mod wgs84;
mod wkt;

pub use datum::Datum;
pub(crate) use geo_keys::crs_from_geo_keys;
pub use relation::CrsRelation;
pub(crate) use vertical::VerticalCrs;
pub use wgs84::PlaceError;
pub use wkt::WktError;

use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The method of web maps: ellipsoidal latitudes, projected as if the Earth were a sphere.
const PSEUDO_MERCATOR: &str = "pseudo_mercator";

/// A horizontal coordinate reference system, by its parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Crs {
    /// What people call it.
    pub name: String,
    /// Its EPSG code, where its source names one.
    pub epsg: Option<u32>,
    /// The body that coordinates refer to.
    pub datum: Datum,
    /// How the body is laid flat; `None` for longitude and latitude in degrees.
    pub projection: Option<Projection>,
}

/// A map projection.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Projection {
    /// The method in lower case with underscores, as `transverse_mercator`.
    pub method: String,
    /// Its parameters other than 0 (scale: other than 1): degrees, metres and ratios.
    pub parameters: BTreeMap<String, f64>,
    /// Length of one unit of the coordinates.
    pub metres_per_unit: f64,
}

impl Crs {
    /// WGS 84 longitude and latitude in degrees, EPSG:4326.
    #[must_use]
    pub fn wgs84() -> Self {
        Self {
            name: "WGS 84".into(),
            epsg: Some(4326),
            datum: Datum::wgs84(),
            projection: None,
        }
    }

    /// The system with an EPSG code, or `None` where the code is not in the table.
    #[must_use]
    pub fn from_epsg(code: u32) -> Option<Self> {
        let definition = crs_definitions::from_code(u16::try_from(code).ok()?)?;
        let mut crs = Self::from_wkt(definition.wkt).ok()?;
        crs.epsg = Some(code);
        Some(crs)
    }

    /// Whether coordinates are longitude and latitude.
    #[must_use]
    pub fn is_geographic(&self) -> bool {
        self.projection.is_none()
    }

    /// How `gdalwarp` is told of this system: its EPSG code, else a PROJ string in its own unit;
    /// `None` where the method has no word there.
    #[must_use]
    pub fn target(&self) -> Option<String> {
        if let Some(code) = self.epsg {
            return Some(format!("EPSG:{code}"));
        }
        let text = self.proj_string()?;
        let unit = self
            .projection
            .as_ref()
            .map_or(1.0, |own| own.metres_per_unit);
        Some(if unit == 1.0 {
            format!("'{text}'")
        } else {
            format!(
                "'{}'",
                text.replace("+units=m", &format!("+to_meter={unit}"))
            )
        })
    }

    /// The zone and hemisphere ('N' or 'S'), where this is a UTM system.
    #[must_use]
    pub fn utm_zone(&self) -> Option<(u8, char)> {
        let projection = self.projection.as_ref()?;
        let get = |name: &str| projection.parameters.get(name).copied().unwrap_or(0.0);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        let zone = (get("central_meridian") + 183.0) / 6.0;
        let is_utm = projection.method == "transverse_mercator"
            && near(get("latitude_of_origin"), 0.0)
            && near(get("scale_factor"), 0.9996)
            && near(get("false_easting"), 500_000.0)
            && near(zone, zone.round())
            && (1.0..=60.0).contains(&zone.round());
        match get("false_northing") {
            _ if !is_utm => None,
            north if near(north, 0.0) => Some((zone.round() as u8, 'N')),
            north if near(north, 1e7) => Some((zone.round() as u8, 'S')),
            _ => None,
        }
    }

    /// The same in PROJ's words, coordinates in metres or degrees; `None` where the method has no
    /// word there.
    #[must_use]
    pub fn proj_string(&self) -> Option<String> {
        let Some(projection) = &self.projection else {
            return Some(format!(
                "+proj=longlat {} +no_defs",
                self.datum.proj_words()
            ));
        };
        let name = match projection.method.as_str() {
            "transverse_mercator" => "tmerc",
            "mercator_1sp" | "mercator_2sp" | "mercator" | PSEUDO_MERCATOR => "merc",
            "lambert_conformal_conic_1sp" | "lambert_conformal_conic_2sp" => "lcc",
            "albers_conic_equal_area" => "aea",
            "lambert_azimuthal_equal_area" => "laea",
            "cassini_soldner" => "cass",
            "oblique_stereographic" => "sterea",
            "polyconic" => "poly",
            "equirectangular" => "eqc",
            _ => return None,
        };
        let mut text = format!("+proj={name}");
        let one_parallel = projection.method == "lambert_conformal_conic_1sp";
        for (parameter, value) in &projection.parameters {
            let word = match parameter.as_str() {
                "latitude_of_origin" | "latitude_of_center" => "lat_0",
                "central_meridian" | "longitude_of_center" => "lon_0",
                "scale_factor" => "k_0",
                "false_easting" => "x_0",
                "false_northing" => "y_0",
                "standard_parallel_1" if matches!(name, "merc" | "eqc") => "lat_ts",
                "standard_parallel_1" => "lat_1",
                "standard_parallel_2" => "lat_2",
                _ => return None,
            };
            text += &format!(" +{word}={value}");
            if one_parallel && word == "lat_0" {
                text += &format!(" +lat_1={value}");
            }
        }
        let datum = if projection.method == PSEUDO_MERCATOR {
            let radius = self.datum.semi_major_axis;
            // PROJ's way to leave latitudes as they are, for all that the sphere is another body.
            format!("+a={radius} +b={radius} +nadgrids=@null +wktext")
        } else {
            self.datum.proj_words()
        };
        Some(format!("{text} {datum} +units=m +no_defs"))
    }
}

impl fmt::Display for Crs {
    /// Name and, where there is one, code: `NAD27 / UTM zone 10N (EPSG:26710)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        match self.epsg {
            Some(code) => write!(f, " (EPSG:{code})"),
            None => Ok(()),
        }
    }
}

impl Projection {
    /// A projection with its words and defaults in one form, so that two can be compared.
    pub(crate) fn new(
        method: &str,
        parameters: impl IntoIterator<Item = (String, f64)>,
        metres_per_unit: f64,
    ) -> Self {
        let parameters: BTreeMap<_, _> = parameters
            .into_iter()
            .map(|(name, value)| (snake_case(&name), value))
            .filter(|(name, value)| *value != if name == "scale_factor" { 1.0 } else { 0.0 })
            .collect();
        let method = match snake_case(method).as_str() {
            "gauss_kruger" => "transverse_mercator".to_owned(),
            "albers" => "albers_conic_equal_area".to_owned(),
            "mercator_auxiliary_sphere" | "popular_visualisation_pseudo_mercator" => {
                PSEUDO_MERCATOR.to_owned()
            }
            "lambert_conformal_conic" if parameters.contains_key("standard_parallel_2") => {
                "lambert_conformal_conic_2sp".to_owned()
            }
            "lambert_conformal_conic" => "lambert_conformal_conic_1sp".to_owned(),
            other => other.to_owned(),
        };
        Self {
            method,
            parameters,
            metres_per_unit,
        }
    }

    fn agrees(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1.0);
        self.method == other.method
            && near(self.metres_per_unit, other.metres_per_unit)
            && self.parameters.len() == other.parameters.len()
            && self.parameters.iter().all(|(name, value)| {
                other
                    .parameters
                    .get(name)
                    .is_some_and(|against| near(*value, *against))
            })
    }
}

/// `Transverse Mercator` and `Transverse_Mercator` as `transverse_mercator`.
fn snake_case(text: &str) -> String {
    let words: Vec<_> = text
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    words.join("_").to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_epsg_code_gives_name_datum_and_projection() {
        let utm = Crs::from_epsg(26710).unwrap();
        assert_eq!(utm.to_string(), "NAD27 / UTM zone 10N (EPSG:26710)");
        assert_eq!(utm.utm_zone(), Some((10, 'N')));
        assert_eq!(
            utm.datum.to_wgs84,
            Some([-8.0, 160.0, 176.0, 0.0, 0.0, 0.0, 0.0])
        );
        assert_eq!(Crs::from_epsg(31985).unwrap().utm_zone(), Some((25, 'S')));
        assert!(Crs::from_epsg(4326).unwrap().is_geographic());
        assert_eq!(Crs::from_epsg(1), None);
        let feet = Crs::from_epsg(2230).unwrap().projection.unwrap();
        assert!((feet.metres_per_unit - 1200.0 / 3937.0).abs() < 1e-12);
        // False origins are kept in metres, whatever the coordinates' unit.
        assert!((feet.parameters["false_easting"] - 2_000_000.0).abs() < 1e-3);
    }

    #[test]
    fn a_target_without_a_code_has_the_systems_own_unit() {
        let mut feet = Crs::from_epsg(2230).unwrap();
        assert_eq!(feet.target().as_deref(), Some("EPSG:2230"));
        feet.epsg = None;
        let target = feet.target().unwrap();
        assert!(target.contains("+to_meter=0.30480060"), "{target}");
        assert!(!target.contains("+units"), "{target}");
        feet.projection = Some(Projection::new("Bonne", [], 1.0));
        assert_eq!(feet.target(), None);
    }

    #[test]
    fn every_epsg_definition_is_understood_or_no_map() {
        for code in 1..=u16::MAX {
            if let Some(definition) = crs_definitions::from_code(code) {
                let known = Crs::from_epsg(u32::from(code)).is_some();
                // Geocentric systems are no maps; a few systems are listed in WKT 2 only.
                let other = ["GEOCCS", "BOUNDCRS", "GEOGCRS"]
                    .iter()
                    .any(|kind| definition.wkt.starts_with(kind));
                let angle = !definition.wkt.contains("PROJCS[")
                    && !definition
                        .wkt
                        .contains("UNIT[\"degree\",0.0174532925199433");
                let unsaid = definition.wkt.is_empty();
                assert!(
                    known || other || angle || unsaid,
                    "{code}: {}",
                    definition.wkt
                );
            }
        }
    }
}
