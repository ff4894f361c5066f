//! A scene for casters over terrain slices, which read the ground as it is.

use crate::canvas::Canvas;
use crate::slices::SliceFrame;
use crate::tally::Tally;
use crate::units::UnitCaster;
use crate::{CastError, Caster, PreparedScene, Scene};
use sandtable_terrain::{Ground, TileIndex};
use sandtable_view::View;
use std::sync::Arc;

/// A caster that cuts views into slices.
pub(crate) trait SliceCaster: Caster + 'static {
    /// Cuts a view over `ground`, or refuses it.
    fn frame<'a>(&self, ground: &'a Ground, view: &View) -> Result<SliceFrame<'a>, CastError>;
}

/// A scene with nothing prepared.
pub(crate) struct SliceScene<C> {
    caster: C,
    scene: Arc<Scene>,
}

impl<C: SliceCaster> SliceScene<C> {
    pub(crate) fn of(caster: C, scene: Arc<Scene>) -> Arc<dyn PreparedScene> {
        Arc::new(Self { caster, scene })
    }
}

impl<C: SliceCaster> UnitCaster for SliceScene<C> {
    type Frame<'a> = SliceFrame<'a>;

    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        _changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        self.caster.prepare(scene)
    }

    fn frame<'a>(&'a self, view: &'a View) -> Result<SliceFrame<'a>, CastError> {
        self.caster.frame(&self.scene.ground, view)
    }

    /// A unit is a block of columns.
    fn units(frame: &SliceFrame<'_>) -> usize {
        frame.units()
    }

    fn cast_unit<T: Tally>(
        frame: &SliceFrame<'_>,
        unit: usize,
        canvas: &Canvas<'_>,
        tally: &mut T,
    ) {
        frame.cast_unit(unit, canvas, tally);
    }
}
