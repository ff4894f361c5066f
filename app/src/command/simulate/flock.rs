//! `sandtable simulate flock`.

use super::line;
use super::steering::{Change, Steering};
use crate::cli::{SimulateFlockArgs, parse_numbers};
use crate::exit::usage;
use anyhow::{Context, Result};
use sandtable_config::{Device, Range, Rig};
use sandtable_input::Replay;
use sandtable_input::flock::{Faults, Motion, RecordedMotion, SimulatedFlock, SimulatorSettings};
use std::path::Path;
use std::sync::Arc;

pub(super) fn run(args: &SimulateFlockArgs) -> Result<()> {
    let birds = u32::from(args.birds);
    if args.hold.len() > birds as usize {
        return Err(usage(format!(
            "{} poses are held, but there are {birds} birds: give --birds {}",
            args.hold.len(),
            args.hold.len()
        )));
    }
    if args
        .erc
        .is_some_and(|address| u32::from(address) > birds + 1)
    {
        return Err(usage(format!(
            "a controller beside {birds} birds has an address from 1 to {}",
            birds + 1
        )));
    }
    let held = |bird: usize| args.hold.get(bird);
    let motions = (0..birds as usize)
        .map(|bird| {
            held(bird).map_or(args.motion, |&[x, y, z, azimuth, elevation, roll]| {
                Motion::hold([x, y, z], [azimuth, elevation, roll])
            })
        })
        .collect();
    let recorded = args.from.as_deref().map(recorded).transpose()?;
    let flock = SimulatedFlock::new(SimulatorSettings {
        recorded: recorded.map(Arc::new),
        birds,
        erc_address: args.erc.map(u32::from),
        baud: args.baud,
        motions,
        faults: Faults {
            drop_every: args.line.drop_every,
            damage_every: args.damage_every,
            stalls: args.line.stall.clone(),
            ..Faults::default()
        },
        ..SimulatorSettings::default()
    });
    let what = format!("a Flock of {birds} birds at {} baud", args.baud);
    let steering = args.steer.then(|| -> Steering<SimulatedFlock> {
        Box::new(move |line| {
            let (bird, motion) = held_bird(line, birds)?;
            let change: Change<_> =
                Box::new(move |flock: &mut SimulatedFlock| flock.set_motion(bird, motion));
            Ok((bird.to_string(), change))
        })
    });
    line::run(flock, &args.line, &what, |port| rig(args, port), steering)
}

/// The workbench with this Flock at `port`, so that its poses are in that table's frame.
fn rig(args: &SimulateFlockArgs, port: &Path) -> Result<Rig> {
    let mut rig = Rig::builtin("workbench")?;
    rig.set_port("flock", port)?;
    rig.devices.retain(|name, _| name == "flock");
    if let Some(Device::Flock(flock)) = rig.devices.get_mut("flock") {
        flock.birds = u32::from(args.birds);
        flock.baud = args.baud;
        flock.erc_address = args.erc.map(u32::from);
        if args.erc.is_some() {
            flock.range = Range::Inches144;
        }
    }
    Ok(rig)
}

/// The motion of the first Flock in a recording.
fn recorded(path: &Path) -> Result<RecordedMotion> {
    let replay = Replay::open(path)?;
    let mut devices = replay.rig().devices.keys();
    devices
        .find_map(|device| RecordedMotion::of(&replay, device))
        .with_context(|| format!("{} holds no pose of a Flock of Birds", path.display()))
}

/// `BIRD,X,Y,Z,AZ,EL,ROLL`.
fn held_bird(line: &str, birds: u32) -> Result<(u32, Motion), String> {
    let wanted = || format!("{line:?} is not BIRD,X,Y,Z,AZ,EL,ROLL with a bird from 1 to {birds}");
    let (bird, pose) = line.split_once(',').ok_or_else(wanted)?;
    let bird = bird.trim().parse().map_err(|_| wanted())?;
    if !(1..=birds).contains(&bird) {
        return Err(wanted());
    }
    let pose = parse_numbers(pose, "X,Y,Z,AZ,EL,ROLL in inches and degrees")?;
    let [x, y, z, azimuth, elevation, roll] = pose;
    Ok((bird, Motion::hold([x, y, z], [azimuth, elevation, roll])))
}
