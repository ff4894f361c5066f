//! The surface that a voxel model's densities stand for: where trilinear densities cross.

use glam::DVec2;
use proptest::prelude::*;
use sandtable_terrain::{CellFlag, DensityFilter, Ground, VoxelShape, VoxelVolume};

fn volume(ground: &Ground, filter: DensityFilter) -> VoxelVolume {
    VoxelVolume::new(ground, VoxelShape::cubic(ground), filter).expect("a sound filter")
}

/// The trilinear density at a place in cells.
fn trilinear(volume: &VoxelVolume, [x, y, level]: [f64; 3]) -> f64 {
    let floor = [x, y, level].map(f64::floor);
    let [u, v, w] = [x - floor[0], y - floor[1], level - floor[2]];
    let cell = volume.cell(floor[0] as u32, floor[1] as u32, floor[2] as i32);
    let [sw, se, nw, ne, sw1, se1, nw1, ne1] = cell.map(f64::from);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let lower = mix(mix(sw, se, u), mix(nw, ne, u), v);
    let upper = mix(mix(sw1, se1, u), mix(nw1, ne1, u), v);
    mix(lower, upper, w)
}

#[test]
fn boxed_densities_of_a_plane_cross_the_half_on_the_plane() {
    let flat_cells = DVec2::new(1.5, 1.0);
    for (spacing, levels, width) in [
        (DVec2::ONE, None, 2.0),
        (DVec2::ONE, None, 3.5),
        // Longer cells need a wider box.
        (flat_cells, Some(48), 4.5),
    ] {
        for step in 0..40 {
            // Slopes up to 45° in all directions.
            let steepness = f64::from(step % 8) / 7.0;
            let direction = f64::from(step) * 0.61;
            let slope = DVec2::new(direction.cos(), direction.sin()) * steepness;
            let plane = |x: f64, y: f64| 100.3 + slope.x * x + slope.y * y;
            let ground = Ground::from_fn(20, 20, spacing, |col, row| {
                plane(f64::from(col) * spacing.x, f64::from(row) * spacing.y) as f32
            });
            let ground = ground.expect("sound");
            let shape = match levels {
                Some(levels) if steepness > 0.0 => VoxelShape::with_levels(&ground, levels),
                _ => Ok(VoxelShape::cubic(&ground)),
            };
            let shape = shape.expect("enough levels");
            // Slices much closer than posts would need a wider box.
            let shape = VoxelShape {
                height: shape.height.max(1.0),
                ..shape
            };
            let filter = DensityFilter::OrientedBox { width };
            let volume = VoxelVolume::new(&ground, shape, filter).expect("a sound filter");
            for at in 0..50 {
                let (x, y) = (4.0 + f64::from(at) * 0.213, 14.0 - f64::from(at) * 0.197);
                let exact = shape.level_at(plane(x * spacing.x, y * spacing.y));
                let density = |level| trilinear(&volume, [x, y, level]);
                assert!(density(exact - 0.02) > 127.5, "{spacing} {slope} {x} {y}");
                assert!(density(exact + 0.02) < 127.5, "{spacing} {slope} {x} {y}");
            }
        }
    }
}

fn any_filter() -> impl Strategy<Value = DensityFilter> {
    prop_oneof![
        Just(DensityFilter::None),
        (0.05..3.0).prop_map(|sigma| DensityFilter::Gaussian { sigma }),
        (0.05..8.0).prop_map(|width| DensityFilter::OrientedBox { width }),
    ]
}

fn any_ground() -> impl Strategy<Value = Ground> {
    let heights = prop_oneof![
        prop::collection::vec(-20.0_f32..20.0, 49),
        prop::collection::vec(prop_oneof![Just(0.0_f32), Just(3.0), Just(900.0)], 49),
    ];
    heights.prop_map(|heights| {
        Ground::from_fn(7, 7, DVec2::new(2.0, 1.0), |col, row| {
            heights[(row * 7 + col) as usize]
        })
        .expect("sound")
    })
}

proptest! {
    #[test]
    fn densities_never_rise_with_the_level(ground in any_ground(), filter in any_filter()) {
        let volume = volume(&ground, filter);
        for row in 0..7 {
            for col in 0..7 {
                let mut column = (-150..volume.shape().levels as i32 + 150)
                    .map(|level| volume.density(col, row, level));
                prop_assert!(column.clone().is_sorted_by(|a, b| a >= b));
                prop_assert_eq!((column.clone().next(), column.next_back()), (Some(255), Some(0)));
            }
        }
    }

    #[test]
    fn trilinear_densities_cross_a_threshold_in_boundary_cells_only(
        ground in any_ground(),
        filter in any_filter(),
        threshold in 0_u8..=254,
        places in prop::collection::vec((0.0..5.99, 0.0..5.99), 8),
    ) {
        let volume = volume(&ground, filter);
        let boundary = volume.boundary(threshold);
        for (x, y) in places {
            // Upwards, the density is above the threshold in every cell below the surface and
            // not above it in every cell above; so it crosses within the span.
            for level in -40..volume.shape().levels as i32 + 40 {
                let flag = boundary.flag(x as u32, y as u32, level);
                for up in [0.0, 0.3, 0.7, 0.999] {
                    let density = trilinear(&volume, [x, y, f64::from(level) + up]);
                    match flag {
                        CellFlag::Below => prop_assert!(density > f64::from(threshold)),
                        CellFlag::Above => prop_assert!(density <= f64::from(threshold) + 1e-9),
                        CellFlag::Boundary => {}
                    }
                }
            }
        }
    }
}
