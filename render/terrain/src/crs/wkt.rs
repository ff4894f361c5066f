//! Well-known text (OGC WKT 1, also in ESRI's spelling, as in `.prj` files) to a CRS.

use super::{Crs, Datum, PSEUDO_MERCATOR, Projection};

/// Nothing real nests deeper; a hostile text must not exhaust the stack.
const MAX_DEPTH: usize = 32;

/// Why a text describes no CRS that is understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WktError {
    /// The brackets, quotes or commas do not fit.
    #[error("the text breaks off or is malformed at byte {0}")]
    Syntax(usize),
    /// A keyword that should be there is not.
    #[error("{within} has no {missing}")]
    Missing {
        /// The element.
        within: &'static str,
        /// What it lacks.
        missing: &'static str,
    },
    /// Another kind of system.
    #[error("{0:?} is neither PROJCS nor GEOGCS (WKT 1)")]
    Kind(String),
    /// A number that cannot be.
    #[error("{what} cannot be {value}")]
    Value {
        /// Which number.
        what: &'static str,
        /// What it is.
        value: String,
    },
}

#[derive(Debug)]
enum Item {
    Text(String),
    Number(f64),
    Element(Element),
}

#[derive(Debug)]
struct Element {
    keyword: String,
    items: Vec<Item>,
}

impl Element {
    fn child(&self, keyword: &'static str) -> Option<&Self> {
        self.children(keyword).next()
    }

    fn children(&self, keyword: &'static str) -> impl Iterator<Item = &Self> {
        self.items.iter().filter_map(move |item| match item {
            Item::Element(element) if element.keyword.eq_ignore_ascii_case(keyword) => {
                Some(element)
            }
            _ => None,
        })
    }

    fn need(&self, within: &'static str, missing: &'static str) -> Result<&Self, WktError> {
        self.child(missing)
            .ok_or(WktError::Missing { within, missing })
    }

    fn name(&self) -> &str {
        match self.items.first() {
            Some(Item::Text(text)) => text,
            _ => "",
        }
    }

    fn number(&self, index: usize) -> Option<f64> {
        match self.items.get(index) {
            Some(Item::Number(value)) => Some(*value),
            Some(Item::Text(text)) => text.trim().parse().ok(),
            _ => None,
        }
    }

    fn epsg(&self) -> Option<u32> {
        let authority = self.child("AUTHORITY")?;
        let code = authority.number(1)?;
        (authority.name().eq_ignore_ascii_case("EPSG") && code > 0.0 && code < 1e6)
            .then_some(code as u32)
    }
}

impl Crs {
    /// Reads WKT 1 (`PROJCS`, `GEOGCS`, or the horizontal part of `COMPD_CS`).
    ///
    /// # Errors
    /// [`WktError`] where the text breaks off, lacks a part, or describes something else.
    pub fn from_wkt(text: &str) -> Result<Self, WktError> {
        let bytes = text.as_bytes();
        let mut at = skip_space(bytes, if text.starts_with('\u{feff}') { 3 } else { 0 });
        let root = element(text, &mut at, 0)?;
        let horizontal = if root.keyword.eq_ignore_ascii_case("COMPD_CS") {
            root.child("PROJCS")
                .or_else(|| root.child("GEOGCS"))
                .ok_or(WktError::Missing {
                    within: "COMPD_CS",
                    missing: "PROJCS",
                })?
        } else {
            &root
        };
        match horizontal.keyword.to_ascii_uppercase().as_str() {
            "PROJCS" => projected(horizontal),
            "GEOGCS" => geographic(horizontal),
            other => Err(WktError::Kind(other.chars().take(40).collect())),
        }
    }
}

fn geographic(element: &Element) -> Result<Crs, WktError> {
    let (datum, unit) = datum(element)?;
    check(
        unit == 1.0,
        "the number of degrees in the unit of angle",
        unit,
    )?;
    let esri = element.name().starts_with("GCS_");
    let name = if esri {
        datum.name.clone()
    } else {
        element.name().to_owned()
    };
    Ok(Crs {
        name,
        epsg: element.epsg(),
        datum,
        projection: None,
    })
}

/// The datum of a `GEOGCS`, and its unit of angle in degrees.
fn datum(element: &Element) -> Result<(Datum, f64), WktError> {
    let datum = element.need("GEOGCS", "DATUM")?;
    let spheroid = datum.need("DATUM", "SPHEROID")?;
    let axis = spheroid.number(1).unwrap_or(f64::NAN);
    let flattening = spheroid.number(2).unwrap_or(f64::NAN);
    check(axis > 1e3 && axis < 1e9, "the ellipsoid's axis", axis)?;
    let oblate = flattening > 2.0 && flattening < 1e9;
    check(
        flattening == 0.0 || oblate,
        "the ellipsoid's inverse flattening",
        flattening,
    )?;
    let unit = degrees_per_unit(element)?;
    let meridian = element
        .child("PRIMEM")
        .and_then(|meridian| meridian.number(1));
    // Writers give the meridian in degrees, whatever the unit of the other angles.
    let meridian = meridian.unwrap_or(0.0);
    check(meridian.abs() <= 180.0, "the prime meridian", meridian)?;
    let shift = datum.child("TOWGS84").map(|shift| {
        std::array::from_fn(|index| shift.number(index).filter(|v| v.is_finite()).unwrap_or(0.0))
    });
    Ok((
        Datum::new(datum.name(), axis, flattening, meridian, shift),
        unit,
    ))
}

fn projected(element: &Element) -> Result<Crs, WktError> {
    let (datum, angle) = datum(element.need("PROJCS", "GEOGCS")?)?;
    let unit = element
        .need("PROJCS", "UNIT")?
        .number(1)
        .unwrap_or(f64::NAN);
    check(unit > 1e-6 && unit < 1e6, "the unit of length", unit)?;
    let mut method = element.need("PROJCS", "PROJECTION")?.name();
    // WKT 1 has no word of its own for it.
    if is_pseudo_mercator(element) {
        method = PSEUDO_MERCATOR;
    }
    let parameters = element.children("PARAMETER").map(|parameter| {
        let name = parameter.name().to_ascii_lowercase();
        let value = parameter.number(1).unwrap_or(0.0);
        let scale = match name.as_str() {
            "false_easting" | "false_northing" => unit,
            "scale_factor" => 1.0,
            _ => angle,
        };
        (name, value * scale)
    });
    let mut crs = Crs {
        name: element.name().into(),
        epsg: element.epsg(),
        projection: Some(Projection::new(method, parameters, unit)),
        datum,
    };
    // ESRI writes NAD_1927_UTM_Zone_10N for what all others call NAD27 / UTM zone 10N.
    if let Some((zone, hemisphere)) = crs.utm_zone().filter(|_| crs.name.contains('_')) {
        crs.name = format!("{} / UTM zone {zone}{hemisphere}", crs.datum.name);
    }
    Ok(crs)
}

/// Whether PROJ's words beside the projection make it a sphere's Mercator.
fn is_pseudo_mercator(element: &Element) -> bool {
    let mut words = element
        .children("EXTENSION")
        .filter(|extension| extension.name().eq_ignore_ascii_case("PROJ4"))
        .filter_map(|extension| match extension.items.get(1) {
            Some(Item::Text(text)) => Some(text.as_str()),
            _ => None,
        });
    words.any(|words| {
        let value = |key| {
            words
                .split_whitespace()
                .find_map(|word| word.strip_prefix(key))
        };
        let axes = (value("+a="), value("+b="));
        value("+proj=") == Some("merc") && axes.0.is_some() && axes.0 == axes.1
    })
}

fn degrees_per_unit(element: &Element) -> Result<f64, WktError> {
    let radians = element
        .need("GEOGCS", "UNIT")?
        .number(1)
        .unwrap_or(f64::NAN);
    check(
        radians > 1e-9 && radians < 10.0,
        "the unit of angle",
        radians,
    )?;
    let degrees = radians.to_degrees();
    // Texts carry 0.0174532925199433 and other roundings of one degree.
    Ok(if (degrees - 1.0).abs() < 1e-9 {
        1.0
    } else {
        degrees
    })
}

fn check(fits: bool, what: &'static str, value: f64) -> Result<(), WktError> {
    if fits {
        Ok(())
    } else {
        Err(WktError::Value {
            what,
            value: value.to_string(),
        })
    }
}

fn skip_space(bytes: &[u8], mut at: usize) -> usize {
    while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
        at += 1;
    }
    at
}

/// Reads `KEYWORD[item, ...]` from `at`, leaving `at` behind it.
fn element(text: &str, at: &mut usize, depth: usize) -> Result<Element, WktError> {
    let bytes = text.as_bytes();
    let start = *at;
    while bytes
        .get(*at)
        .is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
    {
        *at += 1;
    }
    let keyword = text[start..*at].to_owned();
    *at = skip_space(bytes, *at);
    if keyword.is_empty() || depth > MAX_DEPTH || !matches!(bytes.get(*at), Some(b'[' | b'(')) {
        return Err(WktError::Syntax(*at));
    }
    let mut items = Vec::new();
    loop {
        *at = skip_space(bytes, *at + 1);
        items.push(item(text, at, depth)?);
        *at = skip_space(bytes, *at);
        match bytes.get(*at) {
            Some(b',') => {}
            Some(b']' | b')') => {
                *at += 1;
                return Ok(Element { keyword, items });
            }
            _ => return Err(WktError::Syntax(*at)),
        }
    }
}

fn item(text: &str, at: &mut usize, depth: usize) -> Result<Item, WktError> {
    let bytes = text.as_bytes();
    match bytes.get(*at) {
        Some(b'"') => {
            let start = *at + 1;
            let length = bytes[start..]
                .iter()
                .position(|&byte| byte == b'"')
                .ok_or(WktError::Syntax(start))?;
            *at = start + length + 1;
            Ok(Item::Text(text[start..start + length].to_owned()))
        }
        Some(b'0'..=b'9' | b'-' | b'+' | b'.') => {
            let start = *at;
            while bytes
                .get(*at)
                .is_some_and(|b| b.is_ascii_alphanumeric() || b"+-.".contains(b))
            {
                *at += 1;
            }
            text[start..*at]
                .parse()
                .map(Item::Number)
                .map_err(|_| WktError::Syntax(start))
        }
        Some(_) => {
            let start = *at;
            while bytes
                .get(*at)
                .is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_')
            {
                *at += 1;
            }
            // A bare word, as in AXIS["E",EAST], or the keyword of an element.
            let behind = skip_space(bytes, *at);
            if matches!(bytes.get(behind), Some(b'[' | b'(')) {
                *at = start;
                element(text, at, depth + 1).map(Item::Element)
            } else if *at > start {
                Ok(Item::Text(text[start..*at].to_owned()))
            } else {
                Err(WktError::Syntax(start))
            }
        }
        None => Err(WktError::Syntax(*at)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAD27_UTM10: &str = r#"PROJCS["NAD_1927_UTM_Zone_10N",GEOGCS["GCS_North_American_1927",DATUM["D_North_American_1927",SPHEROID["Clarke_1866",6378206.4,294.978698213898]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",-123.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0],UNIT["Meter",1.0]]"#;

    #[test]
    fn an_esri_text_equals_the_epsg_definition_but_for_the_code() {
        let esri = Crs::from_wkt(NAD27_UTM10).unwrap();
        let epsg = Crs::from_epsg(26710).unwrap();
        assert_eq!(esri.name, epsg.name);
        assert_eq!(esri.projection, epsg.projection);
        assert!(esri.datum.same_ellipsoid(&epsg.datum));
        assert_eq!(esri.epsg, None);
    }

    #[test]
    fn every_cut_of_a_text_is_an_error() {
        for end in 0..NAD27_UTM10.len() {
            assert!(Crs::from_wkt(&NAD27_UTM10[..end]).is_err(), "cut at {end}");
        }
        assert!(Crs::from_wkt(&"A[".repeat(100_000)).is_err());
        assert!(matches!(
            Crs::from_wkt("LOCAL_CS[\"x\"]"),
            Err(WktError::Kind(_))
        ));
    }
}
