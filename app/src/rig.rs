//! From the command line's words to a rig.

use crate::exit::usage;
use anyhow::Result;
use sandtable_config::Rig;
use std::path::Path;

/// The rig of that name, or in that file, with its devices' ports replaced as `ports`
/// (`NAME=PORT`) say.
pub(crate) fn open(name: &str, ports: &[String]) -> Result<Rig> {
    let is_file = name.contains(['/', '\\', '.']);
    let mut rig = if is_file {
        Rig::load(Path::new(name))?
    } else {
        Rig::builtin(name).map_err(usage)?
    };
    for port in ports {
        let (device, path) = port.split_once('=').ok_or_else(|| {
            usage(format!(
                "{port:?} is not NAME=PORT, like flock=/dev/ttyUSB1"
            ))
        })?;
        rig.set_port(device, Path::new(path)).map_err(usage)?;
    }
    Ok(rig)
}
