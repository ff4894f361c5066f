//! Whether this user may use a device node.

use std::path::Path;

/// Whether this user may read and write the node. Does not open it: opening a serial port moves its
/// modem lines.
pub(super) fn is_granted(node: &Path) -> bool {
    #[cfg(unix)]
    {
        use rustix::fs::{Access, access};
        access(node, Access::READ_OK | Access::WRITE_OK).is_ok()
    }
    #[cfg(not(unix))]
    {
        // There are no nodes, and no permissions to them.
        let _ = node;
        true
    }
}

/// The group to which the node belongs, if the system names one other than root's.
pub(super) fn group_of(node: &Path) -> Option<String> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let group = std::fs::metadata(node).ok()?.gid();
        let groups = std::fs::read_to_string("/etc/group").ok()?;
        group_named(&groups, group)
    }
    #[cfg(not(unix))]
    {
        let _ = node;
        None
    }
}

/// Looks a group up in the text of `/etc/group`: `name:password:id:members`.
#[cfg(unix)]
fn group_named(groups: &str, id: u32) -> Option<String> {
    groups
        .lines()
        .map(|line| line.split(':'))
        .find_map(|mut fields| {
            let name = fields.next()?;
            (fields.nth(1)?.parse() == Ok(id) && id != 0).then(|| name.to_owned())
        })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn groups_are_found_by_their_number() {
        let groups = "root:x:0:\nbroken\ntty:x:5:\ndialout:x:20:anna,ben\n";
        assert_eq!(group_named(groups, 20).as_deref(), Some("dialout"));
        assert_eq!(group_named(groups, 0), None);
        assert_eq!(group_named(groups, 21), None);
    }

    #[test]
    fn what_is_not_there_cannot_be_used() {
        assert!(is_granted(Path::new("/dev/null")));
        assert!(!is_granted(Path::new("/dev/no-such-node")));
    }
}
