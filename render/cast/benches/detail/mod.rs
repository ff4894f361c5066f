//! Figures of level of detail.

mod afar;
mod curve;
mod flight;
mod footprint;
mod plot;
mod psnr;
mod quality;
mod time;
mod truth;

use crate::pinned_pool::pinned_pool;
use crate::scenes::BenchScene;
use crate::turns::prepared;
use anyhow::Result;
use clap::ValueEnum;
use curve::Curve;
use sandtable_cast::standpoints::Standpoint;
use sandtable_cast::{CastPool, PreparedScene};
use sandtable_view::View;
use std::sync::Arc;

/// What is found out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Figure {
    /// How near to the truth images are, without and with it
    Quality,
    /// What both eyes at a table take, and one
    Time,
    /// What t16384 takes with it, to t4096
    Sizes,
    /// Quality against time over the options, at the table
    Curve,
    /// How calm images are from frame to frame
    Flight,
    /// What a table takes on which the terrain is small
    Afar,
}

impl Figure {
    /// All of them.
    pub(crate) const ALL: [Self; 6] = [
        Self::Quality,
        Self::Time,
        Self::Sizes,
        Self::Curve,
        Self::Flight,
        Self::Afar,
    ];
}

/// The casters, as `sandtable bench --caster` takes them: without and with level of detail.
const POINT: &str = "planes";
const DETAIL: &str = "planes?lod=on";

/// The scenes whose times are compared.
const SIZES: [&str; 2] = ["t4096", "t16384"];

/// A scene with level of detail, kept for comparison.
struct Kept {
    prepared: Arc<dyn PreparedScene>,
    views: Vec<Standpoint>,
}

/// What goes on from scene to scene.
pub(crate) struct Bench {
    rounds: usize,
    frames: u32,
    /// One thread, and two.
    pools: [CastPool; 2],
    curves: Vec<Curve>,
    smaller: Option<Kept>,
}

impl Bench {
    pub(crate) fn new(rounds: usize, frames: u32) -> Result<Self> {
        Ok(Self {
            rounds,
            frames,
            pools: [pinned_pool(1)?, pinned_pool(2)?],
            curves: Vec::new(),
            smaller: None,
        })
    }

    /// Finds out `figures` of `scene` and prints them.
    pub(crate) fn print(&mut self, scene: BenchScene, figures: &[Figure]) -> Result<()> {
        let pool = &self.pools[1];
        let point = prepared(&scene, pool, POINT)?;
        let detail = prepared(&scene, pool, DETAIL)?;
        for figure in figures {
            match figure {
                Figure::Quality => quality::print(&scene, [&point, &detail], pool)?,
                Figure::Time => time::print(&scene, [&point, &detail], &self.pools, self.rounds)?,
                Figure::Sizes => {
                    if scene.name == SIZES[1] {
                        let Some(smaller) = &self.smaller else {
                            eprintln!("{} is compared with {}: choose both", SIZES[1], SIZES[0]);
                            continue;
                        };
                        time::print_sizes(smaller, &detail, &scene, &self.pools, self.rounds)?;
                    }
                }
                Figure::Curve => {
                    self.curves
                        .extend(curve::print(&scene, [&point, &detail], pool, self.rounds)?);
                }
                Figure::Flight => flight::print(&scene, [&point, &detail], pool, self.frames)?,
                Figure::Afar => afar::print(&scene, [&point, &detail], pool, self.rounds)?,
            }
        }
        if scene.name == SIZES[0] {
            self.smaller = Some(Kept {
                prepared: detail,
                views: scene.views,
            });
        }
        Ok(())
    }

    /// The curves so far, as an SVG image.
    pub(crate) fn plot(&self) -> String {
        plot::svg(&self.curves)
    }
}

/// The eyes at a table, where the scene has both.
fn eyes(scene: &BenchScene) -> Option<[View; 2]> {
    let eye = |name: &str| scene.views.iter().find(|at| at.name == name);
    Some([eye("left")?.view, eye("right")?.view])
}
