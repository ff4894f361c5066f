//! The packed voxel model against a volume made voxel by voxel from its definition.

use glam::DVec2;
use sandtable_terrain::{
    BoundaryArray, CellFlag, DensityFilter, Ground, HIGHEST_LEVEL, LOWEST_LEVEL, VoxelError,
    VoxelShape, VoxelVolume, pre_texture, pre_texture_updated,
};

const FILTERS: [DensityFilter; 5] = [
    DensityFilter::None,
    DensityFilter::Gaussian { sigma: 0.6 },
    DensityFilter::Gaussian { sigma: 1.0 },
    DensityFilter::OrientedBox { width: 1.0 },
    DensityFilter::OrientedBox { width: 3.5 },
];

/// Hills with edges, the same at each call.
fn hills(col: u32, row: u32) -> f32 {
    let (x, y) = (f64::from(col), f64::from(row));
    let step = if (col / 13 + row / 9).is_multiple_of(5) {
        4.0
    } else {
        0.0
    };
    ((x * 0.11).sin() * 6.0 + (y * 0.07).cos() * 5.0 + (x * y * 0.001).sin() + step) as f32
}

fn ground(cols: u32, rows: u32) -> Ground {
    Ground::from_fn(cols, rows, DVec2::new(1.5, 2.0), hills).expect("a sound grid")
}

fn volume(ground: &Ground, filter: DensityFilter) -> VoxelVolume {
    VoxelVolume::new(ground, VoxelShape::cubic(ground), filter).expect("a sound filter")
}

/// The density of a voxel by its definition, without rounding.
fn naive(ground: &Ground, shape: VoxelShape, filter: DensityFilter, at: [i64; 3]) -> f64 {
    let [cols, rows] = [ground.grid().cols, ground.grid().rows].map(i64::from);
    let height = |col: i64, row: i64| {
        let (col, row) = (col.clamp(0, cols - 1), row.clamp(0, rows - 1));
        f64::from(ground.heights().post(col as u32, row as u32))
    };
    let z = |level: i64| shape.base + level as f64 * shape.height;
    let [col, row, level] = at;
    match filter {
        DensityFilter::None => 255.0 * f64::from(u8::from(z(level) < height(col, row))),
        DensityFilter::Gaussian { sigma } => {
            let radius = (2.5 * sigma).ceil() as i64;
            let weight = |at: i64| (-0.5 * (at as f64 / sigma).powi(2)).exp();
            let (mut sum, mut total) = (0.0, 0.0);
            for dz in -radius..=radius {
                for dy in -radius..=radius {
                    for dx in -radius..=radius {
                        let share = weight(dx) * weight(dy) * weight(dz);
                        total += share;
                        if z(level + dz) < height(col + dx, row + dy) {
                            sum += share;
                        }
                    }
                }
            }
            255.0 * sum / total
        }
        DensityFilter::OrientedBox { width } => {
            let spacing = ground.grid().spacing;
            let slope = |ends: [(i64, i64); 2], axis: usize| {
                let [before, after] =
                    ends.map(|(col, row)| (col.clamp(0, cols - 1), row.clamp(0, rows - 1)));
                let steps = (after.0 - before.0) + (after.1 - before.1);
                (height(after.0, after.1) - height(before.0, before.1))
                    / (steps as f64 * spacing[axis])
            };
            let east = slope([(col - 1, row), (col + 1, row)], 0);
            let north = slope([(col, row - 1), (col, row + 1)], 1);
            let distance =
                (z(level) - height(col, row)) / (1.0 + east * east + north * north).sqrt();
            let voxel = spacing.min_element().min(shape.height);
            255.0 * (0.5 - distance / (width * voxel)).clamp(0.0, 1.0)
        }
    }
}

#[test]
fn packed_densities_are_those_of_the_definition() {
    let ground = ground(23, 19);
    for shape in [
        VoxelShape::cubic(&ground),
        VoxelShape::with_levels(&ground, 40).expect("enough levels"),
    ] {
        for filter in FILTERS {
            let volume = VoxelVolume::new(&ground, shape, filter).expect("a sound filter");
            assert_eq!(volume.full_bytes(), 23 * 19 * shape.levels as usize);
            for row in 0..19 {
                for col in 0..23 {
                    for level in -6..shape.levels as i32 + 6 {
                        let at = [i64::from(col), i64::from(row), i64::from(level)];
                        let exact = naive(&ground, shape, filter, at);
                        let packed = f64::from(volume.density(col, row, level));
                        // Rounding alone makes half a step; the Gaussian's weights are rounded
                        // to 2⁻¹⁶, and a half goes to the surface's side under the box.
                        assert!(
                            (packed - exact).abs() <= 0.51,
                            "{filter:?}: {packed}, not {exact} at {at:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn cells_read_their_eight_voxels_across_tile_borders() {
    let ground = ground(300, 270);
    for filter in FILTERS {
        let volume = volume(&ground, filter);
        let top = volume.shape().levels as i32;
        for row in (0..269).filter(|row| row % 37 == 0 || (252..260).contains(row)) {
            for col in (0..299).filter(|col| col % 41 == 0 || (252..260).contains(col)) {
                for level in -3..top + 3 {
                    let expected = [0, 1].map(|up| {
                        [(0, 0), (1, 0), (0, 1), (1, 1)]
                            .map(|(x, y)| volume.density(col + x, row + y, level + up))
                    });
                    let cell = volume.cell(col, row, level);
                    assert_eq!(cell[..4], expected[0], "{filter:?} {col} {row} {level}");
                    assert_eq!(cell[4..], expected[1], "{filter:?} {col} {row} {level}");
                }
            }
        }
        // The tiles' shared columns, and those beside them, know what lies behind the border.
        for col in 254..259 {
            for level in -3..top + 3 {
                let at = [i64::from(col), 255, i64::from(level)];
                let exact = naive(&ground, volume.shape(), filter, at);
                assert!((f64::from(volume.density(col, 255, level)) - exact).abs() <= 0.51);
            }
        }
    }
}

/// The flag of a cell by its eight voxels.
fn naive_flag(volume: &VoxelVolume, threshold: u8, at: (u32, u32, i32)) -> CellFlag {
    let below = volume
        .cell(at.0, at.1, at.2)
        .map(|density| density > threshold);
    match below.iter().filter(|&&below| below).count() {
        0 => CellFlag::Above,
        8 => CellFlag::Below,
        _ => CellFlag::Boundary,
    }
}

#[test]
fn flags_are_those_of_the_cells_own_voxels() {
    let ground = ground(270, 30);
    for filter in FILTERS {
        let volume = volume(&ground, filter);
        for threshold in [0, 1, 100, 127, 200, 254] {
            let boundary = volume.boundary(threshold);
            assert_eq!(boundary.threshold(), threshold);
            for row in 0..29 {
                for col in 0..269 {
                    for level in -5..volume.shape().levels as i32 + 5 {
                        assert_eq!(
                            boundary.flag(col, row, level),
                            naive_flag(&volume, threshold, (col, row, level)),
                            "{filter:?} at {threshold}: {col} {row} {level}"
                        );
                    }
                }
            }
        }
        assert_eq!(
            volume.boundary(255).span(3, 3),
            volume.boundary(254).span(3, 3)
        );
    }
}

fn assert_same_spans(a: &BoundaryArray, b: &BoundaryArray) {
    assert_eq!(a.threshold(), b.threshold());
    for row in 0..a.spans().rows() {
        for col in 0..a.spans().cols() {
            assert_eq!(a.span(col, row), b.span(col, row), "{col} {row}");
        }
    }
}

#[test]
fn the_boundary_of_heights_is_that_of_binary_and_of_boxed_voxels() {
    let grounds = [
        ground(300, 270),
        // Heights on the slices themselves, where a density would be exactly one half.
        Ground::from_fn(40, 40, DVec2::ONE, |col, row| ((col * row) % 7) as f32).expect("sound"),
    ];
    for ground in &grounds {
        let shape = VoxelShape::cubic(ground);
        let heights = BoundaryArray::from_heights(ground, shape);
        for filter in FILTERS {
            if !matches!(filter, DensityFilter::Gaussian { .. }) {
                assert_same_spans(&heights, &volume(ground, filter).boundary(127));
            }
        }
    }
}

fn assert_same_densities(a: &VoxelVolume, b: &VoxelVolume) {
    assert_eq!(a.shape(), b.shape());
    let levels = -20..a.shape().levels as i32 + 60;
    for row in 0..a.grid().rows {
        for col in 0..a.grid().cols {
            for level in levels.clone().chain([LOWEST_LEVEL, HIGHEST_LEVEL]) {
                let (a, b) = (a.density(col, row, level), b.density(col, row, level));
                assert_eq!(a, b, "{col} {row} {level}");
            }
        }
    }
}

#[test]
fn an_edit_at_a_tile_corner_gives_the_model_made_anew() {
    let ground = ground(300, 270);
    // Over the corner, out of the range upwards and downwards.
    let edit = |col: u32, row: u32, _: f32| {
        if (col + row).is_multiple_of(2) {
            40.0
        } else {
            -35.0
        }
    };
    let (edited, changed) = ground.edited(255..258, 254..257, edit).expect("finite");
    let shape = VoxelShape::cubic(&ground);
    for filter in FILTERS {
        let before = volume(&ground, filter);
        let after = before.updated(&edited, &changed);
        let fresh = VoxelVolume::new(&edited, shape, filter).expect("a sound filter");
        assert_same_densities(&after, &fresh);
        let boundary = after.boundary_updated(&before.boundary(90), &changed);
        assert_same_spans(&boundary, &fresh.boundary(90));
    }
    let heights =
        BoundaryArray::from_heights(&ground, shape).from_heights_updated(&edited, shape, &changed);
    assert_same_spans(&heights, &BoundaryArray::from_heights(&edited, shape));
}

#[test]
fn an_edit_beside_a_tile_reaches_it_through_the_filter_alone() {
    let ground = ground(300, 30);
    let (edited, changed) = ground
        .edited(258..259, 9..10, |_, _, _| 60.0)
        .expect("finite");
    assert_eq!(changed.len(), 1, "the edit itself is in the eastern tile");
    for filter in FILTERS {
        let after = volume(&ground, filter).updated(&edited, &changed);
        let shape = after.shape();
        let fresh = VoxelVolume::new(&edited, shape, filter).expect("a sound filter");
        assert_same_densities(&after, &fresh);
    }
}

#[test]
fn edited_colours_are_those_made_anew() {
    // Wide enough for tiles out of the edit's reach, but not out of a new range's.
    let ground = ground(800, 270);
    for to in [0.0, 400.0] {
        let edit = ground.edited(255..258, 254..257, |_, _, _| to);
        let (edited, changed) = edit.expect("finite");
        let updated = pre_texture_updated(&pre_texture(&ground), &ground, &edited, &changed);
        let fresh = pre_texture(&edited);
        for tile in fresh.tile_indices() {
            assert_eq!(updated.tile_posts(tile), fresh.tile_posts(tile), "to {to}");
        }
    }
}

#[test]
fn edits_out_of_all_bounds_are_cut_off_at_the_limits() {
    let ground = ground(20, 20);
    let edit = |col: u32, _, _| if col == 5 { 1e30 } else { -1e30 };
    let (edited, changed) = ground.edited(5..7, 5..15, edit).expect("finite");
    for filter in FILTERS {
        let volume = volume(&ground, filter).updated(&edited, &changed);
        let [low, high] = volume.boundary(127).span(5, 10).map(i32::from);
        let reach = filter.radius() as i32;
        assert!(
            low >= LOWEST_LEVEL - 1 - reach && high < HIGHEST_LEVEL + reach,
            "{filter:?}"
        );
        assert!(
            volume.bytes() < 1 << 22,
            "{filter:?}: {} bytes",
            volume.bytes()
        );
        if filter == DensityFilter::None {
            assert_eq!([low, high], [LOWEST_LEVEL - 1, HIGHEST_LEVEL - 1]);
        }
    }
}

#[test]
fn another_grid_gives_a_model_made_anew() {
    let (small, large) = (ground(20, 20), ground(30, 25));
    let before = volume(&small, DensityFilter::Gaussian { sigma: 1.0 });
    let after = before.updated(&large, &[]);
    let fresh = VoxelVolume::new(&large, before.shape(), before.filter()).expect("sound");
    assert_same_densities(&after, &fresh);
    let boundary = after.boundary_updated(&before.boundary(127), &[]);
    assert_same_spans(&boundary, &fresh.boundary(127));
}

#[test]
fn spikes_planes_and_the_smallest_ground_are_defined() {
    let spike = |col, row| if (col, row) == (50, 50) { 1e6 } else { 0.0 };
    let grounds = [
        Ground::from_fn(100, 100, DVec2::ONE, spike).expect("sound"),
        Ground::from_fn(300, 3, DVec2::ONE, |_, _| 250.0).expect("sound"),
        Ground::from_fn(2, 2, DVec2::new(30.0, 20.0), |col, _| col as f32).expect("sound"),
    ];
    for ground in &grounds {
        for filter in FILTERS {
            let volume = volume(ground, filter);
            assert!(
                volume.bytes() < 400_000,
                "{filter:?}: {} bytes",
                volume.bytes()
            );
            let grid = ground.grid();
            let boundary = volume.boundary(127);
            let top = volume.shape().levels as i32;
            for (col, row) in [
                (0, 0),
                (grid.cols / 2, grid.rows / 2),
                (grid.cols - 2, grid.rows - 2),
            ] {
                let (col, row) = (col.min(grid.cols - 2), row.min(grid.rows - 2));
                let [low, high] = boundary.span(col, row).map(i32::from);
                assert!(
                    0 <= low && low <= high && high < top,
                    "{filter:?}: {low} to {high}"
                );
                assert_eq!(volume.density(col, row, -1), 255);
                assert_eq!(volume.density(col, row, top), 0);
            }
        }
    }
}

#[test]
fn what_is_no_shape_or_filter_is_refused() {
    let ground = ground(5, 5);
    let shape = VoxelShape::cubic(&ground);
    let none = DensityFilter::None;
    for (shape, filter) in [
        (
            VoxelShape {
                height: 0.0,
                ..shape
            },
            none,
        ),
        (
            VoxelShape {
                height: f64::NAN,
                ..shape
            },
            none,
        ),
        (
            VoxelShape {
                base: f64::INFINITY,
                ..shape
            },
            none,
        ),
        (
            VoxelShape {
                levels: 5000,
                ..shape
            },
            none,
        ),
        (shape, DensityFilter::Gaussian { sigma: 0.0 }),
        (shape, DensityFilter::OrientedBox { width: f64::NAN }),
    ] {
        let error: VoxelError = VoxelVolume::new(&ground, shape, filter).expect_err("refused");
        assert!(error.to_string().contains("must be") || error.to_string().contains("ask for"));
    }
}

#[test]
fn any_number_of_threads_makes_the_same_model() {
    let ground = ground(520, 300);
    let make = |threads, filter| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| {
            let volume = volume(&ground, filter);
            let (boundary, colours) = (volume.boundary(127), pre_texture(&ground));
            (volume, boundary, colours)
        })
    };
    for filter in [FILTERS[2], FILTERS[4]] {
        let (volume, boundary, colours) = make(1, filter);
        for threads in [2, 7] {
            let other = make(threads, filter);
            assert_same_densities(&volume, &other.0);
            assert_same_spans(&boundary, &other.1);
            for tile in colours.tile_indices() {
                assert_eq!(colours.tile_posts(tile), other.2.tile_posts(tile));
            }
        }
    }
}

#[test]
fn a_volume_of_512_by_512_by_64_takes_less_than_4_mib() {
    let terrain = sandtable_terrain::open(
        &"builtin:ridges?size=512".parse().expect("a known name"),
        None,
    );
    let ground = terrain.expect("a built-in terrain").ground;
    let shape = VoxelShape::with_levels(&ground, 64).expect("enough levels");
    for (filter, limit) in [
        (DensityFilter::None, 2_300_000),
        (DensityFilter::Gaussian { sigma: 1.0 }, 3_900_000),
        (DensityFilter::OrientedBox { width: 3.5 }, 3_300_000),
    ] {
        let volume = VoxelVolume::new(&ground, shape, filter).expect("a sound filter");
        assert_eq!(volume.full_bytes(), 512 * 512 * 64);
        let bytes = volume.bytes() + volume.boundary(127).bytes();
        assert!(
            bytes < limit && limit < 4 << 20,
            "{filter:?}: {bytes} bytes"
        );
    }
}
