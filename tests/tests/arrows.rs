//! Dependencies between the crates point one way, as ARCHITECTURE.md draws them.

use cargo_metadata::MetadataCommand;
use std::collections::{BTreeMap, BTreeSet};

/// Each crate and the crates of ours that it may use. `sandtable` and `sandtable-tests` may use
/// all; only they are used by nobody.
const ARROWS: [(&str, &[&str]); 12] = [
    ("sandtable-pose", &[]),
    ("sandtable-field", &[]),
    (
        "sandtable-calibration",
        &["sandtable-field", "sandtable-pose"],
    ),
    (
        "sandtable-config",
        &["sandtable-field", "sandtable-motion", "sandtable-pose"],
    ),
    (
        "sandtable-input",
        &["sandtable-config", "sandtable-motion", "sandtable-pose"],
    ),
    ("sandtable-motion", &["sandtable-pose"]),
    ("sandtable-view", &["sandtable-pose"]),
    ("sandtable-terrain", &[]),
    ("sandtable-cast", &["sandtable-terrain", "sandtable-view"]),
    (
        "sandtable-stage",
        &["sandtable-cast", "sandtable-terrain", "sandtable-view"],
    ),
    ("sandtable-audio", &[]),
    (
        "sandtable",
        &[
            "sandtable-audio",
            "sandtable-calibration",
            "sandtable-cast",
            "sandtable-config",
            "sandtable-field",
            "sandtable-input",
            "sandtable-pose",
            "sandtable-stage",
            "sandtable-terrain",
            "sandtable-view",
        ],
    ),
];

/// Crates that one of ours must not use, and why.
const FORBIDDEN: [(&str, &[&str], &str); 5] = [
    (
        "sandtable-calibration",
        &["wgpu", "winit", "serialport", "egui", "rayon"],
        "calibration is mathematics",
    ),
    (
        "sandtable-cast",
        &["wgpu", "winit", "serialport", "egui"],
        "a caster sees no GPU and no device",
    ),
    (
        "sandtable-terrain",
        &["wgpu", "winit", "serialport", "egui"],
        "terrain sees no eye",
    ),
    (
        "sandtable-input",
        &["wgpu", "winit", "egui"],
        "input sees no pixel",
    ),
    (
        "sandtable-view",
        &["wgpu", "winit", "serialport", "egui", "rayon"],
        "views are geometry",
    ),
];

#[test]
fn every_dependency_follows_an_arrow() {
    let metadata = MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml"))
        .no_deps()
        .other_options(vec!["--offline".to_owned()])
        .exec()
        .expect("cargo metadata runs");
    let allowed: BTreeMap<_, BTreeSet<_>> = ARROWS
        .iter()
        .map(|(name, uses)| (*name, uses.iter().copied().collect()))
        .collect();
    let mut seen = BTreeSet::new();
    for package in metadata.workspace_packages() {
        let name = package.name.as_str();
        let uses: BTreeSet<_> = package
            .dependencies
            .iter()
            .map(|d| d.name.as_str())
            .collect();
        for (_, forbidden, why) in FORBIDDEN.iter().filter(|(owner, ..)| *owner == name) {
            let used = forbidden.iter().find(|other| uses.contains(**other));
            assert_eq!(used, None, "{name} uses it, but {why}");
        }
        if name == "sandtable-tests" {
            continue;
        }
        let allowed = allowed.get(name).unwrap_or_else(|| {
            panic!("the crate {name} has no place in ARCHITECTURE.md's picture and in this test")
        });
        for used in uses.iter().filter(|used| used.starts_with("sandtable")) {
            assert!(allowed.contains(used), "{name} must not use {used}");
        }
        seen.insert(name.to_owned());
    }
    for (name, _) in ARROWS {
        assert!(seen.contains(name), "{name} is drawn but gone");
    }
}
