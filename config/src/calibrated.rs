//! Writing what was measured into a rig's text, which stays as people wrote it otherwise.

use crate::beside::Beside;
use crate::{Rig, RigError, SensorName};
use glam::{DQuat, DVec3};
use sandtable_pose::Rigid;
use time::Date;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// Decimals of metres that are written: a thousandth of a millimetre.
pub(crate) const METRE_DECIMALS: i32 = 6;

/// Decimals of quaternions and directions: a micrometre at 100 m.
pub(crate) const ROTATION_DECIMALS: i32 = 9;

/// An entry of a rig that was measured at the table.
#[derive(Clone, Debug, PartialEq)]
pub enum Calibrated {
    /// How a tracker stands at the table: `table_from_tracker` of a device. A `correction` of its
    /// field was measured for where it stood before, and is named no more.
    Tracker {
        /// The device's name.
        device: String,
        /// From the transmitter's frame to the table's.
        table_from_tracker: Rigid,
    },
    /// How a tracker's field is bent: `correction` of a device. The day stands in its file.
    Field {
        /// The device's name.
        device: String,
        /// The correction's file, from the rig's folder; [`FieldCorrection::compose`](crate::FieldCorrection::compose) says what is
        /// in it.
        file: String,
    },
    /// Where a stylus has its tip: `[stylus]`.
    Stylus {
        /// The sensor on it.
        sensor: SensorName,
        /// The tip in the sensor's own axes, in metres.
        tip: DVec3,
    },
    /// Where the eyes sit on the head: `eyes` of `[head]`, in the head sensor's axes and metres.
    Eyes {
        /// The middle between the eyes.
        middle: DVec3,
        /// The unit vector from the left eye to the right eye.
        rightwards: DVec3,
        /// The distance between the eyes.
        interpupillary: f64,
    },
}

impl Calibrated {
    /// `text`, a rig, with this entry and the day it was measured in it. Comments, order and every
    /// other entry stay as they are. Errors call the rig `file`; the files that it names are not
    /// read.
    ///
    /// # Errors
    /// Where `text` is no rig, or has no device or head that the entry belongs to.
    pub fn write_into(&self, text: &str, file: &str, date: Date) -> Result<String, RigError> {
        let rig = Rig::parse_beside(text, file, Beside::Unread)?;
        self.admit(&rig)?;
        let is_crlf = text.contains("\r\n");
        let text = text.replace("\r\n", "\n");
        let mut document: DocumentMut =
            text.parse()
                .map_err(|error: toml_edit::TomlError| RigError::Syntax {
                    file: file.to_owned(),
                    line: 1,
                    problem: error.message().to_owned(),
                })?;
        self.write(&mut document, date);
        let mut written = document.to_string();
        if is_crlf {
            written = written.replace('\n', "\r\n");
        }
        Rig::parse_beside(&written, file, Beside::Unread)?;
        Ok(written)
    }

    /// Whether `rig` has what the entry belongs to.
    fn admit(&self, rig: &Rig) -> Result<(), RigError> {
        match self {
            Self::Tracker { device, .. } | Self::Field { device, .. } => {
                rig.sensor(&format!("{device}/1")).map(drop)
            }
            Self::Stylus { sensor, .. } => rig.sensor(&sensor.to_string()).map(drop),
            Self::Eyes { .. } if rig.head.is_none() => Err(RigError::NoHead {
                rig: rig.name.clone(),
            }),
            Self::Eyes { .. } => Ok(()),
        }
    }

    fn write(&self, document: &mut DocumentMut, date: Date) {
        // Comments behind the last entry stay before a new table.
        let behind = document.trailing().as_str().unwrap_or_default().to_owned();
        let is_new = matches!(self, Self::Stylus { .. }) && !document.contains_key("stylus");
        if is_new {
            document.set_trailing("");
        }
        let root = document.as_table_mut();
        let calibrated = ("calibrated", day(date));
        match self {
            Self::Tracker {
                device,
                table_from_tracker,
            } => {
                if let Some(device) = device_in(root, device) {
                    device.remove("correction");
                    let entry = device.entry("table_from_tracker").or_insert(Item::None);
                    if let Some(table) = entry.as_table_mut() {
                        // Other ways to write the rotation.
                        table.remove("axes");
                        table.remove("angles");
                    }
                    let Rigid {
                        rotation,
                        translation,
                    } = *table_from_tracker;
                    set(
                        entry,
                        [
                            ("translation", metres(translation)),
                            ("quaternion", quaternion(rotation)),
                            calibrated,
                        ],
                    );
                }
            }
            Self::Field { device, file } => {
                if let Some(device) = device_in(root, device) {
                    let entry = device.entry("correction").or_insert(Item::None);
                    put(entry, file.as_str().into());
                }
            }
            Self::Stylus { sensor, tip } => {
                let stylus = root.entry("stylus").or_insert_with(|| {
                    let mut table = Table::new();
                    let end = if behind.is_empty() || behind.ends_with('\n') {
                        ""
                    } else {
                        "\n"
                    };
                    table
                        .decor_mut()
                        .set_prefix(format!("{behind}{end}{STYLUS}"));
                    Item::Table(table)
                });
                set(
                    stylus,
                    [
                        ("sensor", sensor.to_string().into()),
                        ("tip", metres(*tip)),
                        calibrated,
                    ],
                );
            }
            Self::Eyes {
                middle,
                rightwards,
                interpupillary,
            } => {
                let head = root.get_mut("head").and_then(Item::as_table_like_mut);
                if let Some(head) = head {
                    set(
                        head.entry("eyes").or_insert(Item::None),
                        [
                            ("middle", metres(*middle)),
                            (
                                "rightwards",
                                numbers(rightwards.to_array(), ROTATION_DECIMALS),
                            ),
                            (
                                "interpupillary",
                                rounded(*interpupillary, METRE_DECIMALS).into(),
                            ),
                            calibrated,
                        ],
                    );
                }
            }
        }
    }
}

/// What stands above a new `[stylus]`.
const STYLUS: &str =
    "\n# Marks are touched with its tip, here in its sensor's own axes and metres.\n";

/// The table of a device.
fn device_in<'a>(root: &'a mut Table, device: &str) -> Option<&'a mut dyn TableLike> {
    root.get_mut("devices")?
        .as_table_like_mut()?
        .get_mut(device)?
        .as_table_like_mut()
}

/// Gives an entry these values. One on a line of its own keeps the comment behind it; a table with
/// a header keeps its other keys and every comment.
fn set<const N: usize>(entry: &mut Item, values: [(&str, Value); N]) {
    if let Some(table) = entry.as_table_mut() {
        for (key, value) in values {
            put(table.entry(key).or_insert(Item::None), value);
        }
    } else {
        put(entry, Value::from(InlineTable::from_iter(values)));
    }
}

/// Puts a value into an item's place, with the blanks and comments around the one it replaces.
fn put(item: &mut Item, mut value: Value) {
    if let Some(old) = item.as_value() {
        *value.decor_mut() = old.decor().clone();
    }
    *item = Item::Value(value);
}

fn metres(place: DVec3) -> Value {
    numbers(place.to_array(), METRE_DECIMALS)
}

/// As a rig has it: w first, and of q and -q the one with w above 0.
fn quaternion(rotation: DQuat) -> Value {
    let q = if rotation.w < 0.0 {
        -rotation
    } else {
        rotation
    };
    numbers([q.w, q.x, q.y, q.z], ROTATION_DECIMALS)
}

fn numbers<const N: usize>(numbers: [f64; N], decimals: i32) -> Value {
    Array::from_iter(numbers.map(|number| rounded(number, decimals))).into()
}

pub(crate) fn rounded(number: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    // Adding 0 makes a plain 0 of a negative one.
    (number * scale).round() / scale + 0.0
}

fn day(date: Date) -> Value {
    toml_edit::Datetime {
        date: Some(toml_edit::Date {
            year: u16::try_from(date.year()).unwrap_or_default(),
            month: date.month().into(),
            day: date.day(),
        }),
        time: None,
        offset: None,
    }
    .into()
}
