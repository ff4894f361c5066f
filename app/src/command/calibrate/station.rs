//! The sensor that measures, live: its poses while it is held still, and while it moves.

use super::dialogue::Dialogue;
use anyhow::{Result, bail};
use glam::{DQuat, DVec3};
use sandtable_config::{Rig, SensorName};
use sandtable_input::{Clock, Condition, Devices, Hub};
use sandtable_pose::{Nanos, Pose, Rigid, Validity};
use std::sync::Arc;
use std::time::Duration;

/// How often the hub is asked: each pose of the fastest tracker is seen.
const PERIOD: Duration = Duration::from_millis(2);

/// How long a still sensor is averaged.
const STILL: Duration = Duration::from_millis(500);

/// The fewest poses that are averaged; slow lines take longer than [`STILL`] for them.
const LEAST: usize = 8;

/// The longest that a slow line is listened to.
const LONGEST: Duration = Duration::from_secs(10);

/// How long a device may take to start, auto-configuration and silences counted in.
const START: Duration = Duration::from_secs(20);

/// A device that waits, for a port say, is given up after this.
const WAITING: Duration = Duration::from_secs(4);

/// One sensor of a rig, and whoever moves it.
pub(super) struct Station {
    hub: Arc<Hub>,
    clock: Clock,
    devices: Devices,
    sensor: SensorName,
    pub(super) dialogue: Dialogue,
}

/// How far a sensor that is held still may move meanwhile.
#[derive(Clone, Copy)]
pub(super) struct Steadiness {
    /// In metres.
    pub(super) metres: f64,
    /// In radians.
    pub(super) radians: f64,
}

impl Steadiness {
    /// Of a tip on a mark, which may turn about itself.
    pub(super) const TIP: Self = Self {
        metres: 2e-3,
        radians: f64::INFINITY,
    };
    /// Of a head, which nobody holds as still as a hand on a table.
    pub(super) const HEAD: Self = Self {
        metres: 5e-3,
        radians: 2.0 * std::f64::consts::PI / 180.0,
    };
}

/// A sensor as it was while it was held still.
#[derive(Clone)]
pub(super) struct Still {
    /// Its mean pose.
    pub(super) pose: Rigid,
    /// The mean place of the point that was watched, in the frame of the poses.
    pub(super) point: DVec3,
}

/// Why a pose cannot be used.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unusable {
    #[error("{sensor} has said nothing yet{why}")]
    Silent { sensor: SensorName, why: String },
    #[error("{sensor} is not live: its last pose came {seconds:.1} s ago{why}")]
    Lost {
        sensor: SensorName,
        seconds: f64,
        why: String,
    },
    #[error(
        "{sensor} is not live: it repeats itself to the bit, as a frozen one does; switch it off and on"
    )]
    Frozen { sensor: SensorName },
    #[error("{sensor} gave too few poses; see that its line is fast enough")]
    TooFew { sensor: SensorName },
    #[error(
        "{sensor} moved by {millimetres:.1} mm, where {limit_mm:.0} mm are allowed; hold it still"
    )]
    Moved {
        sensor: SensorName,
        millimetres: f64,
        limit_mm: f64,
    },
    #[error(
        "{sensor} turned by {degrees:.1} degrees, where {limit_degrees:.0} are allowed; hold it still"
    )]
    Turned {
        sensor: SensorName,
        degrees: f64,
        limit_degrees: f64,
    },
}

impl Station {
    /// Starts the sensor's device and waits until the sensor is live.
    pub(super) fn start(rig: &Rig, sensor: &SensorName, dialogue: Dialogue) -> Result<Self> {
        // Other devices have no part in it, and may be away.
        let mut rig = rig.clone();
        rig.devices.retain(|name, _| *name == sensor.device);
        let hub = Arc::new(Hub::for_rig(&rig));
        let clock = Clock::start();
        let devices = Devices::start(&rig, &hub, clock, None)?;
        let station = Self {
            hub,
            clock,
            devices,
            sensor: sensor.clone(),
            dialogue,
        };
        station.wait_until_live()?;
        Ok(station)
    }

    fn wait_until_live(&self) -> Result<()> {
        self.dialogue
            .remark(format_args!("{}: starting", self.sensor.device));
        let begun = self.clock.now();
        let mut waiting_since = None;
        loop {
            self.dialogue.pause(10 * PERIOD)?;
            let now = self.clock.now();
            let Err(problem) = self.live_at(now) else {
                self.dialogue
                    .remark(format_args!("{} is live", self.sensor));
                return Ok(());
            };
            match self.waits_for() {
                Some(_) => {
                    // Why it waits the driver has logged.
                    if now.since(*waiting_since.get_or_insert(now)) > WAITING {
                        bail!(
                            "nothing comes from {}: its device is not there, for the reason above",
                            self.sensor
                        );
                    }
                }
                None => waiting_since = None,
            }
            if now.since(begun) > START {
                bail!("{problem}");
            }
        }
    }

    /// Ends the device's stream and closes its port.
    pub(super) fn stop(self) {
        self.devices.stop();
    }

    /// Averages half a second of live poses from now on, and watches `point`, in the sensor's axes
    /// and metres, meanwhile.
    pub(super) fn still(
        &self,
        point: DVec3,
        steadiness: Steadiness,
    ) -> Result<Result<Still, Unusable>> {
        let begun = self.clock.now();
        let mut poses: Vec<Pose> = Vec::new();
        loop {
            self.dialogue.pause(PERIOD)?;
            let now = self.clock.now();
            let pose = match self.live_at(now) {
                Ok(pose) => pose,
                Err(problem) => return Ok(Err(problem)),
            };
            let newest = poses.last().map_or(begun, |pose| pose.time);
            if pose.time > newest {
                poses.push(pose);
            }
            let lasting = now.since(begun);
            if lasting >= STILL && poses.len() >= LEAST {
                break;
            }
            if lasting >= LONGEST {
                return Ok(Err(Unusable::TooFew {
                    sensor: self.sensor.clone(),
                }));
            }
        }
        let poses: Vec<Rigid> = poses.iter().map(|pose| pose.frame_from_body).collect();
        Ok(self.steady(&poses, point, steadiness))
    }

    /// All live poses from now on, until a line is entered or `lasting` is over; and whether some
    /// were missing between them.
    pub(super) fn moving(&self, lasting: Duration) -> Result<(Vec<Rigid>, Option<Unusable>)> {
        let begun = self.clock.now();
        let mut newest = begun;
        let (mut poses, mut problem) = (Vec::new(), None);
        while self.clock.now().since(begun) < lasting && !self.dialogue.has_entered() {
            self.dialogue.pause(PERIOD)?;
            match self.live_at(self.clock.now()) {
                Ok(pose) if pose.time > newest => {
                    newest = pose.time;
                    poses.push(pose.frame_from_body);
                }
                Ok(_) => {}
                Err(error) => problem = Some(error),
            }
        }
        Ok((poses, problem))
    }

    /// The newest pose. One that is held for a moment counts as live: it was measured, and the next
    /// one follows or it is lost.
    fn live_at(&self, now: Nanos) -> Result<Pose, Unusable> {
        let sensor = || self.sensor.clone();
        let why = || {
            self.waits_for()
                .map_or_else(String::new, |why| format!(": {why}"))
        };
        let Some(pose) = self.hub.pose_at(&self.sensor, now) else {
            return Err(Unusable::Silent {
                sensor: sensor(),
                why: why(),
            });
        };
        if pose.validity != Validity::Lost {
            return Ok(pose);
        }
        let age = now.since(pose.time);
        Err(if age < STILL {
            Unusable::Frozen { sensor: sensor() }
        } else {
            Unusable::Lost {
                sensor: sensor(),
                seconds: age.as_secs_f64(),
                why: why(),
            }
        })
    }

    /// What its device waits for, if it does.
    fn waits_for(&self) -> Option<String> {
        self.devices
            .states()
            .into_iter()
            .find_map(|state| match state.condition {
                Condition::Waiting(why) => Some(why),
                Condition::Starting | Condition::Streaming => None,
            })
    }

    fn steady(
        &self,
        poses: &[Rigid],
        point: DVec3,
        steadiness: Steadiness,
    ) -> Result<Still, Unusable> {
        // Single poses differ by the tracker's noise; the means of quarters tell it from motion.
        let quarters: Vec<Still> = poses
            .chunks(poses.len().div_ceil(4))
            .map(|poses| mean(poses, point))
            .collect();
        let (mut metres, mut radians) = (0.0_f64, 0.0_f64);
        for (index, quarter) in quarters.iter().enumerate() {
            for earlier in &quarters[..index] {
                metres = metres.max(quarter.point.distance(earlier.point));
                let turn = quarter.pose.rotation.angle_between(earlier.pose.rotation);
                radians = radians.max(turn);
            }
        }
        if metres > steadiness.metres {
            return Err(Unusable::Moved {
                sensor: self.sensor.clone(),
                millimetres: 1e3 * metres,
                limit_mm: 1e3 * steadiness.metres,
            });
        }
        if radians > steadiness.radians {
            return Err(Unusable::Turned {
                sensor: self.sensor.clone(),
                degrees: radians.to_degrees(),
                limit_degrees: steadiness.radians.to_degrees(),
            });
        }
        Ok(mean(poses, point))
    }
}

/// The mean of poses that differ little.
fn mean(poses: &[Rigid], point: DVec3) -> Still {
    let count = poses.len() as f64;
    let first = poses[0].rotation;
    let rotation = poses.iter().fold(DQuat::from_array([0.0; 4]), |sum, pose| {
        // q and -q are the same attitude.
        if pose.rotation.dot(first) < 0.0 {
            sum - pose.rotation
        } else {
            sum + pose.rotation
        }
    });
    Still {
        pose: Rigid::new(
            rotation.normalize(),
            poses.iter().map(|pose| pose.translation).sum::<DVec3>() / count,
        ),
        point: poses.iter().map(|pose| pose.point(point)).sum::<DVec3>() / count,
    }
}
