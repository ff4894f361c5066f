//! What a terrain takes that is seen small from far away.

use crate::scenes::BenchScene;
use crate::scenes::views::zoomed_out;
use crate::turns::{cast, timed};
use anyhow::Result;
use sandtable_cast::{CastPool, PreparedScene};
use std::sync::Arc;

/// How many times smaller it is on the table's glass than as large as that.
const SMALLER: [f64; 4] = [1.0, 4.0, 16.0, 64.0];

/// Prints what one eye at a table takes, without and with level of detail, as the terrain on it gets smaller.
pub(super) fn print(
    scene: &BenchScene,
    casters: [&Arc<dyn PreparedScene>; 2],
    pool: &CastPool,
    rounds: usize,
) -> Result<()> {
    println!(
        "\nFrom afar: the left eye at the table on {} threads, in ms: median of {rounds} turns",
        pool.threads()
    );
    println!(
        "{:<11} {:>7} {:>9} {:>9} {:>9}",
        "scene", "smaller", "cells", "point", "detail"
    );
    let ground = &scene.scene.ground;
    for times in SMALLER {
        let view = zoomed_out(ground, -0.5, times);
        let middle = 0.5 * ground.grid().extent();
        let cells = (view.eye.truncate() - middle).length() / ground.grid().cell_length();
        let entries = casters.map(|caster| cast(pool, caster, vec![view]));
        let taken = timed(rounds, entries.into())?;
        println!(
            "{:<11} {times:>7} {cells:>9.0} {:>9.2} {:>9.2}",
            scene.name,
            taken[0][rounds / 2],
            taken[1][rounds / 2]
        );
    }
    Ok(())
}
