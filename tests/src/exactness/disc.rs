//! The rays around a pixel's centre, and the search among them for one that agrees with the pixel.

use super::{HIT_TOLERANCE, RAY_TOLERANCE, is_close_colour};
use glam::{DVec2, DVec3};
use sandtable_cast::Sight;
use sandtable_terrain::Ground;
use sandtable_view::{Ray, Rays, View};
use std::f64::consts::TAU;

/// How near the rays of a disc come to seeing what the pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Answer {
    /// None hits where the pixel does.
    Differs,
    /// One hits where the pixel does; its colour is another.
    AgreesInDepth,
    /// One sees what the pixel shows.
    Agrees,
}

/// Rays on a circle around the centre.
struct Ring {
    /// How many, at equal angles.
    rays: u32,
    /// The first ray's angle, in steps from one ray to the next, so that no two rings share a ray.
    turn: f64,
    /// The circle's radius over that of the disc.
    radius: f64,
}

const fn ring(rays: u32, turn: f64, radius: f64) -> Ring {
    Ring { rays, turn, radius }
}

/// The search goes on to the next stage only while no ray agrees: 8 rays, 32 more, 128 more, 512 more.
/// A good caster's rays pass far nearer to the centre than the tolerance, so the third stage's rings close
/// in on it and show what is too thin for the outer ones; the last one's lie all over the disc, where a photo
/// has other colours every few hundredths of a cell.
const STAGES: [&[Ring]; 4] = [
    &[ring(8, 0.0, 1.0)],
    &[ring(16, 0.5, 1.0), ring(16, 0.5, 0.125)],
    &[
        ring(32, 0.25, 1.0),
        ring(32, 0.25, 0.25),
        ring(32, 0.75, 0.0625),
        ring(32, 0.75, 0.015_625),
    ],
    &[
        ring(128, 0.125, 0.9),
        ring(128, 0.625, 0.7),
        ring(128, 0.375, 0.5),
        ring(128, 0.875, 0.3),
    ],
];

/// How many rays of a ring are compared with the centre's besides with their neighbours.
const SPOKES: u32 = 8;

/// How often the way between two rays is halved: until f64 hardly tells their directions apart.
/// Along a ray that touches a hill, depth goes with the root of the direction, so that a tenth of
/// a cell may be that fine.
const HALVINGS: u32 = 40;

/// All rays that may answer for one pixel, and what the pixel shows.
pub(super) struct Disc<'a> {
    ground: &'a Ground,
    rays: Rays,
    eye: DVec3,
    /// The pixel's centre in image coordinates.
    centre: DVec2,
    /// What the image has there, and the unit direction in which it has it.
    found: Sight,
    forward: DVec3,
    /// How far two hits may lie apart, in metres.
    tolerance: f64,
    /// In pixels.
    radius: f64,
}

/// One ray that was cast: where it passes the centre, in pixels, and whether it ends nearer or
/// farther than the pixel says (metres).
#[derive(Clone, Copy)]
struct Probe {
    at: DVec2,
    beyond: f64,
}

impl<'a> Disc<'a> {
    pub(super) fn new(ground: &'a Ground, view: &View, [i, j]: [u32; 2], found: Sight) -> Self {
        let rays = view.rays();
        let centre = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
        let direction = rays.direction(centre.x, centre.y);
        let tolerance = HIT_TOLERANCE * ground.grid().cell_length();
        let mut radius = RAY_TOLERANCE;
        if found.depth.is_finite() {
            // A ray from here on passes the hit at more than the tolerance, whatever it hits.
            let per_pixel = slowest_turn(view, direction) * found.depth.abs();
            radius = radius.min(1.01 * tolerance / per_pixel);
        }
        Self {
            ground,
            rays,
            eye: view.eye,
            centre,
            found,
            forward: direction.normalize(),
            tolerance,
            radius,
        }
    }

    /// Looks for a ray that agrees: the centre's first, then those of the rings, and between
    /// neighbours of which one ends before and one behind the pixel's hit.
    pub(super) fn search(&self) -> Answer {
        let (mut best, centre) = self.look(DVec2::ZERO);
        for ring in STAGES.into_iter().flatten() {
            if best == Answer::Agrees {
                break;
            }
            best = best.max(self.search_ring(ring, centre));
        }
        best
    }

    fn search_ring(&self, ring: &Ring, centre: Probe) -> Answer {
        let at = |k: u32| {
            let angle = TAU * (f64::from(k) + ring.turn) / f64::from(ring.rays);
            self.radius * ring.radius * DVec2::from_angle(angle)
        };
        let (mut best, first) = self.look(at(0));
        let mut before = first;
        for k in 1..=ring.rays {
            if best == Answer::Agrees {
                break;
            }
            let probe = if k < ring.rays {
                let (answer, probe) = self.look(at(k));
                best = best.max(answer);
                probe
            } else {
                first
            };
            best = best.max(self.search_between(before, probe));
            if k % (ring.rays / SPOKES) == 0 {
                best = best.max(self.search_between(centre, probe));
            }
            before = probe;
        }
        best
    }

    /// Halves the way between two rays towards where they would meet the pixel's hit, if the
    /// depths between them range over it. Where they leap over it, it finds nothing.
    fn search_between(&self, a: Probe, b: Probe) -> Answer {
        let mut best = Answer::Differs;
        if a.beyond * b.beyond >= 0.0 || a.beyond.is_nan() || b.beyond.is_nan() {
            return best;
        }
        let (mut nearer, mut farther) = if a.beyond < 0.0 {
            (a.at, b.at)
        } else {
            (b.at, a.at)
        };
        for _ in 0..HALVINGS {
            let (answer, probe) = self.look(0.5 * (nearer + farther));
            best = best.max(answer);
            if best == Answer::Agrees {
                break;
            }
            if probe.beyond < 0.0 {
                nearer = probe.at;
            } else {
                farther = probe.at;
            }
        }
        best
    }

    /// Casts the ray that passes the centre at `at` pixels.
    fn look(&self, at: DVec2) -> (Answer, Probe) {
        let place = self.centre + at;
        let ray = Ray {
            origin: self.eye,
            direction: self.rays.direction(place.x, place.y),
        };
        let sight = sandtable_cast::sight(self.ground, &ray);
        let agrees_in_depth = if sight.depth.is_finite() {
            let hit = sight.depth * ray.direction.normalize();
            (hit - self.found.depth * self.forward).length() <= self.tolerance
        } else {
            self.found.depth == sight.depth
        };
        let answer = match agrees_in_depth {
            false => Answer::Differs,
            true if is_close_colour(self.found.colour, sight.colour) => Answer::Agrees,
            true => Answer::AgreesInDepth,
        };
        // Sky against sky is no number, and is not searched between.
        let beyond = sight.depth - self.found.depth;
        (answer, Probe { at, beyond })
    }
}

/// By how many radians a ray turns for a pixel's step at least, whichever way the step goes.
fn slowest_turn(view: &View, direction: DVec3) -> f64 {
    let step = |side: DVec3, pixels: u32| {
        let step = side / f64::from(pixels);
        step.reject_from(direction) / direction.length()
    };
    let across = step(view.window.across(), view.size[0]);
    let upwards = step(view.window.upwards(), view.size[1]);
    // The smaller singular value of both steps: from the sum of the squares and the product.
    let squares = across.length_squared() + upwards.length_squared();
    let product = across.cross(upwards).length();
    let root = (squares * squares - 4.0 * product * product)
        .max(0.0)
        .sqrt();
    // The difference cancels; the product over the larger value does not.
    product / (0.5 * (squares + root)).sqrt()
}
