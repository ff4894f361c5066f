//! Our casters and Embree, frame by frame in turns: the same terrain, views, threads and work.
//!
//! Prints a table of medians and ratios, and one of what each held and how long it took to be
//! ready. `scenes` says how to choose scenes; `--help` tells the rest.

mod contest;
mod embree;
#[allow(unreachable_pub, reason = "it is a library's")]
#[path = "../../../tests/src/random_views/kind.rs"]
mod kind;
mod measured;
mod pinned_pool;
#[allow(
    dead_code,
    unreachable_pub,
    reason = "a library's, and tests draw more from it"
)]
#[path = "../../../tests/src/random.rs"]
mod random;
mod random_heads;
mod scenes;
mod warm_up;

use anyhow::{Result, ensure};
use clap::Parser;
use contest::{Contest, report};
use embree::Compiled;
use measured::{MEASURED, THREADS};
use pinned_pool::pinned_pool;
use std::path::Path;

/// Times casters against Embree
#[derive(Parser)]
struct Arguments {
    /// Timed frames of each contender in each view, for each number of threads
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Of each scene, as many views by heads that are anywhere and turned in any way, besides its own
    #[arg(long, default_value_t = 0, value_name = "N")]
    random_heads: usize,
    /// A caster, as `sandtable bench` takes it; may be given more than once
    #[arg(long, value_name = "NAME", default_values = MEASURED)]
    caster: Vec<String>,
    /// What cargo passes to every bench
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    ensure!(arguments.rounds > 0, "--rounds must be at least 1");
    let program = match embree::compiled(Path::new(env!("CARGO_TARGET_TMPDIR")))? {
        Compiled::Ready(program) => Some(program),
        Compiled::Missing(what) => {
            eprintln!("Embree is left out: {what}");
            None
        }
    };
    let pools = THREADS
        .into_iter()
        .map(pinned_pool)
        .collect::<Result<Vec<_>>>()?;
    let mut lines = Vec::new();
    let mut holdings = Vec::new();
    let columns = report::Columns::new(&arguments.caster);
    columns.print_head();
    for scene in scenes::chosen() {
        let mut scene = scene?;
        let ground = &scene.scene.ground;
        let random: Vec<_> = random_heads::views(ground, arguments.random_heads).collect();
        scene.views.extend(random);
        let mut contest = Contest::prepare(&scene, &arguments.caster, &pools, program.as_deref())?;
        for at in &scene.views {
            for line in contest.race(at, arguments.rounds)? {
                columns.print(&line);
                lines.push(line);
            }
        }
        holdings.extend(contest.into_holdings());
    }
    columns.print_summary(&lines);
    report::print_holdings(&holdings);
    Ok(())
}
