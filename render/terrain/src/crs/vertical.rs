//! Vertical coordinate reference systems: what a raster's heights are counted in, and from where.

use geotiff_reader::geokeys::{self, GeoKeyDirectory};

const USER_DEFINED: u16 = 32_767;
const METRE: &str = "metre";
const FOOT: &str = "foot";
const US_FOOT: &str = "US survey foot";

/// EPSG code, name and unit: every system there whose unit is not the metre, and common ones in
/// metres.
const KNOWN: [(u16, &str, &str); 34] = [
    (5614, "KOC WD depth (ft)", FOOT),
    (5702, "NGVD29 height (ftUS)", US_FOOT),
    (5754, "Poolbeg height (ft(Br36))", "British foot (1936)"),
    (6130, "GCVD54 height (ft)", FOOT),
    (6131, "LCVD61 height (ft)", FOOT),
    (6132, "CBVD61 height (ft)", FOOT),
    (6358, "NAVD88 depth (ftUS)", US_FOOT),
    (6359, "NGVD29 depth (ftUS)", US_FOOT),
    (6360, "NAVD88 height (ftUS)", US_FOOT),
    (8050, "MSL height (ft)", FOOT),
    (8051, "MSL depth (ft)", FOOT),
    (8052, "MSL height (ftUS)", US_FOOT),
    (8053, "MSL depth (ftUS)", US_FOOT),
    (8228, "NAVD88 height (ft)", FOOT),
    (3855, "EGM2008 height", METRE),
    (5611, "Caspian height", METRE),
    (5621, "EVRF2007 height", METRE),
    (5701, "ODN height", METRE),
    (5703, "NAVD88 height", METRE),
    (5709, "NAP height", METRE),
    (5711, "AHD height", METRE),
    (5713, "CGVD28 height", METRE),
    (5714, "MSL height", METRE),
    (5715, "MSL depth", METRE),
    (5720, "NGF-IGN69 height", METRE),
    (5728, "LN02 height", METRE),
    (5773, "EGM96 height", METRE),
    (5783, "DHHN92 height", METRE),
    (5861, "LAT depth", METRE),
    (5866, "MLLW depth", METRE),
    (5941, "NN2000 height", METRE),
    (6357, "NAVD88 depth", METRE),
    (7837, "DHHN2016 height", METRE),
    (7839, "NZVD2016 height", METRE),
];

/// What a file says about its heights.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct VerticalCrs {
    /// The system's name and code, where one is named.
    pub name: Option<String>,
    /// The unit of heights, where it is known.
    pub unit: Option<String>,
    /// Whether values grow downwards.
    pub is_depth: bool,
}

impl VerticalCrs {
    /// The vertical part of a GeoTIFF's keys. The unit that a key names counts more than the
    /// system's own.
    pub(crate) fn from_geo_keys(keys: &GeoKeyDirectory) -> Self {
        let code = keys
            .get_short(geokeys::VERTICAL_CS_TYPE)
            .filter(|&code| code != 0);
        let known = KNOWN.iter().find(|(known, ..)| Some(*known) == code);
        let cited = keys
            .get_ascii(geokeys::VERTICAL_CITATION)
            .map(|text| text.trim_matches(['\0', '|', ' ']))
            .filter(|text| !text.is_empty());
        let name = known.map(|(_, name, _)| *name).or(cited);
        let unit = keys
            .get_short(geokeys::VERTICAL_UNITS)
            .and_then(unit)
            .or_else(|| known.map(|(.., unit)| (*unit).to_owned()));
        Self {
            is_depth: name.is_some_and(|name| name.contains("depth")),
            name: match (name, code) {
                (Some(name), None | Some(USER_DEFINED)) => Some(name.to_owned()),
                (Some(name), Some(code)) => Some(format!("{name} (EPSG:{code})")),
                (None, Some(USER_DEFINED)) => Some("a user-defined one".to_owned()),
                (None, Some(code)) => Some(format!("EPSG:{code}")),
                (None, None) => None,
            },
            unit,
        }
    }
}

/// A unit of length by its EPSG code; `None` where the code names none.
fn unit(code: u16) -> Option<String> {
    let name = match code {
        0 | USER_DEFINED => return None,
        9001 => METRE,
        9002 => FOOT,
        9003 => US_FOOT,
        9014 => "fathom",
        9036 => "kilometre",
        9095 => "British foot (1936)",
        9096 => "yard",
        other => return Some(format!("EPSG:{other}")),
    };
    Some(name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use geotiff_reader::geokeys::GeoKeyValue;

    fn vertical(keys: &[(u16, u16)]) -> VerticalCrs {
        let mut directory = GeoKeyDirectory::new();
        for &(key, code) in keys {
            directory.set(key, GeoKeyValue::Short(code));
        }
        VerticalCrs::from_geo_keys(&directory)
    }

    #[test]
    fn a_code_names_the_unit_unless_a_key_does() {
        let unit = |keys: &[(u16, u16)]| vertical(keys).unit;
        assert_eq!(unit(&[(4096, 6360)]).as_deref(), Some("US survey foot"));
        assert_eq!(unit(&[(4096, 8228)]).as_deref(), Some("foot"));
        assert_eq!(unit(&[(4096, 5703)]).as_deref(), Some("metre"));
        assert_eq!(unit(&[(4096, 5703), (4099, 9002)]).as_deref(), Some("foot"));
        assert_eq!(unit(&[(4099, 9003)]).as_deref(), Some("US survey foot"));
        assert_eq!(unit(&[(4096, 5102)]), None);
        assert_eq!(vertical(&[]), VerticalCrs::default());
    }

    #[test]
    fn a_system_is_named_with_its_code() {
        let navd88 = vertical(&[(4096, 6360)]);
        let name = navd88.name.as_deref();
        assert_eq!(name, Some("NAVD88 height (ftUS) (EPSG:6360)"));
        assert!(!navd88.is_depth && vertical(&[(4096, 6358)]).is_depth);
        let other = vertical(&[(4096, 5102)]).name;
        assert_eq!(other.as_deref(), Some("EPSG:5102"));
    }
}
