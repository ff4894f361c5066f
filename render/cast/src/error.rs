//! Why a caster cannot be had, or cannot cast.

use sandtable_terrain::VoxelError;

/// What goes wrong between a caster's name and its image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CastError {
    /// There is no such caster.
    #[error("no caster is called {name:?}: use {known}")]
    UnknownCaster {
        /// What was asked for.
        name: String,
        /// All casters' names.
        known: String,
    },
    /// The caster has no such option.
    #[error("{caster} has no option {option:?}: {known}")]
    UnknownOption {
        /// The caster's name.
        caster: &'static str,
        /// What was asked for.
        option: String,
        /// What options it has.
        known: String,
    },
    /// An option's value is none that it can have.
    #[error("{caster}: {option} = {value:?}, but it must be {expected}")]
    BadValue {
        /// The caster's name.
        caster: &'static str,
        /// The option's name.
        option: String,
        /// Its value as it was given.
        value: String,
        /// What values it can have.
        expected: String,
    },
    /// No voxels can be made so.
    #[error("{caster}: {error}")]
    Voxels {
        /// The caster's name.
        caster: &'static str,
        /// What is wrong.
        error: VoxelError,
    },
    /// There is not the memory for an image.
    #[error(
        "an image of {} by {} pixels needs {} MiB of memory, which the system does not give; \
         make it smaller", size[0], size[1], memory_of(*size) >> 20
    )]
    NoMemory {
        /// Its pixels across and down.
        size: [u32; 2],
    },
    /// The caster's algorithm is not made for such a view.
    #[error("{caster} cannot cast this view: {reason}")]
    View {
        /// The caster's name.
        caster: &'static str,
        /// What is wrong with the view, and what would do.
        reason: String,
    },
}

/// Bytes of an image's colours and depths.
fn memory_of([width, height]: [u32; 2]) -> u64 {
    (u64::from(width) * u64::from(height)).saturating_mul(8)
}
