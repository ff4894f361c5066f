//! Whether a device's file may be opened, and by whom if not: told without opening it, since
//! opening a serial port can reset what is plugged into it.

use std::path::Path;

/// Why the file may not be read and written by this process, and what helps; `None` where it may,
/// or where that cannot be told.
#[cfg(unix)]
pub(crate) fn access_problem(path: &Path) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    let metadata = match std::fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) => return Some(format!("cannot be looked at ({error})")),
    };
    let process = Process::of_status(&std::fs::read_to_string("/proc/self/status").ok()?)?;
    let (mode, owner, group) = (metadata.mode(), metadata.uid(), metadata.gid());
    if process.may_use(mode, owner, group) {
        return None;
    }
    let groups = std::fs::read_to_string("/etc/group").unwrap_or_default();
    let name = group_name(&groups, group).filter(|_| group != 0 && mode & 0o060 == 0o060);
    Some(match name {
        Some(name) => format!(
            "only group {name} may use it: `sudo usermod -aG {name} $USER`, then log in again"
        ),
        None => "only root may use it: add a udev rule that gives it to your group".to_owned(),
    })
}

/// Elsewhere than on Unix nothing is told.
#[cfg(not(unix))]
pub(crate) fn access_problem(_path: &Path) -> Option<String> {
    None
}

/// Who this process is.
#[cfg(unix)]
#[derive(Debug, PartialEq)]
struct Process {
    user: u32,
    groups: Vec<u32>,
}

#[cfg(unix)]
impl Process {
    /// Reads it from the text of `/proc/self/status`.
    fn of_status(status: &str) -> Option<Self> {
        let field = |name: &str| -> Option<Vec<u32>> {
            let line = status.lines().find(|line| line.starts_with(name))?;
            line.split_whitespace()
                .skip(1)
                .map(|number| number.parse().ok())
                .collect()
        };
        // Real, effective, saved, file system: access goes by the last.
        let user = *field("Uid:")?.get(3)?;
        let own_group = *field("Gid:")?.get(3)?;
        let mut groups = field("Groups:").unwrap_or_default();
        groups.push(own_group);
        Some(Self { user, groups })
    }

    fn may_use(&self, mode: u32, owner: u32, group: u32) -> bool {
        // The system looks at the first class that fits, even where a later one would allow more.
        let bits = if self.user == 0 {
            return true;
        } else if self.user == owner {
            mode >> 6
        } else if self.groups.contains(&group) {
            mode >> 3
        } else {
            mode
        };
        bits & 0o6 == 0o6
    }
}

/// A group's name in the text of `/etc/group`.
#[cfg(unix)]
fn group_name(groups: &str, id: u32) -> Option<&str> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        let number = fields.nth(1)?;
        (number.parse() == Ok(id)).then_some(name)
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const STATUS: &str = "Name:\tx\nUid:\t1000\t1000\t1000\t1000\nGid:\t100\t100\t100\t100\n\
        Groups:\t20 44 \n";

    #[test]
    fn a_ports_group_opens_it_and_others_do_not() {
        let me = Process::of_status(STATUS).unwrap();
        assert_eq!(me.groups, [20, 44, 100]);
        assert!(me.may_use(0o660, 0, 20));
        assert!(!me.may_use(0o660, 0, 21));
        assert!(me.may_use(0o666, 0, 21));
        assert!(me.may_use(0o600, 1000, 21));
        assert!(!me.may_use(0o640, 0, 20));
        let root = Process::of_status(&STATUS.replace("1000", "0")).unwrap();
        assert!(root.may_use(0o600, 5, 5));
    }

    #[test]
    fn groups_have_names() {
        let groups = "root:x:0:\ndialout:x:20:me\n";
        assert_eq!(group_name(groups, 20), Some("dialout"));
        assert_eq!(group_name(groups, 7), None);
    }

    #[test]
    fn what_is_missing_is_said_and_what_is_open_to_all_is_fine() {
        assert!(access_problem(Path::new("/dev/no-such")).is_some());
        assert_eq!(access_problem(Path::new("/dev/null")), None);
    }
}
