//! What is measured.

/// The casters, as `sandtable bench --caster` takes them.
pub(crate) const MEASURED: [&str; 2] = ["planes", "coherent"];

/// The numbers of threads.
pub(crate) const THREADS: [usize; 2] = [1, 2];
