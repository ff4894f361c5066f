//! Ground whose photograph is finer than its posts, as most are that people have.

use anyhow::Result;
use sandtable_terrain::Ground;

/// The photograph of `fine` over every `times`-th of its posts along each side, each the mean of those
/// around it.
pub(super) fn thinned(fine: &Ground, times: u32) -> Result<Ground> {
    let grid = fine.grid();
    let posts = |side: u32| (side - 1) / times + 1;
    let heights = fine.heights();
    let reach = times as i32 - 1;
    let ground = Ground::from_fn(
        posts(grid.cols),
        posts(grid.rows),
        grid.spacing * f64::from(times),
        |col, row| {
            let at = |post: u32, by: i32, side: u32| {
                (post as i32 * times as i32 + by).clamp(0, side as i32 - 1) as u32
            };
            let (mut sum, mut weights) = (0.0, 0.0);
            for north in -reach..=reach {
                for east in -reach..=reach {
                    let weight = (times as i32 - north.abs()) * (times as i32 - east.abs());
                    let height = heights.post(at(col, east, grid.cols), at(row, north, grid.rows));
                    sum += f64::from(weight) * f64::from(height);
                    weights += f64::from(weight);
                }
            }
            (sum / weights) as f32
        },
    )?;
    Ok(match fine.photo() {
        Some(photo) => ground.with_photo(photo.clone()),
        None => ground,
    })
}
