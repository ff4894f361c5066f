//! Views by heads that are anywhere, and turned in any way.

use crate::kind::Kind;
use crate::random::Random;
use glam::DVec3;
use sandtable_cast::standpoints::Standpoint;
use sandtable_terrain::Ground;

const SIZE: [u32; 2] = [1920, 1080];

/// Kinds that see the ground's sides, which Embree's geometries do not have.
const SIDES: [Kind; 4] = [
    Kind::Outside,
    Kind::FarOutside,
    Kind::UnderTheBorder,
    Kind::Buried,
];

/// As many views of `ground`, of all kinds but those that see its sides, by eyes in the air; the same for the same
/// ground. They are named by their seeds and kinds.
pub(crate) fn views(ground: &Ground, count: usize) -> impl Iterator<Item = Standpoint> {
    let kinds = Kind::ALL.into_iter().filter(|kind| !SIDES.contains(kind));
    let views = kinds.cycle().zip(0..).map(|(kind, seed)| Standpoint {
        name: format!("{seed} {kind}"),
        view: kind.view(ground, &mut Random::new(seed), SIZE),
    });
    views
        .filter(|at| is_in_the_air(ground, at.view.eye))
        .take(count)
}

fn is_in_the_air(ground: &Ground, eye: DVec3) -> bool {
    let height = ground.height_at(eye.x, eye.y);
    height.is_none_or(|height| height < eye.z)
}
