//! Whether two coordinate reference systems put the same coordinates in the same place.

use super::Crs;
use proj4rs::{Proj, transform::transform};

/// How far one system's coordinates are from another's.
#[derive(Clone, Debug, PartialEq)]
pub enum CrsRelation {
    /// Nothing differs.
    Same,
    /// The parameters agree; names or codes differ.
    NameOnly,
    /// The same coordinates lie up to this many metres apart.
    Shifted(f64),
    /// They cannot be compared, and why.
    Unrelated(String),
}

impl Crs {
    /// How `self`'s coordinates relate to `other`'s near the given places (in `self`).
    #[must_use]
    pub fn relation_to(&self, other: &Self, places: &[[f64; 2]]) -> CrsRelation {
        let flat = match (&self.projection, &other.projection) {
            (None, None) => true,
            (Some(own), Some(others)) => own.agrees(others),
            _ => {
                return CrsRelation::Unrelated(
                    "one is in degrees, the other in units of length".into(),
                );
            }
        };
        if flat && self.datum.same_ellipsoid(&other.datum) {
            if self.datum.name == other.datum.name {
                return CrsRelation::Same;
            }
            let unnamed = self.datum.is_unnamed() || other.datum.is_unnamed();
            let shifts = (self.datum.to_wgs84, other.datum.to_wgs84);
            if unnamed || matches!(shifts, (Some(a), Some(b)) if a == b) {
                return CrsRelation::NameOnly;
            }
        }
        for crs in [self, other] {
            if crs.datum.shift().is_none() {
                return CrsRelation::Unrelated(format!(
                    "how the datum {} lies to WGS 84 is not known here",
                    crs.datum.name
                ));
            }
        }
        let systems = (self.system(), other.system());
        let (Some(from), Some(to)) = systems else {
            let crs = if systems.0.is_none() { self } else { other };
            let method = crs
                .projection
                .as_ref()
                .map_or("", |projection| &projection.method);
            return CrsRelation::Unrelated(format!("the projection {method} is not computed here"));
        };
        let mut shift = 0.0_f64;
        for &place in places {
            match self.distance(other, &from, &to, place) {
                Some(distance) => shift = shift.max(distance),
                None => {
                    return CrsRelation::Unrelated(format!(
                        "{place:?} cannot be carried from one to the other"
                    ));
                }
            }
        }
        CrsRelation::Shifted(shift)
    }

    fn system(&self) -> Option<Proj> {
        Proj::from_proj_string(&self.proj_string()?).ok()
    }

    /// Metres between a place of `self` and the place of equal coordinates in `other`.
    fn distance(&self, other: &Self, from: &Proj, to: &Proj, place: [f64; 2]) -> Option<f64> {
        let unit = |crs: &Self| {
            crs.projection
                .as_ref()
                .map_or(1f64.to_radians(), |projection| projection.metres_per_unit)
        };
        let mut point = (place[0] * unit(self), place[1] * unit(self), 0.0);
        transform(from, to, &mut point).ok()?;
        let (dx, dy) = (
            point.0 / unit(other) - place[0],
            point.1 / unit(other) - place[1],
        );
        let [east, north] = match &other.projection {
            Some(projection) => [projection.metres_per_unit; 2],
            None => other.datum.metres_per_degree(place[1]),
        };
        Some((dx * east).hypot(dy * north)).filter(|distance| distance.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crs::{Datum, Projection};

    fn epsg(code: u32) -> Crs {
        Crs::from_epsg(code).unwrap()
    }

    #[test]
    fn an_unnamed_datum_on_the_same_ellipsoid_differs_in_name_only() {
        let sirgas = epsg(31985);
        let unnamed = Crs {
            name: "UTM Zone 25, Southern Hemisphere".into(),
            epsg: None,
            datum: Datum::new("unknown", 6_378_137.0, 298.257_222_101, 0.0, None),
            projection: sirgas.projection.clone(),
        };
        assert_eq!(unnamed.relation_to(&sirgas, &[]), CrsRelation::NameOnly);
        assert_eq!(sirgas.relation_to(&sirgas, &[]), CrsRelation::Same);
    }

    #[test]
    fn nad83_is_near_wgs84_and_nad27_is_not() {
        let place = [[562_000.0, 5_115_000.0]];
        let CrsRelation::Shifted(near) = epsg(26910).relation_to(&epsg(32610), &place) else {
            panic!("NAD83 and WGS 84 can be compared");
        };
        assert!(near < 0.01, "{near} m");
        let CrsRelation::Shifted(far) = epsg(26710).relation_to(&epsg(32610), &place) else {
            panic!("NAD27 and WGS 84 can be compared");
        };
        // cs2cs gives 225 m with the continental mean: 95 m east, 203 m north.
        assert!((150.0..300.0).contains(&far), "{far} m");
    }

    #[test]
    fn degrees_and_metres_are_unrelated() {
        let relation = epsg(4326).relation_to(&epsg(32610), &[[-122.0, 46.0]]);
        assert!(matches!(relation, CrsRelation::Unrelated(_)));
    }

    #[test]
    fn zones_lie_far_apart_and_odd_projections_are_said_to_be_odd() {
        let place = [[500_000.0, 5_000_000.0]];
        let zones = epsg(32610).relation_to(&epsg(32611), &place);
        assert!(
            matches!(zones, CrsRelation::Shifted(metres) if metres > 1e5),
            "{zones:?}"
        );
        let mut odd = epsg(32610);
        odd.projection = Some(Projection::new("Bonne", [], 1.0));
        let relation = odd.relation_to(&epsg(32610), &place);
        assert!(matches!(relation, CrsRelation::Unrelated(why) if why.contains("bonne")));
    }
}
