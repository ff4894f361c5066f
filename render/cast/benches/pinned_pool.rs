//! Threads that stay where they are while they are measured.

use anyhow::{Context, Result};
use sandtable_cast::CastPool;

/// A pool whose thread k runs on the k-th of the processors that this program may use, all of
/// them in turn where there are more threads (on Linux; elsewhere threads are not bound).
pub(crate) fn pinned_pool(threads: usize) -> Result<CastPool> {
    let pool = CastPool::new(threads).context("cannot start the casting threads")?;
    #[cfg(target_os = "linux")]
    {
        use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
        // The pool's threads are asked, not the caller: it may be bound itself.
        let bind = |thread: rayon::BroadcastContext<'_>| {
            let allowed = sched_getaffinity(None)?;
            let usable = (0..CpuSet::MAX_CPU).filter(|&cpu| allowed.is_set(cpu));
            if let Some(cpu) = usable.cycle().nth(thread.index()) {
                let mut own = CpuSet::new();
                own.set(cpu);
                sched_setaffinity(None, &own)?;
            }
            Ok::<_, rustix::io::Errno>(())
        };
        pool.run(|| rayon::broadcast(bind))
            .into_iter()
            .collect::<Result<Vec<_>, _>>()
            .context("cannot bind the casting threads to processors")?;
    }
    Ok(pool)
}
