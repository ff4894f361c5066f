//! `sandtable doctor`: what is there, what is missing, and how to get it.

use crate::cli::DoctorArgs;
use crate::doctor::examine;
use crate::rig;
use anyhow::Result;
use std::io::Write;

pub(crate) fn run(args: &DoctorArgs) -> Result<()> {
    let rig = match &args.rig {
        Some(name) => Some(rig::open(name, &args.device)?),
        None => None,
    };
    let report = examine(rig);
    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{:#}", report.json())?;
    } else {
        write!(out, "{report}")?;
    }
    Ok(())
}
