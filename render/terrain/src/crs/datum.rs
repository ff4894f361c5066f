//! Datums: the ellipsoid and where it sits in the Earth.

use serde::Serialize;

/// The body that coordinates refer to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Datum {
    /// What people call it; "unknown" where the source does not say.
    pub name: String,
    /// The ellipsoid's semi-major axis in metres.
    pub semi_major_axis: f64,
    /// The ellipsoid's inverse flattening; 0 for a sphere.
    pub inverse_flattening: f64,
    /// Longitude of the prime meridian in degrees east of Greenwich.
    pub prime_meridian: f64,
    /// Position-vector transformation to WGS 84 (metres, arc seconds, parts per million), where
    /// it is known.
    pub to_wgs84: Option<[f64; 7]>,
}

/// Common datums: name, spellings (letters and digits only), shift to WGS 84 in metres. Those
/// with 0 agree with WGS 84 within two metres.
const KNOWN: [(&str, &[&str], [f64; 3]); 9] = [
    (
        "WGS 84",
        &["wgs1984", "wgs84", "worldgeodeticsystem1984"],
        [0.0; 3],
    ),
    (
        "NAD83",
        &["northamericandatum1983", "northamerican1983", "nad83"],
        [0.0; 3],
    ),
    // Clarke 1866, mean of the conterminous United States.
    (
        "NAD27",
        &["northamericandatum1927", "northamerican1927", "nad27"],
        [-8.0, 160.0, 176.0],
    ),
    (
        "ETRS89",
        &[
            "europeanterrestrialreferencesystem1989",
            "etrs1989",
            "etrs89",
        ],
        [0.0; 3],
    ),
    (
        "ED50",
        &["europeandatum1950", "european1950", "ed50"],
        [-87.0, -98.0, -121.0],
    ),
    (
        "SIRGAS 2000",
        &[
            "sirgas2000",
            "sistemadereferenciageocentricoparalasamericas2000",
        ],
        [0.0; 3],
    ),
    (
        "GDA94",
        &["geocentricdatumofaustralia1994", "gda1994", "gda94"],
        [0.0; 3],
    ),
    (
        "GDA2020",
        &["geocentricdatumofaustralia2020", "gda2020"],
        [0.0; 3],
    ),
    (
        "NZGD2000",
        &["newzealandgeodeticdatum2000", "nzgd2000"],
        [0.0; 3],
    ),
];

impl Datum {
    /// WGS 84.
    #[must_use]
    pub fn wgs84() -> Self {
        Self::new("WGS 84", 6_378_137.0, 298.257_223_563, 0.0, None)
    }

    /// A datum, its name in the usual spelling and its shift looked up where none is given.
    pub(crate) fn new(
        name: &str,
        semi_major_axis: f64,
        inverse_flattening: f64,
        prime_meridian: f64,
        to_wgs84: Option<[f64; 7]>,
    ) -> Self {
        let key = key(name);
        let known = KNOWN
            .iter()
            .find(|(_, spellings, _)| spellings.contains(&key.as_str()));
        Self {
            name: known.map_or_else(|| name.replace('_', " "), |(usual, ..)| (*usual).to_owned()),
            semi_major_axis,
            inverse_flattening,
            prime_meridian,
            to_wgs84: to_wgs84
                .or_else(|| known.map(|(_, _, [x, y, z])| [*x, *y, *z, 0.0, 0.0, 0.0, 0.0])),
        }
    }

    /// Whether the source names no datum.
    #[must_use]
    pub fn is_unnamed(&self) -> bool {
        let key = key(&self.name);
        key.is_empty() || key.starts_with("unknown") || key.starts_with("notspecified")
    }

    /// The first eccentricity squared.
    #[must_use]
    pub fn eccentricity_squared(&self) -> f64 {
        if self.inverse_flattening == 0.0 {
            return 0.0;
        }
        let flattening = 1.0 / self.inverse_flattening;
        flattening * (2.0 - flattening)
    }

    /// Metres in a degree of longitude and in a degree of latitude at `latitude` (degrees).
    #[must_use]
    pub fn metres_per_degree(&self, latitude: f64) -> [f64; 2] {
        let (sin, cos) = latitude.to_radians().sin_cos();
        let e2 = self.eccentricity_squared();
        let w2 = 1.0 - e2 * sin * sin;
        let prime_vertical = self.semi_major_axis / w2.sqrt();
        let meridian = prime_vertical * (1.0 - e2) / w2;
        [prime_vertical * cos, meridian].map(f64::to_radians)
    }

    pub(crate) fn same_ellipsoid(&self, other: &Self) -> bool {
        (self.semi_major_axis - other.semi_major_axis).abs() < 1e-3
            && (self.inverse_flattening - other.inverse_flattening).abs() < 1e-7
            && (self.prime_meridian - other.prime_meridian).abs() < 1e-9
    }

    /// The shift to WGS 84, taken as none for an unnamed datum on a geocentric ellipsoid.
    pub(crate) fn shift(&self) -> Option<[f64; 7]> {
        let geocentric = (self.semi_major_axis - 6_378_137.0).abs() < 1e-3
            && (self.inverse_flattening - 298.257_222).abs() < 1e-5;
        self.to_wgs84
            .or((geocentric && self.is_unnamed()).then_some([0.0; 7]))
    }

    /// The datum in PROJ's words.
    pub(crate) fn proj_words(&self) -> String {
        let mut text = format!("+a={}", self.semi_major_axis);
        if self.inverse_flattening == 0.0 {
            text += &format!(" +b={}", self.semi_major_axis);
        } else {
            text += &format!(" +rf={}", self.inverse_flattening);
        }
        if let Some(shift) = self.shift() {
            text += &format!(
                " +towgs84={}",
                shift.map(|value| value.to_string()).join(",")
            );
        }
        if self.prime_meridian != 0.0 {
            text += &format!(" +pm={}", self.prime_meridian);
        }
        text
    }
}

/// Letters and digits of a name, without ESRI's prefix.
fn key(name: &str) -> String {
    name.trim_start_matches("D_")
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .collect::<String>()
        .to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_degree_has_the_length_that_tables_give() {
        // WGS 84 at the equator and at 45°.
        let [east, north] = Datum::wgs84().metres_per_degree(0.0);
        assert!((east - 111_319.49).abs() < 0.01 && (north - 110_574.28).abs() < 0.01);
        let [east, north] = Datum::wgs84().metres_per_degree(45.0);
        assert!((east - 78_846.84).abs() < 0.01 && (north - 111_131.78).abs() < 0.01);
    }

    #[test]
    fn spellings_of_a_datum_are_one() {
        let esri = Datum::new("D_North_American_1927", 6_378_206.4, 294.978_698, 0.0, None);
        let epsg = Datum::new(
            "North_American_Datum_1927",
            6_378_206.4,
            294.978_698,
            0.0,
            None,
        );
        assert_eq!(esri, epsg);
        assert_eq!(esri.name, "NAD27");
    }
}
