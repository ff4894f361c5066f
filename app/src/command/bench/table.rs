//! The figures as a table for people, and how many times as fast the casters are as one of them.

use super::figures::{Check, Figures};
use sandtable_terrain::Ground;
use std::io::{self, Write};

/// Prints the table, and the ratios to `rival` where there is one.
pub(super) fn print(
    out: &mut impl Write,
    name: &str,
    ground: &Ground,
    lines: &[Figures],
    rival: Option<&str>,
) -> io::Result<()> {
    let grid = ground.grid();
    writeln!(out, "{name}: {} by {} posts", grid.cols, grid.rows)?;
    let width = |least: usize, text: fn(&Figures) -> &str| {
        let widths = lines.iter().map(|line| text(line).chars().count());
        widths.fold(least, usize::max)
    };
    let caster = width(8, |line| &line.caster);
    let view = width(8, |line| &line.view);
    writeln!(
        out,
        "{:<caster$} {:<view$} {:>7} {:<10} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}  error \
         against brute force",
        "caster",
        "view",
        "threads",
        "scheme",
        "median ms",
        "p5",
        "p95",
        "Mpix/s",
        "shading",
        "rays/px",
        "smp/ray",
        "cell/ray"
    )?;
    for line in lines {
        write!(
            out,
            "{:<caster$} {:<view$} {:>7} {:<10} ",
            line.caster, line.view, line.threads, line.scheme
        )?;
        if let Some(reason) = &line.refused {
            writeln!(out, "refused: {reason}")?;
            continue;
        }
        let number = |value: Option<f64>| value.map_or_else(String::new, |it| format!("{it:.2}"));
        writeln!(
            out,
            "{:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}  {}",
            number(line.median_ms),
            number(line.p5_ms),
            number(line.p95_ms),
            number(line.mpix_per_s),
            number(line.shade_only_ms),
            number(line.rays_per_pixel),
            number(line.samples_per_ray),
            number(line.cells_per_ray),
            check_in_words(line.check.as_ref())
        )?;
    }
    print_preparation(out, lines)?;
    if let Some(rival) = rival {
        print_ratios(out, lines, rival)?;
    }
    print_first_picture(out, lines)
}

fn check_in_words(check: Option<&Check>) -> String {
    let Some(check) = check else {
        return "not checked (--check)".to_owned();
    };
    let psnr = check
        .psnr_db
        .map_or("identical".into(), |db| format!("{db:.1} dB"));
    format!(
        "{} pixels over 0.1 cell, {} over 0.5; at most {:.3} cells; {psnr}",
        check.over_0_1_cell, check.over_0_5_cell, check.max_cells
    )
}

/// How long each caster took to prepare the scene.
fn print_preparation(out: &mut impl Write, lines: &[Figures]) -> io::Result<()> {
    let mut told: Vec<&str> = Vec::new();
    for line in lines {
        if let (Some(time), false) = (line.prepare_ms, told.contains(&line.caster.as_str())) {
            writeln!(out, "{} prepared the scene in {time:.1} ms", line.caster)?;
            told.push(&line.caster);
        }
    }
    Ok(())
}

/// How many times as fast as `rival` each other caster is, over the views that both took.
fn print_ratios(out: &mut impl Write, lines: &[Figures], rival: &str) -> io::Result<()> {
    let mut groups: Vec<(&str, usize, &str)> = Vec::new();
    for line in lines.iter().filter(|line| line.caster != rival) {
        let group = (line.caster.as_str(), line.threads, line.scheme);
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    for (caster, threads, scheme) in groups {
        let is_of = |line: &&Figures, caster: &str| {
            line.caster == caster && line.threads == threads && line.scheme == scheme
        };
        let (mut own, mut theirs, mut ratios) = (0.0, 0.0, Vec::new());
        for line in lines.iter().filter(|line| is_of(line, caster)) {
            let other = lines
                .iter()
                .find(|other| is_of(other, rival) && other.view == line.view);
            let times = (line.median_ms, other.and_then(|other| other.median_ms));
            if let (Some(mine), Some(other)) = times {
                own += mine;
                theirs += other;
                ratios.push(other / mine);
            }
        }
        if own > 0.0 {
            let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
            writeln!(
                out,
                "{caster} on {threads} threads ({scheme}) is {:.1} times as fast as {rival} over \
                 {} views, and at least {least:.1} times in each",
                theirs / own,
                ratios.len()
            )?;
        }
    }
    Ok(())
}

fn print_first_picture(out: &mut impl Write, lines: &[Figures]) -> io::Result<()> {
    let Some(line) = lines.first() else {
        return Ok(());
    };
    let mb = |bytes: u64| bytes as f64 / 1e6;
    let Some(time) = line.first_picture_ms else {
        return writeln!(
            out,
            "no caster takes the first view: no first picture was timed"
        );
    };
    let peak = line
        .peak_resident_bytes
        .map_or("not known here".to_owned(), |bytes| {
            format!("{:.0} MB", mb(bytes))
        });
    writeln!(
        out,
        "first picture {time:.0} ms after the start; peak resident memory then {peak} (limit {:.0} \
         MB)",
        mb(line.resident_limit_bytes)
    )
}
