//! Hard views of hard ground: the same picture whatever was cast before, and whichever way.

use sandtable_cast::{CastPool, Image, Planes, caster_by_name};
use sandtable_tests::hard_views::{HardView, hard_case};
use std::sync::Arc;

/// How many grounds are looked at, in place of [`USUAL_CASES`].
const CASES_VARIABLE: &str = "SANDTABLE_VIEWS";
const USUAL_CASES: u64 = 400;

#[test]
fn pictures_hang_on_nothing_that_was_cast_before() {
    let cases = std::env::var(CASES_VARIABLE).map_or(USUAL_CASES, |text| {
        text.parse()
            .unwrap_or_else(|error| panic!("{CASES_VARIABLE}={text}: {error}"))
    });
    // What threads remember of earlier casts differs with their number, and with the order of the views.
    let pools = [2, 1].map(|threads| CastPool::new(threads).expect("threads"));
    let (mut pixels, mut ground) = (0, 0);
    for case in (0..cases).map(hard_case) {
        let prepared = |caster: &str| {
            let caster = caster_by_name(caster).expect("a caster's name");
            let prepared = pools[0].run(|| caster.prepare(Arc::clone(&case.scene)));
            prepared.expect("any scene will do")
        };
        let detail = prepared(Planes::WITH_DETAIL);
        let plain = (case.seed % 4 == 0).then(|| prepared("planes?lod=on&isa=portable"));
        let cast = |pool: &CastPool, prepared, view: &HardView| {
            let mut images = [Image::default()];
            let cast = pool.cast(prepared, &[view.view], &mut images);
            cast.expect("any view will do");
            let [image] = images;
            image
        };
        let images = case
            .views
            .iter()
            .map(|view| cast(&pools[0], &*detail, view));
        let images: Vec<_> = images.collect();
        for (view, image) in case.views.iter().zip(&images).rev() {
            let again = cast(&pools[1], &*detail, view);
            assert!(*image == again, "{case}, {}", view.name);
            if let Some(plain) = &plain {
                let again = cast(&pools[1], &**plain, view);
                assert!(*image == again, "{case}, {}, in plain Rust", view.name);
            }
            let are_depths = image.depth.iter().all(|&depth| depth >= 0.0);
            assert!(are_depths, "{case}, {}", view.name);
            pixels += image.depth.len();
            ground += image.depth.iter().filter(|depth| depth.is_finite()).count();
        }
    }
    println!("{pixels} pixels, {ground} of ground");
    assert!(4 * ground > pixels, "{ground} of {pixels} are ground");
}
