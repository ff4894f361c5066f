//! Where eyes look in hard views, and through which windows.

use super::eyes::{Standing, anywhere, surface};
use crate::random::Random;
use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Screen, View};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// What is unusual about a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Window {
    /// Nothing.
    Plain,
    /// From 126 to 178 degrees.
    Wide,
    /// Up to 180 degrees, less a hundredth.
    AllButHalf,
    /// Down to a millionth of a radian.
    Narrow,
    /// Sides that are not at right angles, or of different scale by up to thirty.
    Sheared,
    /// Mirrored or lying on its side.
    Mirrored,
    /// Off the axis by up to five windows.
    OffAxis,
    /// The same directions, through a window of another size.
    Scaled,
    /// A level glass under the eye or over it.
    Glass,
    /// With the middle pixels' rays straight ahead.
    Centred,
}

const WINDOWS: [Window; 10] = [
    Window::Plain,
    Window::Wide,
    Window::AllButHalf,
    Window::Narrow,
    Window::Sheared,
    Window::Mirrored,
    Window::OffAxis,
    Window::Scaled,
    Window::Glass,
    Window::Centred,
];

/// Sizes in pixels: mostly small ones, and such as have hardly any rows or columns.
const SIZES: [[u32; 2]; 14] = [
    [160, 120],
    [160, 120],
    [320, 240],
    [161, 121],
    [240, 180],
    [1, 200],
    [200, 1],
    [2000, 3],
    [3, 2000],
    [5000, 3],
    [17, 300],
    [64, 64],
    [130, 97],
    [400, 20],
];

/// From one pixel to the next, as an angle.
const WIDE_ENOUGH: f64 = 1.0 / 8192.0;

/// A window of some kind for an eye that stands so.
pub(super) fn window(
    ground: &Ground,
    eye: DVec3,
    standing: Standing,
    random: &mut Random,
) -> (Window, View) {
    let target = surface(ground, anywhere(ground, random));
    let kind = *random.choose(&WINDOWS);
    let attitude = attitude(eye, target, standing, random);
    let size = *random.choose(&SIZES);
    let mut horizontal_fov = match kind {
        Window::Wide => random.between(2.2, 3.1),
        Window::AllButHalf => random.between(179.0, 179.99).to_radians(),
        Window::Narrow => random.octaves(1e-6, 2e-2),
        _ => random.octaves(0.02, 2.0),
    };
    if matches!(standing, Standing::Far | Standing::Afar) {
        let seen = random.octaves(0.05, 1.5) * ground.grid().extent().max_element();
        horizontal_fov = 2.0 * (0.5 * seen / (target - eye).length()).atan();
    }
    if standing == Standing::Far {
        // A telescope's pixels are narrower than numbers of 32 bits tell from so far away.
        horizontal_fov = horizontal_fov
            .max(f64::from(size[0]) * WIDE_ENOUGH)
            .min(2.0);
    }
    let camera = Camera {
        eye,
        attitude,
        horizontal_fov,
    };
    let mut view = camera.view(size);
    view.window = changed(kind, &view, random);
    (kind, view)
}

fn attitude(eye: DVec3, target: DVec3, standing: Standing, random: &mut Random) -> Attitude {
    let to = target - eye;
    let roll = random.between(-PI, PI);
    let yaw = to.x.atan2(to.y);
    let pitch = to.z.atan2(to.truncate().length());
    let towards = Attitude { yaw, pitch, roll };
    let is_far = matches!(standing, Standing::Far | Standing::Afar);
    let any = Attitude {
        yaw: random.between(-PI, PI),
        pitch: random.between(-FRAC_PI_2, FRAC_PI_2),
        roll,
    };
    match random.bits() % 6 {
        _ if is_far => towards,
        0 => towards,
        1 => any,
        // Along the ground's axes and diagonals, straight up or down, rolled by eighths.
        2 => {
            let mut eighths = || FRAC_PI_4 * (random.bits() % 8) as f64;
            let (yaw, roll) = (eighths(), eighths());
            let pitches = [0.0, -0.2, -FRAC_PI_4, -FRAC_PI_2, FRAC_PI_2];
            Attitude {
                yaw,
                pitch: *random.choose(&pitches),
                roll,
            }
        }
        // With the nadir or the zenith in the image.
        3 => Attitude {
            pitch: -FRAC_PI_2 + random.between(0.0, 0.5),
            ..towards
        },
        4 => Attitude {
            pitch: FRAC_PI_2 - random.between(0.0, 0.5),
            ..towards
        },
        _ => Attitude {
            pitch: random.between(-0.4, 0.1),
            roll: if random.unit() < 0.5 { 0.0 } else { roll },
            ..towards
        },
    }
}

/// The window of a camera's view, as its kind has it.
fn changed(kind: Window, view: &View, random: &mut Random) -> Screen {
    let (eye, screen) = (view.eye, view.window);
    let (across, upwards) = (screen.across(), screen.upwards());
    match kind {
        Window::Plain | Window::Wide | Window::AllButHalf | Window::Narrow => screen,
        Window::Sheared => {
            let middle = screen.lower_left + 0.5 * (across + upwards);
            let (turn, stretch) = (random.between(-1.0, 1.0), random.octaves(0.03, 30.0));
            let skew = random.octaves(0.1, 1.0) * random.between(-20.0, 20.0);
            let mut sides = [across + turn * upwards, stretch * upwards + skew * across];
            if random.unit() < 0.5 {
                sides.reverse();
            }
            let longest = sides[0].length().max(sides[1].length());
            let [x, y] = sides.map(|side| side * (across.length() / longest).min(1.0));
            spanned(middle - 0.5 * (x + y), x, y)
        }
        Window::Mirrored => {
            let corner = screen.lower_left;
            match random.bits() % 3 {
                0 => spanned(corner + across, -across, upwards),
                1 => spanned(corner + upwards, across, -upwards),
                _ => spanned(corner, upwards, across),
            }
        }
        Window::OffAxis => {
            let mut windows = || random.between(-5.0, 5.0);
            let shift = windows() * across + windows() * upwards;
            screen.map(|corner| corner + shift)
        }
        Window::Scaled => {
            let by = random.octaves(1e-5, 1e8);
            screen.map(|corner| eye + by * (corner - eye))
        }
        Window::Glass => {
            let below = if random.unit() < 0.8 { -1.0 } else { 1.0 };
            let height = below * random.octaves(1e-2, 1.0);
            let turn = DVec2::from_angle(random.between(0.0, TAU));
            let lean = DVec2::from_angle(random.between(-0.8, 0.8));
            let x = turn * random.octaves(0.3, 4.0);
            let y = lean.rotate(turn.perp()) * random.octaves(0.3, 4.0);
            let mut beyond = || random.between(-0.5, 1.5);
            let corner = -beyond() * x - beyond() * y;
            let scale = random.octaves(0.1, 10.0);
            spanned(
                eye + scale * corner.extend(height),
                scale * x.extend(0.0),
                scale * y.extend(0.0),
            )
        }
        Window::Centred => {
            let [width, height] = view.size.map(f64::from);
            let half = 0.5 * (across / width + upwards / height);
            screen.map(|corner| corner + half)
        }
    }
}

fn spanned(lower_left: DVec3, across: DVec3, upwards: DVec3) -> Screen {
    Screen {
        lower_left,
        lower_right: lower_left + across,
        upper_left: lower_left + upwards,
    }
}
