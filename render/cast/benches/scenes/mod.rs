//! Terrains, and views of them, that casters are measured on.
//!
//! `tN` is the fractal terrain of N by N posts a metre apart, and `tNxK` its photograph over means of
//! K by K of them; `cityN` is a town of as many posts, and `cityNxK` the same with K by
//! K pixels of its photograph to a post; `spikesN`, `gorgesN`, `woodN` and `boxesN` have cliffs all over; the
//! others are real. The environment chooses: `SANDTABLE_BENCH_SCENES` names scenes
//! (`t512,pyrenees`), `SANDTABLE_BENCH_LARGE=1` adds t16384, and `SANDTABLE_PEERS` is a folder that has
//! the fractal terrains as raw files.

mod city;
mod cliffs;
mod fractal;
mod noise;
mod photo;
mod raw;
mod real;
mod thinned;
pub(crate) mod views;

use anyhow::{Result, bail};
use cliffs::Cliffs;
use sandtable_cast::Scene;
use sandtable_cast::standpoints::Standpoint;
use sandtable_terrain::Ground;
use std::env;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is measured where nothing is chosen, and where t16384 is asked for besides.
const SCENES: [&str; 4] = ["t512", "t4096", "pyrenees", "ruby-range"];
const LARGE: &str = "t16384";

/// A terrain with a photograph, and its views.
pub(crate) struct BenchScene {
    /// What tables call it.
    pub(crate) name: String,
    /// The terrain.
    pub(crate) scene: Arc<Scene>,
    /// The views.
    pub(crate) views: Vec<Standpoint>,
}

impl BenchScene {
    fn new(name: &str, ground: Ground, views: Vec<Standpoint>) -> Self {
        Self {
            name: name.to_owned(),
            scene: Scene::new(ground),
            views,
        }
    }
}

/// The scenes that the environment chooses, each made when it is asked for, so that no two are
/// held at once. Real ones whose files are not there are left out with a message.
pub(crate) fn chosen() -> impl Iterator<Item = Result<BenchScene>> {
    let large = env::var("SANDTABLE_BENCH_LARGE").is_ok_and(|value| value == "1");
    let names: Vec<String> = match env::var("SANDTABLE_BENCH_SCENES") {
        Ok(names) => names
            .split(',')
            .map(|name| name.trim().to_owned())
            .collect(),
        Err(_) => {
            let large = large.then_some(LARGE);
            SCENES.into_iter().chain(large).map(str::to_owned).collect()
        }
    };
    let peers = env::var_os("SANDTABLE_PEERS").map(PathBuf::from);
    names
        .into_iter()
        .filter_map(move |name| scene(&name, peers.as_deref()).transpose())
}

/// The scene of that name, or `None` where its files are not there. Fractal ones are read from the
/// folder `peers` where that is given.
pub(crate) fn scene(name: &str, peers: Option<&Path>) -> Result<Option<BenchScene>> {
    if let Some((side, times)) = sizes(name, "t") {
        let (mut ground, mut views) = match peers {
            Some(folder) => raw::scene(folder, side)?,
            None => {
                let ground = fractal::ground(side)?;
                let views = views::all(&ground);
                (ground, views)
            }
        };
        if times > 1 {
            (ground, views) = thinned::thinned(&ground, times, views)?;
        }
        return Ok(Some(BenchScene::new(name, ground, views)));
    }
    if let Some((side, pixels)) = sizes(name, "city") {
        let ground = city::ground(side, pixels)?;
        let views = views::all(&ground);
        return Ok(Some(BenchScene::new(name, ground, views)));
    }
    for (kind, cliffs) in Cliffs::ALL {
        if let Some((side, 1)) = sizes(name, kind) {
            let ground = cliffs.ground(side)?;
            let views = views::all(&ground);
            return Ok(Some(BenchScene::new(name, ground, views)));
        }
    }
    let Some(file) = real::file(name) else {
        bail!(
            "no scene is called {name:?}: there are tN, tNxK, cityN, cityNxK, spikesN, gorgesN, woodN, boxesN, {}",
            real::NAMES.join(", ")
        );
    };
    if !file.exists() {
        eprintln!("{name} is left out: {} is not there", file.display());
        return Ok(None);
    }
    let ground = real::ground(&file)?;
    let views = views::horizon_and_table(&ground);
    Ok(Some(BenchScene::new(name, ground, views)))
}

/// The two numbers behind what a scene's name begins with; the second is 1 where there is none.
fn sizes(name: &str, kind: &str) -> Option<(u32, u32)> {
    let sizes = name.strip_prefix(kind)?;
    let (side, times) = sizes.split_once('x').unwrap_or((sizes, "1"));
    Some((side.parse().ok()?, times.parse().ok()?))
}
