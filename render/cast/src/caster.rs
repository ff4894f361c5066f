//! The interface that every caster stands behind.

use crate::{CastError, Image, Scheme, Work};
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

/// A way of casting with its options: it prepares scenes, and the prepared scenes cast views.
pub trait Caster: Send + Sync {
    /// Makes from `scene` whatever this caster needs, tile by tile, on the current thread pool.
    ///
    /// # Errors
    /// Where this caster's options do not suit the scene.
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError>;
}

/// A scene, with what its caster has made of it.
pub trait PreparedScene: Send + Sync {
    /// The scene that is cast.
    fn scene(&self) -> &Arc<Scene>;

    /// Prepares `scene`, which differs from this one in the tiles `changed` only, by renewing what
    /// depends on them and sharing the rest.
    ///
    /// # Errors
    /// As [`Caster::prepare`].
    fn updated(
        &self,
        scene: Arc<Scene>,
        changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError>;

    /// Casts each view into the image beside it, as one job of the current thread pool.
    ///
    /// `images` are first set to their views' sizes; their memory is reused.
    ///
    /// # Errors
    /// [`CastError::View`] where this caster is not made for one of the views; no image is changed
    /// then.
    ///
    /// # Panics
    /// Where `views` and `images` differ in number.
    fn cast(&self, views: &[View], images: &mut [Image], scheme: Scheme) -> Result<(), CastError>;

    /// Counts the work that casting `view` takes.
    ///
    /// # Errors
    /// As [`PreparedScene::cast`].
    fn work(&self, view: &View) -> Result<Work, CastError>;
}
