//! The command line.

mod bench;
mod calibrate;
mod reproduce;
mod simulate;

pub(crate) use bench::{BenchArgs, CastersArgs, ViewSet};
pub(crate) use calibrate::{
    CalibrateArgs, CalibrateCheckArgs, CalibrateEyesArgs, CalibrateFieldArgs, CalibrateStylusArgs,
    CalibrateTrackerArgs, CalibrationStep, MarkSource, MeasuringArgs, SavingArgs,
};
pub(crate) use reproduce::{Paper, ReproduceArgs};
pub(crate) use simulate::{
    GloveHand, SimulateArgs, SimulateFlockArgs, SimulateGloveArgs, SimulatePinchArgs,
    SimulatedDevice, SimulatedLineArgs, parse_numbers,
};

use crate::window::GuideStep;
use clap::{Args, Parser, Subcommand, ValueEnum};
use sandtable_cast::Scheme;
use sandtable_stage::StereoMode;
use std::ffi::OsString;
use std::net::SocketAddr;
use std::path::PathBuf;

/// A sand table that you can walk around.
///
/// Shows real terrain in true perspective for a tracked head on a horizontal stereo display, in a
/// window on a desktop, or without any display.
#[derive(Debug, Parser)]
#[command(
    name = "sandtable",
    version,
    max_term_width = 100,
    args_conflicts_with_subcommands = true
)]
pub(crate) struct Cli {
    /// What to do; without a command, `fly`.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,

    /// Without a command: how to fly.
    #[command(flatten)]
    pub(crate) fly: FlyArgs,
}

/// One command of the program.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Open the table and fly over the terrain.
    Fly(FlyArgs),
    /// Print a file's size, coordinate system, extent and statistics.
    Info(InfoArgs),
    /// Render one image, or a flight along a path.
    Render(RenderArgs),
    /// List the casters, with what can be set of each.
    Casters(CastersArgs),
    /// Time casters against each other.
    Bench(BenchArgs),
    /// Redo a paper's measurements and figures, beside the paper's own numbers.
    Reproduce(ReproduceArgs),
    /// Be a device: play a motion on a pseudo-terminal, or as a VRPN server.
    Simulate(SimulateArgs),
    /// Record the rig's devices without opening the table.
    Record(RecordArgs),
    /// Offer the rig's devices to other programs, as a VRPN server.
    ServeVrpn(ServeVrpnArgs),
    /// Find how tracker, stylus and eyes sit, and write it into the rig.
    Calibrate(CalibrateArgs),
    /// List what is there to see, hear and touch with, and what is missing.
    Doctor(DoctorArgs),
}

/// Help for the TERRAIN argument, shared by the commands that take one.
const TERRAIN_HELP: &str = "A GeoTIFF, SRTM .hgt or ESRI ASCII grid, or builtin:ridges?size=N&seed=S, or \
     builtin:jacksboro (which is taken where none is given)";

/// Which terrain, with which photograph.
#[derive(Clone, Debug, Args)]
pub(crate) struct TerrainArgs {
    #[arg(help = TERRAIN_HELP)]
    pub(crate) terrain: Option<OsString>,

    /// A photograph to lay over it: GeoTIFF, PNG or JPEG in the same coordinate system.
    #[arg(long, value_name = "FILE")]
    pub(crate) photo: Option<PathBuf>,
}

/// A switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum OnOff {
    /// Yes.
    On,
    /// No.
    Off,
}

/// How both eyes reach the glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum StereoArg {
    /// One image, from the middle of the eyes.
    Mono,
    /// The left eye's image beside the right eye's.
    SideBySide,
    /// The left eye's image above the right eye's.
    TopBottom,
    /// Red for the left eye, cyan for the right.
    Anaglyph,
}

impl StereoArg {
    /// The stage's word for it.
    pub(crate) fn mode(self) -> StereoMode {
        match self {
            Self::Mono => StereoMode::Mono,
            Self::SideBySide => StereoMode::SideBySide,
            Self::TopBottom => StereoMode::TopBottom,
            Self::Anaglyph => StereoMode::Anaglyph,
        }
    }
}

/// Arguments of `fly`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  sandtable fly\n  sandtable fly mountains.tif --photo mountains.jpg --stereo anaglyph\n  \
    sandtable fly --rig workbench --device flock=/dev/ttyUSB1 --record today.mcap\n  \
    sandtable fly --replay today.mcap"
)]
pub(crate) struct FlyArgs {
    #[command(flatten)]
    pub(crate) terrain: TerrainArgs,

    /// The rig: desktop, workbench, or a rig file.
    #[arg(long, value_name = "RIG")]
    pub(crate) rig: Option<String>,

    /// Use this port for a device of the rig, or this address of a VRPN server (may be given once for
    /// each device).
    #[arg(long, value_name = "NAME=PORT")]
    pub(crate) device: Vec<String>,

    /// Fly what was recorded; needs no device. The rig is the recording's own.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["rig", "device", "record"])]
    pub(crate) replay: Option<PathBuf>,

    /// How many times as fast as it was recorded, 0.01 to 100.
    #[arg(long, value_name = "X", default_value_t = 1.0, requires = "replay", value_parser = parse_replay_speed)]
    pub(crate) replay_speed: f64,

    /// Stay at the replay's end, where otherwise a window begins it anew.
    #[arg(long, requires = "replay")]
    pub(crate) once: bool,

    /// Record devices, rig and placement to this file.
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,

    /// Begin with a step of the calibration: `check` touches three marks, ten seconds that tell
    /// whether tracker and table still agree.
    #[arg(long, value_name = "STEP", value_enum, conflicts_with_all = ["replay", "record"])]
    pub(crate) calibrate: Option<GuideStep>,

    /// Marks for calibrating in the window, in table metres; otherwise crosses on the glass.
    #[arg(
        long,
        value_name = "FILE",
        default_value = "glass",
        hide_default_value = true
    )]
    pub(crate) marks: MarkSource,

    /// How both eyes reach the glass, in place of what the rig says.
    #[arg(long, value_enum, value_name = "MODE")]
    pub(crate) stereo: Option<StereoArg>,

    /// Exchange the eyes.
    #[arg(long)]
    pub(crate) swap_eyes: bool,

    /// The caster, with its options: NAME or NAME?KEY=VALUE&KEY=VALUE (see `sandtable casters`).
    #[arg(long, value_name = "CASTER", default_value = "planes")]
    pub(crate) caster: String,

    /// Level of detail: heights and colours at the resolution of what a pixel covers, calm where one
    /// point a pixel would flicker, and faster over large terrains. A table has it, a desktop not.
    #[arg(long, value_enum, value_name = "on|off", num_args = 0..=1, require_equals = true, default_missing_value = "on")]
    pub(crate) lod: Option<OnOff>,

    /// Casting threads; 0 takes one for each core.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads)]
    pub(crate) threads: usize,

    /// Open no window: write the flight to a file, as where there is no display.
    #[arg(long)]
    pub(crate) headless: bool,

    /// Where a flight without a display goes: .avi, .mp4 (needs ffmpeg), or a folder of images.
    #[arg(long, short, value_name = "FILE", default_value = "out/flight.avi")]
    pub(crate) output: PathBuf,

    /// Seconds of flight without a display; a replay lasts as long as its recording.
    #[arg(long, value_name = "S", default_value_t = 8.0)]
    pub(crate) seconds: f64,

    /// Size of the window, or of the frames of a flight without a display.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,

    /// Write the sound of a flight without a display to this WAV file.
    #[arg(long, value_name = "FILE")]
    pub(crate) audio: Option<PathBuf>,

    /// Make no sound.
    #[arg(long)]
    pub(crate) mute: bool,

    /// Print every 5 s how old the tracked head's pose is on the glass, and by which stages.
    #[arg(long, conflicts_with = "replay")]
    pub(crate) latency: bool,
}

/// Arguments of `info`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  sandtable info N42E001.hgt --cell 600,600 --json")]
pub(crate) struct InfoArgs {
    /// A GeoTIFF, SRTM .hgt or ESRI ASCII grid.
    pub(crate) file: PathBuf,

    /// Print this cell's value too: column and row from the top left, from 0.
    #[arg(long, value_name = "COL,ROW", value_parser = parse_cell)]
    pub(crate) cell: Vec<(u32, u32)>,

    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `render`.
#[derive(Debug, Args)]
#[command(
    override_usage = "sandtable render [OPTIONS] <--view <FILE>|--path <FILE>> --output <FILE> [TERRAIN]",
    after_help = "Examples:\n  sandtable render mountains.tif --view ridge.toml -o ridge.png --depth ridge.tif\n  \
    sandtable render mountains.tif --path hike.gpx -o hike.avi --audio hike.wav\n\n\
    A view file, in metres east, north and up of the terrain's south-west post, and degrees:\n  \
    size = [640, 360]\n  \
    eye = [15000.0, -500.0, 3000.0]\n  \
    camera = { yaw = 0.0, pitch = -8.0, roll = 0.0, horizontal_fov = 60.0 }\n\
    yaw is the heading, clockwise from north; pitch is up and roll right wing down where positive.\n\
    docs/views.md has the rest: two eyes, and a window in place of a camera."
)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) terrain: TerrainArgs,

    /// The view file: size, eye, and camera or screen (docs/views.md; see the example below).
    #[arg(long, value_name = "FILE", required_unless_present = "path")]
    pub(crate) view: Option<PathBuf>,

    /// Fly along this GPX track instead; a view file beside it gives size and field of view.
    #[arg(long, value_name = "FILE")]
    pub(crate) path: Option<PathBuf>,

    /// The caster, with its options: NAME or NAME?KEY=VALUE&KEY=VALUE (see `sandtable casters`).
    #[arg(long, value_name = "CASTER", default_value = "planes")]
    pub(crate) caster: String,

    /// Level of detail: heights and colours at the resolution of what a pixel covers, in place of one
    /// point a pixel.
    #[arg(long, value_enum, value_name = "on|off", num_args = 0..=1, require_equals = true, default_missing_value = "on")]
    pub(crate) lod: Option<OnOff>,

    /// Casting threads; 0 takes one for each core.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads)]
    pub(crate) threads: usize,

    /// How the work is shared out among them: stealing, interleave or pool.
    #[arg(long, value_name = "SCHEME", default_value_t)]
    pub(crate) scheme: Scheme,

    /// Both eyes, each at the view's size, in one image.
    #[arg(long, value_enum, value_name = "MODE", default_value = "mono")]
    pub(crate) stereo: StereoArg,

    /// The image (.png or .jpg), or for a flight .avi, .mp4 or a folder.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// Write depth too: a float32 TIFF of metres from the eye, infinite for sky (the left eye's
    /// where there are two).
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    pub(crate) depth: Option<PathBuf>,

    /// Write the flight's sound to this WAV file.
    #[arg(long, value_name = "FILE", requires = "path")]
    pub(crate) audio: Option<PathBuf>,

    /// Metres a second along a track that has no times, and metres above ground where it has no
    /// elevations.
    #[arg(long, value_names = ["SPEED", "HEIGHT"], num_args = 2, default_values_t = [100.0, 150.0])]
    pub(crate) flight: Vec<f64>,
}

/// Arguments of `serve-vrpn`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  sandtable serve-vrpn --rig workbench --device flock=/dev/ttyUSB1\n  \
    sandtable serve-vrpn --rig lab.toml --listen 0.0.0.0:3883"
)]
pub(crate) struct ServeVrpnArgs {
    /// The rig: workbench, or a rig file.
    #[arg(long, value_name = "RIG", default_value = "workbench")]
    pub(crate) rig: String,

    /// Use this port for a device of the rig, or this address of a VRPN server (may be given once for
    /// each device).
    #[arg(long, value_name = "NAME=PORT")]
    pub(crate) device: Vec<String>,

    /// Where to listen: an address of this computer and a port; 0.0.0.0 is all it has, and then
    /// anyone who can reach it hears everything.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:3883")]
    pub(crate) listen: SocketAddr,
}

/// Arguments of `record`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  sandtable record --rig workbench --device flock=/dev/ttyUSB1 -o today.mcap"
)]
pub(crate) struct RecordArgs {
    /// The rig: workbench, or a rig file.
    #[arg(long, value_name = "RIG", default_value = "workbench")]
    pub(crate) rig: String,

    /// Use this port for a device of the rig, or this address of a VRPN server (may be given once for
    /// each device).
    #[arg(long, value_name = "NAME=PORT")]
    pub(crate) device: Vec<String>,

    /// The recording, which must not exist yet.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// Stop after so many seconds; otherwise at Ctrl-C.
    #[arg(long, value_name = "S")]
    pub(crate) seconds: Option<f64>,

    #[command(flatten)]
    pub(crate) terrain: TerrainArgs,
}

/// Arguments of `doctor`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  sandtable doctor\n  \
    sandtable doctor --rig workbench --device flock=/dev/ttyUSB1")]
pub(crate) struct DoctorArgs {
    /// Start the devices of this rig, listen to them for two seconds, and say how each one is:
    /// workbench, or a rig file.
    #[arg(long, value_name = "RIG")]
    pub(crate) rig: Option<String>,

    /// Use this port for a device of the rig, or this address of a VRPN server (may be given once for
    /// each device).
    #[arg(long, value_name = "NAME=PORT", requires = "rig")]
    pub(crate) device: Vec<String>,

    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// `WxH` in pixels.
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let wanted = || format!("{text:?} is not WIDTHxHEIGHT in pixels, like 1280x720");
    let (width, height) = text.split_once('x').ok_or_else(wanted)?;
    let side = |text: &str| match text.parse::<u32>() {
        Ok(side) if (16..=16_384).contains(&side) => Ok(side),
        Ok(_) => Err(format!("{text} is not from 16 to 16384 pixels")),
        Err(_) => Err(wanted()),
    };
    Ok([side(width)?, side(height)?])
}

/// `COL,ROW`.
fn parse_cell(text: &str) -> Result<(u32, u32), String> {
    let wanted = || format!("{text:?} is not COLUMN,ROW, like 12,7");
    let (col, row) = text.split_once(',').ok_or_else(wanted)?;
    Ok((
        col.trim().parse().map_err(|_| wanted())?,
        row.trim().parse().map_err(|_| wanted())?,
    ))
}

/// The most casting threads: more than any machine has processors for one program, and each takes
/// memory.
const MOST_THREADS: usize = 1024;

/// A number of casting threads.
fn parse_threads(text: &str) -> Result<usize, String> {
    let threads = text.parse::<usize>().ok();
    threads
        .filter(|threads| *threads <= MOST_THREADS)
        .ok_or_else(|| {
            format!("{text:?} is not a whole number from 0 (one for each core) to {MOST_THREADS}")
        })
}

/// How many times as fast a recording is replayed.
fn parse_replay_speed(text: &str) -> Result<f64, String> {
    let speed = text.parse::<f64>().ok();
    speed
        .filter(|speed| (0.01..=100.0).contains(speed))
        .ok_or_else(|| format!("{text:?} is not a number from 0.01 to 100"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_grammar_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn flying_needs_no_command() {
        let cli = Cli::parse_from(["sandtable", "mountains.tif", "--stereo", "anaglyph"]);
        assert!(cli.command.is_none());
        assert_eq!(cli.fly.terrain.terrain, Some("mountains.tif".into()));
        assert_eq!(cli.fly.stereo, Some(StereoArg::Anaglyph));
    }

    #[test]
    fn no_command_starts_threads_without_end() {
        for command in ["fly", "render", "bench", "reproduce wan1999"] {
            let parse = |threads: &str| {
                let line = format!("sandtable {command} --threads {threads}");
                let view = ["--view=v.toml", "--output=i.png"];
                let view = view.iter().filter(|_| command == "render");
                Cli::try_parse_from(line.split(' ').chain(view.copied()))
            };
            assert!(parse("1024").is_ok(), "{command}");
            for odd in ["1025", "100000", "99999999999999999999", "-1", "many"] {
                let error = parse(odd).unwrap_err();
                assert_eq!(error.exit_code(), 2);
                assert!(
                    error.to_string().contains("to 1024") || odd == "-1",
                    "{error}"
                );
            }
        }
    }

    #[test]
    fn bad_usage_says_what_is_right() {
        let error = Cli::try_parse_from(["sandtable", "fly", "--size", "12"]).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("1280x720"));
    }
}
