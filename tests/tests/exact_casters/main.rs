//! Casters that claim to be exact, before the judge; and the judge, before images that are known to
//! be right or wrong.

mod coherence;
mod drawn;
mod judge;
mod measured;
mod precision;

use sandtable_cast::{CastPool, Scene, caster_by_name};
use sandtable_tests::exactness::{Verdict, judge};
use sandtable_view::View;
use std::sync::Arc;

/// The caster that must be exact.
const CASTER: &str = "planes";

/// What the judge says of the exact caster's image.
fn verdict_of(scene: &Arc<Scene>, view: View) -> Verdict {
    let caster = caster_by_name(CASTER).expect("a caster's name");
    let pool = CastPool::new(0).expect("threads");
    let image = pool.picture(&*caster, scene, view);
    judge(scene, &view, &image.expect("any view will do"))
}

fn is_sky(depth: f32) -> bool {
    depth == f32::INFINITY
}
