//! `sandtable reproduce`: a paper's measurements and figures, done again beside its own numbers.
//!
//! ```text
//! Paper --its file--> Report (prose, tables, figures) --table--> text or JSON on standard output
//!                        ^                            --page---> DIR/index.html and its images
//!                        |
//!     trial (casters by name, timed in turns), truth (what a view ought to show),
//!     mesh and upload (the GPU), blocks (a made scene)
//! ```

mod blocks;
mod cohenor1996;
mod guedes1997;
mod mesh;
mod page;
mod picture;
mod report;
mod szenberg1997;
mod table;
mod trial;
mod truth;
mod upload;
mod voxel_model;
mod wan1999;

use crate::cli::{Paper, ReproduceArgs};
use crate::exit::usage;
use crate::files::{write_image, write_text};
use anyhow::{Context, Result};
use report::Report;
use sandtable_cast::{CastPool, Scene};
use sandtable_terrain::TerrainSource;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// What all papers' measurements are made with.
struct Setup {
    /// One casting thread.
    one: CastPool,
    /// As many as were asked for.
    many: CastPool,
    /// Frames timed for each figure.
    frames: usize,
    /// Posts along each side of generated terrains, where not the paper's own.
    size: Option<u32>,
}

impl Setup {
    /// The generated mountains, with `posts` along each side unless another size was asked for.
    fn ridges(&self, posts: u32) -> Result<(String, Arc<Scene>)> {
        let size = self.size.unwrap_or(posts);
        opened(&TerrainSource::Ridges { size, seed: 0 })
    }

    /// Both pools, or the first alone where they are alike.
    fn pools(&self) -> Vec<&CastPool> {
        let mut pools = vec![&self.one];
        if self.many.threads() > 1 {
            pools.push(&self.many);
        }
        pools
    }
}

/// A terrain's name, and the terrain as a scene.
fn opened(source: &TerrainSource) -> Result<(String, Arc<Scene>)> {
    let terrain = sandtable_terrain::open(source, None)?;
    Ok((terrain.name, Scene::new(terrain.ground)))
}

pub(crate) fn run(args: &ReproduceArgs) -> Result<()> {
    let frames = args.frames.unwrap_or(usual_frames(args.paper));
    if frames == 0 {
        return Err(usage("--frames must be at least 1"));
    }
    let pool = |threads| CastPool::new(threads).context("cannot start the casting threads");
    let setup = Setup {
        one: pool(1)?,
        many: pool(args.threads)?,
        frames,
        size: args.size,
    };
    let report = match args.paper {
        Paper::Wan1999 => wan1999::report(&setup)?,
        Paper::Szenberg1997 => szenberg1997::report(&setup)?,
        Paper::Guedes1997 => guedes1997::report(&setup)?,
        Paper::CohenOr1996 => cohenor1996::report(&setup)?,
    };
    let folder = match &args.out {
        Some(folder) => folder.clone(),
        None => PathBuf::from("out").join(args.paper.to_string()),
    };
    for picture in report.pictures() {
        write_image(&folder.join(&picture.file), &picture.image)?;
    }
    // Last, so that a page never links to an image that is not there.
    let page = folder.join("index.html");
    write_text(&page, &page::html(&report))?;

    let mut out = std::io::stdout().lock();
    if args.json {
        let json = json(&report, &page.display().to_string());
        writeln!(out, "{}", serde_json::to_string_pretty(&json)?)?;
    } else {
        writeln!(out, "{}\n{}\n", report.title, report.citation)?;
        for table in report.tables() {
            writeln!(out, "{}", table::text(table))?;
        }
        writeln!(out, "{}", page.display())?;
    }
    Ok(())
}

/// As many frames as a paper's figures take to be steady, and to be there within a minute.
fn usual_frames(paper: Paper) -> usize {
    match paper {
        Paper::Wan1999 => 11,
        // The cost of depth is a few hundredths of some milliseconds.
        Paper::Szenberg1997 => 201,
        Paper::Guedes1997 => 21,
        Paper::CohenOr1996 => 5,
    }
}

fn json(report: &Report, page: &str) -> serde_json::Value {
    let tables: Vec<_> = report.tables().map(table::json).collect();
    let images: Vec<_> = report.pictures().map(|picture| &picture.file).collect();
    serde_json::json!({
        "paper": report.citation,
        "page": page,
        "images": images,
        "tables": tables,
    })
}
