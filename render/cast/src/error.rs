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
    /// The caster's algorithm is not made for such a view.
    #[error("{caster} cannot cast this view: {reason}")]
    View {
        /// The caster's name.
        caster: &'static str,
        /// What is wrong with the view, and what would do.
        reason: String,
    },
}
