//! Memory that was asked for and not given.

/// The system gives less memory than is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} MiB of memory are needed at once, which the system does not give", .bytes.div_ceil(1 << 20))]
pub struct NoMemory {
    /// How much was asked for; as much as there can be where it is more than that.
    pub bytes: u64,
}

impl NoMemory {
    /// For `count` items.
    pub(crate) fn for_items<T>(count: usize) -> Self {
        Self {
            bytes: (count as u64).saturating_mul(size_of::<T>() as u64),
        }
    }
}
