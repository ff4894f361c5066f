//! The figures as tables.

use crate::embree::Geometry;

/// A contender's frames in one view on some threads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// The median of their times, milliseconds.
    pub(crate) median_ms: f64,
    /// The share of the checked pixels that are right in depth and colour, in [0, 1].
    pub(crate) right: f64,
}

/// All contenders in one view on some threads; `None` where one did not take part.
pub(crate) struct Line {
    pub(crate) scene: String,
    pub(crate) view: String,
    pub(crate) threads: usize,
    /// In the order of [`Geometry::ALL`].
    pub(crate) embree: [Option<Run>; Geometry::ALL.len()],
    /// In the order of the casters asked for.
    pub(crate) ours: Vec<Option<Run>>,
}

impl Line {
    /// Embree's best time over that of one of ours.
    pub(crate) fn ratio(&self, ours: usize) -> Option<f64> {
        let best = self.embree.iter().flatten().map(|run| run.median_ms);
        let best = best.reduce(f64::min)?;
        Some(best / self.ours[ours]?.median_ms)
    }
}

/// What a contender took to be ready for a scene, on one thread, and what it holds.
pub(crate) struct Holding {
    pub(crate) scene: String,
    pub(crate) contender: String,
    pub(crate) ready_ms: f64,
    /// For posts and colours.
    pub(crate) terrain_bytes: u64,
    /// For all else, where it is known.
    pub(crate) bytes: Option<u64>,
    /// The same at its highest while it was made, where it is known.
    pub(crate) peak_bytes: Option<u64>,
}

/// What tables call Embree with a geometry.
pub(crate) fn name(geometry: Geometry) -> &'static str {
    match geometry {
        Geometry::Grid => "Embree grid",
        Geometry::Triangles => "Embree triangles",
    }
}

/// Widths of a column of figures, and of views' names.
const WIDTH: usize = 16;
const VIEW_WIDTH: usize = 20;

/// The columns of the table of times.
pub(crate) struct Columns {
    casters: Vec<String>,
}

impl Columns {
    /// Columns for Embree and these casters.
    pub(crate) fn new(casters: &[String]) -> Self {
        Self {
            casters: casters.to_vec(),
        }
    }

    /// Prints the head of the table.
    pub(crate) fn print_head(&self) {
        println!(
            "Medians in ms, and the share of pixels that are as brute force has them; x: Embree's best \
             over ours"
        );
        print!("{:<12} {:<VIEW_WIDTH$} {:>7}", "scene", "view", "threads");
        for geometry in Geometry::ALL {
            print!(" {:>WIDTH$}", name(geometry));
        }
        for caster in &self.casters {
            print!(" {caster:>WIDTH$} {:>6}", "x");
        }
        println!();
    }

    /// Prints a line.
    pub(crate) fn print(&self, line: &Line) {
        print!(
            "{:<12} {:<VIEW_WIDTH$} {:>7}",
            line.scene, line.view, line.threads
        );
        for run in &line.embree {
            print!(" {:>WIDTH$}", run_in_words(run));
        }
        for (place, run) in line.ours.iter().enumerate() {
            let ratio = or_dash(line.ratio(place), |ratio| format!("{ratio:.2}"));
            print!(" {:>WIDTH$} {ratio:>6}", run_in_words(run));
        }
        println!();
    }

    /// Prints the ratios over all lines, for each caster and number of threads.
    pub(crate) fn print_summary(&self, lines: &[Line]) {
        let mut threads: Vec<_> = lines.iter().map(|line| line.threads).collect();
        threads.sort_unstable();
        threads.dedup();
        for (place, caster) in self.casters.iter().enumerate() {
            for &threads in &threads {
                let lines = lines.iter().filter(|line| line.threads == threads);
                let ratios: Vec<_> = lines.filter_map(|line| line.ratio(place)).collect();
                if ratios.is_empty() {
                    continue;
                }
                let logarithms: f64 = ratios.iter().map(|ratio| ratio.ln()).sum();
                println!(
                    "{caster}, threads: {threads}; x over {} views: {:.2} in the geometric mean, \
                     {:.2} to {:.2}",
                    ratios.len(),
                    (logarithms / ratios.len() as f64).exp(),
                    ratios.iter().copied().fold(f64::INFINITY, f64::min),
                    ratios.iter().copied().fold(0.0, f64::max)
                );
            }
        }
    }
}

fn run_in_words(run: &Option<Run>) -> String {
    or_dash(*run, |run| {
        // Rounded down: all pixels are right only where it says so.
        let per_mille = (1000.0 * run.right).floor();
        format!("{:.2} {:>5.1} %", run.median_ms, per_mille / 10.0)
    })
}

fn or_dash<T>(value: Option<T>, words: impl Fn(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), words)
}

/// Prints what each contender took to be ready and holds.
pub(crate) fn print_holdings(holdings: &[Holding]) {
    let mb = |bytes: u64| format!("{:.1}", bytes as f64 / 1e6);
    println!("\nReady on one thread, and megabytes held");
    println!(
        "{:<12} {:<WIDTH$} {:>9} {:>9} {:>9} {:>9}",
        "scene", "", "ms", "terrain", "beside", "at most"
    );
    for holding in holdings {
        println!(
            "{:<12} {:<WIDTH$} {:>9.1} {:>9} {:>9} {:>9}",
            holding.scene,
            holding.contender,
            holding.ready_ms,
            mb(holding.terrain_bytes),
            or_dash(holding.bytes, mb),
            or_dash(holding.peak_bytes, mb)
        );
    }
}
