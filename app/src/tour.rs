//! A short flight over any terrain, for machines without a display and for films of the program.

use crate::session::{Session, Viewpoint};
use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;
use sandtable_view::Attitude;
use std::f64::consts::TAU;

/// How far ahead the camera looks, as a share of the round.
const AHEAD: f64 = 0.04;

/// A round over the terrain at a steady height above its relief.
pub(crate) struct Tour {
    centre: DVec2,
    radii: DVec2,
    /// Heights above the relief along the round, evenly spaced, smoothed.
    heights: Vec<f64>,
}

impl Tour {
    /// Plans the round over `ground`.
    pub(crate) fn over(ground: &Ground) -> Self {
        const STATIONS: usize = 128;
        let extent = ground.grid().extent();
        let (centre, radii) = (0.5 * extent, 0.36 * extent);
        let [low, high] = ground.range().map(f64::from);
        let clearance = 0.02 * extent.min_element() + 0.25 * (high - low);
        let place = |station: usize| {
            let angle = TAU * station as f64 / STATIONS as f64;
            centre + radii * DVec2::new(angle.cos(), angle.sin())
        };
        let relief: Vec<f64> = (0..STATIONS)
            .map(place)
            .map(|at| ground.height_at(at.x, at.y).unwrap_or(low))
            .collect();
        // Over the highest of the neighbouring stations, then averaged: it rises before a ridge.
        let around = |values: &[f64], station: usize, reach: usize| -> Vec<f64> {
            (0..=2 * reach)
                .map(|step| values[(station + STATIONS + step - reach) % STATIONS])
                .collect()
        };
        let highest: Vec<f64> = (0..STATIONS)
            .map(|station| around(&relief, station, 6).into_iter().fold(low, f64::max))
            .collect();
        let heights = (0..STATIONS)
            .map(|station| {
                let near = around(&highest, station, 8);
                near.iter().sum::<f64>() / near.len() as f64 + clearance
            })
            .collect();
        Self {
            centre,
            radii,
            heights,
        }
    }

    /// The place at `share` of the round.
    fn place(&self, share: f64) -> DVec3 {
        // Clockwise seen from above, from the south.
        let angle = -TAU * (share + 0.25);
        let on_ground = self.centre + self.radii * DVec2::new(angle.cos(), angle.sin());
        let station = (angle / TAU).rem_euclid(1.0) * self.heights.len() as f64;
        let (first, mix) = (station as usize % self.heights.len(), station.fract());
        let next = (first + 1) % self.heights.len();
        on_ground.extend(self.heights[first] * (1.0 - mix) + self.heights[next] * mix)
    }

    /// Eye and attitude at `share` of the round: looking ahead and down, banked into the turn.
    fn pose(&self, share: f64) -> (DVec3, Attitude) {
        let (eye, ahead) = (self.place(share), self.place(share + AHEAD));
        let beyond = self.place(share + 2.0 * AHEAD);
        let heading = |from: DVec3, to: DVec3| (to.x - from.x).atan2(to.y - from.y);
        let yaw = heading(eye, ahead);
        let turn = (heading(ahead, beyond) - yaw + 1.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
        let climb = (ahead.z - eye.z).atan2(ahead.truncate().distance(eye.truncate()));
        let pitch = 0.5 * climb - 12f64.to_radians();
        (
            eye,
            Attitude {
                yaw: yaw + 0.5 * turn,
                pitch,
                roll: 0.35 * turn,
            },
        )
    }

    /// Puts `session` where the tour is at `share` of the round: a camera flies it; at a table,
    /// where nothing may move the picture but heads, the head sways and leans in.
    pub(crate) fn guide(&self, session: &mut Session, share: f64, seconds: f64) {
        let pose = self.pose(share);
        match session.viewpoint_mut() {
            Viewpoint::Camera { camera, .. } => {
                let way = pose.0.distance(camera.eye);
                (camera.eye, camera.attitude) = pose;
                let speed = if seconds > 0.0 { way / seconds } else { 0.0 };
                session.set_airspeed(speed);
            }
            Viewpoint::Table { .. } => session.sway(share),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hills() -> Ground {
        Ground::from_fn(200, 150, DVec2::splat(30.0), |col, row| {
            (300.0 * (f64::from(col) * 0.1).sin() * (f64::from(row) * 0.07).cos()) as f32
        })
        .unwrap()
    }

    #[test]
    fn the_round_stays_over_the_ground_and_closes() {
        let ground = hills();
        let tour = Tour::over(&ground);
        for step in 0..500 {
            let at = tour.place(f64::from(step) / 500.0);
            let height = ground.height_at(at.x, at.y).expect("within the terrain");
            assert!(
                at.z > height + 10.0,
                "{} m above ground at {step}",
                at.z - height
            );
        }
        assert!(tour.place(0.0).distance(tour.place(1.0)) < 1e-6);
    }

    #[test]
    fn the_camera_looks_where_it_flies_and_banks_into_the_turn() {
        let tour = Tour::over(&hills());
        for step in 0..100 {
            let share = f64::from(step) / 100.0;
            let (eye, attitude) = tour.pose(share);
            let way = (tour.place(share + 1e-3) - eye).truncate().normalize();
            let [_, _, forward] = attitude.axes();
            assert!(forward.truncate().normalize().dot(way) > 0.9);
            // Clockwise is to the right: the right wing is down.
            assert!(attitude.roll > 0.0 && attitude.pitch < 0.2);
        }
    }
}
