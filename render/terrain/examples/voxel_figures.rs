//! Prints sizes and building times of the voxel model and the pyramid.
//!
//! ```text
//! cargo run --release -p sandtable-terrain --example voxel_figures
//! ```

use sandtable_terrain::{
    BoundaryArray, DensityFilter, Ground, Pyramid, VoxelShape, VoxelVolume, open, pre_texture,
};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Cells in the list that is read, and how often it is.
const CELLS: u32 = 1 << 18;
const ROUNDS: u32 = 40;

fn main() -> Result<(), Box<dyn Error>> {
    let ground = ridges(512)?;
    let shape = VoxelShape::with_levels(&ground, 64)?;
    println!("512 x 512 posts, 64 levels {:.1} m apart", shape.height);
    for filter in [
        DensityFilter::None,
        DensityFilter::Gaussian { sigma: 0.7 },
        DensityFilter::Gaussian { sigma: 1.0 },
        DensityFilter::OrientedBox { width: 2.0 },
        DensityFilter::OrientedBox { width: 3.5 },
    ] {
        let volume = VoxelVolume::new(&ground, shape, filter)?;
        let boundary = volume.boundary(127);
        println!("{filter:?}");
        let columns = ground.grid().posts() as f64;
        println!(
            "  {} bytes packed ({:.2} a column), {} full; boundary array {}; together {:.2} MiB",
            volume.bytes(),
            volume.bytes() as f64 / columns,
            volume.full_bytes(),
            boundary.bytes(),
            (volume.bytes() + boundary.bytes()) as f64 / f64::from(1 << 20),
        );
        let build = || VoxelVolume::new(&ground, shape, filter);
        println!("  built in {}", on_threads(build)?);
        println!("  boundary in {}", on_threads(|| volume.boundary(127))?);
        let [random, along] = read_times(&volume, &boundary);
        println!("  {random:.1} ns a cell read at random, {along:.1} ns along rows");
    }
    let from_heights = || BoundaryArray::from_heights(&ground, shape);
    println!("boundary from heights in {}", on_threads(from_heights)?);
    println!("pre-texture in {}", on_threads(|| pre_texture(&ground))?);

    let ground = ridges(1025)?;
    let pyramid = Pyramid::new(&ground);
    let bytes = pyramid.bytes() as f64 / f64::from(1 << 20);
    println!(
        "pyramid of 1025 x 1025 posts: {} levels, {bytes:.1} MiB",
        pyramid.levels()
    );
    println!("  built in {}", on_threads(|| Pyramid::new(&ground))?);
    let (edited, changed) = ground.edited(500..520, 500..520, |_, _, height| height)?;
    let update = || pyramid.updated(&edited, &changed);
    println!(
        "  updated ({} tiles) in {}",
        changed.len(),
        on_threads(update)?
    );
    Ok(())
}

fn ridges(size: u32) -> Result<Ground, Box<dyn Error>> {
    let source = format!("builtin:ridges?size={size}").parse()?;
    Ok(open(&source, None)?.ground)
}

/// The best of five times, on one thread and on two.
fn on_threads<T: Send>(build: impl Fn() -> T + Sync) -> Result<String, Box<dyn Error>> {
    let mut times = Vec::new();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            let start = Instant::now();
            pool.install(|| black_box(build()));
            best = best.min(start.elapsed().as_secs_f64());
        }
        times.push(format!("{:.1} ms", best * 1e3));
    }
    Ok(format!("{} on one thread, {} on two", times[0], times[1]))
}

/// Nanoseconds a read of a boundary cell's voxels: at random over the terrain, and along rows.
fn read_times(volume: &VoxelVolume, boundary: &BoundaryArray) -> [f64; 2] {
    let grid = volume.grid();
    let (cols, rows) = (grid.cols - 1, grid.rows - 1);
    let mut state = 1_u32;
    let mut random = move |below: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((u64::from(state) * u64::from(below)) >> 32) as u32
    };
    let level = |col, row| i32::from(boundary.span(col, row)[0]);
    let scattered = (0..CELLS).map(|_| (random(cols), random(rows)));
    let along = (0..CELLS).map(|at| (at % cols, at / cols % rows));
    let cells: [Vec<_>; 2] = [scattered.collect(), along.collect()];
    cells.map(|cells: Vec<(u32, u32)>| {
        let cells: Vec<_> = cells
            .into_iter()
            .map(|(col, row)| (col, row, level(col, row)))
            .collect();
        let start = Instant::now();
        let mut sum = 0_u64;
        for _ in 0..ROUNDS {
            for &(col, row, level) in &cells {
                sum = sum.wrapping_add(u64::from_le_bytes(volume.cell(col, row, level)));
            }
        }
        black_box(sum);
        start.elapsed().as_secs_f64() * 1e9 / f64::from(ROUNDS * CELLS)
    })
}
