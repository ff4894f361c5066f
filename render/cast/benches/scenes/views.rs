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
pub(crate) fn all(ground: &Ground) -> Vec<Standpoint> {
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

/// One eye at a table, the terrain's lowest post in the glass and its southern border a quarter of
/// a metre before the glass's front, so that no eye sees a wall there: Embree has none. `eye` is
/// −½ for the left one and ½ for the right one.
fn at_table(ground: &Ground, eye: f64) -> View {
    zoomed_out(ground, eye, 1.0)
}

/// The same eye where the terrain is so many `times` smaller on the glass, around its middle.
pub(crate) fn zoomed_out(ground: &Ground, eye: f64, times: f64) -> View {
    let middle = 0.5 * DVec2::new(ground.grid().extent().x, side(ground));
    let placement = Placement {
        anchor: middle.extend(ground.range()[0].into()),
        yaw: 0.0,
        scale: times * side(ground) / SIDE_ON_GLASS,
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
