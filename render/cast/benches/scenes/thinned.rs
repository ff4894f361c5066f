//! Ground whose photograph is finer than its posts, as most are that people have.

use anyhow::Result;
use sandtable_cast::standpoints::Standpoint;
use sandtable_terrain::{Ground, Photo};

/// The photograph of `fine`, a pixel a post, over fewer posts: each is the mean of `times` by `times` of them, and in
/// their middle, as areas in files of both are; and the views of it, from the same places.
pub(super) fn thinned(
    fine: &Ground,
    times: u32,
    mut views: Vec<Standpoint>,
) -> Result<(Ground, Vec<Standpoint>)> {
    let grid = fine.grid();
    let ground = Ground::from_fn(
        grid.cols / times,
        grid.rows / times,
        grid.spacing * f64::from(times),
        |col, row| {
            let within = |at: u32| at * times..(at + 1) * times;
            let posts = within(row).flat_map(|row| within(col).map(move |col| (col, row)));
            let sum: f64 = posts
                .map(|(col, row)| f64::from(fine.heights().post(col, row)))
                .sum();
            (sum / f64::from(times * times)) as f32
        },
    )?;
    let middle = 0.5 * f64::from(times - 1) * grid.spacing;
    for standpoint in &mut views {
        let window = &mut standpoint.view.window;
        for place in [
            &mut standpoint.view.eye,
            &mut window.lower_left,
            &mut window.lower_right,
            &mut window.upper_left,
        ] {
            *place -= middle.extend(0.0);
        }
    }
    let photo = fine.photo().map(|photo| Photo {
        origin: photo.origin - middle,
        ..photo.clone()
    });
    let ground = match photo {
        Some(photo) => ground.with_photo(photo),
        None => ground,
    };
    Ok((ground, views))
}
