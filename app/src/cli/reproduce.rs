//! Arguments of `reproduce`.

use super::parse_threads;
use clap::{Args, ValueEnum};
use std::fmt;
use std::path::PathBuf;

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  sandtable reproduce wan1999\n  \
    sandtable reproduce guedes1997 --out figures --threads 2 --json")]
pub(crate) struct ReproduceArgs {
    /// The paper.
    #[arg(value_enum)]
    pub(crate) paper: Paper,

    /// The folder for the page (index.html) and its images; otherwise out/PAPER.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Casting threads beside one; 0 takes one for each core.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads)]
    pub(crate) threads: usize,

    /// Frames timed for each figure; otherwise from 5, for the slowest paper, to 201, for the
    /// quickest.
    #[arg(long, value_name = "F")]
    pub(crate) frames: Option<usize>,

    /// Posts along each side of the generated terrains; otherwise as the paper has them.
    #[arg(long, value_name = "POSTS", value_parser = clap::value_parser!(u32).range(33..=4097))]
    pub(crate) size: Option<u32>,

    /// Print the tables as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// A paper whose measurements can be redone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Paper {
    /// Voxel-based terrain on the Responsive Workbench: ray coherence, boundary cells, roll.
    Wan1999,
    /// Terrain with objects: the floating horizon with depth, and what its upload costs.
    Szenberg1997,
    /// Photo-textured height fields: inclined view planes.
    Guedes1997,
    /// Photo-realistic flythrough: multiresolution, parallel columns.
    #[value(name = "cohenor1996")]
    CohenOr1996,
}

impl fmt::Display for Paper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Wan1999 => "wan1999",
            Self::Szenberg1997 => "szenberg1997",
            Self::Guedes1997 => "guedes1997",
            Self::CohenOr1996 => "cohenor1996",
        })
    }
}
