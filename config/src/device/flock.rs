//! Ascension's Flock of Birds.

use super::port::read_port;
use super::tracking::{read_ages, read_speeds};
use crate::field_correction::read_correction;
use crate::fields::Fields;
use crate::rigid::read_measured_rigid;
use crate::{FieldCorrection, RigError};
use sandtable_pose::Rigid;
use std::time::Duration;
use time::Date;

/// An Ascension Flock of Birds: magnetic trackers, position and attitude of 1 to 14 birds.
#[derive(Clone, Debug, PartialEq)]
pub struct Flock {
    /// The serial port's path.
    pub port: String,
    /// Bits a second, as the units' switches say.
    pub baud: u32,
    /// How many birds there are, 1 to [`Flock::MOST_BIRDS`].
    pub birds: u32,
    /// Whether the birds share the line (FBB addresses from 1); one bird may stand alone.
    pub group: bool,
    /// The address of an Extended Range Controller, if there is one; the birds take the others.
    pub erc_address: Option<u32>,
    /// How units are addressed on the line.
    pub addressing: Addressing,
    /// What a record holds.
    pub format: RecordFormat,
    /// Whether each record brings the state of its bird's buttons.
    pub buttons: bool,
    /// Who sets the pace.
    pub mode: FlockMode,
    /// When a record is believed.
    pub confirm: Confirm,
    /// How far positions reach.
    pub range: Range,
    /// Where sensors are, seen from the transmitter.
    pub hemisphere: Hemisphere,
    /// How the quaternions on the line are meant.
    pub quaternion: QuaternionSign,
    /// Whether to reset the units by the line's RTS before starting them.
    pub reset_with_rts: bool,
    /// The silence before auto-configuration.
    pub silence_before: Duration,
    /// The silence after auto-configuration.
    pub silence_after: Duration,
    /// A pose older than this is held, no longer live.
    pub held_after: Duration,
    /// A pose older than this is lost.
    pub lost_after: Duration,
    /// No sensor is believed to move faster, in metres a second.
    pub max_speed: f64,
    /// No sensor is believed to turn faster, in degrees a second.
    pub max_turn: f64,
    /// From the transmitter's frame (x forward, y right, z down; metres) to the table's.
    pub table_from_tracker: Rigid,
    /// When that was measured, where it was.
    pub calibrated: Option<Date>,
    /// How its field is bent, where that was measured.
    pub correction: Option<FieldCorrection>,
}

impl Flock {
    /// The most birds on one line.
    pub const MOST_BIRDS: u32 = 14;

    /// The birds' addresses on the line, lowest first; empty for one that stands alone.
    #[must_use]
    pub fn addresses(&self) -> Vec<u8> {
        if !self.group {
            return Vec::new();
        }
        (1..=self.units())
            .filter(|address| Some(u32::from(*address)) != self.erc_address)
            .collect()
    }

    /// How many units are on the line, an Extended Range Controller counted too.
    #[must_use]
    pub fn units(&self) -> u8 {
        let units = self.birds + u32::from(self.erc_address.is_some());
        u8::try_from(units).unwrap_or(u8::MAX)
    }
}

/// How units are addressed on the line, as the system's firmware is set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Addressing {
    /// Up to 14 units.
    Normal,
    /// Up to 30.
    Expanded,
    /// Up to 126; addresses go in bytes of their own.
    SuperExpanded,
}

/// What a bird's record holds. What it does not hold of a pose is taken as that of the transmitter:
/// no turn, or no way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RecordFormat {
    /// x, y, z.
    Position,
    /// Azimuth, elevation and roll.
    Angles,
    /// The nine elements of a rotation matrix.
    Matrix,
    /// A quaternion.
    Quaternion,
    /// x, y, z; azimuth, elevation and roll: what birds send after power-up.
    PositionAngles,
    /// x, y, z; a rotation matrix.
    PositionMatrix,
    /// x, y, z; a quaternion.
    PositionQuaternion,
}

impl RecordFormat {
    /// All formats.
    pub const ALL: [Self; 7] = [
        Self::Position,
        Self::Angles,
        Self::Matrix,
        Self::Quaternion,
        Self::PositionAngles,
        Self::PositionMatrix,
        Self::PositionQuaternion,
    ];
}

/// Who sets the pace of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlockMode {
    /// The Flock sends a record of each bird every measuring cycle.
    Stream,
    /// The host asks for each record; nothing is sent that it does not read.
    Point,
}

/// When a record is believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confirm {
    /// As soon as it is whole.
    Immediate,
    /// Once the next record's mark follows it: a doubled byte shows then, a cycle later.
    NextMark,
}

/// How far positions reach along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// 36 inches: 0.11 mm a step.
    Inches36,
    /// 72 inches: 0.22 mm a step.
    Inches72,
    /// 144 inches, of an Extended Range Controller only: 0.45 mm a step.
    Inches144,
}

impl Range {
    /// The full scale in metres.
    #[must_use]
    pub fn metres(self) -> f64 {
        let inches = match self {
            Self::Inches36 => 36.0,
            Self::Inches72 => 72.0,
            Self::Inches144 => 144.0,
        };
        inches * 0.0254
    }
}

/// The half-space that sensors keep to: a magnetic field does not tell p from −p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hemisphere {
    /// x > 0.
    Forward,
    /// x < 0.
    Aft,
    /// y > 0.
    Right,
    /// y < 0.
    Left,
    /// z < 0: above the transmitter.
    Upper,
    /// z > 0: below the transmitter.
    Lower,
}

/// How the quaternions on the line are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuaternionSign {
    /// The line carries the conjugate of transmitter-from-sensor, as the manual has it.
    Conjugate,
    /// The line carries transmitter-from-sensor itself.
    AsSent,
}

pub(super) fn read_flock(fields: &Fields<'_>) -> Result<Flock, RigError> {
    let port = read_port(fields)?;
    let baud = match fields.get("baud") {
        Some(value) => value.one_of(
            &[2400, 4800, 9600, 19200, 38400, 57600, 115_200],
            "as the units' switches 1 to 3 say",
        )?,
        None => 115_200,
    };
    let birds = fields
        .need("birds", "write how many there are, 1 to 14")?
        .integer(1..=Flock::MOST_BIRDS, "birds")?;
    let group = match fields.get("group") {
        Some(value) => {
            let group = value.boolean()?;
            if !group && birds > 1 {
                return Err(value.error(
                    "is false with more than one bird",
                    "write group = true: birds share a line in group mode only",
                ));
            }
            group
        }
        None => true,
    };
    let (range, erc_address) = read_range(fields, birds, group)?;
    let addressing = read_addressing(fields, birds, erc_address)?;
    let quick = |key: &str, default: f64, range| match fields.get(key) {
        Some(value) => value.number(range, "seconds").map(Duration::from_secs_f64),
        None => Ok(Duration::from_secs_f64(default)),
    };
    let (held_after, lost_after) = read_ages(fields)?;
    let (max_speed, max_turn) = read_speeds(fields)?;
    let (table_from_tracker, calibrated) = read_measured_rigid(
        &fields.need(
            "table_from_tracker",
            "write { translation = [..], axes = [..] }: how the transmitter sits at the table",
        )?,
        "translation",
    )?;
    Ok(Flock {
        port,
        baud,
        birds,
        group,
        erc_address,
        addressing,
        format: fields.choice_or(
            "format",
            RecordFormat::PositionQuaternion,
            &[
                ("position", RecordFormat::Position),
                ("angles", RecordFormat::Angles),
                ("matrix", RecordFormat::Matrix),
                ("quaternion", RecordFormat::Quaternion),
                ("position-angles", RecordFormat::PositionAngles),
                ("position-matrix", RecordFormat::PositionMatrix),
                ("position-quaternion", RecordFormat::PositionQuaternion),
            ],
        )?,
        buttons: match fields.get("buttons") {
            Some(value) => value.boolean()?,
            None => false,
        },
        mode: fields.choice_or(
            "mode",
            FlockMode::Stream,
            &[("stream", FlockMode::Stream), ("point", FlockMode::Point)],
        )?,
        confirm: fields.choice_or(
            "confirm",
            Confirm::Immediate,
            &[
                ("immediate", Confirm::Immediate),
                ("next_mark", Confirm::NextMark),
            ],
        )?,
        range,
        hemisphere: fields
            .need(
                "hemisphere",
                "write the half-space of the sensors: \"upper\" for a transmitter under the table",
            )?
            .choice(&[
                ("forward", Hemisphere::Forward),
                ("aft", Hemisphere::Aft),
                ("right", Hemisphere::Right),
                ("left", Hemisphere::Left),
                ("upper", Hemisphere::Upper),
                ("lower", Hemisphere::Lower),
            ])?,
        quaternion: fields.choice_or(
            "quaternion",
            QuaternionSign::Conjugate,
            &[
                ("conjugate", QuaternionSign::Conjugate),
                ("as-sent", QuaternionSign::AsSent),
            ],
        )?,
        reset_with_rts: match fields.get("reset_with_rts") {
            Some(value) => value.boolean()?,
            None => true,
        },
        // Newer manuals ask for 0.6 s of silence on both sides; hosts take more.
        silence_before: quick("silence_before", 1.0, 0.6..=30.0)?,
        silence_after: quick("silence_after", 1.5, 0.6..=30.0)?,
        held_after,
        lost_after,
        max_speed,
        max_turn,
        correction: read_correction(fields, &table_from_tracker)?,
        table_from_tracker,
        calibrated,
    })
}

fn read_addressing(
    fields: &Fields<'_>,
    birds: u32,
    erc_address: Option<u32>,
) -> Result<Addressing, RigError> {
    let addressing = fields.choice_or(
        "addressing",
        Addressing::Normal,
        &[
            ("normal", Addressing::Normal),
            ("expanded", Addressing::Expanded),
            ("super-expanded", Addressing::SuperExpanded),
        ],
    )?;
    let units = birds + u32::from(erc_address.is_some());
    if addressing == Addressing::Normal && units > 14 {
        return Err(fields.error(
            "addressing",
            &format!("is normal, which reaches 14 units, and there are {units}"),
            "write addressing = \"expanded\", or fewer birds",
        ));
    }
    Ok(addressing)
}

fn read_range(
    fields: &Fields<'_>,
    birds: u32,
    group: bool,
) -> Result<(Range, Option<u32>), RigError> {
    let range_value = fields.need("range", "write 36, 72 or 144 inches")?;
    let range = match range_value.one_of(&[36, 72, 144], "inches")? {
        36 => Range::Inches36,
        72 => Range::Inches72,
        _ => Range::Inches144,
    };
    let erc = fields.get("erc_address");
    match (range, &erc) {
        (Range::Inches144, None) => {
            return Err(range_value.error(
                "is 144, which only an Extended Range Controller has",
                "write its address beside it, as erc_address = 1, or a range of 36 or 72",
            ));
        }
        (Range::Inches36 | Range::Inches72, Some(erc)) => {
            return Err(erc.error(
                "stands beside a range under 144",
                "write range = 144: with an Extended Range Controller it is always that",
            ));
        }
        _ => {}
    }
    let address = match erc {
        Some(erc) if !group => {
            return Err(erc.error("stands beside group = false", "write group = true"));
        }
        Some(erc) => Some(erc.integer(1..=birds + 1, "(one above the birds at most)")?),
        None => None,
    };
    Ok((range, address))
}
