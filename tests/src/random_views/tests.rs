//! What the kinds of random views say of themselves.

use super::{Case, Kind, TERRAINS};
use glam::{DVec2, DVec3};
use sandtable_view::View;
use std::collections::BTreeSet;

fn cases(kind: Kind) -> impl Iterator<Item = Case> {
    (0..40 * Kind::ALL.len() as u64)
        .filter(move |seed| Kind::ALL[(seed % Kind::ALL.len() as u64) as usize] == kind)
        .map(super::case)
}

fn sees(view: &View, point: DVec3) -> bool {
    let [width, height] = view.size.map(f64::from);
    view.pixel_of(point)
        .is_some_and(|pixel| (0.0..=width).contains(&pixel.x) && (0.0..=height).contains(&pixel.y))
}

fn is_over_the_rectangle(case: &Case) -> bool {
    let extent = case.scene.ground.grid().extent();
    let at = case.view.eye.truncate();
    at.clamp(DVec2::ZERO, extent) == at
}

/// The eye's height over the surface, or over that of the border's nearest place.
fn clearance(case: &Case) -> f64 {
    let ground = &case.scene.ground;
    let extent = ground.grid().extent();
    let at = case.view.eye.truncate().clamp(DVec2::ZERO, extent);
    case.view.eye.z - ground.height_at(at.x, at.y).unwrap()
}

#[test]
fn every_view_is_proper_and_follows_from_its_seed() {
    for kind in Kind::ALL {
        for case in cases(kind) {
            assert!(case.view.is_proper(), "{case}");
            assert_eq!(case.kind, kind);
            let again = super::case(case.seed);
            assert_eq!(case.view, again.view);
            assert_eq!(case.to_string(), again.to_string());
        }
    }
}

#[test]
fn what_is_below_or_above_is_in_the_image_where_the_kind_says_so() {
    use Kind::{LeaningOver, NadirInside, StraightDown, ToTheZenith};
    for case in [NadirInside, StraightDown, LeaningOver]
        .into_iter()
        .flat_map(cases)
    {
        assert!(sees(&case.view, case.view.eye - DVec3::Z), "{case}");
    }
    for case in cases(ToTheZenith) {
        assert!(sees(&case.view, case.view.eye + DVec3::Z), "{case}");
    }
    for case in cases(StraightDown) {
        let middle = case.view.direction(160.0, 120.0).normalize();
        assert!(middle.truncate().length() < 1e-12, "{case}");
    }
}

#[test]
fn the_eye_is_where_the_kind_says() {
    use Kind::{Buried, FarOutside, LowOver, Outside, UnderTheBorder};
    for case in cases(Buried) {
        assert!(
            is_over_the_rectangle(&case) && clearance(&case) < 0.0,
            "{case}"
        );
    }
    for case in cases(LowOver) {
        let cells = clearance(&case) / case.scene.ground.grid().cell_length();
        assert!((-1e-9..=1.0).contains(&cells), "{case}: {cells}");
    }
    for case in cases(UnderTheBorder) {
        assert!(
            !is_over_the_rectangle(&case) && clearance(&case) < 0.0,
            "{case}"
        );
    }
    for case in cases(Outside) {
        assert!(!is_over_the_rectangle(&case), "{case}");
    }
    for case in cases(FarOutside) {
        let extent = case.scene.ground.grid().extent();
        let way = case.view.eye - (0.5 * extent).extend(0.0);
        assert!(way.length() > 4.0 * extent.max_element(), "{case}");
    }
}

#[test]
fn pixels_lie_in_grid_lines() {
    for case in cases(Kind::AlongGridLines) {
        let spacing = case.scene.ground.grid().spacing;
        let at = case.view.eye.truncate() / spacing;
        assert!((at - at.round()).length() < 1e-9, "{case}");
        let middle = case.view.ray(159, 120).direction.normalize();
        let off = middle.truncate().abs().min_element();
        assert!(off < 1e-9, "{case}: {off}");
    }
}

#[test]
fn skewed_windows_raised_glass_and_all_grounds_occur() {
    let is_rectangle = |view: &View| {
        let (across, upwards) = (view.window.across(), view.window.upwards());
        across.dot(upwards).abs() < 1e-9 * across.length() * upwards.length()
    };
    assert!(cases(Kind::OffAxis).all(|case| !is_rectangle(&case.view)));
    let heights = |case: &Case| case.view.window.centre().z;
    assert!(
        cases(Kind::Table).any(|case| heights(&case) > f64::from(case.scene.ground.range()[0]))
    );
    let grounds: BTreeSet<_> = Kind::ALL
        .into_iter()
        .flat_map(cases)
        .map(|case| case.terrain)
        .collect();
    assert_eq!(grounds.len(), TERRAINS.len(), "{grounds:?}");
}
