//! sandtable: a sand table that you can walk around.

mod cli;
mod command;
mod doctor;
mod exit;
mod files;
mod film;
mod guide;
mod interrupt;
mod likeness;
mod live;
mod navigation;
mod notice;
mod offer;
mod overwriting;
mod partial;
mod resident;
mod rig;
mod scene;
mod session;
mod tape;
mod told;
mod tour;
mod track;
mod vantage;
mod video;
mod window;

use clap::Parser;
use cli::{Cli, Command};
use std::io::IsTerminal;
use std::process::ExitCode;
use std::time::Instant;
use tracing_subscriber::EnvFilter;

fn main() -> ExitCode {
    let started = Instant::now();
    let cli = Cli::parse();
    let filter = EnvFilter::try_from_env("SANDTABLE_LOG")
        .unwrap_or_else(|_| EnvFilter::new("warn,sandtable=info,sandtable_input=info"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .init();
    exit::report(match &cli.command {
        None => command::fly::run(&cli.fly),
        Some(Command::Fly(args)) => command::fly::run(args),
        Some(Command::Info(args)) => command::info::run(args),
        Some(Command::Render(args)) => command::render::run(args),
        Some(Command::Casters(args)) => command::casters::run(args),
        Some(Command::Bench(args)) => command::bench::run(args, started),
        Some(Command::Reproduce(args)) => command::reproduce::run(args),
        Some(Command::Simulate(args)) => command::simulate::run(args),
        Some(Command::Record(args)) => command::record::run(args),
        Some(Command::ServeVrpn(args)) => command::serve_vrpn::run(args),
        Some(Command::Calibrate(args)) => command::calibrate::run(args),
        Some(Command::Doctor(args)) => command::doctor::run(args),
    })
}
