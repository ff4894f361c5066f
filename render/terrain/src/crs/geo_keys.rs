//! GeoTIFF's keys to a CRS.

use super::{Crs, Datum, PSEUDO_MERCATOR, Projection};
use geotiff_reader::geokeys::{self, GeoKeyDirectory};

const USER_DEFINED: u16 = 32_767;
const GEOG_PRIME_MERIDIAN_LONG: u16 = 2061;
const GEOG_ELLIPSOID: u16 = 2056;
const GEOG_SEMI_MAJOR_AXIS: u16 = 2057;
const GEOG_SEMI_MINOR_AXIS: u16 = 2058;
const GEOG_INVERSE_FLATTENING: u16 = 2059;
const GEOG_TO_WGS84: u16 = 2062;
const PROJ_LINEAR_UNIT_SIZE: u16 = 3077;

/// Projection parameters: key, name in WKT's words, whether it is a length.
const PARAMETERS: [(u16, &str, bool); 14] = [
    (3078, "standard_parallel_1", false),
    (3079, "standard_parallel_2", false),
    (3080, "central_meridian", false),
    (3081, "latitude_of_origin", false),
    (3082, "false_easting", true),
    (3083, "false_northing", true),
    (3084, "central_meridian", false),
    (3085, "latitude_of_origin", false),
    (3086, "false_easting", true),
    (3087, "false_northing", true),
    (3088, "longitude_of_center", false),
    (3089, "latitude_of_center", false),
    (3092, "scale_factor", false),
    (3095, "central_meridian", false),
];

/// The CRS that a GeoTIFF's keys describe, `None` where they describe none, or what about them
/// is not understood.
pub(crate) fn crs_from_geo_keys(keys: &GeoKeyDirectory) -> Result<Option<Crs>, String> {
    let projected = code(keys, geokeys::PROJECTED_CRS_TYPE);
    let geographic = code(keys, geokeys::GEODETIC_CRS_TYPE);
    let model = keys.get_short(geokeys::GT_MODEL_TYPE);
    match model {
        Some(3) => Err("is in geocentric coordinates".into()),
        Some(1) => projected_crs(keys, projected).map(Some),
        Some(2) => geographic_crs(keys, geographic).map(Some),
        _ if projected.is_some() => projected_crs(keys, projected).map(Some),
        _ if geographic.is_some() => geographic_crs(keys, geographic).map(Some),
        _ => Ok(None),
    }
}

fn code(keys: &GeoKeyDirectory, key: u16) -> Option<u16> {
    keys.get_short(key).filter(|&code| code != 0)
}

fn number(keys: &GeoKeyDirectory, key: u16) -> Option<f64> {
    keys.get_double(key)?
        .first()
        .copied()
        .filter(|value| value.is_finite())
}

/// A citation without padding, or `None` where it says nothing.
fn citation(keys: &GeoKeyDirectory, key: u16) -> Option<String> {
    let text = keys
        .get_ascii(key)?
        .split('|')
        .next()?
        .trim_matches(['\0', ' ', '\n']);
    let text = text.strip_prefix("GCS Name = ").unwrap_or(text);
    (!text.is_empty() && !text.eq_ignore_ascii_case("unknown")).then(|| text.to_owned())
}

/// `Datum = NAME` out of a citation of several parts.
fn cited_datum(keys: &GeoKeyDirectory) -> Option<&str> {
    keys.get_ascii(geokeys::GEODETIC_CITATION)?
        .split('|')
        .find_map(|part| part.trim().strip_prefix("Datum = "))
}

fn geographic_crs(keys: &GeoKeyDirectory, code: Option<u16>) -> Result<Crs, String> {
    // 9102 is the degree.
    let unit = keys.get_short(geokeys::GEOG_ANGULAR_UNITS).unwrap_or(9102);
    if unit != 9102 {
        return Err(format!(
            "has coordinates in an angular unit other than the degree (EPSG:{unit})"
        ));
    }
    let epsg = code.filter(|&code| code != USER_DEFINED).map(u32::from);
    if let Some(crs) = epsg.and_then(Crs::from_epsg).filter(Crs::is_geographic) {
        return Ok(crs);
    }
    let datum = datum(keys)?;
    let name = citation(keys, geokeys::GEODETIC_CITATION)
        .or_else(|| citation(keys, geokeys::GT_CITATION))
        .unwrap_or_else(|| datum.name.clone());
    Ok(Crs {
        name,
        epsg,
        datum,
        projection: None,
    })
}

fn projected_crs(keys: &GeoKeyDirectory, code: Option<u16>) -> Result<Crs, String> {
    let epsg = code.filter(|&code| code != USER_DEFINED).map(u32::from);
    if let Some(crs) = epsg
        .and_then(Crs::from_epsg)
        .filter(|crs| !crs.is_geographic())
    {
        let metres_per_unit = unit(keys)?;
        return Ok(match (crs.projection.clone(), metres_per_unit) {
            // The file's own unit counts, should it contradict the code's.
            (Some(projection), Some(metres_per_unit)) => Crs {
                projection: Some(Projection {
                    metres_per_unit,
                    ..projection
                }),
                ..crs
            },
            _ => crs,
        });
    }
    let projection = projection(keys, unit(keys)?.unwrap_or(1.0));
    let name = citation(keys, geokeys::GT_CITATION)
        .or_else(|| citation(keys, geokeys::PROJ_CITATION))
        .unwrap_or_else(|| "unnamed".to_owned());
    Ok(Crs {
        name,
        epsg,
        datum: datum(keys)?,
        projection: Some(projection),
    })
}

fn unit(keys: &GeoKeyDirectory) -> Result<Option<f64>, String> {
    match keys.get_short(geokeys::PROJ_LINEAR_UNITS) {
        None | Some(0) => Ok(None),
        Some(9001) => Ok(Some(1.0)),
        Some(9002) => Ok(Some(0.3048)),
        Some(9003) => Ok(Some(1200.0 / 3937.0)),
        Some(9036) => Ok(Some(1000.0)),
        Some(USER_DEFINED) => number(keys, PROJ_LINEAR_UNIT_SIZE)
            .filter(|&size| size > 1e-6 && size < 1e6)
            .map(Some)
            .ok_or_else(|| "has coordinates in a unit of length of its own without a size".into()),
        Some(other) => Err(format!(
            "has coordinates in the unit of length EPSG:{other}"
        )),
    }
}

fn projection(keys: &GeoKeyDirectory, metres_per_unit: f64) -> Projection {
    // Codes 16001..16060 and 16101..16160 are the UTM zones, north and south.
    if let Some(zone) = code(keys, geokeys::PROJECTION)
        && let (160 | 161, zone @ 1..=60) = (zone / 100, zone % 100)
    {
        let south = code(keys, geokeys::PROJECTION).is_some_and(|code| code > 16_100);
        let parameters = [
            ("central_meridian", f64::from(zone) * 6.0 - 183.0),
            ("scale_factor", 0.9996),
            ("false_easting", 500_000.0),
            ("false_northing", if south { 1e7 } else { 0.0 }),
        ]
        .map(|(name, value)| (name.to_owned(), value));
        return Projection::new("transverse_mercator", parameters, metres_per_unit);
    }
    let method = match keys.get_short(geokeys::PROJ_COORD_TRANS) {
        Some(1) => "transverse_mercator".to_owned(),
        Some(7) if cites_auxiliary_sphere(keys) => PSEUDO_MERCATOR.to_owned(),
        Some(7) => "mercator_1sp".to_owned(),
        Some(8) => "lambert_conformal_conic_2sp".to_owned(),
        Some(9) => "lambert_conformal_conic_1sp".to_owned(),
        Some(10) => "lambert_azimuthal_equal_area".to_owned(),
        Some(11) => "albers_conic_equal_area".to_owned(),
        Some(15) => "polar_stereographic".to_owned(),
        Some(16) => "oblique_stereographic".to_owned(),
        Some(17) => "equirectangular".to_owned(),
        Some(18) => "cassini_soldner".to_owned(),
        Some(22) => "polyconic".to_owned(),
        Some(other) => format!("geotiff_transformation_{other}"),
        None => "unnamed".to_owned(),
    };
    let parameters = PARAMETERS.into_iter().filter_map(|(key, name, length)| {
        let scale = if length { metres_per_unit } else { 1.0 };
        Some((name.to_owned(), number(keys, key)? * scale))
    });
    Projection::new(&method, parameters, metres_per_unit)
}

/// Whether a Mercator projection is that of web maps: GeoTIFF has no key for that, and writers say
/// so in ESRI's words.
fn cites_auxiliary_sphere(keys: &GeoKeyDirectory) -> bool {
    [geokeys::GT_CITATION, geokeys::PROJ_CITATION]
        .into_iter()
        .filter_map(|key| keys.get_ascii(key))
        .any(|text| {
            ["Auxiliary_Sphere", "Pseudo-Mercator"]
                .iter()
                .any(|name| text.contains(name))
        })
}

fn datum(keys: &GeoKeyDirectory) -> Result<Datum, String> {
    // A geographic system named by code brings its datum; so does a datum's code, which EPSG
    // numbers 2000 above the geographic system of the same name.
    let by_code = code(keys, geokeys::GEODETIC_CRS_TYPE)
        .into_iter()
        .chain(code(keys, geokeys::GEODETIC_DATUM).and_then(|code| code.checked_sub(2000)))
        .find_map(|code| Crs::from_epsg(u32::from(code)).filter(Crs::is_geographic));
    if let Some(crs) = by_code {
        return Ok(crs.datum);
    }
    let (axis, flattening) = ellipsoid(keys)?;
    let shift = keys.get_double(GEOG_TO_WGS84).map(|values| {
        std::array::from_fn(|index| {
            values
                .get(index)
                .copied()
                .filter(|v| v.is_finite())
                .unwrap_or(0.0)
        })
    });
    let meridian = number(keys, GEOG_PRIME_MERIDIAN_LONG).unwrap_or(0.0);
    Ok(Datum::new(
        cited_datum(keys).unwrap_or("unknown"),
        axis,
        flattening,
        meridian,
        shift,
    ))
}

fn ellipsoid(keys: &GeoKeyDirectory) -> Result<(f64, f64), String> {
    let by_code = match keys.get_short(GEOG_ELLIPSOID) {
        Some(7001) => Some((6_377_563.396, 299.324_964_6)),
        Some(7004) => Some((6_377_397.155, 299.152_812_8)),
        Some(7008) => Some((6_378_206.4, 294.978_698_213_898)),
        Some(7019) => Some((6_378_137.0, 298.257_222_101)),
        Some(7022) => Some((6_378_388.0, 297.0)),
        Some(7030) => Some((6_378_137.0, 298.257_223_563)),
        _ => None,
    };
    if let Some(ellipsoid) = by_code {
        return Ok(ellipsoid);
    }
    let Some(axis) = number(keys, GEOG_SEMI_MAJOR_AXIS) else {
        // Projected coordinates need no ellipsoid; this one stands for "not said".
        return Ok((6_378_137.0, 298.257_223_563));
    };
    let flattening = number(keys, GEOG_INVERSE_FLATTENING)
        .or_else(|| {
            let minor = number(keys, GEOG_SEMI_MINOR_AXIS)?;
            Some(if minor == axis {
                0.0
            } else {
                axis / (axis - minor)
            })
        })
        .unwrap_or(0.0);
    let sound =
        axis > 1e3 && axis < 1e9 && (flattening == 0.0 || (flattening > 2.0 && flattening < 1e9));
    sound.then_some((axis, flattening)).ok_or_else(|| {
        format!("has an ellipsoid of axis {axis} m and inverse flattening {flattening}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geotiff_reader::geokeys::GeoKeyValue;

    fn directory(keys: &[(u16, GeoKeyValue)]) -> GeoKeyDirectory {
        let mut directory = GeoKeyDirectory::new();
        for (id, value) in keys {
            directory.set(*id, value.clone());
        }
        directory
    }

    #[test]
    fn a_utm_zone_given_by_parameters_equals_the_one_given_by_code() {
        let keys = directory(&[
            (1024, GeoKeyValue::Short(1)),
            (3072, GeoKeyValue::Short(USER_DEFINED)),
            (3074, GeoKeyValue::Short(16_125)),
            (3076, GeoKeyValue::Short(9001)),
        ]);
        let crs = crs_from_geo_keys(&keys).unwrap().unwrap();
        assert_eq!(crs.utm_zone(), Some((25, 'S')));
        assert_eq!(crs.projection, Crs::from_epsg(31985).unwrap().projection);
        assert!(crs.datum.is_unnamed() && crs.epsg.is_none());
    }

    #[test]
    fn mercator_is_that_of_web_maps_where_it_is_said_to_be() {
        let mercator = |citation: &str| {
            let keys = directory(&[
                (1024, GeoKeyValue::Short(1)),
                (1026, GeoKeyValue::Ascii(citation.to_owned())),
                (2048, GeoKeyValue::Short(4326)),
                (3072, GeoKeyValue::Short(USER_DEFINED)),
                (3075, GeoKeyValue::Short(7)),
                (3076, GeoKeyValue::Short(9001)),
            ]);
            crs_from_geo_keys(&keys).unwrap().unwrap().projection
        };
        let web = Crs::from_epsg(3857).unwrap().projection;
        assert_eq!(mercator("WGS_1984_Web_Mercator_Auxiliary_Sphere"), web);
        assert_ne!(mercator("World Mercator"), web);
    }

    #[test]
    fn gradians_and_geocentric_coordinates_are_refused() {
        let gradians = [
            (1024, GeoKeyValue::Short(2)),
            (2054, GeoKeyValue::Short(9105)),
        ];
        assert!(
            crs_from_geo_keys(&directory(&gradians))
                .unwrap_err()
                .contains("9105")
        );
        let geocentric = [(1024, GeoKeyValue::Short(3))];
        assert!(crs_from_geo_keys(&directory(&geocentric)).is_err());
        assert_eq!(crs_from_geo_keys(&directory(&[])), Ok(None));
    }
}
