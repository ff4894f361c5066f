//! The views of the scenes.

use crate::scenes::{scene, views};
use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;
use std::fs;

/// The views that the first measurements were made from, as their files had them for 512 posts a
/// side, in the order of ours; eyes near the ground stand over level ground here.
const MEASURED: [(&str, &str); 7] = [
    (
        "wan0",
        "500 400 255.5 15.33 102.2  -0.5761955687 1.096388161 -0.101  \
         0.002309401077 -1.414100318e-19 0  0 -0.001154700538 -0.002",
    ),
    (
        "wan45",
        "500 400 255.5 15.33 102.2  -0.7332139297 0.8252005747 -0.5707106781  \
         0.001632993162 0.0008164965809 0.001414213562  0.001632993162 -0.0008164965809 -0.001414213562",
    ),
    (
        "low",
        "1920 1080 240.17 40.88 6.132  -0.5770495659 1.035424009 0.1821281112  \
         0.0006014065304 0 0  0 -8.369961177e-05 -0.0005955536834",
    ),
    (
        "low45",
        "1920 1080 240.17 40.88 6.132  -0.6374626952 0.9654105523 -0.3160435212  \
         0.0004252586359 5.918456307e-05 0.0004211200481  0.0004252586359 -5.918456307e-05 -0.0004211200481",
    ),
    (
        "wbL",
        "1920 1080 245.28 -79.84375 191.625  -277.067793 510.8373553 -191.625  \
         0.2994140625 0 0  0 -0.3252893519 0",
    ),
    (
        "wbR",
        "1920 1080 265.72 -79.84375 191.625  -297.507793 510.8373553 -191.625  \
         0.2994140625 0 0  0 -0.3252893519 0",
    ),
    (
        "down",
        "1920 1080 255.5 255.5 178.85  -0.8301568654 0.3775415349 -0.9707892332  \
         0.0007871557988 0.0001382686416 1.209693866e-05  0.0001387968054 -0.0007841604333 -6.86051483e-05",
    ),
];

#[test]
fn views_are_those_of_the_first_measurements() {
    let folder = tempfile::tempdir().unwrap();
    let write = |ending: &str, bytes: &[u8]| {
        fs::write(folder.path().join(format!("t512.{ending}")), bytes).unwrap();
    };
    write("f32", &vec![0; 4 * 512 * 512]);
    write("rgb", &vec![0; 3 * 512 * 512]);
    for (name, text) in MEASURED {
        write(&format!("{name}.cam"), text.as_bytes());
    }
    let measured = scene("t512", Some(folder.path())).unwrap().unwrap();
    let ours = views::all(&measured.scene.ground);
    assert_eq!(ours.len(), MEASURED.len());
    for (ours, measured) in ours.iter().zip(&measured.views) {
        let name = &ours.name;
        assert_eq!(*name, measured.name);
        let (ours, measured) = (ours.view, measured.view);
        assert_eq!(ours.size, measured.size);
        assert!((ours.eye - measured.eye).length() < 1e-6, "{name}");
        for (i, j) in [(0, 0), (499, 0), (0, 399)] {
            let [ours, measured] =
                [ours, measured].map(|view| view.ray(i, j).direction.normalize());
            assert!(
                (ours - measured).length() < 1e-6,
                "{name}: {ours} is not {measured}"
            );
        }
    }
}

#[test]
fn eyes_and_tables_stand_over_the_lowest_post() {
    let ground = |low: f32| {
        let height = |col: u32, row: u32| low + (col * row) as f32;
        Ground::from_fn(40, 30, DVec2::new(30.0, 20.0), height).unwrap()
    };
    let (low, high) = (views::all(&ground(0.0)), views::all(&ground(500.0)));
    for (low, high) in low.iter().zip(&high) {
        let rise = high.view.eye - low.view.eye;
        assert!((rise - 500.0 * DVec3::Z).length() < 1e-3, "{}", low.name);
    }
    // 39 cells of 30 m are 1.6 m wide on the table.
    let [front, back] = [
        low[4].view.window.lower_left.y,
        low[4].view.window.upper_left.y,
    ];
    let metre = 39.0 * 30.0 / 1.6;
    assert!((front - 0.25 * metre).abs() < 1e-6 && (back - 1.35 * metre).abs() < 1e-6);
}
