//! The latency of a tracked head, as the window tells it; how large it is depends on the machine.

use crate::session::{Session, wait_for};
use sandtable_input::flock::{Motion, Simulator, SimulatorSettings};
use std::fs::File;
use std::path::Path;

/// A table as it is told: its frames, and by name a line's median and 95th percentile.
#[derive(Debug)]
struct Table {
    frames: usize,
    lines: Vec<(String, f64, f64)>,
}

impl Table {
    fn line(&self, name: &str) -> (f64, f64) {
        let found = self.lines.iter().find(|line| line.0 == name);
        let (_, median, p95) = found.unwrap_or_else(|| panic!("no {name} in {self:?}"));
        (*median, *p95)
    }
}

/// All tables in the notes so far, the newest last.
fn tables(notes: &Path) -> Vec<Table> {
    let text = std::fs::read_to_string(notes).expect("it is there");
    let mut tables: Vec<Table> = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let [
            "latency",
            "in",
            "ms,",
            "frames:",
            frames,
            "median",
            "95",
            "%",
        ] = words[..]
        {
            tables.push(Table {
                frames: frames.parse().expect("a count"),
                lines: Vec::new(),
            });
        } else if let ([name @ .., median, p95], Some(table)) = (&words[..], tables.last_mut())
            && table.lines.len() < 7
        {
            let number = |word: &str| word.parse().expect("milliseconds");
            let line = (name.join(" "), number(median), number(p95));
            table.lines.push(line);
        }
    }
    tables.retain(|table| table.lines.len() == 7);
    tables
}

#[test]
fn the_way_of_a_tracked_head_to_the_glass_is_told_by_stages() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let notes = folder.path().join("notes.txt");
    let settings = SimulatorSettings {
        motions: vec![Motion::named("circle").expect("it is one"), Motion::Still],
        ..SimulatorSettings::default()
    };
    let flock = Simulator::start(settings, None).expect("a pseudo-terminal");
    let device = format!("flock={}", flock.path().display());
    let arguments = [
        "builtin:jacksboro",
        "--rig",
        "workbench",
        "--device",
        &device,
        "--size",
        "320x200",
        "--mute",
        "--latency",
    ];
    let file = File::create(&notes).expect("it can be written");
    let Some(session) = Session::open_noting(&arguments, file.into()) else {
        return;
    };
    let before = wait_for("a table while it runs", || {
        let told = tables(&notes);
        told.last()
            .is_some_and(|last| last.frames > 20)
            .then_some(told.len())
    });
    session.close();
    let told = tables(&notes);
    assert!(told.len() > before, "nothing is told at the end");
    for table in &told {
        assert!(table.frames > 0);
        let stages = ["line", "wait", "queue", "cast", "glass"].map(|name| table.line(name));
        for (median, p95) in stages {
            assert!(0.0 <= median && median <= p95, "{table:?}");
        }
        // A record of a bird in a group has 15 bytes, of 10 bits each at 115200 a second.
        assert!(stages[0].0 >= 1.3, "{table:?}");
        // A cast is never over at once.
        assert!(stages[3].0 > 0.0, "{table:?}");
        let (median, p95) = table.line("measurement to glass");
        // No stage is longer than all together; and as at most one frame in twenty is above each
        // stage's p95, at least three in four are below their sum. Figures are rounded.
        let longest = stages
            .iter()
            .fold(0.0, |most: f64, stage| most.max(stage.0));
        let most: f64 = stages.iter().map(|stage| stage.1).sum();
        assert!(longest <= median && median <= most + 0.3, "{table:?}");
        assert!(median <= p95);
        // The workbench predicts nothing.
        assert_eq!(table.line("predicted"), (0.0, 0.0));
    }
    flock.stop();
}
