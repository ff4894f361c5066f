//! Views by heads that are anywhere, and turned in any way.

use crate::kind::Kind;
use crate::random::Random;
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

/// As many views of `ground`, of all kinds but those that see its sides; the same for the same ground.
pub(crate) fn views(ground: &Ground, count: u64) -> impl Iterator<Item = Standpoint> {
    let kinds = Kind::ALL.into_iter().filter(|kind| !SIDES.contains(kind));
    kinds.cycle().zip(0..count).map(|(kind, seed)| Standpoint {
        name: format!("{seed} {kind}"),
        view: kind.view(ground, &mut Random::new(seed), SIZE),
    })
}
