//! All devices of a rig, each in a thread of its own.

use crate::device_thread::DeviceThread;
use crate::recording::{DeviceEvent, Recorder};
use crate::{Clock, Hub, Sample, Stream, StreamCounts};
use crate::{data_glove, dtrack, flock, hid_glove, pinch, vrpn};
use crossbeam_channel::Sender;
use sandtable_config::{Device, Rig};
use sandtable_pose::Nanos;
use std::convert::Infallible;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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
    /// Why it did not stream when it was last tried; none once it does.
    pub trouble: Option<String>,
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
    reset_asked: Arc<AtomicBool>,
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
                trouble: None,
            }));
            let reset_asked = Arc::new(AtomicBool::new(false));
            let outlet = Outlet {
                device: name.clone(),
                hub: Arc::clone(hub),
                clock,
                recorder: recorder.cloned(),
                state: Arc::clone(&state),
                reset_asked: Arc::clone(&reset_asked),
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
                    Device::Pinch(pinch) => pinch::driver::run(&pinch, driven),
                    Device::DataGlove(glove) => data_glove::run(&glove, driven),
                    Device::HidGlove(glove) => hid_glove::run(&glove, driven),
                })
                .map_err(|source| DevicesError {
                    device: name.clone(),
                    source,
                })?;
            devices.running.push(Running {
                state,
                reset_asked,
                stop: Some(stop),
                thread: Some(thread),
            });
        }
        Ok(devices)
    }

    /// How each device is, in the order of their names.
    #[must_use]
    pub fn states(&self) -> Vec<DeviceState> {
        let state = |running: &Running| lock(&running.state).clone();
        self.running.iter().map(state).collect()
    }

    /// Lets a device that learns its ranges forget them and begin anew, as for another hand.
    /// Returns whether there is a device of that name.
    pub fn reset_calibration(&self, device: &str) -> bool {
        let named = |running: &&Running| lock(&running.state).name == device;
        let found = self.running.iter().find(named);
        if let Some(running) = found {
            running.reset_asked.store(true, Ordering::Relaxed);
        }
        found.is_some()
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
    pub(crate) device: String,
    pub(crate) hub: Arc<Hub>,
    pub(crate) clock: Clock,
    pub(crate) recorder: Option<Recorder>,
    pub(crate) state: Arc<Mutex<DeviceState>>,
    pub(crate) reset_asked: Arc<AtomicBool>,
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
            self.hub.push_read(&self.device, sample, arrival);
            if let (Some(recorder), Sample::Pose(pose)) = (&self.recorder, sample) {
                recorder.pose(&self.device, pose);
            }
        });
        lock(&self.state).counts = stream.counts();
    }

    /// Tells `stream` the time where it wants to be told.
    pub(crate) fn pass_time(&self, stream: &mut dyn Stream) {
        let now = self.clock.now();
        if stream.due().is_some_and(|due| due <= now) {
            self.bytes(&[], now, stream);
        }
    }

    /// Lets `stream` forget the ranges that it has learnt, where that was asked for.
    pub(crate) fn reset_where_asked(&self, stream: &mut dyn Stream) {
        if self.reset_asked.swap(false, Ordering::Relaxed) {
            self.tell_calibration(stream);
            self.event(DeviceEvent::CalibrationReset);
            stream.reset_calibration();
        }
    }

    /// Logs what `stream` has learnt, so that it can be kept in the rig.
    pub(crate) fn tell_calibration(&self, stream: &dyn Stream) {
        if let Some(learnt) = stream.calibration() {
            tracing::info!(device = self.device, "to keep its calibration: {learnt}");
        }
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
        let mut state = lock(&self.state);
        // While it is tried again, what was wrong the last time is all that is known.
        match &condition {
            Condition::Starting => {}
            Condition::Streaming => state.trouble = None,
            Condition::Waiting(why) => state.trouble = Some(why.clone()),
        }
        state.condition = condition;
    }
}

fn lock(state: &Mutex<DeviceState>) -> MutexGuard<'_, DeviceState> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}
