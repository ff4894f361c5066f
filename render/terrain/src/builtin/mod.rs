//! Terrains that need no file.

mod noise;
mod ridges;

use crate::open::terrain_from_raster;
use crate::raster::GeoTiff;
use crate::{Georeference, Ground, Terrain, TerrainError, TerrainSource};
use glam::DVec2;
use ridges::Ridges;
use std::path::Path;

/// Metres between the posts of `builtin:ridges`.
const RIDGES_SPACING: f64 = 30.0;

/// Real heights; see `data/README.md` for source and licence.
const JACKSBORO: &[u8] = include_bytes!("../../data/jacksboro.tif");

/// Procedural mountains, `size` posts a side.
pub(crate) fn ridges(size: u32, seed: u64) -> Result<Terrain, TerrainError> {
    let name = TerrainSource::Ridges { size, seed }.to_string();
    let ridges = Ridges::new(seed);
    let spacing = DVec2::splat(RIDGES_SPACING);
    // The middle of the grid is the same place at any size.
    let middle = f64::from(size - 1) / 2.0;
    let place = |post: u32| (f64::from(post) - middle) * RIDGES_SPACING;
    let ground = Ground::from_fn(size, size, spacing, |col, row| {
        ridges.height(place(col), place(row))
    })
    .map_err(|source| TerrainError::Ground {
        name: name.clone(),
        source,
    })?;
    Ok(Terrain {
        name,
        ground,
        georeference: Georeference::nowhere(spacing),
        notes: Vec::new(),
    })
}

/// The Jacksboro Fault, Tennessee.
pub(crate) fn jacksboro() -> Result<Terrain, TerrainError> {
    let name = TerrainSource::Jacksboro.to_string();
    let path = Path::new(&name);
    let mut raster = GeoTiff::from_bytes(path, JACKSBORO)?;
    terrain_from_raster(path, name.clone(), &mut raster, &|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ridges_are_the_same_for_any_number_of_threads_and_differ_by_seed() {
        let make = |threads, seed| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| ridges(300, seed)).unwrap().ground
        };
        let (one, three, other) = (make(1, 5), make(3, 5), make(1, 6));
        let mut differing = 0;
        for tile in one.heights().tile_indices() {
            let posts = one.heights().tile_posts(tile);
            assert_eq!(posts, three.heights().tile_posts(tile));
            differing += posts
                .iter()
                .zip(other.heights().tile_posts(tile))
                .filter(|(a, b)| a != b)
                .count();
        }
        assert!(differing > 80_000);
    }

    #[test]
    fn ridges_of_any_size_are_mountains() {
        assert!(ridges(2, 0).is_ok());
        let ground = ridges(513, 0).unwrap().ground;
        let [low, high] = ground.range();
        assert!(
            high - low > 500.0 && low > -100.0 && high < 6000.0,
            "{low} to {high}"
        );
        assert_eq!(ground.grid().extent(), DVec2::splat(512.0 * RIDGES_SPACING));
    }

    #[test]
    fn jacksboro_is_the_real_one() {
        let terrain = jacksboro().unwrap();
        let grid = terrain.ground.grid();
        assert_eq!((grid.cols, grid.rows), (403, 344));
        assert_eq!(terrain.ground.range(), [236.0, 1076.0]);
        // Cross Mountain; file row 297 of 344 from the north.
        assert_eq!(terrain.ground.heights().post(219, 343 - 297), 1076.0);
        assert_eq!(
            terrain.georeference.crs.as_ref().and_then(|crs| crs.epsg),
            Some(4326)
        );
        assert!((grid.spacing.x - 74.8).abs() < 0.1 && (grid.spacing.y - 92.5).abs() < 0.1);
        assert!(JACKSBORO.len() < 200_000);
    }
}
