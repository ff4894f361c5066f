//! `sandtable record`: the rig's devices to a file, without opening the table.

use crate::cli::RecordArgs;
use crate::exit::usage;
use crate::session::Session;
use crate::tape::{self, Tape};
use crate::told::Told;
use crate::{interrupt, rig, scene};
use anyhow::{Context, Result, bail};
use sandtable_cast::{CASTERS, CastPool};
use sandtable_config::{Device, SensorName};
use sandtable_input::{Clock, DeviceState, Devices, Hub};
use sandtable_pose::Nanos;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How often devices are looked at.
const PERIOD: Duration = Duration::from_millis(200);

/// The longest recording, in seconds: thirty years.
const LONGEST: f64 = 1e9;

pub(crate) fn run(args: &RecordArgs) -> Result<()> {
    if args
        .seconds
        .is_some_and(|seconds| !(seconds > 0.0 && seconds <= LONGEST))
    {
        return Err(usage(
            "--seconds must be above 0 and at most 1000000000; without it, Ctrl-C ends",
        ));
    }
    let rig = rig::open(&args.rig, &args.device)?;
    if rig.devices.is_empty() {
        bail!("the rig {:?} has no devices to record", rig.name);
    }
    let open = scene::open(&args.terrain)?;
    let pool = Arc::new(CastPool::new(0).context("cannot start the casting threads")?);
    let hub = Arc::new(Hub::for_rig(&rig));
    let caster = scene::caster(CASTERS[0].name)?;
    let session = Session::new(rig, &open, &caster, pool, Arc::clone(&hub))?;
    let stop = interrupt::channel()?;
    let clock = Clock::start();
    let tape = Tape::create(&args.output, &session, &args.terrain, clock.now())?;
    let devices = Devices::start(session.rig(), &hub, clock, Some(tape.recorder()))?;
    eprintln!("recording to {}; Ctrl-C ends it", args.output.display());

    let end = args
        .seconds
        .map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let mut told = Told::default();
    loop {
        let wait = end.map_or(PERIOD, |end| {
            PERIOD.min(end.saturating_duration_since(Instant::now()))
        });
        if stop.recv_timeout(wait).is_ok() || end.is_some_and(|end| Instant::now() >= end) {
            break;
        }
        told.tell(&devices);
        if let Some(problem) = tape.recorder().problem() {
            bail!("{problem}");
        }
    }
    let states = devices.states();
    devices.stop();
    tape::finish(&tape, &args.output)?;
    tell_silent(args, &session, &states)
}

/// Names the devices of which nothing was recorded that shows in a replay; fails where that is
/// all of them.
fn tell_silent(args: &RecordArgs, session: &Session, states: &[DeviceState]) -> Result<()> {
    let devices = &session.rig().devices;
    let silent: Vec<&str> = states
        .iter()
        .filter(|state| !was_heard(session.hub(), &devices[&state.name], state))
        .map(|state| state.name.as_str())
        .collect();
    let output = args.output.display();
    let remedy = format!("`sandtable doctor --rig {}` says what is wrong", args.rig);
    if silent.len() == devices.len() {
        bail!("{output} holds nothing of {}; {remedy}", silent.join(", "));
    }
    for name in silent {
        let what = match devices[name].gestures() {
            Some(_) => "state of a hand",
            None => "pose",
        };
        eprintln!("{name}: no {what} was recorded; {remedy}");
    }
    Ok(())
}

/// Whether a tracker has told a pose, or a glove has spoken: some tell changes only.
fn was_heard(hub: &Hub, device: &Device, state: &DeviceState) -> bool {
    if device.gestures().is_some() {
        return state.counts.samples > 0 || !device.has_poses() && state.counts.records > 0;
    }
    let of_device = |sensor: &SensorName| sensor.device == state.name;
    let mut sensors = hub.sensors().filter(of_device);
    sensors.any(|sensor| hub.pose_at(&sensor, Nanos(u64::MAX)).is_some())
}
