//! What level of detail takes and saves.

use super::{Kept, eyes};
use crate::scenes::BenchScene;
use crate::turns::{cast, timed};
use anyhow::Result;
use sandtable_cast::{CastPool, PreparedScene};
use std::sync::Arc;

/// Prints what both eyes at a table take on two threads, and the left one on one, without and with
/// level of detail.
pub(super) fn print(
    scene: &BenchScene,
    casters: [&Arc<dyn PreparedScene>; 2],
    [one, two]: &[CastPool; 2],
    rounds: usize,
) -> Result<()> {
    let Some(eyes) = eyes(scene) else {
        return Ok(());
    };
    println!("\nTime at the table, in ms: median of {rounds} turns, and the least");
    println!(
        "{:<11} {:<5} {:>7} {:>9} {:>9} {:>9} {:>9}  goal",
        "scene", "eyes", "threads", "point", "least", "detail", "least"
    );
    let runs = [
        ("both", two, eyes.to_vec(), "<= 24"),
        ("left", one, vec![eyes[0]], ""),
    ];
    for (what, pool, views, goal) in runs {
        let entries = casters.map(|caster| cast(pool, caster, views.clone()));
        let times = timed(rounds, entries.into())?;
        let [point, detail] = [&times[0], &times[1]].map(|times| [times[rounds / 2], times[0]]);
        println!(
            "{:<11} {what:<5} {:>7} {:>9.2} {:>9.2} {:>9.2} {:>9.2}  {goal}",
            scene.name,
            pool.threads(),
            point[0],
            point[1],
            detail[0],
            detail[1],
        );
    }
    Ok(())
}

/// Prints for each view what `larger`, prepared for `scene`, takes to `smaller`, both with level of
/// detail.
pub(super) fn print_sizes(
    smaller: &Kept,
    larger: &Arc<dyn PreparedScene>,
    scene: &BenchScene,
    pools: &[CastPool; 2],
    rounds: usize,
) -> Result<()> {
    let [name, of] = super::SIZES;
    println!("\nSizes: {of} to {name} with level of detail, in ms: median of {rounds} turns");
    println!(
        "{:<7} {:>7} {name:>9} {of:>9} {:>7} {:>9}  goal",
        "view", "threads", "ratio", "of least"
    );
    for at in &scene.views {
        let Some(same) = smaller.views.iter().find(|same| same.name == at.name) else {
            continue;
        };
        for pool in pools {
            let entries = vec![
                cast(pool, &smaller.prepared, vec![same.view]),
                cast(pool, larger, vec![at.view]),
            ];
            let times = timed(rounds, entries)?;
            let middle = rounds / 2;
            println!(
                "{:<7} {:>7} {:>9.2} {:>9.2} {:>7.2} {:>9.2}  <= 1.15",
                at.name,
                pool.threads(),
                times[0][middle],
                times[1][middle],
                times[1][middle] / times[0][middle],
                times[1][0] / times[0][0]
            );
        }
    }
    Ok(())
}
