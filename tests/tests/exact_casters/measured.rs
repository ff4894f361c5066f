//! The views that the benches measure.

use super::CASTER;
use sandtable_cast::{CastPool, caster_by_name};
use sandtable_tests::exactness::judge;
use std::path::PathBuf;

#[allow(dead_code, reason = "the benches use more of it")]
#[path = "../../../render/cast/benches/scenes/mod.rs"]
mod scenes;

/// The views that the benches measure, of the scenes that `SANDTABLE_BENCH_SCENES` names.
#[test]
fn the_exact_caster_sees_what_is_measured() {
    let names = std::env::var("SANDTABLE_BENCH_SCENES");
    let names = names
        .as_deref()
        .unwrap_or("t512,city512,pyrenees,ruby-range");
    let peers = std::env::var_os("SANDTABLE_PEERS").map(PathBuf::from);
    let caster = caster_by_name(CASTER).expect("a caster's name");
    let pool = CastPool::new(0).expect("threads");
    for name in names.split(',') {
        let bench = scenes::scene(name, peers.as_deref()).expect("a scene's name");
        let Some(bench) = bench else {
            continue;
        };
        for standpoint in &bench.views {
            let image = pool
                .picture(&*caster, &bench.scene, standpoint.view)
                .expect("any view will do");
            let verdict = judge(&bench.scene, &standpoint.view, &image);
            println!("{name} {}: {verdict}", standpoint.name);
            assert_eq!(verdict.wrong(), 0, "{name} {}: {verdict}", standpoint.name);
        }
    }
}
