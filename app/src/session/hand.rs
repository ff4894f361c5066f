//! What the hand is at: it grabs the world, flies over it or points at it.

use super::{Session, Viewpoint};
use crate::navigation::{carried, hand_flight};
use crate::window::MouseDrive;
use glam::{DVec2, DVec3};
use sandtable_cast::pick;
use sandtable_config::Intent;
use sandtable_input::FlightAxes;
use sandtable_input::intent::IntentState;
use sandtable_pose::Rigid;
use sandtable_view::Ray;

/// What the intent `act` does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum HandMode {
    /// The world goes along with the hand.
    #[default]
    Grab,
    /// The hand flies by where it goes from where it began.
    Fly,
    /// The hand points at the ground.
    Point,
}

impl HandMode {
    fn next(self) -> Self {
        match self {
            Self::Grab => Self::Fly,
            Self::Fly => Self::Point,
            Self::Point => Self::Grab,
        }
    }

    /// What people call it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Grab => "grab",
            Self::Fly => "fly",
            Self::Point => "point",
        }
    }
}

/// What the hand is at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct HandWork {
    /// What the intent `act` does.
    pub(super) mode: HandMode,
    at: Option<Work>,
    /// The ground that was pointed at last, in world metres.
    pub(super) pointed: Option<DVec3>,
    /// Where the hand is beside the mouse's pointer, in table metres.
    beside_pointer: DVec2,
    /// Where the mouse's hand was when a button went down since the last step.
    pressed: Option<Rigid>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Work {
    mode: HandMode,
    /// Where it began; of a grabbing hand, where it was last.
    from: Rigid,
    /// Whether a sensor moved it. A hand that changes over to the mouse or back leaps.
    tracked: bool,
}

impl Session {
    /// Lets the mouse move head and hand where nothing tracks them.
    pub(super) fn move_bodies(&mut self, intents: &IntentState, mouse: &MouseDrive) {
        let Viewpoint::Table { screen, .. } = &self.viewpoint else {
            return;
        };
        let (across, upwards) = (screen.across(), screen.upwards());
        let per_height = upwards.length();
        let moved = mouse.moved * per_height;
        let moves_head = intents.holds(Intent::MoveHead);
        let moves_hand = intents.holds(Intent::MoveHand);
        if moves_head {
            let up = 0.02 * mouse.wheel;
            self.head.push(DVec3::new(moved.x, -moved.y, up));
        } else if moves_hand {
            self.hand.push(DVec3::new(0.0, 0.0, -moved.y));
            // As far as the window is high is half a turn.
            self.hand.turn(-mouse.moved.x * std::f64::consts::PI);
        }
        let Some(pointer) = mouse.pointer else {
            return;
        };
        // The hand hovers over the place on the glass that the mouse points to; beside it, while
        // it is at something that began there.
        let upper_left = screen.upper_left;
        let on_glass = |at: DVec2| upper_left + at.x * across - at.y * upwards;
        if let Some(at) = mouse.pressed_at.filter(|_| self.doing.at.is_none()) {
            let mut pressed = self.hand.clone();
            let height = pressed.table_from_body().translation.z;
            pressed.place(on_glass(at).with_z(height));
            self.doing.pressed = Some(pressed.table_from_body());
        }
        let on_glass = on_glass(pointer);
        let hand = self.hand.table_from_body().translation;
        if moves_head || moves_hand {
            self.doing.beside_pointer = (hand - on_glass).truncate();
            return;
        }
        if self.doing.at.is_none() {
            self.doing.beside_pointer = DVec2::ZERO;
        }
        let to = on_glass.truncate() + self.doing.beside_pointer;
        self.hand.place(to.extend(hand.z));
    }

    /// Does what the hand is asked for; gives how it flies.
    pub(super) fn work_the_hand(
        &mut self,
        intents: &IntentState,
        mouse: &MouseDrive,
    ) -> FlightAxes {
        let pressed = self.doing.pressed.take();
        if intents.begins(Intent::NextMode) {
            self.doing.mode = self.doing.mode.next();
        }
        let mode = [
            (Intent::Grab, HandMode::Grab),
            (Intent::Fly, HandMode::Fly),
            (Intent::Point, HandMode::Point),
            (Intent::Act, self.doing.mode),
        ];
        let mode = mode.into_iter().find(|(intent, _)| intents.holds(*intent));
        let Some((_, mode)) = mode else {
            self.doing.at = None;
            return FlightAxes::default();
        };
        let hand = self.hand.table_from_body();
        let tracked = self.hand.is_tracked();
        let at = |from| Work {
            mode,
            from,
            tracked,
        };
        let work = self
            .doing
            .at
            .filter(|work| (work.mode, work.tracked) == (mode, tracked));
        // A drag may have begun before this step.
        let began = pressed.filter(|_| !tracked).unwrap_or(hand);
        let work = work.unwrap_or(at(began));
        self.doing.at = Some(match mode {
            HandMode::Grab => at(hand),
            HandMode::Fly | HandMode::Point => work,
        });
        match (mode, &mut self.viewpoint) {
            (HandMode::Grab, Viewpoint::Table { flight, .. }) => {
                flight.placement = carried(&flight.placement, &work.from, &hand);
            }
            (
                HandMode::Grab,
                Viewpoint::Camera {
                    camera,
                    horizontal_fov,
                    ..
                },
            ) => {
                // Grabbing the picture takes it along: to the right turns left.
                let radians = *horizontal_fov / mouse.aspect();
                camera.turn(-mouse.moved.x * radians, mouse.moved.y * radians);
            }
            (HandMode::Fly, _) => return hand_flight(&work.from, &hand),
            (HandMode::Point, _) => {
                let ray = self.pointing(mouse);
                self.doing.pointed = ray.and_then(|ray| pick(self.ground(), &ray));
            }
        }
        FlightAxes::default()
    }

    /// Where the hand points, in the world: a tracked one along its own axis, the mouse's at what
    /// is seen under the pointer.
    fn pointing(&self, mouse: &MouseDrive) -> Option<Ray> {
        if let Some(placement) = self.placement().filter(|_| self.hand.is_tracked()) {
            let hand = self.hand.table_from_body();
            let forward = self.rig.hand.as_ref().map_or(DVec3::X, |hand| hand.forward);
            return Some(Ray {
                origin: placement.world_from_table(hand.translation),
                direction: placement.world_vector_from_table(hand.direction(forward)),
            });
        }
        let pointer = mouse.pointer?;
        let view = *self.views(mouse.picture, false).first()?;
        let at = pointer * DVec2::from(view.size.map(f64::from));
        Some(Ray {
            origin: view.eye,
            direction: view.direction(at.x, at.y),
        })
    }
}
