//! What a window shows: the session's side of it, camera or table, live or replayed.

use super::{HeadTimes, MouseDrive};
use glam::{DVec2, DVec3};
use sandtable_cast::PreparedScene;
use sandtable_input::intent::{DeskState, IntentState};
use sandtable_view::{Attitude, View};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Something to show, moved by people.
pub(crate) trait Show {
    /// Moves on by `step` of real time, at most a quarter of a second, as people ask; tells what
    /// they meant, of which the window does its own part.
    ///
    /// After a rest, in which nothing moved and nobody asked, `step` is that of one frame.
    /// `now` is the time of the call, for shows that look up trackers' poses.
    fn advance(&mut self, drive: &Drive, step: Duration, now: Instant) -> Advanced;

    /// What is to be seen: one view, or for stereo the left and the right eye's.
    ///
    /// `frame` is the size of the window in pixels: it gives the proportions of a camera's
    /// picture, and a table's screen does not depend on it. The window itself sets the views' own
    /// sizes, to what each eye's image is to be cast at.
    fn views(&self, frame: [u32; 2], stereo: bool) -> Vec<View>;

    /// The scene, prepared by the caster in use. Must not wait for preparations.
    fn scene(&self) -> Arc<dyn PreparedScene>;

    /// What the panel says.
    fn readings(&self) -> Readings;

    /// What people can ask for, and by what: meanings and sources.
    fn bindings(&self) -> Vec<(String, String)>;

    /// Does what people asked for at the panel or by a key.
    fn apply(&mut self, wish: Wish);
}

/// What became of a show that was advanced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Advanced {
    /// Whether it moves by itself.
    pub(crate) activity: Activity,
    /// What people meant.
    pub(crate) intents: IntentState,
    /// When the head that the views follow was measured and taken in; `None` where no tracker tells
    /// it now.
    pub(crate) head: Option<HeadTimes>,
}

/// Whether a show moves by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    /// Nothing will change before the next wish, key, or [`super::Waker::wake`].
    Still,
    /// It is to be advanced again for the next frame.
    Moving,
}

/// What people ask for by keyboard and mouse, since the last call.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drive {
    /// The keys and the mouse's buttons that are down; gamepads are the show's own.
    pub(crate) desk: DeskState,
    /// Where the mouse goes.
    pub(crate) mouse: MouseDrive,
}

/// What the panel says about the show.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Readings {
    /// The terrain's name.
    pub(crate) terrain: String,
    /// The eye (for a table: the world point at the middle of the glass), in world metres.
    pub(crate) position: DVec3,
    /// Metres above the ground, if there is ground below.
    pub(crate) above_ground: Option<f64>,
    /// Where the camera looks; of a table only yaw is shown.
    pub(crate) attitude: Attitude,
    /// Metres in the world per second at a full axis.
    pub(crate) speed: f64,
    /// How the world lies on the table, where there is one.
    pub(crate) table: Option<TableReadings>,
    /// The caster in use: one of [`sandtable_cast::CASTERS`], with its options.
    pub(crate) caster: String,
    /// What the hand does.
    pub(crate) hand: HandReadings,
    /// The devices and how they are.
    pub(crate) devices: Vec<Device>,
    /// The step of the calibration that is under way.
    pub(crate) guide: Option<GuideReadings>,
    /// Whether one could be begun.
    pub(crate) can_calibrate: bool,
    /// What people should know, the newest last.
    pub(crate) messages: Vec<String>,
}

/// What the hand does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HandReadings {
    /// What it does when it acts, in a word.
    pub(crate) mode: &'static str,
    /// The ground that it pointed at last, in world metres.
    pub(crate) pointed: Option<DVec3>,
}

/// How the world lies on a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TableReadings {
    /// World metres per table metre.
    pub(crate) scale: f64,
    /// Vertical exaggeration.
    pub(crate) exaggeration: f64,
}

/// A device's line on the panel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Device {
    /// Its name in the rig.
    pub(crate) name: String,
    /// How it is, in a word or two.
    pub(crate) state: String,
    /// Whether it works.
    pub(crate) works: bool,
}

/// A step of the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum GuideStep {
    /// Where the stylus has its tip.
    Stylus,
    /// How the tracker stands at the table.
    Tracker,
    /// How the tracker's field is bent.
    Field,
    /// Where the eyes sit on the head.
    Eyes,
    /// How far off three marks are.
    Check,
}

impl GuideStep {
    /// All of them, in the order in which a new table takes them.
    pub(crate) const ALL: [Self; 5] = [
        Self::Stylus,
        Self::Tracker,
        Self::Field,
        Self::Eyes,
        Self::Check,
    ];

    /// What people call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Stylus => "stylus",
            Self::Tracker => "tracker",
            Self::Field => "field",
            Self::Eyes => "eyes",
            Self::Check => "check",
        }
    }

    /// What it finds out.
    pub(crate) fn meaning(self) -> &'static str {
        match self {
            Self::Stylus => "where the stylus has its tip, by pivoting it",
            Self::Tracker => "how the tracker stands at the table, by touching marks",
            Self::Field => "how metal bends the tracker's field, by touching many marks",
            Self::Eyes => "where the eyes sit on the head, by sighting over marks",
            Self::Check => "how far off three marks are, in ten seconds",
        }
    }
}

/// A step of the calibration, as far as it has come.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GuideReadings {
    /// The step.
    pub(crate) title: &'static str,
    /// What was said, the newest last.
    pub(crate) lines: Vec<String>,
    /// What is asked now.
    pub(crate) question: Option<String>,
    /// The mark that is asked about: from (0, 0) at the glass's upper left to (1, 1) at its lower
    /// right corner.
    pub(crate) mark: Option<DVec2>,
    /// Whether that mark stands above the glass.
    pub(crate) mark_is_raised: bool,
    /// Whether the step has ended.
    pub(crate) ended: bool,
}

/// What people answer in a calibration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum GuideWish {
    /// Begin this step.
    Begin(GuideStep),
    /// This line; an empty one is "now".
    Answer(String),
    /// End the step without a result.
    Stop,
    /// Put away what it said.
    Close,
}

/// What people ask for at the panel or by a key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Wish {
    /// Back to where the show began.
    Home,
    /// Be there, in world metres.
    Position(DVec3),
    /// Look there.
    Attitude(Attitude),
    /// Fly as fast, in metres per second.
    Speed(f64),
    /// Lay the world on the table so.
    Table(TableReadings),
    /// Cast by the caster of that name, one of [`sandtable_cast::CASTERS`].
    Caster(&'static str),
    /// Calibrate.
    Guide(GuideWish),
}
