//! A head at a table: it stops, sways, leans over, looks about and comes back.

use crate::noise::Noise;
use glam::{DQuat, DVec3, EulerRot};
use sandtable_pose::Rigid;
use std::f64::consts::{PI, TAU};

/// Where a head is at any time, in the table's frame.
pub(crate) struct HeadPath {
    pieces: Vec<Piece>,
}

/// Place in metres, then yaw, pitch and roll in radians.
type Six = [f64; 6];

/// A part of the path, from one standstill to the next.
struct Piece {
    start: f64,
    seconds: f64,
    from: Six,
    motion: Motion,
}

enum Motion {
    /// Stands still.
    Stop,
    /// Goes there with the least jerk (Flash and Hogan 1985).
    Reach(Six),
    /// Swings so far to either side, so often a second, swelling and ebbing.
    Sway { far: Six, hertz: f64 },
}

/// Where the head comes back to: above the user's edge, looking down at the glass.
const REST: Six = [0.0, -0.9, 0.6, 0.0, -0.6, 0.0];

impl HeadPath {
    /// A path of at least so many seconds.
    pub(crate) fn new(seed: u64, length: f64) -> Self {
        let mut random = Noise::new(seed);
        let mut path = Self { pieces: Vec::new() };
        let (mut start, mut from) = (0.0, REST);
        for kind in (0..5).cycle() {
            let (seconds, motion) = match kind {
                0 => (random.between(1.0, 2.0), Motion::Stop),
                1 => (random.between(3.0, 5.0), sway(&mut random)),
                2 => (random.between(0.7, 1.5), lean(&mut random)),
                3 => (random.between(0.35, 0.8), glance(&mut random, from)),
                _ => (random.between(0.6, 1.2), Motion::Reach(REST)),
            };
            let to = match motion {
                Motion::Reach(to) => to,
                Motion::Stop | Motion::Sway { .. } => from,
            };
            path.pieces.push(Piece {
                start,
                seconds,
                from,
                motion,
            });
            (start, from) = (start + seconds, to);
            if start >= length {
                break;
            }
        }
        path
    }

    /// The pose at a time in seconds; after the path's end, that of its end.
    pub(crate) fn at(&self, seconds: f64) -> Rigid {
        let piece = self.pieces.partition_point(|piece| piece.start <= seconds);
        let [x, y, z, yaw, pitch, roll] = self.pieces[piece.saturating_sub(1)].at(seconds);
        let turn = DQuat::from_euler(EulerRot::ZXY, yaw, pitch, roll);
        Rigid::new(turn, DVec3::new(x, y, z))
    }
}

impl Piece {
    fn at(&self, seconds: f64) -> Six {
        let done = ((seconds - self.start) / self.seconds).clamp(0.0, 1.0);
        match &self.motion {
            Motion::Stop => self.from,
            Motion::Reach(to) => {
                let share = done.powi(3) * (10.0 - 15.0 * done + 6.0 * done * done);
                std::array::from_fn(|i| self.from[i] + share * (to[i] - self.from[i]))
            }
            Motion::Sway { far, hertz } => {
                let swing = (PI * done).sin().powi(2) * (TAU * hertz * done * self.seconds).sin();
                std::array::from_fn(|i| self.from[i] + swing * far[i])
            }
        }
    }
}

fn sway(random: &mut Noise) -> Motion {
    let mut up_to = |most: f64| random.between(-most, most);
    let far = [
        up_to(0.12),
        up_to(0.04),
        up_to(0.03),
        up_to(0.2),
        up_to(0.1),
        up_to(0.15),
    ];
    Motion::Sway {
        far,
        hertz: random.between(0.4, 1.0),
    }
}

fn lean(random: &mut Noise) -> Motion {
    Motion::Reach([
        random.between(-0.4, 0.4),
        random.between(-0.8, -0.4),
        random.between(0.45, 0.7),
        random.between(-0.5, 0.5),
        random.between(-0.9, -0.4),
        random.between(-0.2, 0.2),
    ])
}

/// A quick turn to one side, with the little way that the head's middle goes.
fn glance(random: &mut Noise, from: Six) -> Motion {
    let [x, y, z, yaw, pitch, roll] = from;
    let turn = random.between(0.5, 1.0) * if yaw > 0.0 { -1.0 } else { 1.0 };
    Motion::Reach([
        x - 0.08 * turn,
        y,
        z,
        yaw + turn,
        pitch + random.between(-0.2, 0.2),
        roll,
    ])
}
