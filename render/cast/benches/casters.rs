//! The casters' times, named `SCENE/VIEW/CASTER/THREADS`. `scenes` says how to choose scenes; what
//! stands behind `--` is criterion's, such as a part of the names to run.

mod measured;
mod pinned_pool;
mod scenes;

use anyhow::Result;
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput};
use measured::{MEASURED, THREADS};
use pinned_pool::pinned_pool;
use sandtable_cast::{CastPool, Image, PreparedScene, caster_by_name};
use scenes::BenchScene;
use std::sync::Arc;
use std::time::Duration;

fn main() -> Result<()> {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(2500))
        .configure_from_args();
    let pools = THREADS
        .into_iter()
        .map(pinned_pool)
        .collect::<Result<Vec<_>>>()?;
    for scene in scenes::chosen() {
        measure(&mut criterion, &pools, &scene?)?;
    }
    criterion.final_summary();
    Ok(())
}

/// Times every caster in every view of a scene; a caster that refuses a view is left out there.
fn measure(criterion: &mut Criterion, pools: &[CastPool], scene: &BenchScene) -> Result<()> {
    let prepared = MEASURED
        .into_iter()
        .map(|name| {
            let caster = caster_by_name(name)?;
            let prepare = || caster.prepare(Arc::clone(&scene.scene));
            Ok((name, pools[pools.len() - 1].run(prepare)?))
        })
        .collect::<Result<Vec<(&str, Arc<dyn PreparedScene>)>>>()?;
    for at in &scene.views {
        let mut group = criterion.benchmark_group(format!("{}/{}", scene.name, at.name));
        let pixels = u64::from(at.view.size[0]) * u64::from(at.view.size[1]);
        group.throughput(Throughput::Elements(pixels));
        // Frames take up to a second: as many of them in the last sample as in the first.
        group.sampling_mode(SamplingMode::Flat);
        for (name, prepared) in &prepared {
            let mut images = [Image::default()];
            if let Err(refusal) = pools[0].run(|| prepared.work(&at.view)) {
                eprintln!("{}/{}: {refusal}", scene.name, at.name);
                continue;
            }
            for pool in pools {
                let id = BenchmarkId::new(*name, pool.threads());
                group.bench_function(id, |bencher| {
                    bencher.iter(|| {
                        pool.cast(&**prepared, &[at.view], &mut images)
                            .expect("the caster has taken this view before");
                    });
                });
            }
        }
        group.finish();
    }
    Ok(())
}
