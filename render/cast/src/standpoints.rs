//! Standpoints: views of any ground that casters are compared and timed from.
//!
//! They follow from the ground alone, so that a bench and a test mean the same views by the same
//! names.

use glam::DVec3;
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Placement, Screen, View};

/// A view and what it is called.
#[derive(Clone, Debug, PartialEq)]
pub struct Standpoint {
    /// What tables of figures call it.
    pub name: String,
    /// The view.
    pub view: View,
}

impl Standpoint {
    fn new(name: impl Into<String>, view: View) -> Self {
        Self {
            name: name.into(),
            view,
        }
    }
}

/// Field of view of all cameras here.
const HORIZONTAL_FOV: f64 = std::f64::consts::FRAC_PI_3;

/// The glass of a workbench, in table metres.
const GLASS: [f64; 2] = [1.8, 1.1];

/// Twelve views without roll, of `size` pixels: from just above the ground and from high up, from
/// inside and from beyond the border, of the horizon and steeply down.
#[must_use]
pub fn level(ground: &Ground, size: [u32; 2]) -> Vec<Standpoint> {
    const PITCHES: [f64; 12] = [
        -5.0, -15.0, -30.0, 0.0, -20.0, -45.0, 5.0, -10.0, -60.0, -2.0, -25.0, -35.0,
    ];
    let extent = ground.grid().extent();
    let [low, high] = ground.range().map(f64::from);
    PITCHES
        .into_iter()
        .enumerate()
        .map(|(k, pitch)| {
            let share = |step: f64| 0.15 + 0.7 * (k as f64 * step).fract();
            // Every fourth eye stands outside, before the southern border.
            let outside = k % 4 == 3;
            let x = share(0.618) * extent.x;
            let y = if outside {
                -0.1 * extent.y
            } else {
                share(0.414) * extent.y
            };
            let floor = ground.height_at(x, y).unwrap_or(high);
            let z = match k % 3 {
                0 => floor + 0.1 * (high - low),
                1 => floor + 0.5 * (high - low),
                _ => high + 0.8 * (high - low),
            };
            let attitude = Attitude {
                yaw: if outside { 0.2 } else { 0.7 * k as f64 },
                pitch: pitch.to_radians(),
                roll: 0.0,
            };
            let eye = DVec3::new(x, y, z);
            let camera = Camera {
                eye,
                attitude,
                horizontal_fov: HORIZONTAL_FOV,
            };
            Standpoint::new(format!("level {k}, pitch {pitch}°"), camera.view(size))
        })
        .collect()
}

/// One view of each kind that a session shows: pitched as in the papers' measurements (W10), to
/// the horizon, rolled, straight down, and one eye at a table.
#[must_use]
pub fn mixed(ground: &Ground) -> Vec<Standpoint> {
    let camera = |y: f64, above: f64, pitch: f64, roll: f64, size: [u32; 2]| {
        let extent = ground.grid().extent();
        let z = f64::from(ground.range()[1]) + above * extent.max_element();
        let attitude = Attitude {
            yaw: 0.2,
            pitch: pitch.to_radians(),
            roll: roll.to_radians(),
        };
        let eye = DVec3::new(0.5 * extent.x, y * extent.y, z);
        Camera {
            eye,
            attitude,
            horizontal_fov: HORIZONTAL_FOV,
        }
        .view(size)
    };
    vec![
        Standpoint::new("pitched", camera(0.02, 0.1, -30.0, 0.0, [500, 400])),
        Standpoint::new("horizon", camera(0.05, 0.02, -8.0, 0.0, [1280, 720])),
        Standpoint::new("rolled", camera(0.05, 0.02, -8.0, 30.0, [1280, 720])),
        Standpoint::new("down", camera(0.5, 0.5, -90.0, 0.0, [1280, 720])),
        Standpoint::new(
            "table",
            at_table(ground, DVec3::new(0.0, -0.75, 0.6), [1280, 782]),
        ),
    ]
}

/// One eye at `eye` (table metres) over a workbench on which all of the ground lies.
#[must_use]
pub fn at_table(ground: &Ground, eye: DVec3, size: [u32; 2]) -> View {
    let glass = Screen::horizontal(GLASS[0], GLASS[1]);
    let heights = ground.range().map(f64::from);
    let placement = Placement::fitted(ground.grid().extent(), heights, &glass, 0.05, 1.0);
    View {
        eye: placement.world_from_table(eye),
        window: glass.map(|corner| placement.world_from_table(corner)),
        size,
    }
}

/// The view of Wan, Qu and Kaufman's measurements (1999; papers' row W10): 500 by 400 pixels,
/// looking east and 30° down from the western border, rolled by `roll` radians.
///
/// The paper does not say where the eye is, nor its field of view.
#[must_use]
pub fn wan(ground: &Ground, roll: f64) -> View {
    let extent = ground.grid().extent();
    let z = f64::from(ground.range()[1]) + 0.1 * extent.max_element();
    Camera {
        eye: DVec3::new(0.02 * extent.x, 0.5 * extent.y, z),
        attitude: Attitude {
            yaw: std::f64::consts::FRAC_PI_2,
            pitch: (-30.0_f64).to_radians(),
            roll,
        },
        horizontal_fov: HORIZONTAL_FOV,
    }
    .view([500, 400])
}

/// A horizontal view direction, as the floating horizon with depth needs it (Szenberg, Gattass
/// and Carvalho 1997; papers' row Z2): northwards from the southern border, from just above the
/// highest post.
#[must_use]
pub fn ahead(ground: &Ground, size: [u32; 2]) -> View {
    let extent = ground.grid().extent();
    let z = f64::from(ground.range()[1]) + 0.01 * extent.max_element();
    Camera {
        eye: DVec3::new(0.5 * extent.x, 0.02 * extent.y, z),
        attitude: Attitude::default(),
        horizontal_fov: HORIZONTAL_FOV,
    }
    .view(size)
}

/// A view whose plane is inclined by `inclination` radians, in (0, π/2], from upright (Guedes,
/// Gattass and Carvalho 1997; papers' row G3): northwards, at the middle of the ground.
#[must_use]
pub fn inclined(ground: &Ground, inclination: f64, size: [u32; 2]) -> View {
    let extent = ground.grid().extent();
    let [low, high] = ground.range().map(f64::from);
    let z = high + 0.25 * extent.max_element();
    let back = (z - 0.5 * (low + high)) / inclination.tan();
    Camera {
        eye: DVec3::new(0.5 * extent.x, 0.5 * extent.y - back, z),
        attitude: Attitude {
            pitch: -inclination,
            ..Attitude::default()
        },
        horizontal_fov: HORIZONTAL_FOV,
    }
    .view(size)
}

/// A view `pitch` radians down, northwards from inside the southern border, as Cohen-Or and
/// others (1996; papers' row C11) measured at three pitches. Along `flown`, in [0, 1], the eye
/// flies to the middle of the ground.
#[must_use]
pub fn flown(ground: &Ground, pitch: f64, flown: f64, size: [u32; 2]) -> View {
    let extent = ground.grid().extent();
    let z = f64::from(ground.range()[1]) + 0.05 * extent.max_element();
    Camera {
        eye: DVec3::new(0.5 * extent.x, (0.02 + 0.48 * flown) * extent.y, z),
        attitude: Attitude {
            pitch: -pitch,
            ..Attitude::default()
        },
        horizontal_fov: HORIZONTAL_FOV,
    }
    .view(size)
}
