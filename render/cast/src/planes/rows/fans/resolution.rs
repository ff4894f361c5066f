//! In which of the ground's resolutions planes go side by side.

use super::super::March;
use crate::lanes::Lanes;
use crate::planes::field::Axis;

/// How many cells of the ground's own level, and of finer ones, a pixel may cover before the next one is taken; of
/// coarser ones it is two. Where pixels are hardly wider than posts, these are nearer to the truth than anything
/// that is made of them.
const FINEST: f32 = 2.6;

/// How many cells of the finest level a pixel may cover, in the same way, up to which profiles are bent
/// between lines of posts; of wider pixels straight ones are as near to the truth as pixels are.
const BENT: f32 = 1.3;

/// A cliff is where planes see so many pixels, or more, of the way from one of the ground's own posts to the next.
const CLIFF: f32 = 3.0;

/// How many levels finer, at most, cliffs are looked at.
const FINER: usize = 2;

/// In so many of the ground's own cells along the way cliffs are looked for at once.
const AT_ONCE: i32 = 32;

/// The resolution that suits a plane in the midst of those that go side by side.
pub(super) struct Resolution {
    pub(super) plane: usize,
    /// Pixels to a cell, at most, and how wide a pixel is for each 1 of t, times that.
    pub(super) cell: f64,
    pub(super) width: f32,
    /// How many metres of a pixel's width there are to `width` times t.
    pub(super) metres: f32,
    pub(super) native: usize,
    pub(super) coarsest: usize,
    /// The level that suits how wide pixels are.
    pub(super) suited: usize,
    /// The one that planes are in: where there are cliffs, it may be finer.
    pub(super) level: usize,
    /// Whether profiles are bent between lines.
    pub(super) is_bent: bool,
    /// The t up to which it suits.
    pub(super) limit: f32,
    /// How twisted cells of the finest level may be, for each 1 of t, that profiles are not looked at in: metres.
    pub(super) twist: f32,
}

impl Resolution {
    /// Takes the level that suits pixels at t, but none finer than before.
    fn suit_pixels(&mut self, t: f32) {
        let covered = t * self.width;
        let finer = (0..=self.native).find(|&level| covered < up_to(level));
        let level = finer
            .unwrap_or_else(|| (((covered.to_bits() >> 23) - 127) as usize).min(self.coarsest));
        self.suited = self.suited.max(level);
        self.level = self.suited;
        let limit = if self.suited == self.coarsest {
            f32::INFINITY
        } else if self.suited <= self.native {
            up_to(self.suited) / self.width
        } else {
            (2 << self.suited) as f32 / self.width
        };
        self.limit = limit.max(t * 1.001);
    }

    /// Whether there are levels with the very same ground and closer lines.
    #[inline(always)]
    pub(super) fn may_be_closer(&self) -> bool {
        self.level > 0 && self.level <= self.native
    }

    /// Takes closer lines up to t, at which there is one of this level's.
    pub(super) fn come_closer(&mut self, t: f32) {
        self.level = self.level.saturating_sub(FINER);
        self.limit = t;
    }
}

/// How many cells of the finest level a pixel may cover before a level is left that is no coarser than the ground's
/// own.
fn up_to(level: usize) -> f32 {
    FINEST * (1 << level) as f32
}

impl<L: Lanes> March<'_, L> {
    /// Takes the level that suits planes at t, of which the outer ones advance so much along the minor axis. Gives
    /// whether it is another one.
    ///
    /// Before a cliff a pixel covers little of the way between two posts, however wide it is: levels that suit its
    /// width have a slope there, with the colours of what lies before and behind.
    pub(super) fn suit(&self, at: &mut Resolution, t: f32, outer: [f32; 2]) -> bool {
        let before = at.level;
        at.suit_pixels(t);
        if at.is_bent {
            let end = BENT / at.width;
            if t < end {
                at.limit = at.limit.min(end.max(t * 1.001));
            } else if let Some(end) = self.cliffs_ahead(at, t, outer) {
                at.limit = at.limit.min(end);
            } else {
                at.is_bent = false;
            }
        }
        if at.suited > at.native && self.may_see_cliffs(at, t) {
            let end = t + self.stretch();
            let cliffs = self.cliffs(at, [t, end], outer);
            let finer = (0..FINER)
                .filter(|&k| cliffs >= CLIFF * (1 << k) as f32)
                .count();
            at.level = at.suited.saturating_sub(finer).max(at.native);
            at.limit = at.limit.min(end);
        }
        if at.is_bent {
            // Bent profiles go on from a line of their level.
            while at.level > before && !self.is_on_line(at.level, t) {
                at.level -= 1;
                at.limit = t;
            }
        }
        at.level != before
    }

    /// Whether one of a level's lines is at t, which is at one of a finer level's.
    fn is_on_line(&self, level: usize, t: f32) -> bool {
        let field = &self.fields[level];
        let line = t / field.scale + field.major.fraction;
        (line - line.round()).abs() < 0.1
    }

    /// How much of t is looked at at once for cliffs.
    fn stretch(&self) -> f32 {
        AT_ONCE as f32 * self.fields[self.native].scale
    }

    /// Whether there is ground so steep that its cliffs would count at t.
    fn may_see_cliffs(&self, at: &Resolution, t: f32) -> bool {
        let [east, north] = self.frame.levels[self.native].steepness.steepest();
        east.max(north) >= CLIFF * t * at.width * at.metres
    }

    /// The end of the next stretch from t on with a cliff.
    fn cliffs_ahead(&self, at: &Resolution, t: f32, outer: [f32; 2]) -> Option<f32> {
        let (mut from, stretch) = (t, self.stretch());
        let last = self.bounds[0][1]
            .min(self.bounds[1][1] / outer[0].min(outer[1]).max(f32::MIN_POSITIVE));
        while from < last && self.may_see_cliffs(at, from) {
            let end = from + stretch;
            if self.cliffs(at, [from, end], outer) >= CLIFF {
                return Some(end);
            }
            from = end;
        }
        None
    }

    /// How many pixels planes see at most, between two t, of the way from one of the ground's own posts to the next.
    fn cliffs(&self, at: &Resolution, [from, end]: [f32; 2], outer: [f32; 2]) -> f32 {
        let own = &self.fields[self.native];
        let cells = |axis: &Axis, from: f32, to: f32| {
            let [from, to] =
                [from, to].map(|along| axis.ground_alone(axis.cell_alone(along / own.scale)));
            [from.min(to), from.max(to)]
        };
        let major = cells(&own.major, from, end);
        let [least, most] = [outer[0].min(outer[1]), outer[0].max(outer[1])];
        let minor = cells(&own.minor, least * from, most * end);
        let steepness = self.frame.levels[self.native].steepness;
        let [rise, highest] = steepness.among(if own.major_axis == 0 {
            [major, minor]
        } else {
            [minor, major]
        });
        let away = from * at.metres * at.cell as f32;
        let below = (own.eye_height - highest).max(0.0);
        rise * away / away.hypot(below) / (from * at.width * at.metres)
    }
}
