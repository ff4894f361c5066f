//! `sandtable bench`: casters, timed side by side.

mod contest;
mod figures;
pub(crate) mod measure;
mod plot;
mod table;

use crate::cli::{BenchArgs, ViewSet};
use crate::command::render::read_view;
use crate::exit::usage;
use crate::notice::notice;
use crate::scene::ChosenCaster;
use crate::{files, overwriting, scene};
use anyhow::Result;
use contest::Contest;
use sandtable_cast::{CASTERS, standpoints};
use sandtable_terrain::Ground;
use sandtable_view::View;
use std::io::Write;
use std::time::Instant;

pub(crate) fn run(args: &BenchArgs, started: Instant) -> Result<()> {
    if args.frames == 0 {
        return Err(usage("--frames must be at least 1"));
    }
    let view_files = args.view.iter().map(|view| ("a view", Some(&**view)));
    overwriting::refuse(
        args.terrain.files().into_iter().chain(view_files),
        [("--plot", args.plot.as_deref())],
    )?;
    if let Some(path) = &args.plot {
        files::check_plot_name(path)?;
    }
    let casters = match args.caster.as_slice() {
        [] => vec![scene::caster(CASTERS[0].name)?],
        names => names
            .iter()
            .map(|name| scene::caster(name))
            .collect::<Result<_>>()?,
    };
    let rival = rival(args.rival.as_deref(), &casters)?;
    let open = scene::open(&args.terrain)?;
    let views = views(args, &open.scene.ground)?;
    let contest = Contest::prepare(&open.scene, &casters, views[0].1, started)?;
    let lines = contest.figures(args, &views)?;

    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&lines)?)?;
    } else {
        table::print(&mut out, &open.name, &open.scene.ground, &lines, rival)?;
    }
    drop(out);
    if let Some(path) = &args.plot {
        files::write_text(path, &plot::svg(&open.name, contest.cores(), &lines)?)?;
        if !args.json {
            notice(format_args!("{}", path.display()));
        }
    }
    Ok(())
}

/// The caster that all others are compared with, if there is one.
fn rival<'a>(asked: Option<&'a str>, casters: &[ChosenCaster]) -> Result<Option<&'a str>> {
    let among = |name: &str| casters.iter().any(|caster| caster.name == name);
    match asked {
        Some(name) if !among(name) => Err(usage(format_args!(
            "the rival {name} is not among the casters: add --caster '{name}'"
        ))),
        Some(name) => Ok(Some(name)),
        None => Ok(among("brute").then_some("brute")),
    }
}

/// The views that are asked for, by name; at least one.
fn views(args: &BenchArgs, ground: &Ground) -> Result<Vec<(String, View)>> {
    let of = |set: Vec<standpoints::Standpoint>| {
        let pairs = set.into_iter().map(|at| (at.name, at.view));
        pairs.collect()
    };
    match (args.view.as_slice(), args.views) {
        ([], ViewSet::Mixed) => Ok(of(standpoints::mixed(ground))),
        ([], ViewSet::Level) => Ok(of(standpoints::level(ground, [640, 360]))),
        (files, _) => files
            .iter()
            .map(|path| Ok((path.display().to_string(), read_view(path)?.mono())))
            .collect(),
    }
}
