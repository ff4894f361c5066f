//! `sandtable info`: what a file holds.

use crate::cli::InfoArgs;
use anyhow::Result;
use std::io::Write;

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    let info = sandtable_terrain::info(&args.file, &args.cell)?;
    let mut out = std::io::stdout().lock();
    if args.json {
        serde_json::to_writer_pretty(&mut out, &info)?;
        writeln!(out)?;
    } else {
        write!(out, "{info}")?;
    }
    Ok(())
}
