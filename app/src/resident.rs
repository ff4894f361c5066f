//! How much memory the program holds.

/// The most memory that the program has held so far, in bytes, where the system tells.
pub(crate) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn the_peak_grows_with_what_is_held() {
        let before = super::peak_bytes().unwrap();
        let held = vec![1u8; 64 << 20];
        let after = super::peak_bytes().unwrap();
        assert!(held.iter().all(|&byte| byte == 1));
        assert!(after >= 64 << 20 && after >= before, "{before} {after}");
    }
}
