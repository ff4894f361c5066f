//! Ground at the resolution of its photo: planes see colours at posts.

use super::frame::Level;
use super::roofs::Roofs;
use super::steepness::Steepness;
use glam::DVec2;
use sandtable_terrain::{Ground, Photo, TileIndex};

/// How many posts lie from a photo's pixel to the next where there are too few posts for it.
const FINER: f64 = 0.75;

/// How many posts lie from a pixel to the next where it matters no more whether pixels lie on posts: what
/// is linear from pixel to pixel is almost so from post to post.
const COARSER: f64 = 3.0;

/// How far pixels may lie beside posts that they are on.
const BESIDE: f64 = 0.1;

/// How many posts there may be for each of the photo's pixels: more where it covers less than all of the
/// ground.
const MOST_A_PIXEL: f64 = 4.0;

/// How many posts there may be: with their colours they take ten bytes each.
const MOST: f64 = (1 << 28) as f64;

/// How many posts lie from one of the photo's pixels to the next.
fn spacing(photo: &Photo, ground: &Ground) -> f64 {
    (photo.spacing / ground.grid().spacing).min_element()
}

/// Whether some of the photo is lost where colours are linear from post to post, magnified: its pixels lie
/// closer, or elsewhere.
pub(super) fn loses_photo(ground: &Ground) -> bool {
    let posts = ground.grid().spacing;
    ground.photo().is_some_and(|photo| {
        let (spacing, origin) = (photo.spacing / posts, photo.origin / posts);
        let pixels = DVec2::new(
            f64::from(photo.pixels.cols()),
            f64::from(photo.pixels.rows()),
        );
        let last = origin + (pixels - 1.0) * spacing;
        let beside = |at: DVec2| (at - at.round()).abs().max_element();
        let is_on_posts = beside(spacing) < 0.5 / pixels.max_element()
            && beside(origin).max(beside(last)) < BESIDE;
        spacing.min_element() < FINER || (spacing.min_element() < COARSER && !is_on_posts)
    })
}

/// The same ground with about a post for each pixel of a photo that is finer than its own posts.
pub(super) struct Refined {
    pub(super) ground: Ground,
    /// How many of its cells lie side by side in one of the ground's.
    pub(super) times: u32,
    roofs: Roofs,
    steepness: Steepness,
}

impl Refined {
    /// Of a ground whose photo is finer.
    pub(super) fn new(ground: &Ground) -> Option<Self> {
        let times = times(ground)?;
        let ground = ground.refined(times);
        Some(Self {
            roofs: Roofs::new(ground.heights()),
            steepness: Steepness::new(ground.heights()),
            ground,
            times,
        })
    }

    /// After an edit that made `ground` of what this was made of, in the tiles `changed`; and its own tiles
    /// that may have changed.
    pub(super) fn updated(&self, ground: &Ground, changed: &[TileIndex]) -> (Self, Vec<TileIndex>) {
        let (ground, changed) = self.ground.refined_again(ground, self.times, changed);
        let refined = Self {
            times: self.times,
            roofs: self.roofs.updated(ground.heights(), &changed),
            steepness: self.steepness.updated(ground.heights(), &changed),
            ground,
        };
        (refined, changed)
    }

    pub(super) fn level(&self) -> Level<'_> {
        Level::new(self.ground.heights(), &self.roofs, &self.steepness)
    }
}

/// By how much a ground is refined, if at all.
fn times(ground: &Ground) -> Option<u32> {
    let photo = ground
        .photo()
        .filter(|photo| spacing(photo, ground) < FINER)?;
    let pixels = f64::from(photo.pixels.cols()) * f64::from(photo.pixels.rows());
    let most = (MOST_A_PIXEL * pixels).min(MOST) / ground.grid().posts() as f64;
    let wanted = (1.0 / spacing(photo, ground)).round().max(2.0);
    let times = wanted.min(most.sqrt().floor());
    (times >= 2.0).then_some(times as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_terrain::TiledRaster;

    #[test]
    fn a_photo_is_seen_at_posts_where_its_pixels_lie_there() {
        let ground = Ground::from_fn(101, 81, DVec2::new(30.0, 20.0), |_, _| 0.0);
        let ground = ground.expect("a sound grid");
        assert!(!loses_photo(&ground));
        let loses = |origin: [f64; 2], spacing: [f64; 2]| {
            let photo = Photo {
                pixels: TiledRaster::from_fn(40, 30, |_, _| [9, 9, 9, 255]),
                origin: DVec2::from_array(origin),
                spacing: DVec2::from_array(spacing),
            };
            loses_photo(&ground.clone().with_photo(photo))
        };
        assert!(!loses([0.0; 2], [30.0, 20.0]) && !loses([-60.0, 40.0], [60.0, 20.0]));
        assert!(!loses([2.0, 1.0], [30.01, 20.0]));
        // Between posts, or drifting away from them.
        assert!(loses([15.0, 0.0], [30.0, 20.0]) && loses([0.0, 10.0], [30.0, 20.0]));
        assert!(loses([0.0; 2], [30.2, 20.0]) && loses([0.0; 2], [45.0, 20.0]));
        // Closer.
        assert!(loses([0.0; 2], [15.0, 20.0]));
        // Much farther apart.
        assert!(!loses([15.0, 7.0], [95.0, 63.0]));
    }

    #[test]
    fn ground_gets_a_post_a_pixel_where_its_photo_is_finer_and_not_much_more() {
        let ground = Ground::from_fn(101, 81, DVec2::splat(30.0), |col, row| (col + row) as f32);
        let ground = ground.expect("a sound grid");
        assert_eq!(times(&ground), None);
        let under = |cols: u32, rows: u32, spacing: f64| {
            let photo = Photo {
                pixels: TiledRaster::from_fn(cols, rows, |_, _| [9, 9, 9, 255]),
                origin: DVec2::ZERO,
                spacing: DVec2::splat(spacing),
            };
            times(&ground.clone().with_photo(photo))
        };
        assert_eq!(under(101, 81, 30.0), None);
        assert_eq!(under(120, 100, 24.0), None);
        assert_eq!(under(150, 120, 20.0), Some(2));
        assert_eq!(under(301, 241, 10.0), Some(3));
        assert_eq!(under(970, 780, 3.1), Some(10));
        // A tenth of the ground, and a corner of it.
        assert_eq!(under(320, 240, 3.1), Some(6));
        assert_eq!(under(80, 60, 3.1), None);
    }
}
