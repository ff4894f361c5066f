//! `sandtable record`: the rig's devices to a file, without opening the table.

use crate::cli::RecordArgs;
use crate::exit::usage;
use crate::session::Session;
use crate::tape::{self, Tape};
use crate::told::Told;
use crate::{interrupt, rig, scene};
use anyhow::{Context, Result, bail};
use sandtable_cast::{CASTERS, CastPool};
use sandtable_input::{Clock, Devices, Hub};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How often devices are looked at.
const PERIOD: Duration = Duration::from_millis(200);

pub(crate) fn run(args: &RecordArgs) -> Result<()> {
    if args
        .seconds
        .is_some_and(|seconds| !(seconds > 0.0 && seconds < 1e9))
    {
        return Err(usage("--seconds must be above 0"));
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
    devices.stop();
    tape::finish(&tape, &args.output)
}
