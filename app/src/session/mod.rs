//! A session: a rig, a terrain, and where on it people are.
//!
//! Everything it shows follows from its own state and a time, so that a replay on a virtual clock
//! shows what the live session showed.

mod body;
mod casting;
mod drive;
mod hand;
mod sound;

pub(crate) use body::Body;
pub(crate) use sound::summit;

use crate::navigation::{FlyCamera, Pace, TableFlight};
use crate::scene::{ChosenCaster, OpenScene};
use crate::vantage;
use anyhow::Result;
use casting::Casting;
use glam::{DVec2, DVec3};
use hand::HandWork;
use sandtable_cast::{CastPool, PreparedScene};
use sandtable_config::{Rig, Viewing};
use sandtable_input::Hub;
use sandtable_input::intent::{DeskState, IntentMapper, IntentState};
use sandtable_pose::Nanos;
use sandtable_terrain::Ground;
use sandtable_view::{EyesInHead, Placement, Screen, Stereo, StereoPair, View};
use std::sync::Arc;

/// Where people look from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Viewpoint {
    /// A camera that flies.
    Camera {
        /// Where it is.
        camera: FlyCamera,
        /// Field of view in radians.
        horizontal_fov: f64,
        /// Its eyes, in world metres.
        stereo: Stereo,
    },
    /// Eyes at a table on which the world lies.
    Table {
        /// The glass, in table metres.
        screen: Screen,
        /// How the world lies on it.
        flight: TableFlight,
        /// Where the eyes sit on the head.
        eyes: EyesInHead,
    },
}

/// A rig, a terrain, and where on it people are.
pub(crate) struct Session {
    rig: Rig,
    terrain: String,
    casting: Casting,
    pool: Arc<CastPool>,
    viewpoint: Viewpoint,
    home: Viewpoint,
    head: Body,
    hand: Body,
    hub: Arc<Hub>,
    intents: IntentMapper,
    doing: HandWork,
    /// World metres a second, for the wind.
    airspeed: f64,
    messages: Vec<String>,
}

impl Session {
    /// Opens `rig` on a terrain, the world fitted to the glass or seen from an overview.
    pub(crate) fn new(
        rig: Rig,
        open: &OpenScene,
        caster: &ChosenCaster,
        pool: Arc<CastPool>,
        hub: Arc<Hub>,
    ) -> Result<Self> {
        let ground = &open.scene.ground;
        let viewpoint = viewpoint(&rig, ground);
        let casting = Casting::new(caster, &open.scene, &pool)?;
        let head = rig.head.as_ref().map_or_else(Body::default, |head| {
            Body::new(head.sensor.clone(), head.rest)
        });
        let hand = rig.hand.as_ref().map_or_else(Body::default, |hand| {
            Body::new(hand.sensor.clone(), hand.rest)
        });
        Ok(Self {
            terrain: open.name.clone(),
            casting,
            pool,
            home: viewpoint.clone(),
            viewpoint,
            head,
            hand,
            hub,
            intents: IntentMapper::new(&rig),
            doing: HandWork::default(),
            airspeed: 0.0,
            messages: Vec::new(),
            rig,
        })
    }

    /// The ground in view.
    pub(crate) fn ground(&self) -> &Ground {
        &self.casting.prepared().scene().ground
    }

    /// The scene, prepared by the caster in use.
    pub(crate) fn prepared(&self) -> &Arc<dyn PreparedScene> {
        self.casting.prepared()
    }

    /// The rig it runs on.
    pub(crate) fn rig(&self) -> &Rig {
        &self.rig
    }

    /// What people call the terrain.
    pub(crate) fn terrain(&self) -> &str {
        &self.terrain
    }

    /// Where head and hand are looked up.
    pub(crate) fn hub(&self) -> &Arc<Hub> {
        &self.hub
    }

    /// Head and hand.
    pub(crate) fn bodies(&self) -> [&Body; 2] {
        [&self.head, &self.hand]
    }

    /// Head and hand, to be moved.
    pub(crate) fn bodies_mut(&mut self) -> [&mut Body; 2] {
        [&mut self.head, &mut self.hand]
    }

    /// Where people look from.
    pub(crate) fn viewpoint(&self) -> &Viewpoint {
        &self.viewpoint
    }

    /// Where people look from, to be moved.
    pub(crate) fn viewpoint_mut(&mut self) -> &mut Viewpoint {
        &mut self.viewpoint
    }

    /// How the world lies on the table, where there is one.
    pub(crate) fn placement(&self) -> Option<Placement> {
        match &self.viewpoint {
            Viewpoint::Camera { .. } => None,
            Viewpoint::Table { flight, .. } => Some(flight.placement),
        }
    }

    /// Lays the world on the table as it was recorded.
    pub(crate) fn set_placement(&mut self, recorded: Placement) {
        if let Viewpoint::Table { flight, .. } = &mut self.viewpoint {
            flight.placement = recorded;
        }
    }

    /// Goes on with `rig` in place of its own, which was calibrated; the world stays where it lies,
    /// and nothing is known of the devices yet.
    pub(crate) fn adopt(&mut self, rig: Rig) {
        let sensors = [
            rig.head.as_ref().and_then(|head| head.sensor.clone()),
            rig.hand.as_ref().and_then(|hand| hand.sensor.clone()),
        ];
        for (body, sensor) in [&mut self.head, &mut self.hand].into_iter().zip(sensors) {
            *body = Body::new(sensor, body.table_from_body());
        }
        if let (Viewpoint::Table { eyes, .. }, Some(head)) = (&mut self.viewpoint, &rig.head) {
            *eyes = eyes_of(head);
        }
        if let (Viewpoint::Table { eyes, .. }, Some(head)) = (&mut self.home, &rig.head) {
            *eyes = eyes_of(head);
        }
        self.hub = Arc::new(Hub::for_rig(&rig));
        self.intents = IntentMapper::new(&rig);
        self.rig = rig;
    }

    /// Where a place of the table is on the glass, from (0, 0) at its upper left to (1, 1) at its
    /// lower right corner, and how far above it; both by the glass's perpendicular.
    pub(crate) fn on_glass(&self, place: DVec3) -> Option<(DVec2, f64)> {
        let Viewpoint::Table { screen, .. } = &self.viewpoint else {
            return None;
        };
        let (across, upwards) = (screen.across(), screen.upwards());
        let from = place - screen.upper_left;
        let share = |side: DVec3| from.dot(side) / side.length_squared();
        let above = from.dot(across.cross(upwards).normalize());
        Some((DVec2::new(share(across), -share(upwards)), above))
    }

    /// Takes in where head and hand are at `time`; what people mean then by their devices, and by
    /// what is pressed at the desk.
    pub(crate) fn take_in(&mut self, time: Nanos, desk: &DeskState) -> IntentState {
        let intents = self.intents.update(time, &self.hub, desk);
        self.head.follow(intents.look);
        self.hand.follow(intents.reach);
        intents
    }

    /// The views for eye images of `size` pixels: one, or a left and a right eye's.
    pub(crate) fn views(&self, size: [u32; 2], stereo: bool) -> Vec<View> {
        match &self.viewpoint {
            Viewpoint::Camera {
                camera,
                horizontal_fov,
                stereo: eyes,
            } => {
                let camera = sandtable_view::Camera {
                    eye: camera.eye,
                    attitude: camera.attitude,
                    horizontal_fov: *horizontal_fov,
                };
                if stereo {
                    camera.stereo_views(*eyes, size).into_array().to_vec()
                } else {
                    vec![camera.view(size)]
                }
            }
            Viewpoint::Table {
                screen,
                flight,
                eyes,
            } => {
                let table_from_head = self.head.table_from_body();
                let pair = |eyes| StereoPair::on_table(eyes, screen, &flight.placement, size);
                if stereo {
                    pair(eyes.on_table(&table_from_head)).into_array().to_vec()
                } else {
                    let middle = table_from_head.point(eyes.middle);
                    vec![
                        pair(StereoPair {
                            left: middle,
                            right: middle,
                        })
                        .left,
                    ]
                }
            }
        }
    }

    /// Casts by another caster as soon as it is prepared.
    pub(crate) fn change_caster(&mut self, caster: ChosenCaster) {
        if let Err(error) = self.casting.change(caster, &self.pool) {
            self.say(format!("{error:#}"));
        }
    }

    /// Takes a caster that has been prepared into use; whether another is still being prepared.
    pub(crate) fn settle_caster(&mut self) -> bool {
        if let Err(error) = self.casting.settle() {
            self.say(format!("{error:#}"));
        }
        self.casting.is_changing()
    }

    /// How fast the flight is, in world metres a second, where it is not driven.
    pub(crate) fn set_airspeed(&mut self, metres_per_second: f64) {
        self.airspeed = metres_per_second;
    }

    /// Moves an untracked head once round its rest, `share` from 0 to 1: from side to side, and
    /// over the glass.
    pub(crate) fn sway(&mut self, share: f64) {
        let rest = self.rig.head.as_ref().map(|head| head.rest.translation);
        if let Some(rest) = rest {
            let (s, c) = (share * std::f64::consts::TAU).sin_cos();
            self.head
                .place(rest + DVec3::new(0.35 * s, 0.15 * (1.0 - c), 0.06 * (1.0 - c)));
        }
    }

    /// Something that people should know, shown in the panel.
    pub(crate) fn say(&mut self, message: impl Into<String>) {
        const KEPT: usize = 6;
        self.messages.push(message.into());
        let surplus = self.messages.len().saturating_sub(KEPT);
        self.messages.drain(..surplus);
    }
}

fn eyes_of(head: &sandtable_config::Head) -> EyesInHead {
    EyesInHead {
        middle: head.eyes.middle,
        rightwards: head.eyes.rightwards,
        interpupillary: head.eyes.interpupillary,
    }
}

/// Where a rig's people begin over `ground`.
fn viewpoint(rig: &Rig, ground: &Ground) -> Viewpoint {
    let extent = ground.grid().extent();
    let longer_side = extent.max_element();
    match &rig.viewing {
        Viewing::Desktop(desktop) => {
            let horizontal_fov = desktop.horizontal_fov.to_radians();
            let overview = vantage::overview(ground, horizontal_fov);
            let screen_distance = desktop.screen_distance.of(longer_side);
            Viewpoint::Camera {
                camera: FlyCamera {
                    eye: overview.eye,
                    attitude: overview.attitude,
                    pace: Pace::Constant(rig.flight.speed.of(longer_side)),
                    turn_rate: rig.flight.turn_rate.to_radians(),
                },
                horizontal_fov,
                stereo: Stereo {
                    separation: desktop.eye_separation.of(screen_distance),
                    screen_distance,
                },
            }
        }
        Viewing::Table(table) => {
            let screen = Screen {
                lower_left: table.lower_left,
                lower_right: table.lower_right,
                upper_left: table.upper_left,
            };
            let heights = ground.range().map(f64::from);
            let placement =
                Placement::fitted(extent, heights, &screen, table.margin, table.exaggeration);
            let speed = rig.flight.speed.of(longer_side) / placement.scale;
            // A table always has a head: rigs without one are refused when they are read.
            let eyes = rig.head.as_ref().map_or(
                EyesInHead {
                    middle: DVec3::ZERO,
                    rightwards: DVec3::X,
                    interpupillary: 0.0,
                },
                eyes_of,
            );
            Viewpoint::Table {
                screen,
                flight: TableFlight {
                    placement,
                    speed,
                    turn_rate: rig.flight.turn_rate.to_radians(),
                },
                eyes,
            }
        }
    }
}
