//! A session driven by people: what their hands ask for, and what the panel says.

use super::{Session, Viewpoint};
use crate::navigation::Pace;
use crate::scene;
use crate::window::{Device, Drive, Readings, TableReadings, Wish};
use glam::DVec3;
use sandtable_view::{Attitude, Placement};
use std::sync::Arc;
use std::time::Duration;

impl Session {
    /// Flies for `step` as `drive` asks; whether anything moved.
    pub(crate) fn drive(&mut self, drive: &Drive, step: Duration) -> bool {
        let seconds = step.as_secs_f64();
        let before = (self.viewpoint.clone(), self.head.table_from_body());
        let start = self.position();
        let ground = Arc::clone(&self.casting.prepared().scene().ground);
        match &mut self.viewpoint {
            Viewpoint::Camera {
                camera,
                horizontal_fov,
                ..
            } => {
                let height = height_above(&ground, camera.eye);
                camera.pace = camera.pace.faster(drive.mouse.wheel);
                let speed = camera.pace.speed(height) * drive.boost;
                camera.advance(&drive.axes, speed, seconds);
                // A drag takes the picture along: dragging right turns left.
                let radians = *horizontal_fov;
                camera.turn(-drive.mouse.drag.x * radians, drive.mouse.drag.y * radians);
                let [right, up, _] = camera.attitude.axes();
                let reach = speed * 0.5;
                camera.eye +=
                    reach * (drive.mouse.other_drag.y * up - drive.mouse.other_drag.x * right);
            }
            Viewpoint::Table { screen, flight, .. } => {
                flight.advance(&drive.axes, drive.boost, seconds);
                let (across, upwards) = (screen.across(), screen.upwards());
                // The main button grabs the world; the other moves the head, as nothing tracks it.
                let per_height = upwards.length();
                let drag = drive.mouse.drag * per_height;
                flight.drag(drag.x * across.normalize() - drag.y * upwards.normalize());
                let head = drive.mouse.other_drag * per_height;
                self.head.push(DVec3::new(head.x, -head.y, 0.0));
                if drive.mouse.wheel != 0.0 {
                    if drive.mouse.buttons[1] {
                        self.head
                            .push(DVec3::new(0.0, 0.0, 0.02 * drive.mouse.wheel));
                    } else {
                        let placement = flight.placement;
                        let scale = placement.scale * 1.1f64.powf(-drive.mouse.wheel);
                        flight.set_scale(scale, placement.exaggeration);
                    }
                }
                if let Some(pointer) = drive.mouse.pointer {
                    // The hand hovers over the place on the glass that the mouse points to.
                    let on_glass = screen.upper_left + pointer.x * across - pointer.y * upwards;
                    let height = self.hand.table_from_body().translation.z;
                    self.hand.place(on_glass.with_z(height));
                }
            }
        }
        self.airspeed = match step.is_zero() {
            true => 0.0,
            false => self.position().distance(start) / seconds,
        };
        before != (self.viewpoint.clone(), self.head.table_from_body())
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
            // A camera has no table, and what is not a number is no wish.
            (Wish::Position(_) | Wish::Table(_), _) => {}
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
            devices: self.device_lines(),
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
