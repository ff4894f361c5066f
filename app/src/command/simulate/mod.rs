//! `sandtable simulate`: be a device.

use crate::cli::{SimulateArgs, SimulatedDevice};
use anyhow::Result;

#[cfg(unix)]
pub(crate) fn run(args: &SimulateArgs) -> Result<()> {
    let SimulatedDevice::Flock(args) = &args.device;
    unix::flock(args)
}

#[cfg(not(unix))]
pub(crate) fn run(_: &SimulateArgs) -> Result<()> {
    anyhow::bail!("simulated devices need pseudo-terminals, which this system does not have")
}

#[cfg(unix)]
mod unix {
    use crate::cli::{SimulateFlockArgs, parse_hold};
    use crate::exit::usage;
    use crate::interrupt;
    use anyhow::{Context, Result};
    use crossbeam_channel::{Receiver, select};
    use sandtable_input::Replay;
    use sandtable_input::flock::{Faults, Motion, RecordedMotion, Simulator, SimulatorSettings};
    use std::io::{BufRead, Write};
    use std::path::Path;
    use std::sync::Arc;

    pub(super) fn flock(args: &SimulateFlockArgs) -> Result<()> {
        let motion = Motion::named(&args.motion).ok_or_else(|| {
            let known = Motion::NAMES.join(", ");
            usage(format!(
                "no motion is called {:?}: use one of {known}",
                args.motion
            ))
        })?;
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
                held(bird).map_or(motion, |&[x, y, z, azimuth, elevation, roll]| {
                    Motion::hold([x, y, z], [azimuth, elevation, roll])
                })
            })
            .collect();
        let recorded = args.from.as_deref().map(recorded).transpose()?;
        let settings = SimulatorSettings {
            recorded: recorded.map(Arc::new),
            birds,
            erc_address: args.erc.map(u32::from),
            baud: args.baud,
            motions,
            faults: Faults {
                drop_every: args.drop_every,
                damage_every: args.damage_every,
                stalls: args.stall.clone(),
                ..Faults::default()
            },
            ..SimulatorSettings::default()
        };
        // Listened to from the start: no signal may end the program with its link still there.
        let stop = interrupt::channel()?;
        let simulator = Simulator::start(settings, args.link.as_deref())?;
        // The path stands alone on its line, for scripts; it must not wait in a buffer.
        let path = args.link.as_deref().unwrap_or(simulator.path());
        let mut out = std::io::stdout();
        writeln!(out, "{}", path.display())?;
        out.flush()?;
        eprintln!(
            "a Flock of {birds} birds at {} baud; Ctrl-C ends it",
            args.baud
        );
        if args.steer {
            steer(&simulator, birds, &stop)?;
        } else {
            // An error means that the handler is gone, and then so is the wish to go on.
            let _ = stop.recv();
        }
        simulator.stop();
        Ok(())
    }

    /// The motion of the first Flock in a recording.
    fn recorded(path: &Path) -> Result<RecordedMotion> {
        let replay = Replay::open(path)?;
        let mut devices = replay.rig().devices.keys();
        devices
            .find_map(|device| RecordedMotion::of(&replay, device))
            .with_context(|| format!("{} holds no pose of a Flock of Birds", path.display()))
    }

    /// Holds birds where lines on standard input say, until Ctrl-C.
    fn steer(simulator: &Simulator, birds: u32, stop: &Receiver<()>) -> Result<()> {
        let (sender, lines) = crossbeam_channel::bounded(1);
        std::thread::Builder::new()
            .name("standard input".into())
            .spawn(move || {
                for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                    if sender.send(line).is_err() {
                        break;
                    }
                }
            })
            .context("cannot start the thread that reads standard input")?;
        loop {
            let line = select! {
                recv(lines) -> line => line,
                recv(stop) -> _ => return Ok(()),
            };
            let Ok(line) = line else {
                // The last ones hold on.
                let _ = stop.recv();
                return Ok(());
            };
            match held_bird(&line, birds) {
                Ok((bird, motion)) => {
                    simulator.set_motion(bird, motion);
                    let mut out = std::io::stdout();
                    writeln!(out, "{bird}")?;
                    out.flush()?;
                }
                Err(problem) => eprintln!("{problem}"),
            }
        }
    }

    /// `BIRD,X,Y,Z,AZ,EL,ROLL`.
    fn held_bird(line: &str, birds: u32) -> Result<(u32, Motion), String> {
        let wanted =
            || format!("{line:?} is not BIRD,X,Y,Z,AZ,EL,ROLL with a bird from 1 to {birds}");
        let (bird, pose) = line.split_once(',').ok_or_else(wanted)?;
        let bird = bird.trim().parse().map_err(|_| wanted())?;
        if !(1..=birds).contains(&bird) {
            return Err(wanted());
        }
        let [x, y, z, azimuth, elevation, roll] = parse_hold(pose)?;
        Ok((bird, Motion::hold([x, y, z], [azimuth, elevation, roll])))
    }
}
