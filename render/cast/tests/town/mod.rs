//! A town, and an eye over its roofs.

use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;

/// Houses of two to five storeys with flat roofs, a street of nine metres between each two.
pub(crate) fn town() -> Ground {
    let house = |col: u32, row: u32| {
        let storeys = (col / 20 * 7 + row / 20 * 5) % 4 + 2;
        if col % 20 < 11 && row % 20 < 11 {
            3.0 * storeys as f32
        } else {
            0.0
        }
    };
    Ground::from_fn(401, 401, DVec2::ONE, house).expect("a sound grid")
}

pub(crate) const OVER_ROOFS: DVec3 = DVec3::new(110.0, 30.0, 30.0);
