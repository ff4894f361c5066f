//! Remedies in the words of the system at hand.

use std::path::Path;

/// How to install what Debian calls by these names.
pub(super) fn install(packages: &[&str]) -> String {
    let packages = packages.join(" ");
    if Path::new("/usr/bin/apt-get").exists() {
        format!("sudo apt install {packages}")
    } else {
        format!("install what Debian calls {packages} (`make deps` has the names elsewhere)")
    }
}

/// How to join a group that may use a device.
pub(super) fn join_group(group: &str) -> String {
    format!("sudo usermod -aG {group} $USER, then log out and in again")
}
