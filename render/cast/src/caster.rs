//! The interface that every caster stands behind.

use crate::{Brute, Coherent, Image};
use sandtable_terrain::{Ground, TileIndex};
use sandtable_view::View;
use std::sync::Arc;

/// An immutable snapshot of everything that can be seen.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The solid ground.
    pub ground: Arc<Ground>,
}

impl Scene {
    /// A scene of bare ground.
    #[must_use]
    pub fn new(ground: Ground) -> Arc<Self> {
        Arc::new(Self {
            ground: Arc::new(ground),
        })
    }
}

/// A way of casting: it prepares scenes, and the prepared scenes cast views.
pub trait Caster: Send + Sync {
    /// The name by which users ask for it.
    fn name(&self) -> &'static str;

    /// One line for help texts: what it does and how exact it is.
    fn summary(&self) -> &'static str;

    /// Makes from `scene` whatever this caster needs, tile by tile, on the current thread pool.
    fn prepare(&self, scene: Arc<Scene>) -> Arc<dyn PreparedScene>;
}

/// A scene, with what its caster has made of it.
pub trait PreparedScene: Send + Sync {
    /// The scene that is cast.
    fn scene(&self) -> &Arc<Scene>;

    /// Prepares `scene`, which differs from this one in the tiles `changed` only, by renewing what
    /// depends on them and sharing the rest.
    fn updated(&self, scene: Arc<Scene>, changed: &[TileIndex]) -> Arc<dyn PreparedScene>;

    /// Casts each view into the image beside it, as one job of the current thread pool.
    ///
    /// `images` are first set to their views' sizes; their memory is reused.
    ///
    /// # Panics
    /// Where `views` and `images` differ in number.
    fn cast(&self, views: &[View], images: &mut [Image]);
}

/// All casters, the default one first.
pub const CASTERS: [&dyn Caster; 2] = [&Coherent, &Brute];

/// The caster of that name.
#[must_use]
pub fn caster_by_name(name: &str) -> Option<&'static dyn Caster> {
    CASTERS.into_iter().find(|caster| caster.name() == name)
}
