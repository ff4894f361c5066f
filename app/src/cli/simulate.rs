//! The grammar of `sandtable simulate`.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand, ValueEnum};
use sandtable_input::flock::Motion;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  sandtable simulate flock --birds 2 --link /tmp/flock\n  \
    sandtable simulate pinch --motion grab --link /tmp/pinch\n  \
    sandtable simulate glove --hand right --vrpn 127.0.0.1:3883"
)]
pub(crate) struct SimulateArgs {
    /// Which device.
    #[command(subcommand)]
    pub(crate) device: SimulatedDevice,
}

/// A device that can be simulated.
#[derive(Debug, Subcommand)]
pub(crate) enum SimulatedDevice {
    /// An Ascension Flock of Birds in group mode.
    Flock(SimulateFlockArgs),
    /// Fakespace PINCH gloves: the box with its two gloves.
    Pinch(SimulatePinchArgs),
    /// A 5DT Data Glove Ultra, offered by VRPN: a USB device cannot be on a pseudo-terminal.
    Glove(SimulateGloveArgs),
}

/// Arguments of every simulated device on a serial line.
#[derive(Debug, Args)]
pub(crate) struct SimulatedLineArgs {
    /// Make a link at PATH to the pseudo-terminal, removed at the end.
    #[arg(long, value_name = "PATH")]
    pub(crate) link: Option<PathBuf>,

    /// Read it by its own driver and offer it as a VRPN server at this address, in place of the
    /// pseudo-terminal: 127.0.0.1:3883 without a word.
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        num_args = 0..=1,
        default_missing_value = VRPN_ADDRESS,
        conflicts_with = "link"
    )]
    pub(crate) vrpn: Option<SocketAddr>,

    /// Lose every Nth byte of what it measures.
    #[arg(long, value_name = "N")]
    pub(crate) drop_every: Option<u64>,

    /// Be silent from a second of the motion on, for some seconds; may be repeated.
    #[arg(long, value_name = "AT,FOR", value_parser = parse_stall)]
    pub(crate) stall: Vec<(Duration, Duration)>,
}

/// Where VRPN servers listen that nobody tells otherwise.
const VRPN_ADDRESS: &str = "127.0.0.1:3883";

/// Arguments of `simulate flock`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  sandtable simulate flock --birds 2 --link /tmp/flock\n  \
    sandtable simulate flock --birds 1 --hold 12,3,-5,30,20,10 --baud 9600\n  \
    sandtable simulate flock --vrpn 127.0.0.1:3883"
)]
pub(crate) struct SimulateFlockArgs {
    /// How many birds.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=14))]
    pub(crate) birds: u8,

    /// The address of an Extended Range Controller; the birds take the others.
    #[arg(long, value_name = "ADDRESS", value_parser = clap::value_parser!(u8).range(1..=15))]
    pub(crate) erc: Option<u8>,

    /// The line's speed, which paces the stream.
    #[arg(long, value_name = "B", default_value_t = 115_200, value_parser = parse_flock_baud)]
    pub(crate) baud: u32,

    /// Hold a still pose: inches and degrees in the transmitter's frame; once a bird.
    #[arg(long, value_name = "X,Y,Z,AZ,EL,ROLL", allow_hyphen_values = true, value_parser = parse_hold)]
    pub(crate) hold: Vec<[f64; 6]>,

    /// Move as the Flock of this recording did, again and again.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["hold", "motion"])]
    pub(crate) from: Option<PathBuf>,

    /// Take poses from standard input: a line BIRD,X,Y,Z,AZ,EL,ROLL holds that bird there from now
    /// on, and is answered by its bird's number.
    #[arg(long)]
    pub(crate) steer: bool,

    /// The motion of birds that are not held.
    #[arg(long, value_name = "MOTION", default_value = "circle", value_parser = motions())]
    pub(crate) motion: Motion,

    /// Damage every Nth record: a byte lost, or a phase bit turned, at each place in turn.
    #[arg(long, value_name = "N")]
    pub(crate) damage_every: Option<u64>,

    #[command(flatten)]
    pub(crate) line: SimulatedLineArgs,
}

/// A hand that has a glove.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum GloveHand {
    /// The left hand.
    Left,
    /// The right hand.
    Right,
}

/// Arguments of `simulate pinch`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  sandtable simulate pinch --motion grab --link /tmp/pinch\n  \
    sandtable simulate pinch --from today.mcap --vrpn\n  \
    echo 'L:thumb+index, R:thumb+middle' | sandtable simulate pinch --steer"
)]
pub(crate) struct SimulatePinchArgs {
    /// What the fingers do: open, pinch, grab (the right hand, by turns), or play (both, by chance);
    /// without a word play, or open where they are steered.
    #[arg(long, value_name = "MOTION")]
    pub(crate) motion: Option<String>,

    /// Touch what the PINCH gloves of this recording touched, again and again.
    #[arg(long, value_name = "FILE", conflicts_with = "motion")]
    pub(crate) from: Option<PathBuf>,

    /// Take contacts from standard input: a line says all fingers that are joined from now on, as
    /// `L:thumb+index, R:thumb+middle` for two groups, `L:thumb R:thumb` for one of both hands, or
    /// `open`, and is answered by the number of its groups.
    #[arg(long)]
    pub(crate) steer: bool,

    /// Have no glove for this hand (may be given for both).
    #[arg(long, value_enum, value_name = "HAND")]
    pub(crate) without: Vec<GloveHand>,

    /// The line's speed.
    #[arg(long, value_name = "B", default_value_t = 9600, value_parser = parse_pinch_baud)]
    pub(crate) baud: u32,

    #[command(flatten)]
    pub(crate) line: SimulatedLineArgs,
}

/// Arguments of `simulate glove`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  sandtable simulate glove --motion pinch\n  \
    sandtable simulate glove --hand left --sensors 14 --hold 0.1,0.2,0.9,0.9,0.8 --vrpn 127.0.0.1:0"
)]
pub(crate) struct SimulateGloveArgs {
    /// The hand that it is for.
    #[arg(long, value_enum, value_name = "HAND", default_value = "right")]
    pub(crate) hand: GloveHand,

    /// How many bend sensors it has: 5, one a finger, or 14.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = parse_sensors)]
    pub(crate) sensors: u8,

    /// What the hand does: open, fist, point, pinch, or play (by chance, after opening and closing
    /// once).
    #[arg(long, value_name = "MOTION", default_value = "play")]
    pub(crate) motion: String,

    /// Hold a still hand: how far each finger is bent, 0 to 1, the thumb first.
    #[arg(long, value_name = "T,I,M,R,L", conflicts_with = "motion", value_parser = parse_flexions)]
    pub(crate) hold: Option<[f64; 5]>,

    /// The most that noise adds to a raw value of 0 to 4095, or takes from it.
    #[arg(long, value_name = "RAW", default_value_t = 2, value_parser = clap::value_parser!(u16).range(0..=100))]
    pub(crate) noise: u16,

    /// The seed of the noise, and of what is played.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Reports a second.
    #[arg(long, value_name = "HZ", default_value_t = 75, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(crate) rate: u16,

    /// The address of its VRPN server, in which it is `glove`.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = VRPN_ADDRESS)]
    pub(crate) vrpn: SocketAddr,
}

/// The motions that have names.
fn motions() -> impl TypedValueParser<Value = Motion> {
    PossibleValuesParser::new(Motion::NAMES)
        .map(|name| Motion::named(&name).expect("each of its names is one"))
}

/// A speed that a Flock's switches can say.
fn parse_flock_baud(text: &str) -> Result<u32, String> {
    const KNOWN: [u32; 7] = [2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200];
    parse_baud(text, &KNOWN).ok_or_else(|| format!("a Flock's line has one of {KNOWN:?} baud"))
}

/// A speed that the rig knows of a PINCH box.
fn parse_pinch_baud(text: &str) -> Result<u32, String> {
    const KNOWN: [u32; 8] = [1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200];
    parse_baud(text, &KNOWN).ok_or_else(|| format!("a PINCH box has one of {KNOWN:?} baud"))
}

fn parse_baud(text: &str, known: &[u32]) -> Option<u32> {
    text.parse().ok().filter(|baud| known.contains(baud))
}

fn parse_sensors(text: &str) -> Result<u8, String> {
    match text {
        "5" => Ok(5),
        "14" => Ok(14),
        _ => Err("a Data Glove Ultra has 5 or 14 sensors".to_owned()),
    }
}

/// `N` finite numbers with commas between them; `wanted` names them.
pub(crate) fn parse_numbers<const N: usize>(text: &str, wanted: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| {
            part.trim()
                .parse::<f64>()
                .ok()
                .filter(|number| number.is_finite())
        })
        .collect::<Option<_>>()
        .ok_or_else(|| format!("{text:?} is not {wanted}"))?;
    let count = numbers.len();
    numbers
        .try_into()
        .map_err(|_| format!("{wanted} are {N} numbers, and these are {count}"))
}

fn parse_hold(text: &str) -> Result<[f64; 6], String> {
    parse_numbers(text, "X,Y,Z,AZ,EL,ROLL in inches and degrees")
}

fn parse_flexions(text: &str) -> Result<[f64; 5], String> {
    let wanted = "T,I,M,R,L from 0 to 1";
    let flexions = parse_numbers(text, wanted)?;
    if flexions.iter().all(|bent| (0.0..=1.0).contains(bent)) {
        Ok(flexions)
    } else {
        Err(format!("{text:?} is not {wanted}"))
    }
}

/// When a stall begins and how long it lasts, in seconds.
fn parse_stall(text: &str) -> Result<(Duration, Duration), String> {
    let seconds = |part: &str| {
        let seconds = part.trim().parse::<f64>().ok()?;
        Duration::try_from_secs_f64(seconds).ok()
    };
    text.split_once(',')
        .and_then(|(at, lasting)| Some((seconds(at)?, seconds(lasting)?)))
        .ok_or_else(|| format!("{text:?} is not AT,FOR in seconds"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Cli, Command};
    use clap::Parser;

    fn parsed(arguments: &str) -> SimulatedDevice {
        let words = ["sandtable", "simulate"]
            .into_iter()
            .chain(arguments.split(' '));
        match Cli::try_parse_from(words).unwrap().command {
            Some(Command::Simulate(simulate)) => simulate.device,
            _ => panic!("not a simulation"),
        }
    }

    #[test]
    fn held_poses_may_be_negative() {
        let flock = parsed("flock --hold -1,2,-3,4,5,6 --hold 0,0,0,0,0,0");
        let SimulatedDevice::Flock(flock) = flock else {
            panic!("not a Flock");
        };
        assert_eq!(flock.hold[0], [-1.0, 2.0, -3.0, 4.0, 5.0, 6.0]);
        assert_eq!(flock.hold.len(), 2);
    }

    #[test]
    fn vrpn_has_an_address_without_a_word() {
        for (arguments, port) in [
            ("pinch --vrpn --baud 1200", Some(3883)),
            ("pinch --vrpn 127.0.0.1:5", Some(5)),
            ("pinch", None),
        ] {
            let SimulatedDevice::Pinch(pinch) = parsed(arguments) else {
                panic!("no PINCH gloves");
            };
            assert_eq!(pinch.line.vrpn.map(|address| address.port()), port);
        }
    }
}
