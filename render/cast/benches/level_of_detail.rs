//! What level of detail makes of the default caster's images and times.
//!
//! Images are judged by the truth, which has 64 rays a pixel. `scenes` says how to choose scenes;
//! `--help` tells the rest.

mod detail;
mod pinned_pool;
mod scenes;
mod turns;
mod warm_up;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use detail::{Bench, Figure};
use std::path::PathBuf;

/// Judges and times the default caster's level of detail
#[derive(Parser)]
struct Arguments {
    /// Timed repetitions of each entry
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Frames of the flight; the truth takes 64 casts for each
    #[arg(long, default_value_t = 60)]
    frames: u32,
    /// What to find out; may be given more than once
    #[arg(long, value_enum, value_name = "WHAT", default_values_t = Figure::ALL)]
    figure: Vec<Figure>,
    /// A view to look through, such as `low`; may be given more than once (else all)
    #[arg(long, value_name = "NAME")]
    view: Vec<String>,
    /// Draw the curve of quality against time into this SVG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// What cargo passes to every bench
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    ensure!(arguments.rounds > 0, "--rounds must be at least 1");
    ensure!(arguments.frames > 1, "--frames must be at least 2");
    let mut bench = Bench::new(arguments.rounds, arguments.frames)?;
    for scene in scenes::chosen() {
        let mut scene = scene?;
        if !arguments.view.is_empty() {
            scene.views.retain(|at| arguments.view.contains(&at.name));
        }
        bench.print(scene, &arguments.figure)?;
    }
    if let Some(file) = arguments.plot {
        std::fs::write(&file, bench.plot())
            .with_context(|| format!("cannot write {}", file.display()))?;
    }
    Ok(())
}
