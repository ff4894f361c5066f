//! Large memory in large pages.

/// Asks for pages of 2 MiB for memory that is about to be used for the first time.
///
/// Rays read posts and colours here and there, and with pages of 4 KiB a processor has to look up
/// again and again where one lies: over 16,384² posts that takes up to a fifth of a cast.
///
/// It is a request: where there are no such pages, or less memory than one of them has, all is as
/// before.
pub fn use_huge_pages<T>(memory: &mut [T]) {
    #[cfg(target_os = "linux")]
    linux::use_huge_pages(memory.as_mut_ptr().cast(), size_of_val(memory));
    #[cfg(not(target_os = "linux"))]
    let _ = memory;
}

#[cfg(target_os = "linux")]
mod linux {
    use rustix::mm::{Advice, madvise};
    use rustix::param::page_size;

    const HUGE: usize = 1 << 21;

    pub(super) fn use_huge_pages(begin: *mut u8, bytes: usize) {
        let page = page_size();
        let outside = begin.addr().next_multiple_of(page) - begin.addr();
        let whole = bytes.saturating_sub(outside) / page * page;
        if whole < HUGE {
            return;
        }
        let begin = begin.wrapping_add(outside).cast();
        // SAFETY: whole pages of memory that the caller has, and what they hold stays as it is.
        #[allow(unsafe_code, reason = "no crate asks for a part of what is allocated")]
        let asked = unsafe { madvise(begin, whole, Advice::LinuxHugepage) };
        // A kernel without huge pages refuses.
        asked.unwrap_or_default();
    }

    #[cfg(test)]
    mod tests {
        use crate::use_huge_pages;

        /// The flags of this process's memory at an address, as the kernel tells them.
        fn flags_at(address: usize) -> String {
            let maps = std::fs::read_to_string("/proc/self/smaps").expect("a list of mappings");
            let mut here = false;
            for line in maps.lines() {
                let range = line
                    .split(' ')
                    .next()
                    .and_then(|range| range.split_once('-'));
                let range = range.map(|(a, b)| [a, b].map(|end| usize::from_str_radix(end, 16)));
                if let Some([Ok(begin), Ok(end)]) = range {
                    here = (begin..end).contains(&address);
                } else if here && let Some(flags) = line.strip_prefix("VmFlags:") {
                    return flags.to_owned();
                }
            }
            panic!("no mapping at {address:x}");
        }

        #[test]
        fn large_memory_is_advised_and_keeps_what_it_holds() {
            let mut memory: Vec<u32> = (0..4 << 20).collect();
            use_huge_pages(&mut memory);
            assert!(memory.iter().copied().eq(0..4 << 20));
            if !std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists() {
                println!("skipped: this kernel has no huge pages");
                return;
            }
            let flags = flags_at((&raw const memory[memory.len() / 2]).addr());
            assert!(flags.split_whitespace().any(|flag| flag == "hg"), "{flags}");
        }

        #[test]
        fn little_memory_is_left_alone() {
            let mut memory = vec![0_u8; 1 << 20];
            use_huge_pages(&mut memory);
            use_huge_pages(&mut memory[..0]);
        }
    }
}
