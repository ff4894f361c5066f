//! A session driven by people: what their hands ask for, and what the panel says.

use super::hand::HandWork;
use super::{Session, Viewpoint};
use crate::navigation::Pace;
use crate::scene;
use crate::window::{Device, HandReadings, MouseDrive, Readings, TableReadings, Wish};
use glam::DVec3;
use sandtable_config::Intent;
use sandtable_input::intent::IntentState;
use sandtable_pose::Rigid;
use sandtable_view::{Attitude, Placement};
use std::sync::Arc;
use std::time::Duration;

/// How many times as fast the intent `faster` makes a flight.
const BOOST: f64 = 5.0;

impl Session {
    /// Goes on for `step` as people mean it; whether anything moved.
    pub(crate) fn drive(
        &mut self,
        intents: &IntentState,
        mouse: &MouseDrive,
        step: Duration,
    ) -> bool {
        let seconds = step.as_secs_f64();
        let before = self.moved();
        let start = self.position();
        self.move_bodies(intents, mouse);
        let axes = intents.flight.combined(self.work_the_hand(intents, mouse));
        let boost = match intents.holds(Intent::Faster) {
            true => BOOST,
            false => 1.0,
        };
        let moves_head = intents.holds(Intent::MoveHead);
        let ground = Arc::clone(&self.casting.prepared().scene().ground);
        match &mut self.viewpoint {
            Viewpoint::Camera { camera, .. } => {
                let height = height_above(&ground, camera.eye);
                camera.pace = camera.pace.faster(mouse.wheel);
                let speed = camera.pace.speed(height) * boost;
                camera.advance(&axes, speed, seconds);
                if moves_head {
                    let [right, up, _] = camera.attitude.axes();
                    let reach = speed * 0.5;
                    camera.eye += reach * (mouse.moved.y * up - mouse.moved.x * right);
                }
            }
            Viewpoint::Table { flight, .. } => {
                flight.advance(&axes, boost, seconds);
                if !moves_head {
                    let Placement {
                        scale,
                        exaggeration,
                        ..
                    } = flight.placement;
                    flight.set_scale(scale * 1.1f64.powf(-mouse.wheel), exaggeration);
                }
            }
        }
        self.airspeed = match step.is_zero() {
            true => 0.0,
            false => self.position().distance(start) / seconds,
        };
        before != self.moved()
    }

    /// What tells whether anything moved that people would see.
    fn moved(&self) -> (Viewpoint, Rigid, HandWork) {
        let head = self.head.table_from_body();
        (self.viewpoint.clone(), head, self.doing)
    }

    /// Does what people asked for at the panel or by a key.
    pub(crate) fn apply(&mut self, wish: Wish) {
        match (wish, &mut self.viewpoint) {
            (Wish::Home, viewpoint) => *viewpoint = self.home.clone(),
            (Wish::Position(at), Viewpoint::Camera { camera, .. }) if at.is_finite() => {
                camera.eye = at;
            }
            (Wish::Position(at), Viewpoint::Table { flight, .. }) if at.is_finite() => {
                flight.placement.anchor = at;
            }
            (Wish::Attitude(attitude), Viewpoint::Camera { camera, .. }) => {
                camera.set_attitude(attitude);
            }
            (Wish::Attitude(attitude), Viewpoint::Table { flight, .. }) => {
                if attitude.yaw.is_finite() {
                    flight.placement.yaw = attitude.yaw.rem_euclid(std::f64::consts::TAU);
                }
            }
            (Wish::Speed(speed), Viewpoint::Camera { camera, .. }) => {
                if speed.is_finite() && speed > 0.0 {
                    camera.pace = Pace::Constant(speed);
                }
            }
            (Wish::Speed(speed), Viewpoint::Table { flight, .. }) => {
                if speed.is_finite() && speed > 0.0 {
                    flight.speed = speed / flight.placement.scale;
                }
            }
            (Wish::Table(table), Viewpoint::Table { flight, .. }) => {
                flight.set_scale(table.scale, table.exaggeration);
            }
            (Wish::Caster(name), _) => match scene::caster(name) {
                Ok(caster) => self.change_caster(caster),
                Err(error) => self.say(format!("{error:#}")),
            },
            // A camera has no table, and what is not a number is no wish; a calibration is not the
            // session's own.
            (Wish::Position(_) | Wish::Table(_) | Wish::Guide(_), _) => {}
        }
    }

    /// What the panel says.
    pub(crate) fn readings(&self) -> Readings {
        let position = self.position();
        let (attitude, speed, table) = match &self.viewpoint {
            Viewpoint::Camera { camera, .. } => {
                let height = height_above(self.ground(), position);
                (camera.attitude, camera.pace.speed(height), None)
            }
            Viewpoint::Table { flight, .. } => {
                let Placement {
                    yaw,
                    scale,
                    exaggeration,
                    ..
                } = flight.placement;
                let attitude = Attitude {
                    yaw,
                    ..Attitude::default()
                };
                (
                    attitude,
                    flight.speed * scale,
                    Some(TableReadings {
                        scale,
                        exaggeration,
                    }),
                )
            }
        };
        Readings {
            terrain: self.terrain.clone(),
            position,
            // The middle of a glass is a place on the table, not one that flies.
            above_ground: table
                .is_none()
                .then(|| height_above(self.ground(), position))
                .flatten(),
            attitude,
            speed,
            table,
            caster: self.casting.name().to_owned(),
            hand: HandReadings {
                mode: self.doing.mode.name(),
                pointed: self.doing.pointed,
            },
            devices: self.device_lines(),
            guide: None,
            can_calibrate: false,
            messages: self.messages.clone(),
        }
    }

    /// The world point that stands for where people are: the camera, or the glass's centre.
    fn position(&self) -> DVec3 {
        match &self.viewpoint {
            Viewpoint::Camera { camera, .. } => camera.eye,
            Viewpoint::Table { flight, .. } => flight.placement.anchor,
        }
    }

    fn device_lines(&self) -> Vec<Device> {
        let bodies = [
            ("head", &self.head, self.rig.head.is_some()),
            ("hand", &self.hand, self.rig.hand.is_some()),
        ];
        let bodies = bodies
            .into_iter()
            .filter(|(.., there)| *there)
            .map(|(name, body, _)| {
                let (state, works) = body.state();
                Device {
                    name: name.into(),
                    state,
                    works,
                }
            });
        bodies.collect()
    }
}

/// Metres above the ground below, if there is ground.
fn height_above(ground: &sandtable_terrain::Ground, at: DVec3) -> Option<f64> {
    ground.height_at(at.x, at.y).map(|height| at.z - height)
}
