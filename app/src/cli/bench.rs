//! Arguments of `bench` and `casters`.

use super::{TerrainArgs, parse_threads};
use clap::{Args, ValueEnum};
use sandtable_cast::Scheme;
use std::path::PathBuf;

/// Arguments of `bench`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  sandtable bench 'builtin:ridges?size=1025' --caster brute --caster planes --plot speeds.svg\n  \
    sandtable bench mountains.tif --view ridge.toml --caster brute --caster planes --check --json\n  \
    sandtable bench --caster planes --threads 2 --scheme stealing --scheme interleave --scheme pool"
)]
pub(crate) struct BenchArgs {
    #[command(flatten)]
    pub(crate) terrain: TerrainArgs,

    /// A view file; may be repeated.
    #[arg(long, value_name = "FILE")]
    pub(crate) view: Vec<PathBuf>,

    /// Without a view file: one view of each kind, or twelve level views at 640x360.
    #[arg(
        long,
        value_enum,
        value_name = "SET",
        default_value = "mixed",
        conflicts_with = "view"
    )]
    pub(crate) views: ViewSet,

    /// A caster, with its options: NAME or NAME?KEY=VALUE&KEY=VALUE (see `sandtable casters`); may
    /// be repeated. Without one: the default caster.
    #[arg(long, value_name = "CASTER")]
    pub(crate) caster: Vec<String>,

    /// Casting threads; may be repeated.
    #[arg(long, value_name = "N", default_values_t = [1, 2], value_parser = parse_threads)]
    pub(crate) threads: Vec<usize>,

    /// How the work is shared out among them, stealing, interleave or pool; may be repeated.
    #[arg(long, value_name = "SCHEME", default_values_t = [Scheme::default()])]
    pub(crate) scheme: Vec<Scheme>,

    /// Frames timed for each figure. Casters take turns, a frame each, so that what else the
    /// machine does meets all of them.
    #[arg(long, value_name = "F", default_value_t = 9)]
    pub(crate) frames: usize,

    /// Compare each caster's image with brute force.
    #[arg(long)]
    pub(crate) check: bool,

    /// The caster, as it stands behind a --caster, that the others' speeds are compared with;
    /// otherwise brute, where it is among them.
    #[arg(long, value_name = "CASTER")]
    pub(crate) rival: Option<String>,

    /// Draw the speeds into this SVG file: medians, with a line from the 5th to the 95th percentile.
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,

    /// Print JSON: a list with an object for each caster, view, number of threads and scheme. Where a
    /// caster cannot cast a view, `refused` says why and times and counts are null. Under `check`,
    /// `max_cells` is null where sky and ground were taken for each other, `psnr_db` where the images
    /// are identical.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Views that need no view file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ViewSet {
    /// Pitched, to the horizon, rolled, straight down, and at a table.
    Mixed,
    /// Twelve views without roll.
    Level,
}

/// Arguments of `casters`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  sandtable casters")]
pub(crate) struct CastersArgs {
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}
