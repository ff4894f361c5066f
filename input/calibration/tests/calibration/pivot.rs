//! The stylus's tip.

use crate::noise::Noise;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sandtable_calibration::{CalibrationError, pivot};
use sandtable_pose::Rigid;

const TIP: DVec3 = DVec3::new(0.152, 0.011, -0.023);
const SPOT: DVec3 = DVec3::new(0.4, -0.2, 0.6);

/// A pose with this attitude and the tip on the spot.
fn standing(rotation: DQuat) -> Rigid {
    Rigid::new(rotation, SPOT - rotation * TIP)
}

/// A stylus tilted to all sides by up to `tilt` radians while it turns in the hand, with noise of
/// `sigma` metres and `turn` radians an axis.
fn poses(seed: u64, count: usize, tilt: f64, sigma: f64, turn: f64) -> Vec<Rigid> {
    let mut noise = Noise::seeded(seed);
    let upright = noise.attitude();
    (0..count)
        .map(|_| {
            let side = noise.between(0.0, std::f64::consts::TAU);
            let axis = DVec3::new(side.cos(), side.sin(), 0.0);
            let tilted = DQuat::from_axis_angle(axis, tilt * noise.share().sqrt());
            let rotation = tilted * DQuat::from_rotation_z(noise.gaussian(0.2)) * upright;
            let pose = standing(rotation);
            Rigid::new(
                noise.turn(turn) * pose.rotation,
                pose.translation + noise.vector(sigma),
            )
        })
        .collect()
}

#[test]
fn two_hundred_noisy_poses_give_the_tip_as_well_as_the_fit_says() {
    let (mut off, mut said, mut spot) = (0.0, 0.0, 0.0);
    for seed in 0..100 {
        let found = pivot(&poses(seed, 200, 0.6, 5e-4, 2e-3)).unwrap();
        off += found.tip.distance_squared(TIP);
        spot += found.spot.distance_squared(SPOT);
        said += found.standard_error.powi(2);
    }
    let root = |sum: f64| 1e3 * (sum / 100.0_f64).sqrt();
    println!(
        "RMS over 100 seeds: tip {:.3} mm, said {:.3} mm, spot {:.3} mm",
        root(off),
        root(said),
        root(spot)
    );
    assert!(root(off) < 0.5 && root(spot) < 0.5);
    assert!((root(said) / root(off) - 1.0).abs() < 0.25);
}

#[test]
fn attitudes_within_forty_degrees_are_refused_and_wider_ones_are_not() {
    let tilts = |degrees: f64| -> Vec<Rigid> {
        (0..8)
            .map(|k| {
                let side = f64::from(k) * std::f64::consts::FRAC_PI_4;
                let axis = DVec3::new(side.cos(), side.sin(), 0.0);
                standing(DQuat::from_axis_angle(axis, (0.5 * degrees).to_radians()))
            })
            .collect()
    };
    let error = pivot(&tilts(39.0)).unwrap_err();
    assert!(
        matches!(error, CalibrationError::NarrowPivot { .. }),
        "{error}"
    );
    assert!(
        error.to_string().contains("at most 39.0 degrees"),
        "{error}"
    );
    let found = pivot(&tilts(41.0)).unwrap();
    assert!((found.spread.to_degrees() - 41.0).abs() < 1e-6);
    assert!(found.tip.distance(TIP) < 1e-12);
}

#[test]
fn tipping_to_and_fro_is_refused_however_far() {
    let poses: Vec<_> = (0..50)
        .map(|k| standing(DQuat::from_rotation_y(0.03 * f64::from(k))))
        .collect();
    let error = pivot(&poses).unwrap_err();
    assert!(matches!(error, CalibrationError::OneAxis { .. }), "{error}");
}

#[test]
fn poses_at_which_the_tip_slipped_are_named() {
    for seed in 0..20 {
        let mut poses = poses(seed, 100, 0.6, 5e-4, 2e-3);
        poses[17].translation += DVec3::new(0.01, 0.0, 0.0);
        poses[60].translation += DVec3::new(0.0, 0.006, -0.006);
        let found = pivot(&poses).unwrap();
        let named: Vec<_> = found.outliers.iter().map(|o| o.item.index).collect();
        assert_eq!(named, [17, 60], "seed {seed}");
        assert_eq!(found.residuals.worst, 17);
        let text = found.outliers[0].to_string();
        assert!(text.starts_with("pose 18 lies "), "{text}");
    }
}

#[test]
fn an_outlier_deviates_from_the_spot_that_the_other_poses_give() {
    let mut poses = poses(31, 12, 0.6, 5e-4, 0.0);
    poses[5].translation.x += 0.02;
    let found = pivot(&poses).unwrap();
    let slipped = poses.remove(5);
    let others = pivot(&poses).unwrap();
    let deviation = slipped.point(others.tip).distance(others.spot);
    assert_eq!(found.outliers[0].item.index, 5);
    assert!((found.outliers[0].deviation - deviation).abs() < 1e-9);
}

#[test]
fn plain_noise_has_a_pose_named_in_one_set_of_a_hundred_at_most() {
    for count in [8, 50] {
        let named = (0..1000)
            .filter(|&seed| {
                let found = pivot(&poses(seed, count, 0.6, 5e-4, 0.0));
                // A few poses at random may lie close together.
                found.is_ok_and(|found| !found.outliers.is_empty())
            })
            .count();
        println!("{count} poses: named in {named} of 1000 sets");
        assert!(named < 22, "{count} poses: {named}");
    }
}

proptest! {
    #[test]
    fn exact_poses_give_the_tip(seed: u64, count in 12_usize..60) {
        let found = pivot(&poses(seed, count, 0.8, 0.0, 0.0))?;
        prop_assert!(found.tip.distance(TIP) < 1e-9);
        prop_assert!(found.spot.distance(SPOT) < 1e-9);
        prop_assert_eq!(found.outliers, []);
    }
}
