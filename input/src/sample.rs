//! Samples: what a device has measured, and when.
//!
//! Every kind of device speaks in these, so that nothing behind the drivers knows a Flock from a
//! VRPN server or one glove from another.

use sandtable_pose::{Nanos, Rigid};

/// Something that a device's sensor has measured at one time.
///
/// Sensors are numbered from 1 on their device. Times of one sensor never go back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// Where a sensor is.
    Pose(PoseSample),
    /// Which of a sensor's buttons are pressed.
    Buttons(ButtonsSample),
    /// How far a sensor's axes are out.
    Axes(AxesSample),
    /// How a hand's fingers are.
    Hand(HandSample),
}

impl Sample {
    /// The sensor's number on its device.
    #[must_use]
    pub fn sensor(&self) -> u32 {
        match self {
            Self::Pose(sample) => sample.sensor,
            Self::Buttons(sample) => sample.sensor,
            Self::Axes(sample) => sample.sensor,
            Self::Hand(sample) => sample.sensor,
        }
    }

    /// When it was measured.
    #[must_use]
    pub fn time(&self) -> Nanos {
        match self {
            Self::Pose(sample) => sample.time,
            Self::Buttons(sample) => sample.time,
            Self::Axes(sample) => sample.time,
            Self::Hand(sample) => sample.time,
        }
    }

    /// The pose, where it is one.
    #[must_use]
    pub fn pose(&self) -> Option<&PoseSample> {
        match self {
            Self::Pose(sample) => Some(sample),
            _ => None,
        }
    }
}

/// One sensor's pose at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSample {
    /// The sensor's number on its device, from 1.
    pub sensor: u32,
    /// When it was measured; for a serial line, when its first byte was on it.
    pub time: Nanos,
    /// The pose in the table's frame, in metres.
    pub table_from_sensor: Rigid,
    /// Whether the device has repeated itself for so long that it must be frozen.
    pub frozen: bool,
}

/// One sensor's buttons at one time, all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ButtonsSample {
    /// The sensor's number on its device, from 1.
    pub sensor: u32,
    /// When they were read.
    pub time: Nanos,
    /// Bit n is set while button n, from 0, is pressed.
    pub pressed: u64,
}

/// The most axes that a sensor has.
pub const AXES: usize = 32;

/// One sensor's axes at one time, all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxesSample {
    /// The sensor's number on its device, from 1.
    pub sensor: u32,
    /// When they were read.
    pub time: Nanos,
    /// The axes from 0 on, in the device's own units (VRPN: mostly −1 to 1); 0 from `count` on.
    pub values: [f64; AXES],
    /// How many there are.
    pub count: usize,
}

/// How one hand's fingers are at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandSample {
    /// The glove's number on its device, from 1; of a pair, 1 is the left and 2 the right hand.
    pub sensor: u32,
    /// When it was read.
    pub time: Nanos,
    /// The fingers.
    pub hand: HandState,
}

/// A hand's fingers, thumb first, little finger last; only what the glove can measure.
///
/// Of a hand that is let go, because its glove is lost or its messages are damaged, nothing is
/// known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HandState {
    /// How far each finger is bent.
    pub flexion: [Option<Flexion>; 5],
    /// Which fingertips touch.
    pub contacts: Option<Contacts>,
}

/// How far a finger is bent at its joints, from 0, straight, to 1, as far as it goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flexion {
    /// At the knuckle.
    pub near: f64,
    /// At the joint after it. A glove with one sensor a finger has the same here.
    pub far: f64,
}

impl Flexion {
    /// That of a finger with one sensor.
    #[must_use]
    pub fn of_one_sensor(bent: f64) -> Self {
        Self {
            near: bent,
            far: bent,
        }
    }

    /// The finger's flexion in one number: the mean of its joints, so that 0 is a straight finger,
    /// 1 one bent at both, and both joints count on the way.
    #[must_use]
    pub fn mean(self) -> f64 {
        0.5 * (self.near + self.far)
    }

    /// The joint that is bent further.
    #[must_use]
    pub fn higher(self) -> f64 {
        self.near.max(self.far)
    }

    /// The joint that is bent less.
    #[must_use]
    pub fn lower(self) -> f64 {
        self.near.min(self.far)
    }
}

/// A set of fingers: bit 0 is the thumb, bit 4 the little finger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Fingers(pub u8);

impl Fingers {
    /// The thumb.
    pub const THUMB: Self = Self(1);
    /// The index finger.
    pub const INDEX: Self = Self(1 << 1);
    /// The middle finger.
    pub const MIDDLE: Self = Self(1 << 2);
    /// The ring finger.
    pub const RING: Self = Self(1 << 3);
    /// The little finger.
    pub const LITTLE: Self = Self(1 << 4);
    /// All five.
    pub const ALL: Self = Self(0b1_1111);

    /// Whether all of `others` are among them.
    #[must_use]
    pub fn contains(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those of either set.
    #[must_use]
    pub fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Those that are not among `others`.
    #[must_use]
    pub fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    /// The finger with this number: 0 is the thumb, 4 the little finger.
    #[must_use]
    pub fn number(finger: usize) -> Self {
        Self(1 << finger.min(7)).only(Self::ALL)
    }

    /// Those that are among `others`, too.
    #[must_use]
    pub fn only(self, others: Self) -> Self {
        Self(self.0 & others.0)
    }

    /// How many there are.
    #[must_use]
    pub fn count(self) -> u32 {
        self.0.count_ones()
    }
}

/// Which fingertips of a hand touch which.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contacts {
    /// For each finger, the fingers of the same hand that it is joined with, itself not counted.
    pub own: [Fingers; 5],
    /// For each finger, the fingers of the other hand that it is joined with.
    pub other: [Fingers; 5],
}

impl Contacts {
    /// The fingers that touch any other, of either hand.
    #[must_use]
    pub fn fingers(&self) -> Fingers {
        let joined = |finger: &usize| !self.own[*finger].with(self.other[*finger]).is_empty();
        let fingers = (0..5).filter(joined).map(Fingers::number);
        fingers.fold(Fingers::default(), Fingers::with)
    }
}
