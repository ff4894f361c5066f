//! How many posts a pixel covers.

use glam::DVec2;
use sandtable_cast::Image;
use sandtable_terrain::Grid;

/// The median footprint of the image's pixels: the side, in posts, of a square as large as the
/// parallelogram on the map from a pixel's hit to those of its neighbours to the right and below.
/// `None` where there is no such pixel.
pub(super) fn median(image: &Image, grid: Grid) -> Option<f64> {
    let [width, height] = image.view.size;
    let row = |j: u32| -> Vec<Option<DVec2>> {
        let posts = |i| Some(image.point(i, j)?.truncate() / grid.spacing);
        (0..width).map(posts).collect()
    };
    let mut sides = Vec::new();
    let mut this = row(0);
    for j in 1..height {
        let below = row(j);
        let neighbours = this.iter().zip(&this[1..]).zip(&below);
        sides.extend(neighbours.filter_map(|((&here, &right), &below)| {
            let (here, right, below) = (here?, right?, below?);
            Some((right - here).perp_dot(below - here).abs().sqrt())
        }));
        this = below;
    }
    let middle = sides.len() / 2;
    (!sides.is_empty()).then(|| *sides.select_nth_unstable_by(middle, f64::total_cmp).1)
}
