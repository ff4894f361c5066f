//! Record formats: the command that chooses each, and what its words mean.

use sandtable_config::RecordFormat;

/// How a format is coded on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Coding {
    /// The command that chooses it.
    pub(crate) command: u8,
    /// Its number in a bird's status word.
    pub(crate) number: u16,
    /// Whether its first three words are a position.
    pub(crate) position: bool,
    /// What its other words are.
    pub(crate) attitude: Option<Attitude>,
}

/// How an attitude is coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Attitude {
    /// Azimuth, elevation and roll, 180 degrees to the full scale.
    Angles,
    /// The elements of a rotation matrix.
    Matrix,
    /// A quaternion, scalar first.
    Quaternion,
}

impl Coding {
    /// A format's coding.
    pub(crate) fn of(format: RecordFormat) -> Self {
        let (command, number, position, attitude) = match format {
            RecordFormat::Position => (b'V', 1, true, None),
            RecordFormat::Angles => (b'W', 2, false, Some(Attitude::Angles)),
            RecordFormat::Matrix => (b'X', 3, false, Some(Attitude::Matrix)),
            RecordFormat::PositionAngles => (b'Y', 4, true, Some(Attitude::Angles)),
            RecordFormat::PositionMatrix => (b'Z', 5, true, Some(Attitude::Matrix)),
            RecordFormat::Quaternion => (b'\\', 7, false, Some(Attitude::Quaternion)),
            RecordFormat::PositionQuaternion => (b']', 8, true, Some(Attitude::Quaternion)),
        };
        Self {
            command,
            number,
            position,
            attitude,
        }
    }

    /// How many words a record has.
    pub(crate) fn words(self) -> usize {
        let attitude = match self.attitude {
            None => 0,
            Some(Attitude::Angles) => 3,
            Some(Attitude::Matrix) => 9,
            Some(Attitude::Quaternion) => 4,
        };
        3 * usize::from(self.position) + attitude
    }
}

/// The format that a command chooses, or `None` for any other command.
pub(crate) fn format_of_command(command: u8) -> Option<RecordFormat> {
    RecordFormat::ALL
        .into_iter()
        .find(|&format| Coding::of(format).command == command)
}
