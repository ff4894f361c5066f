//! Comparisons of the default caster with itself.

mod edits;

use crate::pinned_pool::pinned_pool;
use crate::scenes::BenchScene;
use crate::turns::{Entry, cast, prepared, timed};
use anyhow::Result;
use clap::ValueEnum;
use sandtable_cast::standpoints::Standpoint;
use sandtable_cast::{CastPool, Image, PreparedScene, ShadeFloor, caster_by_name};
use std::fmt;
use std::sync::Arc;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Comparison {
    /// Each instruction set with the best one, on one thread
    Sets,
    /// Both eyes at a table as one job with one of them
    Pair,
    /// Two threads with one
    Threads,
    /// Colouring, where hits are known, with the whole cast
    Shading,
    /// Following an edit of 64 by 64 posts with one of 1024 by 1024, and with preparing anew
    Edits,
}

impl Comparison {
    /// All of them.
    pub(crate) const ALL: [Self; 5] = [
        Self::Sets,
        Self::Pair,
        Self::Threads,
        Self::Shading,
        Self::Edits,
    ];
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        f.pad(value.as_ref().map_or("", |value| value.get_name()))
    }
}

/// The caster's name, as `sandtable bench --caster` takes it.
const CASTER: &str = "planes";

/// Instruction sets, and how many times the best one's time each may take.
const SETS: [(&str, &str); 4] = [
    ("avx512", ""),
    ("avx2", "<= 1.7"),
    ("neon", ""),
    ("portable", "<= 5"),
];

/// A ratio of two medians in milliseconds.
struct Ratio<'a> {
    comparison: Comparison,
    scene: &'a str,
    view: &'a str,
    threads: usize,
    /// What is divided, and by what.
    names: [String; 2],
    ms: [f64; 2],
    /// What it should be.
    goal: &'a str,
}

impl Ratio<'_> {
    fn print(&self) {
        let [over, under] = self.ms;
        println!(
            "{:<8} {:<11} {:<7} {:>7}  {:<14} {:>8.2}  {:<14} {:>8.2} {:>7.2}  {}",
            self.comparison,
            self.scene,
            self.view,
            self.threads,
            self.names[0],
            over,
            self.names[1],
            under,
            over / under,
            self.goal
        );
    }
}

/// Prints the head of the table.
pub(crate) fn print_head() {
    println!("Medians in ms, of repetitions that take turns");
    println!(
        "{:<8} {:<11} {:<7} {:>7}  {:<14} {:>8}  {:<14} {:>8} {:>7}  goal",
        "", "scene", "view", "threads", "", "ms", "over", "ms", "ratio"
    );
}

/// The caster with a scene, and threads.
pub(crate) struct Ours<'a> {
    scene: &'a BenchScene,
    prepared: Arc<dyn PreparedScene>,
    pools: [CastPool; 2],
}

impl<'a> Ours<'a> {
    /// Prepares `scene`.
    pub(crate) fn prepare(scene: &'a BenchScene) -> Result<Self> {
        let pools = [pinned_pool(1)?, pinned_pool(2)?];
        Ok(Self {
            prepared: prepared(scene, &pools[0], CASTER)?,
            scene,
            pools,
        })
    }

    /// Measures one comparison in all views and prints its ratios.
    pub(crate) fn print(&self, comparison: Comparison, rounds: usize) -> Result<()> {
        let each_view =
            |print: &dyn Fn(&Standpoint) -> Result<()>| self.scene.views.iter().try_for_each(print);
        match comparison {
            Comparison::Sets => self.sets(rounds),
            Comparison::Pair => self.pair(rounds),
            Comparison::Threads => each_view(&|at| self.threads(at, rounds)),
            Comparison::Shading => each_view(&|at| self.shading(at, rounds)),
            Comparison::Edits => edits::print(self.scene, &self.prepared, &self.pools[0], rounds),
        }
    }

    fn sets(&self, rounds: usize) -> Result<()> {
        let pool = &self.pools[0];
        let sets: Vec<_> = SETS
            .into_iter()
            .filter_map(|(set, goal)| {
                let name = format!("{CASTER}?isa={set}");
                // Names of other processors' sets are refused.
                caster_by_name(&name).ok()?;
                Some(prepared(self.scene, pool, &name).map(|prepared| (set, goal, prepared)))
            })
            .collect::<Result<_>>()?;
        for at in &self.scene.views {
            let entries = sets
                .iter()
                .map(|(_, _, prepared)| cast(pool, prepared, vec![at.view]))
                .collect();
            let times = medians(rounds, entries)?;
            for ((set, goal, _), &ms) in sets.iter().zip(&times).skip(1) {
                let ratio = Ratio {
                    comparison: Comparison::Sets,
                    scene: &self.scene.name,
                    view: &at.name,
                    threads: 1,
                    names: [(*set).to_owned(), sets[0].0.to_owned()],
                    ms: [ms, times[0]],
                    goal,
                };
                ratio.print();
            }
        }
        Ok(())
    }

    fn pair(&self, rounds: usize) -> Result<()> {
        let eye = |name: &str| self.scene.views.iter().find(|at| at.name == name);
        let (Some(left), Some(right)) = (eye("left"), eye("right")) else {
            return Ok(());
        };
        for pool in &self.pools {
            let views = [
                vec![left.view, right.view],
                vec![left.view],
                vec![right.view],
            ];
            let entries = views.map(|views| cast(pool, &self.prepared, views));
            let times = medians(rounds, entries.into())?;
            let ratio = Ratio {
                comparison: Comparison::Pair,
                scene: &self.scene.name,
                view: "table",
                threads: pool.threads(),
                names: ["both eyes".to_owned(), "one (mean)".to_owned()],
                ms: [times[0], 0.5 * (times[1] + times[2])],
                goal: "<= 1.8",
            };
            ratio.print();
        }
        Ok(())
    }

    fn threads(&self, at: &Standpoint, rounds: usize) -> Result<()> {
        let entries = self.pools.iter();
        let entries = entries.map(|pool| cast(pool, &self.prepared, vec![at.view]));
        let times = medians(rounds, entries.collect())?;
        let ratio = Ratio {
            comparison: Comparison::Threads,
            scene: &self.scene.name,
            view: &at.name,
            threads: 2,
            names: ["1 thread".to_owned(), "2 threads".to_owned()],
            ms: [times[0], times[1]],
            goal: ">= 1.9",
        };
        ratio.print();
        Ok(())
    }

    fn shading(&self, at: &Standpoint, rounds: usize) -> Result<()> {
        for pool in &self.pools {
            let mut images = [Image::default()];
            pool.cast(&*self.prepared, &[at.view], &mut images)?;
            let Some(mut floor) = ShadeFloor::new(&self.scene.scene, &images[0]) else {
                return Ok(());
            };
            let shade: Entry<'_> = Box::new(|| {
                pool.run(|| floor.shade());
                Ok(())
            });
            let times = medians(
                rounds,
                vec![shade, cast(pool, &self.prepared, vec![at.view])],
            )?;
            let ratio = Ratio {
                comparison: Comparison::Shading,
                scene: &self.scene.name,
                view: &at.name,
                threads: pool.threads(),
                names: ["colouring".to_owned(), "all".to_owned()],
                ms: [times[0], times[1]],
                goal: ">= 0.25",
            };
            ratio.print();
        }
        Ok(())
    }
}

/// The median milliseconds of each of `entries`, measured as [`timed`] does.
fn medians(rounds: usize, entries: Vec<Entry<'_>>) -> Result<Vec<f64>> {
    let times = timed(rounds, entries)?;
    Ok(times.iter().map(|times| times[times.len() / 2]).collect())
}
