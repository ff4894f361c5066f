//! From the tracker to the table.

use crate::noise::Noise;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sandtable_calibration::{CalibrationError, Finding, Outlier, Registration, Touch, register};
use sandtable_pose::Rigid;

const LOW: DVec3 = DVec3::new(-0.9, -0.55, 0.0);
const HIGH: DVec3 = DVec3::new(0.9, 0.55, 0.5);

/// Touches of `count` places over the table, with noise of `sigma` metres an axis; the tracker
/// stands anywhere, and turned any way.
fn touches(seed: u64, count: usize, sigma: f64) -> (Rigid, Vec<Touch>) {
    let mut noise = Noise::seeded(seed);
    let turn = noise.attitude();
    let table_from_tracker = Rigid::new(turn, noise.within(-DVec3::ONE, DVec3::ONE));
    let tracker_from_table = table_from_tracker.inverse();
    let touches = (0..count)
        .map(|_| {
            let marked = noise.within(LOW, HIGH);
            Touch {
                measured: tracker_from_table.point(marked) + noise.vector(sigma),
                marked,
            }
        })
        .collect();
    (table_from_tracker, touches)
}

fn outliers(registration: &Registration) -> Vec<Outlier> {
    let outlier = |finding: &Finding| match finding {
        Finding::Outlier(outlier) => Some(*outlier),
        _ => None,
    };
    registration.findings.iter().filter_map(outlier).collect()
}

/// The worked example: positions in inches, and where they are on the table.
fn worked_example() -> (Rigid, [Touch; 4]) {
    let inches = [
        [12.0, 3.0, -5.0],
        [20.0, -8.0, 4.0],
        [30.0, 0.5, -14.0],
        [25.0, 10.0, 2.0],
    ];
    let marks = [
        [0.296181, -0.090797, 0.999907],
        [0.491253, -0.223893, 1.340267],
        [0.604707, 0.295113, 1.145533],
        [0.178664, 0.136448, 1.326720],
    ];
    let rotation = DQuat::from_xyzw(0.11547, -0.34641, 0.46188, 0.80829).normalize();
    (
        Rigid::new(rotation, DVec3::new(0.2, -0.4, 0.9)),
        std::array::from_fn(|k| Touch {
            measured: 0.0254 * DVec3::from_array(inches[k]),
            marked: DVec3::from_array(marks[k]),
        }),
    )
}

#[test]
fn the_worked_example_comes_out_with_four_points_and_with_three() {
    let (truth, touches) = worked_example();
    for touches in [&touches[..], &touches[..3]] {
        let found = register(touches).unwrap();
        // The marks have six places.
        assert!(found.residuals.each.iter().all(|r| *r < 1e-6));
        let Rigid {
            rotation,
            translation,
        } = found.table_from_tracker;
        assert!((rotation.length() - 1.0).abs() < 1e-12);
        assert!(rotation.dot(truth.rotation).abs() > 1.0 - 1e-11);
        assert!(translation.distance(truth.translation) < 3e-6);
        assert!((found.scale - 1.0).abs() < 1e-5);
    }
    assert_eq!(register(&touches).unwrap().findings, []);
    // Three points are always in a plane.
    let three = register(&touches[..3]).unwrap().findings;
    assert!(matches!(three[..], [Finding::HandednessUnknown { .. }]));
}

/// Twelve points with 1 mm noise an axis put the centroid right to 1 mm √(3/12) = 0.5 mm.
#[test]
fn twelve_points_with_a_millimetre_of_noise_are_right_to_a_millimetre_and_a_tenth_of_a_degree() {
    let (mut shift, mut turn, mut rms) = (0.0, 0.0, 0.0);
    for seed in 0..100 {
        let (truth, touches) = touches(seed, 12, 1e-3);
        let found = register(&touches).unwrap();
        let centroid = touches.iter().map(|t| t.marked).sum::<DVec3>() / 12.0;
        let measured = truth.inverse().point(centroid);
        shift += found
            .table_from_tracker
            .point(measured)
            .distance_squared(centroid);
        let off = found.table_from_tracker.rotation * truth.rotation.inverse();
        turn += (2.0 * off.xyz().length().asin()).powi(2);
        rms += found.residuals.rms.powi(2);
    }
    let root = |sum: f64| (sum / 100.0).sqrt();
    println!(
        "RMS over 100 seeds: {:.3} mm at the centroid, {:.4} degrees, residuals {:.3} mm",
        1e3 * root(shift),
        root(turn).to_degrees(),
        1e3 * root(rms)
    );
    assert!(root(shift) < 1e-3);
    assert!(root(turn).to_degrees() < 0.1);
    // 36 coordinates less 6 unknowns.
    let expected = 1e-3 * (30.0_f64 / 12.0).sqrt();
    assert!((root(rms) / expected - 1.0).abs() < 0.05);
}

#[test]
fn a_gross_outlier_is_named_and_nothing_else() {
    for seed in 0..100 {
        let (_, mut touches) = touches(seed, 12, 1e-3);
        let wrong = seed as usize % 12;
        let slip = 0.02 * Noise::seeded(1000 + seed).direction();
        touches[wrong].measured += slip;
        let found = outliers(&register(&touches).unwrap());
        let named: Vec<_> = found.iter().map(|o| o.item.index).collect();
        assert_eq!(named, [wrong], "seed {seed}");
        assert!((found[0].deviation - 0.02).abs() < 0.01, "{found:?}");
        let text = found[0].to_string();
        assert!(
            text.starts_with(&format!("point {} lies ", wrong + 1)),
            "{text}"
        );
    }
}

#[test]
fn two_outliers_are_both_named() {
    for seed in 0..20 {
        let (_, mut touches) = touches(seed, 12, 1e-3);
        touches[3].measured += DVec3::new(0.05, 0.0, 0.0);
        touches[7].measured += DVec3::new(0.0, -0.03, 0.02);
        let found = outliers(&register(&touches).unwrap());
        let named: Vec<_> = found.iter().map(|o| o.item.index).collect();
        assert_eq!(named, [3, 7], "seed {seed}");
    }
}

#[test]
fn marks_that_were_touched_in_each_others_place_are_named() {
    for seed in 0..100 {
        let (_, mut touches) = touches(seed, 6, 1e-3);
        let pair = [seed as usize % 5, 5];
        let apart = touches[pair[0]].marked.distance(touches[pair[1]].marked);
        let [a, b] = pair.map(|k| touches[k].measured);
        (touches[pair[0]].measured, touches[pair[1]].measured) = (b, a);
        if apart < 0.05 {
            continue;
        }
        let found = register(&touches).unwrap();
        let [
            Finding::Exchanged {
                touches: named,
                touched,
                exchanged,
                ..
            },
            ..,
        ] = found.findings[..]
        else {
            panic!("seed {seed}: {:?}", found.findings);
        };
        assert_eq!(named.map(|item| item.index), pair, "seed {seed}");
        assert!(exchanged < 3e-3 && touched > 3.0 * exchanged, "seed {seed}");
        let text = found.findings[0].to_string();
        let names = format!("point {} and point 6", pair[0] + 1);
        assert!(text.starts_with(&names), "{text}");
        // Each touch counts as it was.
        assert!(found.residuals.rms > 2.0 * exchanged, "seed {seed}");
    }
}

/// Of a rectangle's corners, either the two in front or the two behind, seen from below.
#[test]
fn where_two_pairs_may_be_exchanged_both_are_named() {
    let corners = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]];
    let mut noise = Noise::seeded(8);
    let mut touches = corners.map(|[x, y]| Touch {
        measured: DVec3::new(x, y, 0.1) + noise.vector(5e-4),
        marked: DVec3::new(x, y, 0.0),
    });
    let measured = [touches[1].measured, touches[0].measured];
    (touches[0].measured, touches[1].measured) = (measured[0], measured[1]);
    let text = register(&touches).unwrap().findings[0].to_string();
    let pairs = ["point 1 and point 2", "point 3 and point 4"];
    assert!(pairs.iter().all(|pair| text.contains(pair)), "{text}");
}

#[test]
fn what_slipped_is_not_taken_for_exchanged() {
    for seed in 0..1000 {
        let (_, mut touches) = touches(seed, 4 + seed as usize % 9, 1e-3);
        if seed % 2 == 0 {
            touches[2].measured += 0.04 * Noise::seeded(seed).direction();
        }
        // Four places at random may lie in a line.
        let Ok(found) = register(&touches) else {
            continue;
        };
        let exchanged = |finding: &Finding| matches!(finding, Finding::Exchanged { .. });
        assert!(
            !found.findings.iter().any(exchanged),
            "seed {seed}: {:?}",
            found.findings
        );
    }
}

#[test]
fn plain_noise_has_a_point_named_in_one_set_of_a_hundred_at_most() {
    for count in [4, 6, 12, 40] {
        let named = (0..1000)
            .filter(|&seed| {
                let (_, touches) = touches(seed, count, 1e-3);
                // Four places at random may lie in a line.
                register(&touches).is_ok_and(|found| !outliers(&found).is_empty())
            })
            .count();
        println!("{count} points: named in {named} of 1000 sets");
        // 10 are expected at most; 22 would come up by chance once in a thousand.
        assert!(named < 22, "{count} points: {named}");
    }
}

#[test]
fn points_in_a_line_are_refused() {
    let (_, mut touches) = touches(1, 3, 1e-3);
    for (k, touch) in touches.iter_mut().enumerate() {
        touch.marked = DVec3::new(0.1, -0.2, 0.3) + k as f64 * DVec3::new(0.3, 0.2, 0.0);
    }
    let error = register(&touches).unwrap_err();
    assert!(
        matches!(error, CalibrationError::MarksInLine { .. }),
        "{error}"
    );
    let text = error.to_string();
    assert!(text.contains("point 1 and point 3"), "{text}");

    // A few millimetres off the line are noise, and no plane.
    touches[1].marked.z += 0.004;
    assert!(matches!(
        register(&touches),
        Err(CalibrationError::MarksInLine { .. })
    ));

    // The marks are well spread, but the tracker loses two axes.
    let (_, mut touches) = self::touches(2, 6, 1e-3);
    for touch in &mut touches {
        touch.measured = touch.measured.dot(DVec3::X) * DVec3::ONE;
    }
    assert!(matches!(
        register(&touches),
        Err(CalibrationError::MeasurementsInLine { .. })
    ));
}

#[test]
fn left_handed_axes_are_refused_with_their_remedy() {
    let mirrors: [fn(DVec3) -> DVec3; 3] = [
        |p| DVec3::new(-p.x, p.y, p.z),
        |p| DVec3::new(p.y, p.x, p.z),
        // The other hemisphere.
        |p| -p,
    ];
    for (seed, mirror) in mirrors.into_iter().enumerate() {
        for count in [4, 12] {
            let (_, mut touches) = touches(seed as u64, count, 1e-3);
            for touch in &mut touches {
                touch.measured = mirror(touch.measured);
            }
            let error = register(&touches).unwrap_err();
            assert!(
                matches!(error, CalibrationError::Mirrored { .. }),
                "{error}"
            );
            assert!(error.to_string().contains("axis map"), "{error}");
        }
    }
    // One bad touch does not hide the mirror.
    let (_, mut touches) = touches(9, 12, 1e-3);
    for touch in &mut touches {
        touch.measured.y *= -1.0;
    }
    touches[5].measured.x += 0.1;
    assert!(matches!(
        register(&touches),
        Err(CalibrationError::Mirrored { .. })
    ));
}

#[test]
fn points_in_a_plane_register_but_leave_the_handedness_open() {
    for mirror in [1.0, -1.0] {
        let (_, mut touches) = touches(4, 8, 0.0);
        let mut noise = Noise::seeded(5);
        for touch in &mut touches {
            touch.marked.z = 0.0;
            touch.measured = touch.marked * DVec3::new(mirror, 1.0, 1.0) + noise.vector(1e-3);
        }
        let found = register(&touches).unwrap();
        assert!(found.residuals.rms < 2e-3);
        assert!(matches!(
            found.findings[..],
            [Finding::HandednessUnknown { .. }]
        ));
    }
}

#[test]
fn a_wrong_range_is_found_as_a_scale_and_leaves_no_outlier() {
    for (measured_over_true, found_text) in [
        (0.5, Some("that is 2 times it")),
        (2.0, Some("that is 0.5 times it")),
        (0.25, Some("that is 4 times it")),
        (1.015, Some("36, 72 or 144 in")),
        (1.0 / 0.0254, Some("in metres")),
        (1.005, None),
        (0.995, None),
    ] {
        let (_, mut touches) = touches(11, 12, 1e-3);
        for touch in &mut touches {
            touch.measured *= measured_over_true;
        }
        let found = register(&touches).unwrap();
        assert!((found.scale * measured_over_true - 1.0).abs() < 3e-3);
        match (found_text, &found.findings[..]) {
            (Some(text), [finding @ Finding::WrongScale { .. }]) => {
                assert!(finding.to_string().contains(text), "{finding}");
            }
            (None, []) => {}
            other => panic!("{measured_over_true}: {other:?}"),
        }
        // The scale is a check, and no part of the transform.
        let [a, b] = [touches[0].measured, touches[1].measured];
        let turned = found.table_from_tracker.point(a) - found.table_from_tracker.point(b);
        assert!((turned.length() / a.distance(b) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn an_outlier_does_not_pass_for_a_wrong_range() {
    let (_, mut touches) = touches(12, 12, 1e-3);
    touches[4].measured *= 1.3;
    let found = register(&touches).unwrap();
    assert!(
        matches!(found.findings[..], [Finding::Outlier(_)]),
        "{:?}",
        found.findings
    );
    assert!((found.scale - 1.0).abs() < 3e-3);
    assert_eq!(found.residuals.worst, 4);
}

#[test]
fn a_mark_touched_twice_and_a_tracker_that_stands_still_are_refused_by_number() {
    let (_, mut touches) = touches(3, 6, 1e-3);
    touches[4].marked = touches[1].marked + DVec3::splat(1e-4);
    let error = register(&touches).unwrap_err().to_string();
    assert!(error.starts_with("point 2 and point 5 "), "{error}");

    let (_, mut touches) = self::touches(3, 6, 1e-3);
    touches[3].measured = touches[2].measured;
    let error = register(&touches).unwrap_err().to_string();
    assert!(error.starts_with("point 3 and point 4 "), "{error}");
}

proptest! {
    #[test]
    fn exact_touches_give_the_transform_whatever_it_is(seed: u64, count in 5_usize..40) {
        let (truth, touches) = touches(seed, count, 0.0);
        let found = register(&touches)?;
        for touch in &touches {
            let at = found.table_from_tracker.point(touch.measured);
            prop_assert!(at.distance(touch.marked) < 1e-9);
        }
        let shift = found.table_from_tracker.translation - truth.translation;
        prop_assert!(shift.length() < 1e-8);
        prop_assert_eq!(outliers(&found), []);
        prop_assert!((found.scale - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_order_of_touches_does_not_matter(seed: u64, turn in 0_usize..12) {
        let (_, mut touches) = touches(seed, 12, 1e-3);
        let found = register(&touches)?;
        touches.rotate_left(turn);
        let again = register(&touches)?;
        let shift = found.table_from_tracker.translation - again.table_from_tracker.translation;
        prop_assert!(shift.length() < 1e-9);
        prop_assert_eq!((again.residuals.worst + turn) % 12, found.residuals.worst);
        prop_assert_eq!(outliers(&again).len(), outliers(&found).len());
    }
}
