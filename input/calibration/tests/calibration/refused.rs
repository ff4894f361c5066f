//! Measurements that nothing can be made of are refused by name, and none brings a panic or a
//! result that is not finite.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sandtable_calibration::{
    FieldSample, Side, Sighting, Touch, fit_distortion, locate_eye, locate_eyes, pivot, register,
};
use sandtable_pose::Rigid;

/// Mostly what a tracker says, sometimes what a broken one says.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        12 => -1.0..1.0_f64,
        4 => prop::sample::select(vec![0.0, 1.0, -1.0, 0.25, 1e-12, 1e-160, 99.0]),
        1 => any::<f64>(),
    ]
}

fn place() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from_array)
}

fn pose() -> impl Strategy<Value = Rigid> {
    let unit = [number(), number(), number(), number()].prop_map(|[x, y, z, w]| {
        let q = DQuat::from_xyzw(x, y, z, w);
        // Some are left as they are, so that they are refused.
        if x > 0.95 { q } else { q.normalize() }
    });
    (unit, place()).prop_map(|(rotation, translation)| Rigid::new(rotation, translation))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_touches_register_or_are_refused(
        touches in prop::collection::vec((place(), place()), 0..9),
    ) {
        let touches: Vec<_> = touches
            .into_iter()
            .map(|(measured, marked)| Touch { measured, marked })
            .collect();
        if let Ok(found) = register(&touches) {
            prop_assert!(found.table_from_tracker.translation.is_finite());
            prop_assert!((found.table_from_tracker.rotation.length() - 1.0).abs() < 1e-12);
            prop_assert!(found.residuals.rms.is_finite() && found.scale.is_finite());
            prop_assert!(found.findings.iter().all(|f| !f.to_string().is_empty()));
        }
    }

    #[test]
    fn any_poses_pivot_or_are_refused(poses in prop::collection::vec(pose(), 0..9)) {
        if let Ok(found) = pivot(&poses) {
            prop_assert!(found.tip.is_finite() && found.spot.is_finite());
            prop_assert!(found.standard_error.is_finite() && found.residuals.rms.is_finite());
        }
    }

    #[test]
    fn any_sightings_locate_or_are_refused(
        sightings in prop::collection::vec((pose(), place(), place()), 0..7),
    ) {
        let sightings: Vec<_> = sightings
            .into_iter()
            .map(|(table_from_sensor, near, far)| Sighting { table_from_sensor, near, far })
            .collect();
        if let Ok(found) = locate_eye(Side::Left, &sightings) {
            prop_assert!(found.position.is_finite() && found.standard_error().is_finite());
        }
        prop_assert!(locate_eyes(&sightings, &sightings).is_err());
    }

    #[test]
    fn any_samples_fit_or_are_refused(
        samples in prop::collection::vec((place(), place()), 0..14),
    ) {
        let samples: Vec<_> = samples
            .into_iter()
            .map(|(measured, truth)| FieldSample { measured, truth })
            .collect();
        if let Ok(fit) = fit_distortion(&samples) {
            prop_assert!(fit.correction.displacements().iter().all(|d| d.is_finite()));
            prop_assert!(fit.left_out.rms <= fit.before.rms);
        }
    }
}

#[test]
fn messages_count_from_one_and_say_what_to_do() {
    let good = |k: f64| Touch {
        measured: DVec3::new(k, k * k, 0.1 * k),
        marked: DVec3::new(k, k * k, 0.1 * k),
    };
    let mut touches = [0.0, 0.2, 0.5, 0.9].map(good);
    touches[2].measured.y = f64::NAN;
    assert_eq!(
        register(&touches).unwrap_err().to_string(),
        "point 3: the measured position is not finite; leave it out, or measure it again"
    );
    touches[2] = good(0.5);
    touches[1].marked.x = 300.0;
    assert_eq!(
        register(&touches).unwrap_err().to_string(),
        "point 2: the mark's place has a coordinate of 300.0, where 100 m is the most; give it in metres, not in millimetres or inches"
    );
    assert_eq!(
        register(&touches[..2]).unwrap_err().to_string(),
        "2 touched points are too few; give at least 3"
    );
    let many = vec![good(0.1); 1001];
    assert!(
        register(&many)
            .unwrap_err()
            .to_string()
            .contains("the 1000 that are read")
    );

    let mut poses = [Rigid::IDENTITY; 5];
    poses[4].rotation = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.5);
    let error = pivot(&poses).unwrap_err().to_string();
    assert!(
        error.starts_with("pose 5: the attitude is a quaternion of length 0.5000"),
        "{error}"
    );

    let mut samples = [FieldSample {
        measured: DVec3::ZERO,
        truth: DVec3::ZERO,
    }; 9];
    samples[8].truth.z = f64::INFINITY;
    let error = fit_distortion(&samples).unwrap_err().to_string();
    assert!(
        error.starts_with("sample 9: the true place is not finite"),
        "{error}"
    );
}
