//! Views of a terrain: of the papers' measurement, of the horizon, down, and of the eyes at a table.
//!
//! Lengths are shares of the terrain's longer side.

use glam::{DVec2, DVec3};
use sandtable_cast::standpoints::Standpoint;
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Placement, Screen, View};

/// The size of the papers' image (row W10), and of all others here.
const PAPER: [u32; 2] = [500, 400];
const FULL_HD: [u32; 2] = [1920, 1080];

/// The glass, the terrain's longer side on it, and the eyes, in table metres.
const GLASS: [f64; 2] = [1.8, 1.1];
const SIDE_ON_GLASS: f64 = 1.6;
const EYE_BEHIND_FRONT: f64 = 0.5;
const EYE_ABOVE: f64 = 0.6;
const EYES_APART: f64 = 0.064;

/// All views: pitched 30° down with and without roll, the horizon with and without roll, both eyes
/// at a table, and almost straight down.
pub(super) fn all(ground: &Ground) -> Vec<Standpoint> {
    let pitched = |roll| camera(ground, [0.5, 0.03], 0.2, [-30.0, roll], 60.0).view(PAPER);
    let down = camera(ground, [0.5, 0.5], 0.35, [-85.0, -10.0], 75.0).view(FULL_HD);
    [
        ("wan0", pitched(0.0)),
        ("wan45", pitched(-45.0)),
        ("low", horizon(ground, 0.0)),
        ("low45", horizon(ground, -45.0)),
        ("left", at_table(ground, -0.5)),
        ("right", at_table(ground, 0.5)),
        ("down", down),
    ]
    .map(named)
    .into()
}

/// The horizon, and the left eye at a table.
pub(super) fn horizon_and_table(ground: &Ground) -> Vec<Standpoint> {
    [
        ("low", horizon(ground, 0.0)),
        ("left", at_table(ground, -0.5)),
    ]
    .map(named)
    .into()
}

fn named((name, view): (&str, View)) -> Standpoint {
    Standpoint {
        name: name.to_owned(),
        view,
    }
}

fn side(ground: &Ground) -> f64 {
    ground.grid().extent().max_element()
}

/// A camera that looks north from `[x, y]`, shares of the terrain's own extent, `above` the lowest
/// post. Degrees: `[pitch, roll]` and the horizontal field of view.
fn camera(
    ground: &Ground,
    [x, y]: [f64; 2],
    above: f64,
    [pitch, roll]: [f64; 2],
    fov: f64,
) -> Camera {
    let at = DVec2::new(x, y) * ground.grid().extent();
    Camera {
        eye: at.extend(f64::from(ground.range()[0]) + above * side(ground)),
        attitude: Attitude {
            yaw: 0.0,
            pitch: pitch.to_radians(),
            roll: roll.to_radians(),
        },
        horizontal_fov: fov.to_radians(),
    }
}

/// The horizon from close above the highest ground within 2 % of the side.
fn horizon(ground: &Ground, roll: f64) -> View {
    const AROUND: i32 = 20;
    let mut camera = camera(ground, [0.47, 0.08], 0.0, [-8.0, roll], 60.0);
    let steps = -AROUND..=AROUND;
    let places = steps
        .clone()
        .flat_map(|i| steps.clone().map(move |j| (i, j)));
    let highest = places
        .filter_map(|(i, j)| {
            let at = camera.eye.truncate() + DVec2::new(i.into(), j.into()) * side(ground) / 1000.0;
            ground.height_at(at.x, at.y)
        })
        .fold(f64::NEG_INFINITY, f64::max);
    camera.eye.z = highest + 0.012 * side(ground);
    camera.view(FULL_HD)
}

/// One eye at a table on which the terrain is centred, its lowest post in the glass; `eye` is −½
/// for the left one and ½ for the right one.
fn at_table(ground: &Ground, eye: f64) -> View {
    let middle = 0.5 * ground.grid().extent();
    let placement = Placement {
        anchor: middle.extend(ground.range()[0].into()),
        yaw: 0.0,
        scale: side(ground) / SIDE_ON_GLASS,
        exaggeration: 1.0,
    };
    let eye = DVec3::new(
        eye * EYES_APART,
        -0.5 * GLASS[1] - EYE_BEHIND_FRONT,
        EYE_ABOVE,
    );
    View {
        eye: placement.world_from_table(eye),
        window: Screen::horizontal(GLASS[0], GLASS[1])
            .map(|corner| placement.world_from_table(corner)),
        size: FULL_HD,
    }
}

#[cfg(test)]
mod tests {
    use super::super::raw;
    use super::*;

    /// The views that the first measurements were made from, as their files had them; eyes near
    /// the ground stand over level ground here.
    #[test]
    fn views_are_those_of_the_first_measurements() {
        let measured = [
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
                "left",
                "1920 1080 245.28 -79.84375 191.625  -277.067793 510.8373553 -191.625  \
                 0.2994140625 0 0  0 -0.3252893519 0",
            ),
            (
                "right",
                "1920 1080 265.72 -79.84375 191.625  -297.507793 510.8373553 -191.625  \
                 0.2994140625 0 0  0 -0.3252893519 0",
            ),
            (
                "down",
                "1920 1080 255.5 255.5 178.85  -0.8301568654 0.3775415349 -0.9707892332  \
                 0.0007871557988 0.0001382686416 1.209693866e-05  0.0001387968054 -0.0007841604333 -6.86051483e-05",
            ),
        ];
        let ground = Ground::from_fn(512, 512, DVec2::ONE, |_, _| 0.0).unwrap();
        let views = all(&ground);
        assert_eq!(views.len(), measured.len());
        for (found, (name, text)) in views.iter().zip(measured) {
            let (found_view, view) = (found.view, raw::view(text).unwrap());
            assert_eq!(found.name, name);
            assert_eq!(found_view.size, view.size);
            assert!((found_view.eye - view.eye).length() < 1e-6, "{name}");
            for (i, j) in [(0, 0), (499, 0), (0, 399)] {
                let (found, direction) = (found_view.ray(i, j).direction, view.ray(i, j).direction);
                let off = (found.normalize() - direction.normalize()).length();
                assert!(off < 1e-6, "{name}: {found} is not {direction}");
            }
        }
    }

    #[test]
    fn eyes_and_tables_stand_over_the_lowest_post() {
        let ground = |low: f32| {
            let height = |col: u32, row: u32| low + (col * row) as f32;
            Ground::from_fn(40, 30, DVec2::new(30.0, 20.0), height).unwrap()
        };
        for (low, high) in all(&ground(0.0)).iter().zip(&all(&ground(500.0))) {
            let rise = high.view.eye - low.view.eye;
            assert!((rise - 500.0 * DVec3::Z).length() < 1e-3, "{}", low.name);
        }
    }
}
