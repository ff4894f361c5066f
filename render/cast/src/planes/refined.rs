//! Ground with posts as close as the pixels of its photo, or closer.

use super::frame::Level;
use super::roofs::Roofs;
use super::steepness::Steepness;
use glam::DVec2;
use sandtable_terrain::{Ground, Photo, TileIndex};

/// How many posts lie from a photo's pixel to the next where there are too few posts for it.
const FINER: f64 = 0.75;

/// How many posts lie from a pixel to the next where it matters no more whether pixels lie on posts: of what is
/// linear from pixel to pixel, what is linear from post to post then has all but a little.
const COARSER: f64 = 1.3;

/// And from which on, even magnified.
const MUCH_COARSER: f64 = 3.0;

/// How many of a photo's pixels one of the image covers, at most, where it shows what is linear between those: right
/// before the eye, and all over an image.
const WIDE_NEAR: f64 = 0.2;
const WIDE: f64 = 0.5;

/// How far pixels may lie beside posts that they are on.
const BESIDE: f64 = 0.02;

/// Up to where ground is refined. There is more than a post to a pixel where the photo covers less than all of the
/// ground. With their colours and what is made of them posts take some 12 bytes each.
const MOST: Room = Room {
    posts: (1 << 27) as f64,
    a_pixel: 4.0,
};

/// The same where every other post would do, but for pixels that lie beside posts.
const MOST_TWICE: Room = Room {
    posts: (1 << 26) as f64,
    a_pixel: 8.0,
};

/// How many posts there may be, and for each of the photo's pixels.
struct Room {
    posts: f64,
    a_pixel: f64,
}

impl Room {
    /// How many times as close posts may be along each side.
    fn times(&self, photo: &Photo, ground: &Ground) -> u32 {
        let pixels = f64::from(photo.pixels.cols()) * f64::from(photo.pixels.rows());
        let most = self.posts.min(self.a_pixel * pixels);
        (most / ground.grid().posts() as f64).sqrt() as u32
    }
}

/// How many posts lie from one of the photo's pixels to the next.
fn spacing(photo: &Photo, ground: &Ground) -> f64 {
    (photo.spacing / ground.grid().spacing).min_element()
}

/// Whether the photo's pixels lie on posts, where there are `times` as many of these along each side.
fn is_on_posts(photo: &Photo, ground: &Ground, times: u32) -> bool {
    let posts = ground.grid().spacing / f64::from(times);
    let (spacing, first) = (photo.spacing / posts, photo.origin / posts);
    let pixels = DVec2::new(
        f64::from(photo.pixels.cols()),
        f64::from(photo.pixels.rows()),
    );
    let last = first + (pixels - 1.0) * spacing;
    let beside = |at: DVec2| (at - at.round()).abs().max_element();
    beside(spacing) < 0.5 / pixels.max_element() && beside(first).max(beside(last)) < BESIDE
}

/// Up to how many posts a pixel covers rays see more of a photo than what is linear from post to post has of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BetterByRays {
    /// Before the eye, where farther ground is seen beside it.
    pub(super) near: f64,
    /// All over an image.
    pub(super) all: f64,
}

/// Whether pixels so many posts apart may lie beside posts.
fn may_lie_beside(spacing: f64) -> bool {
    spacing >= COARSER
}

/// Where rays see more of a ground's photo than posts have, if they do so anywhere.
pub(super) fn better_by_rays(ground: &Ground) -> Option<BetterByRays> {
    let photo = ground.photo()?;
    let spacing = spacing(photo, ground);
    if spacing >= FINER && (spacing >= MUCH_COARSER || is_on_posts(photo, ground, 1)) {
        return None;
    }
    let [near, all] = if may_lie_beside(spacing) {
        [WIDE_NEAR * spacing, WIDE * spacing]
    } else {
        [spacing.max(1.0); 2]
    };
    Some(BetterByRays { near, all })
}

/// The same ground with closer posts, for a photo whose pixels lie between its own ones.
pub(super) struct Refined {
    pub(super) ground: Ground,
    /// How many of its cells lie side by side in one of the ground's: a power of two.
    pub(super) times: u32,
    roofs: Roofs,
    steepness: Steepness,
}

impl Refined {
    /// Of a ground whose photo is lost on it, where there is room.
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

/// How many times as close posts are to be, if that takes little room: for pixels to lie on posts, or not to matter
/// where they lie; else, for there to be about a post a pixel.
///
/// Powers of two, so that the ground's own posts are one of the levels: else tips of spikes, which are many pixels
/// wide where these suit, lay between the posts of all of them.
fn times(ground: &Ground) -> Option<u32> {
    let photo = ground.photo()?;
    let spacing = spacing(photo, ground);
    let most = MOST.times(photo, ground);
    let mut times = 1;
    while f64::from(times) * spacing < FINER && times <= most {
        times *= 2;
    }
    let will_do = may_lie_beside(f64::from(times) * spacing) || is_on_posts(photo, ground, times);
    if !will_do && 2 * times <= MOST_TWICE.times(photo, ground) {
        return Some(2 * times);
    }
    (times > 1 && times <= most).then_some(times)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_terrain::TiledRaster;

    #[test]
    fn a_photo_is_seen_at_posts_where_its_pixels_lie_there() {
        let ground = Ground::from_fn(101, 81, DVec2::new(30.0, 20.0), |_, _| 0.0);
        let ground = ground.expect("a sound grid");
        assert_eq!(better_by_rays(&ground), None);
        let by_rays = |origin: [f64; 2], spacing: [f64; 2]| {
            let photo = Photo {
                pixels: TiledRaster::from_fn(40, 30, |_, _| [9, 9, 9, 255]),
                origin: DVec2::from_array(origin),
                spacing: DVec2::from_array(spacing),
            };
            better_by_rays(&ground.clone().with_photo(photo))
        };
        for (origin, spacing) in [
            ([0.0; 2], [30.0, 20.0]),
            ([-60.0, 40.0], [60.0, 20.0]),
            ([0.3, 0.2], [30.001, 20.0]),
            // So far apart that it does not matter where they lie.
            ([15.0, 7.0], [95.0, 63.0]),
        ] {
            assert_eq!(by_rays(origin, spacing), None, "{origin:?}, {spacing:?}");
        }
        for (origin, spacing, posts) in [
            // Between posts, or drifting away from them.
            ([15.0, 0.0], [30.0, 20.0], 1.0),
            ([0.0, 10.0], [30.0, 20.0], 1.0),
            ([0.0; 2], [30.2, 20.0], 1.0),
            ([0.0; 2], [36.0, 24.0], 1.2),
            // Closer.
            ([0.0; 2], [15.0, 20.0], 1.0),
            // Farther apart: a fifth of a pixel.
            ([15.0, 7.0], [60.0, 40.0], 0.4),
        ] {
            let limit = by_rays(origin, spacing).expect("some of it is lost");
            assert!((limit.near - posts).abs() < 1e-9, "{limit:?} is {posts}");
        }
    }

    #[test]
    fn ground_is_refined_until_posts_are_close_enough_and_not_for_a_few_pixels() {
        let ground = Ground::from_fn(101, 81, DVec2::splat(30.0), |col, row| (col + row) as f32);
        let ground = ground.expect("a sound grid");
        assert_eq!(times(&ground), None);
        let under = |cols: u32, rows: u32, spacing: f64, origin: f64| {
            let photo = Photo {
                pixels: TiledRaster::from_fn(cols, rows, |_, _| [9, 9, 9, 255]),
                origin: DVec2::splat(origin),
                spacing: DVec2::splat(spacing),
            };
            times(&ground.clone().with_photo(photo))
        };
        assert_eq!(under(101, 81, 30.0, 0.0), None);
        assert_eq!(under(202, 162, 15.0, 0.0), Some(2));
        assert_eq!(under(404, 324, 7.5, 0.0), Some(4));
        // Areas of 7.5 m and of 15 m within those of 30 m; and of 30 m, around points.
        assert_eq!(under(404, 324, 7.5, -11.25), Some(8));
        assert_eq!(under(202, 162, 15.0, -7.5), Some(4));
        assert_eq!(under(100, 80, 30.0, 15.0), Some(2));
        // Elsewhere between posts, and drifting from one to the next.
        assert_eq!(under(202, 162, 15.0, -4.0), Some(4));
        assert_eq!(under(100, 80, 30.0, 10.0), Some(2));
        assert_eq!(under(120, 100, 24.0, 0.0), Some(2));
        // Three to a post, of which one lies on it: of four posts they may lie beside all.
        assert_eq!(under(301, 241, 10.0, 0.0), Some(4));
        assert_eq!(under(75, 60, 40.0, 7.0), None);
        // A quarter of the ground, and a corner of it.
        assert_eq!(under(202, 162, 7.5, 0.0), Some(4));
        assert_eq!(under(80, 60, 3.75, 0.0), None);
        assert_eq!(under(80, 60, 1e-300, 0.0), None);
    }
}
