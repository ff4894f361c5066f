//! The stream: from datagrams with their arrival times to samples in the table's frame.
//!
//! Live driver and replay run the same stream, so that a recording gives the same samples.

use super::datagram::{Datagram, DtrackBody, FlystickControls};
use crate::tracked_sensors::{NORM_TOLERANCE, TrackedSensors, plausible};
use crate::{AxesSample, ButtonsSample, Sample, Stream, StreamCounts};
use glam::DQuat;
use sandtable_config::Dtrack;
use sandtable_pose::{Nanos, Rigid};

/// A frame whose number is up to so much below the newest came late, or twice. One that is farther
/// below is the first of a controller that was started anew.
const LATE: u32 = 100;

/// Turns one controller's datagrams into samples, one to a push. No socket, no clock.
#[derive(Clone, Debug)]
pub struct DtrackStream {
    bodies: u32,
    sensors: TrackedSensors<[u64; 12]>,
    /// The newest controls of each Flystick.
    controls: Vec<Option<FlystickControls>>,
    datagram: Datagram,
    frame: Option<u32>,
    /// Whether a datagram has told of bodies or Flysticks.
    understood: bool,
    counts: StreamCounts,
}

impl DtrackStream {
    /// The stream of a rig's DTrack controller.
    #[must_use]
    pub fn new(dtrack: &Dtrack) -> Self {
        Self {
            bodies: dtrack.bodies,
            sensors: TrackedSensors::new(&dtrack.tracking, dtrack.bodies + dtrack.flysticks),
            controls: vec![None; dtrack.flysticks as usize],
            datagram: Datagram::default(),
            frame: None,
            understood: false,
            counts: StreamCounts::default(),
        }
    }

    /// Whether a line of bodies or Flysticks has come since it was made or restarted, be it that
    /// none of them is seen.
    #[must_use]
    pub fn is_understood(&self) -> bool {
        self.understood
    }

    /// Whether the frame with this number is one that has not been before.
    fn is_new(&mut self, frame: Option<u32>) -> bool {
        let Some(frame) = frame else {
            return true;
        };
        let new = self
            .frame
            .is_none_or(|newest| frame > newest || newest - frame > LATE);
        if new {
            self.frame = Some(frame);
        }
        new
    }

    fn body(&mut self, first: u32, of: u32, body: &DtrackBody, arrival: Nanos) -> Option<Sample> {
        self.counts.records += 1;
        if body.id >= of {
            self.counts.foreign_records += 1;
            return None;
        }
        let index = (first + body.id) as usize;
        let mut raw = [0; 12];
        let numbers = body.rotation.to_cols_array();
        let numbers = body.position.to_array().into_iter().chain(numbers);
        for (bits, number) in raw.iter_mut().zip(numbers) {
            *bits = number.to_bits();
        }
        let counts = &mut self.counts;
        let sample = self.sensors.sample(index, raw, pose(body), arrival, counts);
        sample.map(Sample::Pose)
    }

    fn controls(
        &mut self,
        id: u32,
        controls: &FlystickControls,
        arrival: Nanos,
        out: &mut dyn FnMut(Sample),
    ) {
        let Some(known) = self.controls.get_mut(id as usize) else {
            self.counts.foreign_records += 1;
            return;
        };
        let before = known.replace(*controls);
        let sensor = self.bodies + id + 1;
        // They are told in every frame; only what is new is let out.
        if before.is_none_or(|before| before.pressed != controls.pressed) {
            self.counts.samples += 1;
            out(Sample::Buttons(ButtonsSample {
                sensor,
                time: arrival,
                pressed: controls.pressed,
            }));
        }
        let same = |before: FlystickControls| {
            (before.values, before.count) == (controls.values, controls.count)
        };
        if controls.count > 0 && !before.is_some_and(same) {
            self.counts.samples += 1;
            out(Sample::Axes(AxesSample {
                sensor,
                time: arrival,
                values: controls.values,
                count: controls.count,
            }));
        }
    }
}

impl Stream for DtrackStream {
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        let mut datagram = std::mem::take(&mut self.datagram);
        datagram.read(bytes);
        self.counts.cut_records += datagram.malformed;
        if datagram.body_lines > 0 {
            self.understood = true;
        } else {
            self.counts.stray_bytes += bytes.len() as u64;
        }
        if self.is_new(datagram.frame) {
            for body in &datagram.bodies {
                if let Some(sample) = self.body(0, self.bodies, body, arrival) {
                    out(sample);
                }
            }
            let flysticks = u32::try_from(self.controls.len()).unwrap_or(u32::MAX);
            for flystick in &datagram.flysticks {
                self.controls(flystick.id, &flystick.controls, arrival, out);
                let body = flystick.body.as_ref();
                let sample = body.and_then(|body| self.body(self.bodies, flysticks, body, arrival));
                if let Some(sample) = sample {
                    out(sample);
                }
            }
        } else {
            self.counts.refused += 1;
        }
        self.datagram = datagram;
    }

    fn restart(&mut self) {
        self.sensors.restart();
        self.controls.fill(None);
        self.frame = None;
        self.understood = false;
    }

    fn counts(&self) -> StreamCounts {
        self.counts
    }
}

/// A body's pose, or `None` where its matrix is no rotation.
fn pose(body: &DtrackBody) -> Option<Rigid> {
    let [x, y, z] = [0, 1, 2].map(|n| body.rotation.col(n));
    let unit = |length: f64| (length - 1.0).abs() <= NORM_TOLERANCE;
    let upright = |dot: f64| dot.abs() <= NORM_TOLERANCE;
    let rotation = unit(x.length())
        && unit(y.length())
        && unit(z.length())
        && upright(x.dot(y))
        && upright(y.dot(z))
        && upright(z.dot(x))
        && x.cross(y).dot(z) > 0.0;
    if !rotation {
        return None;
    }
    plausible(body.position, DQuat::from_mat3(&body.rotation).normalize())
}
