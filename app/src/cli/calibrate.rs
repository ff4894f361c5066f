//! Arguments of `calibrate`.

use anyhow::Result;
use clap::{Args, Subcommand};
use sandtable_config::{Mark, Rig, Viewing, load_marks};
use std::convert::Infallible;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
#[command(after_help = "Examples, in this order for a new table:\n  \
    sandtable calibrate stylus --rig lab.toml --sensor flock/2\n  \
    sandtable calibrate tracker --rig lab.toml --marks marks.toml\n  \
    sandtable calibrate field --rig lab.toml --marks many.toml\n  \
    sandtable calibrate check --rig lab.toml --marks marks.toml\n  \
    sandtable calibrate eyes --rig lab.toml --marks marks.toml --pair post=corner")]
pub(crate) struct CalibrateArgs {
    /// What to measure.
    #[command(subcommand)]
    pub(crate) step: CalibrationStep,
}

/// What can be measured.
#[derive(Debug, Subcommand)]
pub(crate) enum CalibrationStep {
    /// How a tracker stands at the table, by touching marks of known place.
    Tracker(CalibrateTrackerArgs),
    /// How a tracker's field is bent by metal, by touching many marks; after tracker.
    Field(CalibrateFieldArgs),
    /// Where the stylus has its tip, by pivoting it on one spot.
    Stylus(CalibrateStylusArgs),
    /// Where the eyes sit on the head, by sighting over pairs of marks.
    Eyes(CalibrateEyesArgs),
    /// How far off three marks are; fails where one is farther off than it may be.
    Check(CalibrateCheckArgs),
}

/// Where marks come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum MarkSource {
    /// A file of marks.
    File(PathBuf),
    /// Six places on the glass, a tenth of its sides in from its edges; a window shows them.
    Glass,
}

impl FromStr for MarkSource {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "glass" => Self::Glass,
            path => Self::File(path.into()),
        })
    }
}

impl fmt::Display for MarkSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Glass => f.write_str("the glass"),
        }
    }
}

/// The places on the glass, by their shares of its width and its depth; the first three tell a
/// tracker that was moved or turned.
const ON_GLASS: [(&str, [f64; 2]); 6] = [
    ("front left", [0.1, 0.1]),
    ("front right", [0.9, 0.1]),
    ("back left", [0.1, 0.9]),
    ("back right", [0.9, 0.9]),
    ("middle left", [0.1, 0.5]),
    ("middle right", [0.9, 0.5]),
];

impl MarkSource {
    /// The marks.
    pub(crate) fn load(&self, rig: &Rig) -> Result<Vec<Mark>> {
        let table = match (self, &rig.viewing) {
            (Self::File(path), _) => return Ok(load_marks(path)?),
            (Self::Glass, Viewing::Table(table)) => table,
            (Self::Glass, Viewing::Desktop(_)) => {
                return Err(crate::exit::usage(format!(
                    "the rig {:?} has no glass that marks could be on; name a file of marks",
                    rig.name
                )));
            }
        };
        let across = table.lower_right - table.lower_left;
        let away = table.upper_left - table.lower_left;
        let mark = |(name, [right, back]): (&str, [f64; 2])| Mark {
            name: name.to_owned(),
            place: table.lower_left + right * across + back * away,
        };
        Ok(ON_GLASS.into_iter().map(mark).collect())
    }
}

/// Whose sensor measures.
#[derive(Debug, Args)]
pub(crate) struct MeasuringArgs {
    /// The rig: workbench, or a rig file.
    #[arg(long, value_name = "RIG")]
    pub(crate) rig: String,

    /// Use this port for a device of the rig, or this address of a VRPN server (may be given once for
    /// each device).
    #[arg(long, value_name = "NAME=PORT")]
    pub(crate) device: Vec<String>,

    /// The sensor that measures, as flock/2; otherwise the rig's stylus, or for eyes its head.
    #[arg(long, value_name = "NAME/N")]
    pub(crate) sensor: Option<String>,
}

/// Where the result goes.
#[derive(Debug, Args)]
pub(crate) struct SavingArgs {
    /// Write a rig of its own here, in place of changing the rig file; it must not exist yet.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Print the lines that would change, and change nothing.
    #[arg(long)]
    pub(crate) dry_run: bool,
}

/// Arguments of `calibrate tracker`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  sandtable calibrate tracker --rig lab.toml --sensor flock/2 --marks marks.toml\n\n\
    The marks, in table metres:\n  [marks]\n  \"front left\" = [-0.90, -0.55, 0.0]\n  \"post\" = [0.0, 0.20, 0.35]"
)]
pub(crate) struct CalibrateTrackerArgs {
    #[command(flatten)]
    pub(crate) measuring: MeasuringArgs,

    /// The marks' places in table metres; or `glass`: six places on the glass, a tenth of its sides
    /// in from its edges.
    #[arg(long, value_name = "FILE")]
    pub(crate) marks: MarkSource,

    #[command(flatten)]
    pub(crate) saving: SavingArgs,
}

/// Arguments of `calibrate field`.
#[derive(Debug, Args)]
#[command(
    after_help = "First `calibrate tracker`, by marks near the tracker; then this, by 30 to 60 marks through all the \
    space that hands and heads move in, a third of them raised. The correction goes into a file beside the rig, \
    lab.flock-field.toml, that the rig names; calibrating the tracker again drops it.\n\n\
    Example:\n  sandtable calibrate field --rig lab.toml --marks many.toml"
)]
pub(crate) struct CalibrateFieldArgs {
    #[command(flatten)]
    pub(crate) measuring: MeasuringArgs,

    /// The marks' places in table metres, at least 8 and not in a plane.
    #[arg(long, value_name = "FILE")]
    pub(crate) marks: MarkSource,

    #[command(flatten)]
    pub(crate) saving: SavingArgs,
}

/// Arguments of `calibrate stylus`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  sandtable calibrate stylus --rig lab.toml --sensor flock/2")]
pub(crate) struct CalibrateStylusArgs {
    #[command(flatten)]
    pub(crate) measuring: MeasuringArgs,

    /// How long the stylus is pivoted, unless Enter ends it.
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    pub(crate) seconds: f64,

    #[command(flatten)]
    pub(crate) saving: SavingArgs,
}

/// Arguments of `calibrate eyes`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  sandtable calibrate eyes --rig lab.toml --marks marks.toml \
    --pair post=\"back left\" --pair post=\"back right\""
)]
pub(crate) struct CalibrateEyesArgs {
    #[command(flatten)]
    pub(crate) measuring: MeasuringArgs,

    /// The marks' places in table metres; some of them raised, as an eye looks over a near mark at a
    /// far one.
    #[arg(long, value_name = "FILE")]
    pub(crate) marks: MarkSource,

    /// A near and a far mark to bring into line; several are taken in turns.
    #[arg(long, value_name = "NEAR=FAR", required = true)]
    pub(crate) pair: Vec<String>,

    /// Sightings with each eye.
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(3..=100))]
    pub(crate) sightings: u32,

    #[command(flatten)]
    pub(crate) saving: SavingArgs,
}

/// Arguments of `calibrate check`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  sandtable calibrate check --rig lab.toml --marks marks.toml --within 5"
)]
pub(crate) struct CalibrateCheckArgs {
    #[command(flatten)]
    pub(crate) measuring: MeasuringArgs,

    /// The marks' places in table metres, or `glass`; the first three are touched.
    #[arg(long, value_name = "FILE")]
    pub(crate) marks: MarkSource,

    /// How far off a mark may be, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = 5.0)]
    pub(crate) within: f64,
}
