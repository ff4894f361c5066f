//! What the documents tell to write into a rig can be written there.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use sandtable_config::{Rig, SensorSettings};
use std::path::Path;

fn page(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../docs")
        .join(name);
    std::fs::read_to_string(path).unwrap()
}

/// The page's examples of TOML.
fn examples(page: &str) -> Vec<&str> {
    let after = page.split("```toml\n").skip(1);
    after
        .map(|text| text.split("```").next().unwrap())
        .collect()
}

/// What is set for `flock/1` by `lines` in the workbench's file.
fn sensor(lines: &str) -> SensorSettings {
    let text = format!("{}\n{lines}", Rig::builtin_text("workbench").unwrap());
    let rig = Rig::parse(&text, "example").unwrap_or_else(|error| panic!("{error}\n{lines}"));
    let found = rig
        .sensors
        .iter()
        .find(|(name, _)| name.to_string() == "flock/1");
    *found.unwrap().1
}

#[test]
fn every_example_of_a_sensors_filter_can_be_loaded() {
    for name in ["filters.md", "flock.md", "latency.md"] {
        let page = page(name);
        let filters = examples(&page)
            .into_iter()
            .filter(|text| text.starts_with("[sensors."));
        assert!(filters.map(sensor).count() > 0, "no filter in {name}");
    }
}

#[test]
fn the_pages_first_filter_writes_down_what_stands_without_its_numbers() {
    let page = page("filters.md");
    let short = "[sensors.\"flock/1\"]\nsmoothing = { kind = 'one-euro' }\n\
                 prediction = { kind = 'constant-velocity' }\nahead_ms = 30.0";
    assert_eq!(sensor(examples(&page)[0]), sensor(short));
    let short = "[sensors.\"flock/1\"]\nprediction = { kind = 'double-exponential' }\n\
                 ahead_ms = 30.0";
    assert_eq!(sensor(examples(&page)[1]), sensor(short));
}

#[test]
fn every_key_of_the_filters_tables_stands_in_an_example() {
    let page = page("filters.md");
    let written = examples(&page).concat();
    let (_, tables) = page.split_once("## In a rig").unwrap();
    let mut keys = 0;
    for row in tables.lines().filter(|line| line.starts_with("| `")) {
        let first = row.split(" | ").next().unwrap();
        for key in first.split('`').skip(1).step_by(2) {
            keys += 1;
            let stands = [format!("{key} = "), format!("\".{key}]")];
            assert!(stands.iter().any(|words| written.contains(words)), "{key}");
        }
    }
    assert!(keys > 12, "{keys}");
}

#[test]
fn the_ranges_of_the_filters_tables_are_those_that_are_taken() {
    let page = page("filters.md");
    let (_, tables) = page.split_once("## In a rig").unwrap();
    let euro = |key: &str, value: f64| {
        format!("smoothing = {{ kind = 'one-euro', attitude = {{ {key} = {value:?} }} }}")
    };
    let predicted = |key: &str, value: f64| {
        format!("ahead_ms = 1.0\nprediction = {{ kind = 'double-exponential', {key} = {value:?} }}")
    };
    let ahead = |key: &str, value: f64| {
        format!("{key} = {value:?}\nprediction = {{ kind = 'constant-velocity' }}")
    };
    let alone = |key: &str, value: f64| format!("{key} = {value:?}");
    let mut checked = 0;
    for row in tables.lines() {
        let cells: Vec<&str> = row.split(" | ").collect();
        let Some((least, rest)) = cells.get(1).and_then(|cell| cell.split_once(" to ")) else {
            continue;
        };
        let Ok(least) = least.parse::<f64>() else {
            continue;
        };
        let most: f64 = rest.split(' ').next().unwrap().parse().unwrap();
        for key in cells[0].split('`').skip(1).step_by(2) {
            let written: &dyn Fn(&str, f64) -> String = match key {
                "ahead_ms" => &ahead,
                "velocity_window_ms" | "gap_ms" => &alone,
                "horizon_ms" | "position_ms" | "attitude_ms" => &predicted,
                _ => &euro,
            };
            let loads = |value: f64| {
                let text = Rig::builtin_text("workbench").unwrap();
                let lines = written(key, value);
                Rig::parse(&format!("{text}\n[sensors.\"flock/1\"]\n{lines}"), "r").is_ok()
            };
            // A picture that is shown at once is not predicted.
            let least_taken = if key == "ahead_ms" { 1e-3 } else { least };
            assert!(
                loads(least_taken) && loads(most),
                "{key}: {least} to {most}"
            );
            assert!(!loads(least - 1e-4) && !loads(most + 1.0), "{key}");
            checked += 1;
        }
    }
    assert!(checked >= 10, "{checked}");
}
