//! The terrains of the scenes.

use crate::scenes::scene;
use glam::DVec3;
use std::fs;

const SIDE: u32 = 512;

/// Heights of the fractal terrain, row by row.
fn rows() -> Vec<Vec<f32>> {
    let made = scene("t512", None).expect("no file is read");
    let made = made.expect("fractal scenes are always there");
    let heights = made.scene.ground.heights();
    let row = |row| (0..SIDE).map(|col| heights.post(col, row)).collect();
    (0..SIDE).map(row).collect()
}

#[test]
fn fractal_heights_are_whole_steps_from_nothing_to_the_relief() {
    let relief = 0.12 * (SIDE - 1) as f32;
    let steps: Vec<f32> = rows()
        .concat()
        .iter()
        .map(|h| h / relief * 65_535.0)
        .collect();
    assert!(steps.iter().all(|step| (step - step.round()).abs() < 0.02));
    assert_eq!(steps.iter().copied().fold(1.0, f32::min), 0.0);
    assert_eq!(steps.iter().copied().fold(1.0, f32::max).round(), 65_535.0);
}

/// The slopes that the terrain of the first measurements has, with this many posts.
#[test]
fn fractal_slopes_are_those_of_rough_mountains() {
    let mut slopes: Vec<f32> = rows()
        .iter()
        .flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs()))
        .collect();
    slopes.sort_by(f32::total_cmp);
    for (share, slope) in [(0.5, 0.324), (0.9, 0.821), (0.99, 1.353)] {
        let found = slopes[(share * (slopes.len() - 1) as f64) as usize];
        assert!(
            (found / slope - 1.0).abs() < 0.05,
            "{share} of the slopes are below {found}, not {slope}"
        );
    }
}

#[test]
fn raw_files_have_posts_colours_and_views_where_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let write = |ending: &str, bytes: &[u8]| {
        fs::write(folder.path().join(format!("t3.{ending}")), bytes).unwrap();
    };
    let heights: Vec<u8> = (0..9u8)
        .flat_map(|at| f32::from(at).to_le_bytes())
        .collect();
    write("f32", &heights);
    write("rgb", &(0..27).collect::<Vec<u8>>());
    for view in ["wan0", "wan45", "low", "low45", "wbL", "wbR", "down"] {
        write(
            &format!("{view}.cam"),
            b"4 2  1 2 3  0 1 0  0.5 0 0  0 0 -0.5",
        );
    }

    let read = scene("t3", Some(folder.path())).unwrap().unwrap();
    // The second post from the west in the northern row.
    assert_eq!(read.scene.ground.height_at(1.0, 2.0), Some(7.0));
    assert_eq!(read.scene.ground.colour_at(1.0, 2.0), [21, 22, 23]);
    let view = read.views[0].view;
    assert_eq!(view.size, [4, 2]);
    assert_eq!(view.ray(0, 0).direction, DVec3::Y);
    assert_eq!(view.ray(3, 1).direction, DVec3::new(1.5, 1.0, -0.5));
    assert_eq!(view.eye, DVec3::new(1.0, 2.0, 3.0));

    write("rgb", &[0; 26]);
    let error = scene("t3", Some(folder.path())).err().unwrap().to_string();
    assert!(error.contains("t3.rgb has 26 bytes"), "{error}");
}

#[test]
fn a_scene_that_does_not_exist_is_refused_by_name() {
    let error = scene("alps", None).err().unwrap().to_string();
    assert!(
        error.contains("\"alps\"") && error.contains("pyrenees"),
        "{error}"
    );
}
