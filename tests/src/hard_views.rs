//! Hard views of hard ground, all drawn anew from a seed: what no one would ask for, and what finds
//! where a caster's numbers end.
//!
//! Grounds of 2 posts a side and more, as wide as they are long or a thousand times as narrow, as
//! flat as a lake or all cliffs, up to a million cells high; eyes a billionth of a cell before a
//! wall, on posts, on borders, or so far away that pixels are cast alone; windows of almost half of
//! all directions and of a millionth of one, sheared, mirrored, or one pixel wide.

mod eyes;
mod grounds;
mod windows;

use crate::random::Random;
use eyes::Standing;
use glam::DVec3;
use grounds::ground;
use sandtable_cast::Scene;
use sandtable_view::View;
use std::fmt;
use std::sync::Arc;
use windows::window;

/// How many views there are of a ground: to make it takes about as long as to judge one.
const VIEWS: usize = 4;

/// A view of hard ground, and what to call it.
#[derive(Clone, Debug)]
pub struct HardView {
    /// Where the eye is, and the kind of window.
    pub name: String,
    /// The view; it is proper.
    pub view: View,
}

/// A hard ground with some views.
#[derive(Clone, Debug)]
pub struct HardCase {
    /// The seed that it is made of.
    pub seed: u64,
    /// What the ground is called.
    pub ground: &'static str,
    /// The ground.
    pub scene: Arc<Scene>,
    /// The views.
    pub views: Vec<HardView>,
}

impl fmt::Display for HardCase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "seed {} over {}", self.seed, self.ground)
    }
}

/// The case of a seed.
#[must_use]
pub fn hard_case(seed: u64) -> HardCase {
    let mut random = Random::new(seed.wrapping_mul(0x9e37_79b9).wrapping_add(17));
    let (name, ground) = ground(&mut random);
    let mut view = || {
        let standing = *random.choose(&Standing::ALL);
        let eye: DVec3 = standing.eye(&ground, &mut random);
        let (window, view) = window(&ground, eye, standing, &mut random);
        HardView {
            name: format!("{standing:?}, {window:?}"),
            view,
        }
    };
    let views = (0..VIEWS).map(|_| view());
    let views = views.filter(|view| view.view.is_proper()).collect();
    HardCase {
        seed,
        ground: name,
        scene: Scene::new(ground),
        views,
    }
}
