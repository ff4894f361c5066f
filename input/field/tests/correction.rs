//! The grid of displacements.

#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use glam::{DVec3, UVec3};
use proptest::prelude::*;
use sandtable_field::Correction;

const ORIGIN: DVec3 = DVec3::new(-0.9, -0.55, 0.0);
const SPACING: DVec3 = DVec3::new(0.45, 0.275, 0.25);
const COUNTS: UVec3 = UVec3::new(5, 5, 3);

/// Random numbers by splitmix64 (Steele and others 2014).
struct Random(u64);

impl Random {
    /// Even from 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn shares(&mut self) -> DVec3 {
        DVec3::new(self.share(), self.share(), self.share())
    }
}

/// Up to 2 cm to all sides.
fn random(seed: u64) -> Correction {
    let mut random = Random(seed);
    let displacements = (0..75).map(|_| 0.04 * random.shares() - 0.02).collect();
    Correction::new(ORIGIN, SPACING, COUNTS, displacements).unwrap()
}

#[test]
fn nodes_have_their_displacements_and_a_trilinear_field_is_met_between() {
    let correction = random(1);
    for (node, displacement) in correction.nodes().zip(correction.displacements()) {
        assert!(correction.displacement(node).distance(*displacement) < 1e-15);
        assert_eq!(
            correction.correct(node),
            node + correction.displacement(node)
        );
    }
    let field = |p: DVec3| {
        DVec3::new(
            0.01 + 0.02 * p.x - 0.01 * p.y,
            0.03 * p.x * p.z,
            0.05 * p.x * p.y * p.z + 0.01 * p.z,
        )
    };
    let correction = Correction::sampled(ORIGIN, SPACING, COUNTS, field).unwrap();
    let mut random = Random(2);
    for _ in 0..1000 {
        let p = ORIGIN + random.shares() * SPACING * DVec3::new(4.0, 4.0, 2.0);
        assert!(correction.displacement(p).distance(field(p)) < 1e-15);
    }
}

#[test]
fn beyond_the_grid_the_border_holds_on_and_fades_within_half_a_metre() {
    let correction = random(3);
    let border = DVec3::new(0.9, 0.1, 0.2);
    let at = |metres: f64| correction.displacement(border + metres * DVec3::X);
    assert!(at(1e-9).distance(correction.displacement(border)) < 1e-12);
    assert!(at(0.25).distance(0.5 * correction.displacement(border)) < 1e-12);
    assert_eq!(at(0.5), DVec3::ZERO);
    assert_eq!(correction.displacement(DVec3::splat(1e9)), DVec3::ZERO);
    assert_eq!(correction.displacement(DVec3::splat(-1e300)), DVec3::ZERO);
}

#[test]
fn what_is_not_finite_stays_so() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!random(4).correct(DVec3::new(0.1, bad, 0.2)).is_finite());
    }
}

#[test]
fn it_is_written_as_plain_numbers_and_read_again_to_the_last_bit() {
    let correction = random(5);
    let text = serde_json::to_string(&correction).unwrap();
    assert!(
        text.starts_with(r#"{"origin":[-0.9,-0.55,0.0],"spacing":["#),
        "{text}"
    );
    let again: Correction = serde_json::from_str(&text).unwrap();
    assert_eq!(again, correction);
    let identity = Correction::identity();
    let text = serde_json::to_string(&identity).unwrap();
    assert_eq!(serde_json::from_str::<Correction>(&text).unwrap(), identity);
    assert_eq!(identity.correct(DVec3::ONE), DVec3::ONE);
}

#[test]
fn numbers_that_are_no_grid_are_refused_by_name() {
    let good = r#"{"origin":[0,0,0],"spacing":[1,1,1],"counts":[2,1,1],"displacements":[[0,0,0],[0,0,0]]}"#;
    assert!(serde_json::from_str::<Correction>(good).is_ok());
    for (from, to, says) in [
        ("[2,1,1]", "[2,1,0]", "1 to 64"),
        ("[2,1,1]", "[4294967295,4294967295,3]", "1 to 64"),
        ("[2,1,1]", "[2,2,1]", "2 displacements, where 4 nodes"),
        ("[1,1,1]", "[1,-1,1]", "spacing"),
        ("\"counts\"", "\"count\"", "count"),
    ] {
        let error = serde_json::from_str::<Correction>(&good.replace(from, to)).unwrap_err();
        assert!(error.to_string().contains(says), "{error}");
    }
    let nan = vec![DVec3::NAN; 75];
    assert!(Correction::new(ORIGIN, SPACING, COUNTS, nan).is_err());
    let none = vec![DVec3::ZERO; 75];
    assert!(Correction::new(DVec3::NAN, SPACING, COUNTS, none).is_err());
    let many = UVec3::new(u32::MAX, 1, 1);
    assert!(Correction::sampled(ORIGIN, SPACING, many, |_| DVec3::ZERO).is_err());
}

proptest! {
    /// Neither a jump nor more than the nodes say, inside, across the border and beyond.
    #[test]
    fn it_is_continuous_and_never_exceeds_its_nodes(
        seed: u64,
        place in prop::array::uniform3(-2.0..2.0_f64),
        step in prop::array::uniform3(-1e-3..1e-3_f64),
    ) {
        let correction = random(seed);
        let (place, step) = (DVec3::from_array(place), DVec3::from_array(step));
        let most = correction.displacements().iter().map(|d| d.length()).fold(0.0, f64::max);
        let here = correction.displacement(place);
        prop_assert!(here.length() <= most * (1.0 + 1e-12));
        // Two nodes 0.25 m apart differ by twice the most at most, on three axes, and fading adds
        // 1.5 times the most over half a metre.
        let slope = 3.0 * 2.0 * most / 0.25 + 3.0 * most;
        let change = correction.displacement(place + step) - here;
        prop_assert!(change.length() <= slope * step.length() + 1e-15);
    }
}
