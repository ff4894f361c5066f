//! The default caster against itself: what instruction sets, a second eye, a second thread,
//! colouring and edits make of its times, in ratios of medians that were measured in turns.
//!
//! `scenes` says how to choose scenes; `--help` tells the rest.

mod itself;
mod pinned_pool;
mod scenes;
mod turns;
mod warm_up;

use anyhow::{Result, ensure};
use clap::Parser;
use itself::{Comparison, Ours};

/// Times the default caster against itself
#[derive(Parser)]
struct Arguments {
    /// Timed repetitions of each side of a ratio
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// What to compare; may be given more than once
    #[arg(long, value_enum, value_name = "WHAT", default_values_t = Comparison::ALL)]
    compare: Vec<Comparison>,
    /// A view to look through, such as `low`; may be given more than once (else all)
    #[arg(long, value_name = "NAME")]
    view: Vec<String>,
    /// What cargo passes to every bench
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    ensure!(arguments.rounds > 0, "--rounds must be at least 1");
    itself::print_head();
    for scene in scenes::chosen() {
        let mut scene = scene?;
        if !arguments.view.is_empty() {
            scene.views.retain(|at| arguments.view.contains(&at.name));
        }
        let ours = Ours::prepare(&scene)?;
        for comparison in &arguments.compare {
            ours.print(*comparison, arguments.rounds)?;
        }
    }
    Ok(())
}
