//! What may be wrong with a rig.

use std::path::PathBuf;

/// Why a rig cannot be used. Each text names the place and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The file cannot be read at all.
    #[error(
        "cannot read the rig file {path:?} ({source}); name a readable TOML file, or a built-in rig: desktop, workbench"
    )]
    Unreadable {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file of marks cannot be read at all.
    #[error(
        "cannot read the file of marks {path:?} ({source}); name a readable TOML file with [marks]"
    )]
    MarksUnreadable {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is far larger than any rig.
    #[error(
        "the file {path:?} has {size} bytes where a rig or its marks have at most {limit}; name another"
    )]
    TooLarge {
        /// The file that was asked for.
        path: PathBuf,
        /// Its size in bytes.
        size: u64,
        /// The most that is read, in bytes.
        limit: u64,
    },
    /// The text is not TOML.
    #[error("{file}, line {line}: not valid TOML: {problem}")]
    Syntax {
        /// The file, or the name that the text was given under.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What the parser stumbled over.
        problem: String,
    },
    /// A key is missing, unknown, of the wrong type or out of its range.
    #[error("{file}, line {line}: `{key}` {problem}; {remedy}")]
    Invalid {
        /// The file, or the name that the text was given under.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The key with the tables that it lies in, as `devices.flock.baud`.
        key: String,
        /// What is wrong.
        problem: String,
        /// What would be right.
        remedy: String,
    },
    /// No rig of this name is built in.
    #[error("no rig named `{name}` is built in; take desktop or workbench, or a file's path")]
    NoBuiltin {
        /// The name that was asked for.
        name: String,
    },
    /// A sensor was named that the rig does not have.
    #[error("the rig `{rig}` has no sensor `{sensor}`; it has: {known}")]
    NoSensor {
        /// The rig's name.
        rig: String,
        /// The sensor that was asked for.
        sensor: String,
        /// The sensors that it has.
        known: String,
    },
    /// Eyes were measured for a rig without a head.
    #[error(
        "the rig `{rig}` has no head that eyes could sit on; write [head] with `sensor`, `rest` and `eyes`"
    )]
    NoHead {
        /// The rig's name.
        rig: String,
    },
    /// A port was given for a device that the rig does not have.
    #[error("the rig `{rig}` has no device `{device}` to give a port; it has: {known}")]
    NoDevice {
        /// The rig's name.
        rig: String,
        /// The device that was asked for.
        device: String,
        /// The devices that it has.
        known: String,
    },
    /// An address given beside the rig is not one.
    #[error("`{address}` is no device of a VRPN server: {remedy}")]
    BadAddress {
        /// What was given.
        address: String,
        /// What would be right.
        remedy: &'static str,
    },
    /// A port given beside the rig is not one.
    #[error("`{port}` is not a serial port: {remedy}")]
    BadPort {
        /// What was given.
        port: String,
        /// What would be right.
        remedy: String,
    },
}
