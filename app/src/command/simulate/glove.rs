//! `sandtable simulate glove`.

use crate::cli::{GloveHand, SimulateGloveArgs};
use crate::exit::usage;
use crate::interrupt;
use crate::offer::Offer;
use anyhow::{Context, Result};
use sandtable_config::{DataGlove, Device, Rig, Side};
use sandtable_input::Stream;
use sandtable_input::data_glove::{DataGloveStream, Motion, SimulatedDataGlove, SimulatorSettings};
use std::time::{Duration, Instant};

/// What its VRPN server and a rig call it.
const NAME: &str = "glove";

pub(super) fn run(args: &SimulateGloveArgs) -> Result<()> {
    let motion = match args.hold {
        Some(fingers) => Motion::Hold(fingers),
        None => Motion::named(&args.motion, args.seed).ok_or_else(|| {
            let known = Motion::NAMES.join(", ");
            usage(format!(
                "no motion is called {:?}: use one of {known}",
                args.motion
            ))
        })?,
    };
    let rig = rig(args)?;
    let described = described(&rig)?;
    let settings = SimulatorSettings {
        side: match args.hand {
            GloveHand::Left => Side::Left,
            GloveHand::Right => Side::Right,
        },
        motion,
        noise: args.noise,
        seed: args.seed,
        rate: args.rate,
    };
    let glove = SimulatedDataGlove::new(described, settings);
    let mut stream = DataGloveStream::new(described);
    let stop = interrupt::channel()?;
    let mut offer = Offer::start(&rig, args.vrpn)?;
    eprintln!(
        "a 5DT glove of {} sensors (product {:#06x}) at {} reports a second; Ctrl-C ends it",
        args.sensors,
        glove.product(),
        args.rate
    );
    let start = Instant::now();
    let mut number = 0;
    loop {
        let wait = glove.time(number).saturating_sub(start.elapsed());
        if stop.recv_timeout(wait).is_ok() {
            break;
        }
        // What a computer that slept has missed is not made up for.
        let late = start.elapsed().saturating_sub(glove.time(number));
        if late < LATEST {
            let report = glove.report(number);
            stream.push(&report, offer.clock.now(), &mut |sample| {
                offer.hub.push(NAME, sample);
            });
        }
        number += 1;
        offer.tell_guests();
    }
    offer.stop();
    Ok(())
}

/// A report that is due for longer is not sent.
const LATEST: Duration = Duration::from_secs(1);

/// A rig with this glove and its ranges, and nothing else.
fn rig(args: &SimulateGloveArgs) -> Result<Rig> {
    let hand = match args.hand {
        GloveHand::Left => "left",
        GloveHand::Right => "right",
    };
    let ranges: Vec<String> = (0..usize::from(args.sensors))
        .map(|sensor| format!("{:?}", SimulatedDataGlove::range(sensor)))
        .collect();
    let text = format!(
        "name = \"simulated\"\n[camera]\n[devices.{NAME}]\nkind = \"data-glove\"\n\
         hand = \"{hand}\"\nsensors = {}\nauto_calibration = false\nranges = [{}]\n",
        args.sensors,
        ranges.join(", ")
    );
    Ok(Rig::parse(&text, "the simulated glove's rig")?)
}

fn described(rig: &Rig) -> Result<&DataGlove> {
    match rig.devices.get(NAME) {
        Some(Device::DataGlove(glove)) => Some(glove),
        _ => None,
    }
    .context("the simulated glove's rig has lost it")
}
