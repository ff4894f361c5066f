//! Equidistant samples along a ray, and the search among them (papers' rows W4, W5).

use crate::tally::Tally;
use glam::DVec3;

/// A ray as equidistant samples in voxel space: sample n lies at `origin + n · step`.
#[derive(Clone, Copy, Default)]
pub(crate) struct SampledRay {
    origin: DVec3,
    step: DVec3,
    /// Metres in the world from one sample to the next.
    metres: f64,
    /// The samples that lie where the terrain may be.
    first: u32,
    last: u32,
}

/// Added before cutting off, it rounds up all that is not whole but for rounding errors.
const ALMOST_ONE: f64 = 1.0 - 1e-9;

/// What tells whether a point of voxel space lies in the terrain.
pub(crate) trait Solid {
    /// Whether `point` (posts from the south-west one, and levels) is in the terrain. It lies
    /// within the rectangle of posts.
    fn contains<T: Tally>(&self, point: DVec3, tally: &mut T) -> bool;
}

impl SampledRay {
    /// Samples from the eye at `origin` along `direction`, both in voxel space, `interval` voxels
    /// apart. `length` is the direction's length in world metres; `enter` and `leave` tell in
    /// directions from where to where there may be terrain.
    #[inline]
    pub(crate) fn new(
        origin: DVec3,
        direction: DVec3,
        length: f64,
        interval: f64,
        [enter, leave]: [f64; 2],
    ) -> Self {
        let share = interval / direction.length();
        Self {
            origin,
            step: direction * share,
            metres: length * share,
            // Cutting off rounds down, and what is beyond counting is cut off there.
            first: (enter / share + ALMOST_ONE) as u32,
            last: ((leave / share) as u32).min(u32::MAX - 1),
        }
    }

    /// The distance in metres of sample n.
    #[inline]
    pub(crate) fn distance(&self, n: u32) -> f64 {
        f64::from(n) * self.metres
    }

    /// The distance in metres beyond which the ray meets nothing.
    #[inline]
    pub(crate) fn end(&self) -> f64 {
        (f64::from(self.last) + 1.0) * self.metres
    }

    /// Where sample n lies in voxel space.
    #[inline]
    pub(crate) fn point(&self, n: u32) -> DVec3 {
        self.origin + f64::from(n) * self.step
    }

    /// The first sample in the terrain.
    #[inline]
    pub(crate) fn first_hit<S: Solid, T: Tally>(&self, solid: &S, tally: &mut T) -> Option<u32> {
        self.forward(self.first, solid, tally)
    }

    /// The sample in the terrain that coherence finds from `metres` on, the distance at which the
    /// ray below ended: forward to the first sample in the terrain; or, where the start is in it
    /// already, *retracing* to the last one that follows a sample in the air.
    #[inline]
    pub(crate) fn hit_from<S: Solid, T: Tally>(
        &self,
        metres: f64,
        solid: &S,
        tally: &mut T,
    ) -> Option<u32> {
        // The same sample again, where rounding has put it a little before itself.
        let start = ((metres / self.metres + 1e-6) as u32).max(self.first);
        if start > self.last {
            return None;
        }
        tally.sample();
        if !solid.contains(self.point(start), tally) {
            return self.forward(start + 1, solid, tally);
        }
        let mut n = start;
        while n > self.first {
            tally.sample();
            if !solid.contains(self.point(n - 1), tally) {
                break;
            }
            n -= 1;
        }
        Some(n)
    }

    #[inline(always)]
    fn forward<S: Solid, T: Tally>(&self, from: u32, solid: &S, tally: &mut T) -> Option<u32> {
        let mut n = from;
        while n <= self.last {
            tally.sample();
            if solid.contains(self.point(n), tally) {
                return Some(n);
            }
            n += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tally::Work;

    /// A wall from x = 10 to x = 12, and the ground beyond x = 50.
    struct Walls;

    impl Solid for Walls {
        fn contains<T: Tally>(&self, point: DVec3, _: &mut T) -> bool {
            (10.0..12.0).contains(&point.x) || point.x >= 50.0
        }
    }

    fn ray() -> SampledRay {
        SampledRay::new(DVec3::ZERO, 2.0 * DVec3::X, 6.0, 0.6, [0.0, 40.0])
    }

    #[test]
    fn samples_lie_an_interval_apart_from_the_eye_on() {
        let ray = ray();
        assert_eq!(ray.point(5), DVec3::new(3.0, 0.0, 0.0));
        // Three metres for each voxel.
        assert!((ray.distance(5) - 9.0).abs() < 1e-12);
        let mut work = Work::default();
        assert_eq!(ray.first_hit(&Walls, &mut work), Some(17));
        assert_eq!(work.samples, 18);
    }

    #[test]
    fn a_start_in_the_air_goes_forward_and_one_inside_retraces() {
        let ray = ray();
        let from = |metres| ray.hit_from(metres, &Walls, &mut Work::default());
        assert_eq!(from(ray.distance(3)), Some(17));
        // Inside the wall, three samples deep: back to its face.
        assert_eq!(from(ray.distance(19)), Some(17));
        // Beyond the wall it is not seen any more: the price of coherence.
        assert_eq!(from(ray.distance(20)), Some(84));
        assert_eq!(from(ray.distance(1_000_000)), None);
    }

    #[test]
    fn retracing_ends_where_the_ray_enters() {
        let ray = SampledRay::new(10.5 * DVec3::X, DVec3::X, 1.0, 0.25, [0.5, 1.2]);
        assert_eq!(ray.hit_from(1.0, &Walls, &mut Work::default()), Some(2));
    }
}
