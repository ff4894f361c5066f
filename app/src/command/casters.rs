//! `sandtable casters`: what can be asked for behind `--caster`.

use crate::cli::CastersArgs;
use anyhow::Result;
use sandtable_cast::{CASTERS, CasterKind};
use serde_json::{Value, json};
use std::io::Write;

pub(crate) fn run(args: &CastersArgs) -> Result<()> {
    let mut out = std::io::stdout().lock();
    if args.json {
        let list: Vec<_> = CASTERS.iter().map(as_json).collect();
        writeln!(out, "{}", serde_json::to_string_pretty(&list)?)?;
        return Ok(());
    }
    for (place, kind) in CASTERS.iter().enumerate() {
        let default = if place == 0 { " (the default)" } else { "" };
        writeln!(out, "{}{default}\n    {}", kind.name, kind.summary)?;
        for option in kind.options {
            writeln!(out, "    {:<10} {}", option.name, option.meaning)?;
        }
    }
    writeln!(
        out,
        "\nOptions stand behind the name: --caster 'NAME?KEY=VALUE&KEY=VALUE'"
    )?;
    Ok(())
}

fn as_json(kind: &CasterKind) -> Value {
    let options: Vec<_> = kind
        .options
        .iter()
        .map(|option| json!({ "name": option.name, "meaning": option.meaning }))
        .collect();
    json!({ "name": kind.name, "summary": kind.summary, "options": options })
}
