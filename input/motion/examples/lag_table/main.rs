//! Prints how far filters and predictions are off a known path, and how much they tremble at rest.
//!
//! ```text
//! cargo run --release -p sandtable-motion --example lag_table [POSES.csv]
//! ```
//!
//! Without a file the path is a seeded head's, for a minute. Lines of a file are
//! `seconds,x,y,z,qx,qy,qz,qw`; its poses are taken for the truth, so it should come from something
//! better than the tracker in question. In both cases a tracker's noise is added.

mod head_path;
mod noise;
mod poses_csv;

use glam::DVec3;
use head_path::HeadPath;
use noise::Noise;
use poses_csv::RecordedPath;
use sandtable_motion::{
    Derivative, FilterSettings, HORIZON, OneEuroSettings, Prediction, Signal, Smoothing,
    TrackerFilter,
};
use sandtable_pose::{Nanos, Pose, Rigid, Validity};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

/// Samples a second: a Flock of Birds' usual cycle.
const RATE: f64 = 103.3;
/// Standard deviations on each axis: 0.5 mm and 0.1 degree.
const NOISE_M: f64 = 0.5e-3;
const NOISE_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// How far ahead of the newest sample frames are shown, in milliseconds.
const AHEAD_MS: [u64; 5] = [0, 10, 20, 30, 50];
/// The length of the head's path, and of the rest at its first pose, in seconds.
const PATH_S: f64 = 60.0;
const REST_S: f64 = 20.0;
/// Filters settle for so long before anything is counted.
const SETTLE_S: f64 = 1.0;
const SEED: u64 = 2003;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let file = arguments.next();
    if arguments.next().is_some() {
        return Err("give one file of poses, or none".into());
    }
    let table = match file {
        Some(file) => {
            let path = RecordedPath::read(Path::new(&file))?;
            if path.seconds() < 2.0 * SETTLE_S {
                return Err("give a path of two seconds or more".into());
            }
            table(|seconds| path.at(seconds), path.seconds())?
        }
        None => head_table()?,
    };
    print!("{table}");
    Ok(())
}

/// The table of the seeded head.
fn head_table() -> Result<String, Box<dyn Error>> {
    let path = HeadPath::new(SEED, PATH_S);
    table(|seconds| path.at(seconds), PATH_S)
}

/// What is compared: a name, a smoothing and a prediction.
fn rows() -> Vec<(&'static str, Smoothing, Prediction)> {
    let ms = Duration::from_millis;
    let smoothed = |tau| Smoothing::DoubleExponential {
        position: ms(tau),
        attitude: ms(tau),
    };
    let predicted = |tau| Prediction::DoubleExponential {
        position: ms(tau),
        attitude: ms(tau),
        horizon: HORIZON,
    };
    // Attitudes in radians need a quarter of the positions' beta at the same speeds.
    let one_euro = |min_cutoff_hz, beta, derivative| {
        let settings = |beta| OneEuroSettings {
            min_cutoff_hz,
            beta,
            derivative,
            ..OneEuroSettings::POSITION
        };
        Smoothing::OneEuro {
            position: settings(beta),
            attitude: settings(beta / 4.0),
        }
    };
    let (filtered, raw) = (Derivative::FromFiltered, Derivative::FromRaw);
    let (as_is, usual) = (Smoothing::Off, Smoothing::ONE_EURO);
    let (now, onward) = (Prediction::Off, Prediction::CONSTANT_VELOCITY);
    vec![
        ("nothing", as_is, now),
        ("One-Euro: 1 Hz, beta 80", usual, now),
        (
            "One-Euro: 0.5 Hz, beta 80",
            one_euro(0.5, 80.0, filtered),
            now,
        ),
        (
            "One-Euro: 1 Hz, beta 20",
            one_euro(1.0, 20.0, filtered),
            now,
        ),
        (
            "One-Euro: 1 Hz, beta 160, raw speed",
            one_euro(1.0, 160.0, raw),
            now,
        ),
        ("double exponential: 20 ms", smoothed(20), now),
        ("double exponential: 40 ms", smoothed(40), now),
        ("constant velocity", as_is, onward),
        ("predicted double exponential: 20 ms", as_is, predicted(20)),
        ("predicted double exponential: 40 ms", as_is, predicted(40)),
        (
            "One-Euro: 1 Hz, beta 80, then constant velocity",
            usual,
            onward,
        ),
        (
            "One-Euro: 1 Hz, beta 80, then predicted double exponential: 20 ms",
            usual,
            predicted(20),
        ),
    ]
}

fn table(truth: impl Fn(f64) -> Rigid, length: f64) -> Result<String, Box<dyn Error>> {
    let mut out = String::new();
    let mut results = Vec::new();
    for (name, smoothing, prediction) in rows() {
        let filter = TrackerFilter::new(FilterSettings {
            smoothing,
            prediction,
            ..FilterSettings::default()
        })?;
        let off = run(filter.clone(), &truth, length);
        let rest = truth(0.0);
        let still = run(filter, |_| rest, REST_S);
        results.push((name, off, still));
    }
    type Unit = (&'static str, f64, usize, fn(&Off) -> &[DVec3]);
    let units: [Unit; 2] = [
        ("mm", 1e3, 2, |off| &off.metres),
        ("degrees", 1f64.to_degrees(), 3, |off| &off.radians),
    ];
    for (unit, scale, digits, part) in units {
        let ahead = AHEAD_MS.map(|ms| format!("{ms} ms ahead"));
        let ahead = ahead.join(" | ");
        writeln!(
            out,
            "| RMS in {unit} | {ahead} | at rest, 0 ms | at rest, 50 ms |"
        )?;
        writeln!(out, "| --- |{}", " ---: |".repeat(AHEAD_MS.len() + 2))?;
        for (name, off, still) in &results {
            write!(out, "| {name} |")?;
            for off in off {
                write!(out, " {:.digits$} |", scale * rms(part(off)))?;
            }
            for still in [&still[0], &still[AHEAD_MS.len() - 1]] {
                write!(out, " {:.digits$} |", scale * jitter(part(still)))?;
            }
            writeln!(out)?;
        }
        writeln!(out)?;
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    Ok(out)
}

/// How far off poses were, at each sample.
#[derive(Default)]
struct Off {
    metres: Vec<DVec3>,
    radians: Vec<DVec3>,
}

/// How far off the filter is at each of [`AHEAD_MS`].
fn run(
    mut filter: TrackerFilter,
    truth: impl Fn(f64) -> Rigid,
    length: f64,
) -> [Off; AHEAD_MS.len()] {
    let mut noise = Noise::new(SEED + 1);
    let mut off = std::array::from_fn(|_| Off::default());
    let samples = ((length - 0.05) * RATE) as u64;
    for i in 0..samples {
        let seconds = i as f64 / RATE;
        let now = Nanos::from_seconds(seconds);
        filter.push(&Pose {
            frame_from_body: noise.measured(&truth(seconds), NOISE_M, NOISE_RAD),
            time: now,
            validity: Validity::Live,
        });
        if seconds < SETTLE_S {
            continue;
        }
        for (ms, off) in AHEAD_MS.iter().zip(&mut off) {
            let display = now + Duration::from_millis(*ms);
            let shown = filter.pose_at(now, display).expect("a sample was pushed");
            let shown = shown.pose.frame_from_body;
            let truth = truth(display.seconds());
            off.metres.push(shown.translation - truth.translation);
            off.radians
                .push(shown.rotation.difference_from(truth.rotation));
        }
    }
    off
}

/// The root of the mean squared length.
fn rms(vectors: &[DVec3]) -> f64 {
    let sum: f64 = vectors.iter().map(|v| v.length_squared()).sum();
    (sum / vectors.len() as f64).sqrt()
}

/// The same about the mean.
fn jitter(vectors: &[DVec3]) -> f64 {
    let mean = vectors.iter().sum::<DVec3>() / vectors.len() as f64;
    let about: Vec<DVec3> = vectors.iter().map(|v| v - mean).collect();
    rms(&about)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documents_hold_the_table_that_this_prints() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/filters.md");
        let page = std::fs::read_to_string(page).unwrap();
        for line in head_table().unwrap().lines() {
            assert!(page.lines().any(|held| held == line), "not held: {line}");
        }
    }
}
