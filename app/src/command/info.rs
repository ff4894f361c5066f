//! `sandtable info`: what a file holds.

use crate::cli::InfoArgs;
use anyhow::Result;
use std::io::Write;

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    let info = sandtable_terrain::info(&args.file, &args.cell)?;
    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&info)?)?;
    } else {
        write!(out, "{info}")?;
    }
    Ok(())
}
