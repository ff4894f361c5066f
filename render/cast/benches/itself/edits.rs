//! What following an edit of the ground costs.

use super::{CASTER, Comparison, Ratio, medians};
use crate::scenes::BenchScene;
use crate::turns::Entry;
use anyhow::Result;
use sandtable_cast::{CastPool, PreparedScene, Scene, caster_by_name};
use sandtable_terrain::TileIndex;
use std::sync::Arc;

/// Sides of the edited squares, in posts.
const SIDES: [u32; 2] = [64, 1024];

/// Where they begin: within a tile, so that the small one changes only one.
const BEGIN: u32 = 352;

/// A square of ground raised by a metre.
struct Edit {
    scene: Arc<Scene>,
    changed: Vec<TileIndex>,
}

impl Edit {
    fn new(scene: &Scene, side: u32) -> Result<Self> {
        let square = BEGIN..BEGIN + side;
        let raised = |_, _, height| height + 1.0;
        let (ground, changed) = scene.ground.edited(square.clone(), square, raised)?;
        Ok(Self {
            scene: Scene::new(ground),
            changed,
        })
    }

    fn name(&self, side: u32) -> String {
        format!("{side}², {} tiles", self.changed.len())
    }
}

/// Measures what it takes to follow edits, on one thread, and prints the ratios. Grounds too small
/// for both squares are left out.
pub(super) fn print(
    scene: &BenchScene,
    prepared: &Arc<dyn PreparedScene>,
    pool: &CastPool,
    rounds: usize,
) -> Result<()> {
    let grid = scene.scene.ground.grid();
    if grid.cols.min(grid.rows) < BEGIN + SIDES[1] {
        return Ok(());
    }
    let edits = SIDES
        .iter()
        .map(|&side| Edit::new(&scene.scene, side))
        .collect::<Result<Vec<_>>>()?;
    let follow = |edit: &Edit| -> Result<()> {
        pool.run(|| prepared.updated(Arc::clone(&edit.scene), &edit.changed))?;
        Ok(())
    };
    let caster = caster_by_name(CASTER)?;
    let anew: Entry<'_> = Box::new(|| {
        pool.run(|| caster.prepare(Arc::clone(&scene.scene)))?;
        Ok(())
    });
    let mut entries: Vec<Entry<'_>> = vec![anew];
    for edit in &edits {
        entries.push(Box::new(|| follow(edit)));
    }
    for side in SIDES {
        entries.push(Box::new(move || {
            Edit::new(&scene.scene, side)?;
            Ok(())
        }));
    }
    let times = medians(rounds, entries)?;
    let [anew, small, large, edit_small, edit_large] = times[..] else {
        unreachable!("five are timed");
    };
    let names = [edits[0].name(SIDES[0]), edits[1].name(SIDES[1])];
    let print = |view, names: [&str; 2], ms| {
        let ratio = Ratio {
            comparison: Comparison::Edits,
            scene: &scene.name,
            view,
            threads: 1,
            names: names.map(str::to_owned),
            ms,
            goal: "",
        };
        ratio.print();
    };
    print("edit", [&names[1], &names[0]], [edit_large, edit_small]);
    print("follow", [&names[1], &names[0]], [large, small]);
    print("follow", ["prepare anew", &names[1]], [anew, large]);
    print("follow", ["prepare anew", &names[0]], [anew, small]);
    Ok(())
}
