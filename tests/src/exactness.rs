//! The judge of exactness: is a caster's image what brute force sees, ray for ray?
//!
//! Brute force is exact, but a pixel has no single exact answer: where a ray grazes a crest, the
//! next number to its direction that a computer can hold ends a valley further on. So each pixel
//! is held to what brute force sees along *some* ray within [`RAY_TOLERANCE`] of the pixel's
//! centre, and held to that closely:
//!
//! - **Depth.** The pixel's hit, which lies on the ray through its centre at the image's depth,
//!   must lie within [`HIT_TOLERANCE`] of that ray's hit, in space. Sideways counts too, so that
//!   beyond some thousand cells the rays that can agree lie nearer together than the tolerance
//!   says. Sky agrees with sky only.
//! - **Colour.** Each channel must lie within [`COLOUR_TOLERANCE`] of what a ray that agrees in
//!   depth sees. One ray has to answer for both: the colour of one hillside at the depth of another
//!   is wrong.
//!
//! A pixel that agrees with the ray through its centre is done with; only the others are searched.

mod disc;
mod verdict;

pub use verdict::{Fault, Verdict, WrongPixel};

use disc::{Answer, Disc};
use rayon::prelude::*;
use sandtable_cast::{Brute, Caster, Image, Scene, Scheme, Sight};
use sandtable_view::View;
use std::sync::Arc;

/// How far a ray that answers for a pixel may pass from the pixel's centre, in pixels.
pub const RAY_TOLERANCE: f64 = 0.01;
/// How far the hits of such a ray and of the pixel may lie apart, in cells.
pub const HIT_TOLERANCE: f64 = 0.1;
/// How far each channel of their colours may lie apart, in levels of 255.
pub const COLOUR_TOLERANCE: u8 = 2;

/// Judges `image`, which a caster made of `view` and `scene`, on the current thread pool.
///
/// # Panics
/// Where the image is not one of `view`, or the view is not proper.
#[must_use]
pub fn judge(scene: &Arc<Scene>, view: &View, image: &Image) -> Verdict {
    assert_eq!(image.view, *view, "the image is one of the view");
    assert!(view.is_proper(), "each pixel of {view:?} has a ray");
    let exact = exact_image(scene, view);
    let cell = scene.ground.grid().cell_length();
    let width = view.size[0] as usize;
    let wrong_pixel = |index: usize| {
        let pixel = [(index % width) as u32, (index / width) as u32];
        let (found, exact) = (sight(image, index), sight(&exact, index));
        let disc = Disc::new(&scene.ground, view, pixel, found);
        let fault = match disc.search() {
            Answer::Agrees => return None,
            Answer::AgreesInDepth => Fault::Colour,
            Answer::Differs => Fault::Depth,
        };
        Some(WrongPixel {
            pixel,
            fault,
            cells: [found.depth, exact.depth].map(|depth| depth / cell),
            colours: [found.colour, exact.colour],
        })
    };
    let doubtful: Vec<_> = (0..image.depth.len())
        .filter(|&index| !is_close(sight(image, index), sight(&exact, index), cell))
        .collect();
    let wrong = doubtful
        .par_iter()
        .filter_map(|&index| wrong_pixel(index))
        .collect();
    Verdict::new(image.depth.len(), doubtful.len(), wrong)
}

/// What brute force makes of `view`.
fn exact_image(scene: &Arc<Scene>, view: &View) -> Image {
    let mut images = [Image::default()];
    Brute
        .prepare(Arc::clone(scene))
        .and_then(|prepared| prepared.cast(&[*view], &mut images, Scheme::default()))
        .expect("brute force takes any scene and view");
    let [image] = images;
    image
}

/// A pixel as its ray's sight.
fn sight(image: &Image, index: usize) -> Sight {
    let [red, green, blue, _] = image.colour()[index];
    Sight {
        colour: [red, green, blue],
        depth: f64::from(image.depth[index]),
    }
}

/// Whether two sights along one ray agree.
fn is_close(found: Sight, exact: Sight, cell: f64) -> bool {
    let same_hit =
        found.depth == exact.depth || (found.depth - exact.depth).abs() <= HIT_TOLERANCE * cell;
    same_hit && is_close_colour(found.colour, exact.colour)
}

fn is_close_colour(found: [u8; 3], exact: [u8; 3]) -> bool {
    found
        .iter()
        .zip(exact)
        .all(|(found, exact)| found.abs_diff(exact) <= COLOUR_TOLERANCE)
}
