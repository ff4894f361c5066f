//! `sandtable info`: what a file holds.

use crate::cli::InfoArgs;
use crate::exit::usage;
use anyhow::Result;
use sandtable_terrain::TerrainSource;
use std::io::Write;

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    if let source @ (TerrainSource::Ridges { .. } | TerrainSource::Jacksboro) =
        TerrainSource::named(args.file.as_os_str()).map_err(usage)?
    {
        return Err(usage(format_args!(
            "{source} is built in, and info describes files; render, fly and bench take it"
        )));
    }
    let info = sandtable_terrain::info(&args.file, &args.cell)?;
    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&info)?)?;
    } else {
        write!(out, "{info}")?;
    }
    Ok(())
}
