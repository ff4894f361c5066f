//! The rig file as a whole.

use crate::beside::Beside;
use crate::body::{read_hand, read_head};
use crate::controls::{read_flight, read_gamepad};
use crate::device::{VrpnAddress, port_remedy, read_device};
use crate::fields::{Fields, Source, Value, nearest};
use crate::intents::{Intents, read_intents};
use crate::sensor::{SensorSettings, read_sensor_settings};
use crate::stylus::{Stylus, read_stylus};
use crate::text_file::read_text;
use crate::viewing::{read_stereo, read_viewing};
use crate::{Device, Flight, Gamepad, Hand, Head, RigError, SensorName, Stereo, Viewing};
use std::collections::BTreeMap;
use std::path::Path;
use toml::de::DeTable;

/// Everything that stands at one desk or table.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// What people call it.
    pub name: String,
    /// What the picture is seen through.
    pub viewing: Viewing,
    /// Stereo as it starts.
    pub stereo: Stereo,
    /// The viewer's head; every table has one.
    pub head: Option<Head>,
    /// The viewer's hand.
    pub hand: Option<Hand>,
    /// What marks are touched with, where it is known.
    pub stylus: Option<Stylus>,
    /// The devices by name.
    pub devices: BTreeMap<String, Device>,
    /// What is set for single sensors.
    pub sensors: BTreeMap<SensorName, SensorSettings>,
    /// How fast one flies.
    pub flight: Flight,
    /// How a gamepad's sticks are read.
    pub gamepad: Gamepad,
    /// What people mean by keys, buttons, sticks and gestures.
    pub intents: Intents,
    text: String,
}

const BUILTINS: [(&str, &str); 2] = [
    ("desktop", include_str!("../rigs/desktop.toml")),
    ("workbench", include_str!("../rigs/workbench.toml")),
];

impl Rig {
    /// Reads a rig file, and the files beside it that it names.
    ///
    /// # Errors
    /// Where the file cannot be read, is not TOML, or holds anything that is unknown, missing or
    /// out of its range; the same of a file that it names.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let text = read_text(path, |source| RigError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        // Files lie beside the rig itself, not beside a link to it.
        let own = path.canonicalize();
        let own = own.as_deref().unwrap_or(path);
        let folder = own.parent().unwrap_or(Path::new(""));
        Self::parse_beside(&text, &path.display().to_string(), Beside::Folder(folder))
    }

    /// Reads a rig from its text alone; errors call it `file`. No file is read: one that names
    /// another needs [`Rig::parse_with`].
    ///
    /// # Errors
    /// As [`Rig::load`].
    pub fn parse(text: &str, file: &str) -> Result<Self, RigError> {
        Self::parse_with(text, file, &BTreeMap::new())
    }

    /// Reads a rig from its text and those of the files that it names, as [`Rig::files`] gives
    /// them; errors call it `file`.
    ///
    /// # Errors
    /// As [`Rig::load`].
    pub fn parse_with(
        text: &str,
        file: &str,
        files: &BTreeMap<String, String>,
    ) -> Result<Self, RigError> {
        Self::parse_beside(text, file, Beside::Texts(files))
    }

    /// As [`Rig::parse_with`], of a recording's rig: what it asks of devices that cannot give it, which
    /// is refused elsewhere, asked for nothing when it was recorded.
    ///
    /// # Errors
    /// As [`Rig::load`].
    pub fn recorded(
        text: &str,
        file: &str,
        files: &BTreeMap<String, String>,
    ) -> Result<Self, RigError> {
        Self::parse_beside(text, file, Beside::Recorded(files))
    }

    pub(crate) fn parse_beside(
        text: &str,
        file: &str,
        beside: Beside<'_>,
    ) -> Result<Self, RigError> {
        let source = Source { file, text, beside };
        let table = DeTable::parse(text).map_err(|error| source.syntax(&error))?;
        let root = Fields::root(source, table.get_ref());
        let name = root.need("name", "write what people call this rig")?;
        let name = name.text("what people call this rig")?.to_owned();
        let viewing = read_viewing(&root)?;
        let stereo = read_stereo(&root)?;
        let devices = read_devices(&root)?;
        let sensor = |value: &Value<'_>| read_sensor(value, &devices);
        let head = match (&viewing, root.get("head")) {
            (_, Some(value)) => Some(read_head(&value, sensor)?),
            (Viewing::Table(_), None) => {
                return Err(root.error(
                    "head",
                    "is missing",
                    "write [head] with `rest` and `eyes`: a table is seen from them",
                ));
            }
            (Viewing::Desktop(_), None) => None,
        };
        let hand = root
            .get("hand")
            .map(|value| read_hand(&value, sensor))
            .transpose()?;
        let stylus = root
            .get("stylus")
            .map(|value| read_stylus(&value, sensor))
            .transpose()?;
        let sensors = read_sensors(&root, &devices)?;
        let flight = read_flight(&root)?;
        let (gamepad, gamepad_axes) = read_gamepad(&root)?;
        let intents = read_intents(&root, &devices, &gamepad_axes)?;
        root.finish()?;
        Ok(Self {
            name,
            viewing,
            stereo,
            head,
            hand,
            stylus,
            devices,
            sensors,
            flight,
            gamepad,
            intents,
            text: text.to_owned(),
        })
    }

    /// A rig that comes with the program: `desktop` or `workbench`.
    ///
    /// # Errors
    /// [`RigError::NoBuiltin`] for any other name.
    pub fn builtin(name: &str) -> Result<Self, RigError> {
        let text = Self::builtin_text(name)?;
        Self::parse(text, &format!("the built-in rig `{name}`"))
    }

    /// A built-in rig's file, to start one's own from.
    ///
    /// # Errors
    /// [`RigError::NoBuiltin`] for any other name.
    pub fn builtin_text(name: &str) -> Result<&'static str, RigError> {
        BUILTINS
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, text)| *text)
            .ok_or_else(|| RigError::NoBuiltin {
                name: name.to_owned(),
            })
    }

    /// The text that the rig was read from, as recordings keep it.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The texts of the files that it names and whose contents are in force, by the names that it
    /// has for them, as recordings keep them beside [`Rig::text`].
    #[must_use]
    pub fn files(&self) -> BTreeMap<String, String> {
        let corrections = self.devices.values().filter_map(Device::correction);
        corrections
            .map(|correction| (correction.file().to_owned(), correction.text().to_owned()))
            .collect()
    }

    /// The sensor that a command line names, as `flock/2`.
    ///
    /// # Errors
    /// [`RigError::NoSensor`] where the rig has none of that name.
    pub fn sensor(&self, name: &str) -> Result<SensorName, RigError> {
        let found = name.split_once('/').and_then(|(device, number)| {
            let sensors = self.devices.get(device)?.sensors();
            let number = number.parse().ok()?;
            (1..=sensors).contains(&number).then(|| SensorName {
                device: device.to_owned(),
                number,
            })
        });
        found.ok_or_else(|| {
            let known = |(device, kind): (&String, &Device)| match kind.sensors() {
                1 => format!("{device}/1"),
                sensors => format!("{device}/1 to {device}/{sensors}"),
            };
            let known: Vec<String> = self.devices.iter().map(known).collect();
            RigError::NoSensor {
                rig: self.name.clone(),
                sensor: name.to_owned(),
                known: if known.is_empty() {
                    "none".to_owned()
                } else {
                    known.join(", ")
                },
            }
        })
    }

    /// Gives a device another port, as a command line may, or one of a VRPN server another address.
    /// The text stays as it was read.
    ///
    /// # Errors
    /// [`RigError::NoDevice`] for an unknown device, [`RigError::BadPort`] for what is no port.
    pub fn set_port(&mut self, device: &str, port: &Path) -> Result<(), RigError> {
        let bad = |remedy: &str| RigError::BadPort {
            port: port.display().to_string(),
            remedy: remedy.to_owned(),
        };
        let known = || {
            let names: Vec<&str> = self.devices.keys().map(String::as_str).collect();
            if names.is_empty() {
                "none".to_owned()
            } else {
                names.join(", ")
            }
        };
        if !self.devices.contains_key(device) {
            return Err(RigError::NoDevice {
                rig: self.name.clone(),
                device: device.to_owned(),
                known: known(),
            });
        }
        if let Some(Device::Vrpn(vrpn)) = self.devices.get_mut(device) {
            let text = port.display().to_string();
            let address = VrpnAddress::parse(&text).map_err(|remedy| RigError::BadAddress {
                address: text.clone(),
                remedy,
            })?;
            vrpn.move_to(address);
            return Ok(());
        }
        let plain = port.to_str().ok_or_else(|| bad("its path is not UTF-8"))?;
        if plain.is_empty() {
            return Err(bad(&format!(
                "write it after the `=`, as {device}=/dev/ttyUSB0 (or {device}=COM3)"
            )));
        }
        let text = if plain.starts_with("COM") {
            plain.to_owned()
        } else {
            // A shell's relative path means the folder that the program runs in.
            let absolute = std::path::absolute(port).map_err(|error| bad(&error.to_string()))?;
            absolute.display().to_string()
        };
        if let Some(remedy) = port_remedy(&text) {
            return Err(bad(remedy));
        }
        match self.devices.get_mut(device).and_then(Device::port_mut) {
            Some(port) => *port = text,
            None => {
                return Err(bad(&format!(
                    "the device `{device}` is on no serial port and of no VRPN server"
                )));
            }
        }
        Ok(())
    }
}

fn read_devices(root: &Fields<'_>) -> Result<BTreeMap<String, Device>, RigError> {
    let mut devices: BTreeMap<String, Device> = BTreeMap::new();
    let Some(value) = root.get("devices") else {
        return Ok(devices);
    };
    let fields = value.fields()?;
    for name in fields.keys() {
        let Some(value) = fields.get(&name) else {
            continue;
        };
        let plain = !name.is_empty()
            && name.len() <= 40
            && name
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || b == b'-' || b == b'_');
        if !plain {
            return Err(value.error(
                "is not a device's name",
                "name it with letters, digits, - and _ only",
            ));
        }
        let device = read_device(&value)?;
        let shares = |other: &&String| devices[*other].port() == device.port();
        if !value.is_recorded()
            && let Some(port) = device.port()
            && let Some(other) = devices.keys().find(shares)
        {
            let problem = format!("is {port:?}, as that of `{other}`");
            let remedy = "write the port that this device is on: a serial line has one device";
            let place = value.fields()?.get("port");
            return Err(place.as_ref().unwrap_or(&value).error(&problem, remedy));
        }
        devices.insert(name, device);
    }
    fields.finish()?;
    Ok(devices)
}

/// The table `sensors`, in which each key is a sensor's name.
fn read_sensors(
    root: &Fields<'_>,
    devices: &BTreeMap<String, Device>,
) -> Result<BTreeMap<SensorName, SensorSettings>, RigError> {
    let mut sensors = BTreeMap::new();
    let Some(value) = root.get("sensors") else {
        return Ok(sensors);
    };
    let fields = value.fields()?;
    for key in fields.keys() {
        if let Some(value) = fields.get(&key) {
            let name = sensor_name(&key, &value, devices)?;
            sensors.insert(name, read_sensor_settings(&value)?);
        }
    }
    fields.finish()?;
    Ok(sensors)
}

/// `flock/1`: a device of this rig, and one of its sensors.
fn read_sensor(
    value: &Value<'_>,
    devices: &BTreeMap<String, Device>,
) -> Result<SensorName, RigError> {
    let text = value.text("a sensor such as \"flock/1\"")?;
    sensor_name(text, value, devices)
}

/// The sensor that `text` names; `value` is what is wrong where there is none.
fn sensor_name(
    text: &str,
    value: &Value<'_>,
    devices: &BTreeMap<String, Device>,
) -> Result<SensorName, RigError> {
    let remedy = "write a device of this rig and its sensor's number, as \"flock/1\"";
    let problem = format!("is {text:?}");
    let Some((device, number)) = text.split_once('/') else {
        return Err(value.error(&problem, remedy));
    };
    let Some(known) = devices.get(device) else {
        let names: Vec<&str> = devices.keys().map(String::as_str).collect();
        let remedy = match nearest(device, &names) {
            Some(near) => format!("did you mean \"{near}/{number}\"?"),
            None => format!("no device is named `{device}`; write [devices.{device}]"),
        };
        return Err(value.error(&problem, &remedy));
    };
    match number.parse::<u32>() {
        _ if !known.has_poses() => Err(value.error(
            &format!("is {text:?}, and `{device}` does not tell where it is"),
            "write a tracker's sensor: a glove tells of its fingers only",
        )),
        Ok(number) if (1..=known.sensors()).contains(&number) => Ok(SensorName {
            device: device.to_owned(),
            number,
        }),
        _ => Err(value.error(
            &problem,
            &format!("`{device}` has the sensors 1 to {}", known.sensors()),
        )),
    }
}
