//! All devices of a rig, each in a thread of its own.

use crate::device_thread::DeviceThread;
use crate::recording::{DeviceEvent, Recorder};
use crate::{Clock, Hub, Sample, Stream, StreamCounts, dtrack, flock, vrpn};
use crossbeam_channel::Sender;
use sandtable_config::{Device, Rig};
use sandtable_pose::Nanos;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// A rig's devices while they run. Dropping it stops them.
#[derive(Debug)]
pub struct Devices {
    running: Vec<Running>,
}

/// How one device is.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceState {
    /// The device's name in the rig.
    pub name: String,
    /// What it is doing.
    pub condition: Condition,
    /// What its stream has seen.
    pub counts: StreamCounts,
}

/// What a device is doing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Condition {
    /// Its port is being opened, or it is being started.
    Starting,
    /// Its bytes come in.
    Streaming,
    /// It cannot be had just now, for the reason given; it will be tried again.
    Waiting(String),
}

/// A device's thread cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start the thread of the device `{device}` ({source}); end other programs")]
pub struct DevicesError {
    /// The device.
    pub device: String,
    /// What the system says.
    pub source: std::io::Error,
}

#[derive(Debug)]
struct Running {
    state: Arc<Mutex<DeviceState>>,
    /// Dropped to stop the thread.
    stop: Option<Sender<Infallible>>,
    thread: Option<JoinHandle<()>>,
}

impl Devices {
    /// Starts every device of `rig`. A device that is not there is waited for.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn start(
        rig: &Rig,
        hub: &Arc<Hub>,
        clock: Clock,
        recorder: Option<&Recorder>,
    ) -> Result<Self, DevicesError> {
        let mut devices = Self {
            running: Vec::new(),
        };
        for (name, device) in &rig.devices {
            let state = Arc::new(Mutex::new(DeviceState {
                name: name.clone(),
                condition: Condition::Starting,
                counts: StreamCounts::default(),
            }));
            let outlet = Outlet {
                device: name.clone(),
                hub: Arc::clone(hub),
                clock,
                recorder: recorder.cloned(),
                state: Arc::clone(&state),
            };
            let (stop, stopped) = crossbeam_channel::bounded(0);
            let driven = DeviceThread::new(outlet, stopped);
            let device = device.clone();
            let thread = std::thread::Builder::new()
                .name(format!("device {name}"))
                .spawn(move || match device {
                    Device::Flock(flock) => flock::driver::run(&flock, driven),
                    Device::Vrpn(vrpn) => vrpn::driver::run(&vrpn, driven),
                    Device::Dtrack(dtrack) => dtrack::driver::run(&dtrack, driven),
                })
                .map_err(|source| DevicesError {
                    device: name.clone(),
                    source,
                })?;
            devices.running.push(Running {
                state,
                stop: Some(stop),
                thread: Some(thread),
            });
        }
        Ok(devices)
    }

    /// How each device is, in the order of their names.
    #[must_use]
    pub fn states(&self) -> Vec<DeviceState> {
        let lock = |running: &Running| {
            let state = running.state.lock();
            state.unwrap_or_else(PoisonError::into_inner).clone()
        };
        self.running.iter().map(lock).collect()
    }

    /// Ends the streams and closes the ports.
    pub fn stop(mut self) {
        self.end();
    }

    fn end(&mut self) {
        // All are told before any is waited for.
        for running in &mut self.running {
            running.stop = None;
        }
        for running in &mut self.running {
            if let Some(thread) = running.thread.take() {
                // A panic in it has been printed, and its port is closed.
                let _ = thread.join();
            }
        }
    }
}

impl Drop for Devices {
    fn drop(&mut self) {
        self.end();
    }
}

/// Where a device's thread hands on what it reads.
pub(crate) struct Outlet {
    device: String,
    hub: Arc<Hub>,
    clock: Clock,
    recorder: Option<Recorder>,
    state: Arc<Mutex<DeviceState>>,
}

impl Outlet {
    pub(crate) fn device(&self) -> &str {
        &self.device
    }

    pub(crate) fn now(&self) -> Nanos {
        self.clock.now()
    }

    /// Records the bytes as they came, then lets `stream` make samples of them.
    pub(crate) fn bytes(&self, bytes: &[u8], arrival: Nanos, stream: &mut dyn Stream) {
        if let Some(recorder) = &self.recorder {
            recorder.bytes(&self.device, arrival, bytes);
        }
        stream.push(bytes, arrival, &mut |sample| {
            self.hub.push(&self.device, sample);
            if let (Some(recorder), Sample::Pose(pose)) = (&self.recorder, sample) {
                recorder.pose(&self.device, pose);
            }
        });
        self.state().counts = stream.counts();
    }

    pub(crate) fn event(&self, event: DeviceEvent) {
        let now = self.clock.now();
        if let Some(recorder) = &self.recorder {
            recorder.event(&self.device, now, event);
        }
        if event == DeviceEvent::Lost {
            self.hub.let_go(&self.device, now);
        }
    }

    pub(crate) fn set_condition(&self, condition: Condition) {
        self.state().condition = condition;
    }

    fn state(&self) -> std::sync::MutexGuard<'_, DeviceState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
