//! `sandtable calibrate eyes`: where the eyes sit on the head, by sighting over pairs of marks.

use super::dialogue::{Answer, Dialogue, quit};
use super::saving::Destination;
use super::station::{Station, Steadiness};
use crate::cli::{CalibrateEyesArgs, MarkSource};
use crate::exit::usage;
use crate::rig;
use anyhow::{Context, Result, bail};
use glam::DVec3;
use sandtable_calibration::{Eye, LocatedEyes, Sighting, admit_pairs, locate_eyes};
use sandtable_config::{Calibrated, Mark, Rig, SensorName};

pub(super) fn run(args: &CalibrateEyesArgs, dialogue: &Dialogue) -> Result<()> {
    let rig = rig::open(&args.measuring.rig, &args.measuring.device)?;
    if args.marks == MarkSource::Glass {
        return Err(usage(
            "eyes cannot be measured by marks on the glass: the line through two of them lies in the \
             glass, where no eye looks along it; put up a post, measure its top, and name the file \
             of marks with --marks",
        ));
    }
    let marks = args.marks.load(&rig)?;
    let pairs = args
        .pair
        .iter()
        .map(|pair| pair_of(&marks, pair))
        .collect::<Result<Vec<_>>>()?;
    let places: Vec<_> = pairs
        .iter()
        .map(|pair| pair.map(|mark| mark.place))
        .collect();
    admit_pairs(&places).with_context(|| {
        format!(
            "the marks of --pair {} tell no eye, however they are sighted over",
            args.pair.join(" --pair ")
        )
    })?;
    let sensor = head_sensor(&rig, args.measuring.sensor.as_deref())?;
    let destination = Destination::choose(&args.measuring.rig, &args.saving, &rig, dialogue)?;
    let station = Station::start(&rig, &sensor, dialogue.clone())?;
    let sight = |eye: &str, closed: &str| {
        (0..args.sightings)
            .map(|index| {
                let pair = pairs[index as usize % pairs.len()];
                let of = format!("{eye} eye, {} of {}", index + 1, args.sightings);
                sighting(&station, pair, &of, closed)
            })
            .collect::<Result<Vec<_>>>()
    };
    let left = sight("left", "right")?;
    let right = sight("right", "left")?;
    station.stop();
    let found = agree(dialogue, left, right, &destination)?;
    let eyes = found.eyes;
    destination.save(&Calibrated::Eyes {
        middle: eyes.middle,
        rightwards: eyes.rightwards,
        interpupillary: eyes.interpupillary,
    })
}

fn head_sensor(rig: &Rig, asked: Option<&str>) -> Result<SensorName> {
    let Some(head) = &rig.head else {
        bail!("the rig {:?} has no head that eyes could sit on", rig.name);
    };
    match (asked, &head.sensor) {
        (Some(name), _) => rig.sensor(name).map_err(usage),
        (None, Some(sensor)) => Ok(sensor.clone()),
        (None, None) => Err(usage(
            "the rig's [head] has no sensor; name it with --sensor, as flock/1",
        )),
    }
}

/// `NEAR=FAR`: two marks by name.
fn pair_of<'a>(marks: &'a [Mark], pair: &str) -> Result<[&'a Mark; 2]> {
    let named = |name: &str| {
        let found = marks.iter().find(|mark| mark.name == name.trim());
        found.ok_or_else(|| {
            let known: Vec<&str> = marks.iter().map(|mark| mark.name.as_str()).collect();
            usage(format!(
                "no mark is called {name:?}; there are: {}",
                known.join(", ")
            ))
        })
    };
    let (near, far) = pair
        .split_once('=')
        .ok_or_else(|| usage(format!("{pair:?} is not NEAR=FAR, two marks by name")))?;
    Ok([named(near)?, named(far)?])
}

/// Has two marks sighted over, until the sighting can be used.
fn sighting(
    station: &Station,
    [near, far]: [&Mark; 2],
    of: &str,
    closed: &str,
) -> Result<Sighting> {
    let dialogue = &station.dialogue;
    let prompt = format!(
        "{of}: close the {closed} eye, turn the head otherwise than before, bring \"{}\" before \
         \"{}\", hold still, Enter; q ends",
        near.name, far.name
    );
    loop {
        match dialogue.ask_at(&prompt, Some(near.place))? {
            Answer::Enter => {}
            Answer::Quit => return Err(quit()),
            Answer::Words(words) => {
                dialogue.remark(format_args!("{words:?} means nothing here"));
                continue;
            }
        }
        match station.still(DVec3::ZERO, Steadiness::HEAD)? {
            Ok(still) => {
                dialogue.remark("got it");
                return Ok(Sighting {
                    table_from_sensor: still.pose,
                    near: near.place,
                    far: far.place,
                });
            }
            Err(problem) => dialogue.remark(format_args!("again: {problem}")),
        }
    }
}

/// Locates, shows what came out, and leaves out what the user says until it is agreed on.
fn agree(
    dialogue: &Dialogue,
    mut left: Vec<Sighting>,
    mut right: Vec<Sighting>,
    destination: &Destination,
) -> Result<LocatedEyes> {
    loop {
        let found = locate_eyes(&left, &right)?;
        show(&found, dialogue);
        let prompt = format!(
            "{}; l2 leaves out the left eye's sighting 2, r1 the right eye's 1; q ends without",
            destination.enter()
        );
        loop {
            let words = match dialogue.ask(&prompt)? {
                Answer::Enter => return Ok(found),
                Answer::Quit => return Err(quit()),
                Answer::Words(words) => words,
            };
            let side = match words.chars().next() {
                Some('l') => Some(&mut left),
                Some('r') => Some(&mut right),
                _ => None,
            };
            let number = words.get(1..).and_then(|n| n.parse::<usize>().ok());
            match (side, number) {
                (Some(side), Some(number)) if (1..=side.len()).contains(&number) => {
                    side.remove(number - 1);
                    dialogue.remark(format_args!("{words} is left out"));
                    break;
                }
                _ => dialogue.remark(format_args!("{words:?} is no sighting")),
            }
        }
    }
}

fn show(found: &LocatedEyes, dialogue: &Dialogue) {
    for (name, eye) in [("left", &found.left), ("right", &found.right)] {
        show_eye(name, eye, dialogue);
    }
    let [x, y, z] = (1e3 * found.eyes.middle).to_array();
    dialogue.result(format_args!(
        "middle: {x:.1}, {y:.1}, {z:.1} mm in the sensor's axes; {:.1} mm apart, ± {:.1} mm",
        1e3 * found.eyes.interpupillary,
        1e3 * found.interpupillary_error
    ));
}

fn show_eye(name: &str, eye: &Eye, dialogue: &Dialogue) {
    let each: Vec<String> = eye
        .residuals
        .each
        .iter()
        .map(|residual| format!("{:.1}", 1e3 * residual))
        .collect();
    dialogue.result(format_args!(
        "{name} eye: ± {:.1} mm; its lines of sight miss it by {} mm, {:.1} mm RMS",
        1e3 * eye.standard_error(),
        each.join(", "),
        1e3 * eye.residuals.rms
    ));
    for outlier in &eye.outliers {
        dialogue.result(format_args!("note: {outlier}"));
    }
}
