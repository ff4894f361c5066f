//! Random views of random ground, each made anew from its seed: what exact casters are tried on.
//!
//! The seeds go through the kinds of views in turn, so that as many seeds as there are kinds have
//! one of each; the ground, and all else, is drawn.

mod kind;
mod terrains;
#[cfg(test)]
mod tests;

pub use kind::Kind;

use crate::random::Random;
use sandtable_cast::Scene;
use sandtable_view::View;
use std::fmt;
use std::sync::Arc;
use terrains::TERRAINS;

/// Width and height of all views, in pixels.
const SIZE: [u32; 2] = [320, 240];

/// A view of a scene, and what to call it.
#[derive(Clone, Debug)]
pub struct Case {
    /// The seed that it is made of.
    pub seed: u64,
    /// How eye and window were chosen.
    pub kind: Kind,
    /// What the ground is called.
    pub terrain: &'static str,
    /// The ground, shared by all cases over it.
    pub scene: Arc<Scene>,
    /// The view; it is proper.
    pub view: View,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "seed {}, {} over {}, eye {:.2}",
            self.seed, self.kind, self.terrain, self.view.eye
        )
    }
}

/// The case of a seed. The first one over a ground builds it, which the largest takes a second or
/// two for.
#[must_use]
pub fn case(seed: u64) -> Case {
    let kinds = Kind::ALL.len() as u64;
    let kind = Kind::ALL[(seed % kinds) as usize];
    let mut random = Random::new(seed);
    let terrain = random.choose(&TERRAINS);
    let scene = Arc::clone(&terrain.scene);
    let view = kind.view(&scene.ground, &mut random, SIZE);
    Case {
        seed,
        kind,
        terrain: terrain.name,
        scene,
        view,
    }
}
