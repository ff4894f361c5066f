//! `sandtable simulate pinch`.

use super::line;
use super::steering::{Change, Steering};
use crate::cli::{GloveHand, SimulatePinchArgs};
use crate::exit::usage;
use anyhow::{Context, Result};
use sandtable_config::Rig;
use sandtable_input::pinch::{ContactGroups, Faults, Motion, SimulatedPinch, SimulatorSettings};
use sandtable_input::{Fingers, Replay};
use std::path::Path;

pub(super) fn run(args: &SimulatePinchArgs) -> Result<()> {
    let motion = match (&args.from, &args.motion) {
        (Some(path), _) => recorded(path)?,
        (None, Some(name)) => named(name)?,
        (None, None) if args.steer => Motion::Open,
        (None, None) => named("play")?,
    };
    let gloves = [GloveHand::Left, GloveHand::Right].map(|hand| !args.without.contains(&hand));
    let pinch = SimulatedPinch::new(SimulatorSettings {
        baud: args.baud,
        gloves,
        motion,
        faults: Faults {
            drop_every: args.line.drop_every,
            stalls: args.line.stall.clone(),
        },
        ..SimulatorSettings::default()
    });
    let worn = match gloves {
        [true, true] => "two gloves",
        [true, false] => "a left glove",
        [false, true] => "a right glove",
        [false, false] => "no glove",
    };
    let what = format!("a PINCH box with {worn} at {} baud", args.baud);
    let steering = args.steer.then(|| -> Steering<SimulatedPinch> {
        Box::new(|line| {
            let groups = joined(line)?;
            let answer = groups.as_slice().len().to_string();
            let change: Change<_> = Box::new(move |pinch: &mut SimulatedPinch| pinch.join(groups));
            Ok((answer, change))
        })
    });
    line::run(pinch, &args.line, &what, |port| rig(args, port), steering)
}

fn named(name: &str) -> Result<Motion> {
    Motion::named(name).ok_or_else(|| {
        let known = Motion::NAMES.join(", ");
        usage(format!("no motion is called {name:?}: use one of {known}"))
    })
}

/// A rig with this box at `port`, and nothing else.
fn rig(args: &SimulatePinchArgs, port: &Path) -> Result<Rig> {
    let text = format!(
        "name = \"simulated\"\n[camera]\n[devices.pinch]\nkind = \"pinch\"\n\
         port = \"/dev/ttyS0\"\nbaud = {}\n",
        args.baud
    );
    let mut rig = Rig::parse(&text, "the simulated gloves' rig")?;
    rig.set_port("pinch", port)?;
    Ok(rig)
}

/// What the first PINCH gloves in a recording touched.
fn recorded(path: &Path) -> Result<Motion> {
    let replay = Replay::open(path)?;
    let mut devices = replay.rig().devices.keys();
    devices
        .find_map(|device| Motion::recorded(&replay, device))
        .with_context(|| format!("{} holds no contact of PINCH gloves", path.display()))
}

/// The fingers, as they are written.
const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

/// Groups with commas between them, each of `L:` and `R:` with fingers joined by `+`; or `open`.
fn joined(line: &str) -> Result<ContactGroups, String> {
    let wanted = || {
        format!(
            "{line:?} is not `open`, nor groups of two fingers at least, as `L:thumb+index, \
             R:thumb+middle`, or `L:thumb R:thumb` for one of both hands"
        )
    };
    let fingers = |names: &str| {
        names.split('+').try_fold(Fingers::default(), |all, name| {
            let finger = FINGERS.iter().position(|known| *known == name.trim());
            let finger = Fingers::number(finger.ok_or_else(wanted)?);
            // A finger said twice is a slip of the pen.
            if all.contains(finger) {
                return Err(wanted());
            }
            Ok(all.with(finger))
        })
    };
    if line.trim() == "open" {
        return Ok(ContactGroups::default());
    }
    let group = |text: &str| {
        let mut group = [Fingers::default(); 2];
        for part in text.split_whitespace() {
            let (hand, names) = part.split_once(':').ok_or_else(wanted)?;
            let hand = match hand {
                "L" => &mut group[0],
                "R" => &mut group[1],
                _ => return Err(wanted()),
            };
            if !hand.is_empty() {
                return Err(wanted());
            }
            *hand = fingers(names)?;
        }
        Ok(group)
    };
    let groups = line.split(',').map(group).collect::<Result<Vec<_>, _>>()?;
    ContactGroups::new(&groups).ok_or_else(wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_say_which_fingers_are_joined() {
        let (none, thumb, index) = (Fingers::default(), Fingers::THUMB, Fingers::INDEX);
        let groups = |line: &str| joined(line).unwrap().as_slice().to_vec();
        assert_eq!(groups("L:thumb+index"), [[thumb.with(index), none]]);
        assert_eq!(groups("R:little L:thumb"), [[thumb, Fingers::LITTLE]]);
        assert_eq!(
            groups(" L:thumb+index ,R:ring+middle+thumb"),
            [
                [thumb.with(index), none],
                [none, thumb.with(Fingers::MIDDLE).with(Fingers::RING)]
            ]
        );
        assert!(groups(" open").is_empty());
    }

    #[test]
    fn other_lines_are_told_what_is_right() {
        for line in [
            "",
            "L:thumb",
            "thumb+index",
            "L:thumb+toe",
            "X:thumb+index",
            "L:thumb+thumb",
            "L:thumb L:index",
            "L:thumb+index, L:thumb R:thumb",
            "L:thumb+index,",
            "open, L:thumb+index",
        ] {
            let problem = joined(line).unwrap_err();
            assert!(
                problem.contains("L:thumb+index, R:thumb+middle"),
                "{problem}"
            );
        }
    }
}
