//! Where eyes are in hard views.

use crate::random::Random;
use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;
use std::f64::consts::TAU;

/// Where an eye is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// Over the ground, by a hundredth of a cell or many.
    Over,
    /// Over it by so little that numbers hardly tell.
    HardlyOver,
    /// Right over a post.
    OverPost,
    /// Right over a line of posts.
    OverLine,
    /// Right over the border or a corner.
    OverBorder,
    /// Beyond the border by a billionth of a cell to one.
    JustOutside,
    /// Beyond it by up to three times the ground's length.
    Outside,
    /// Near the highest of some posts, and lower than it.
    ByNeedle,
    /// Up to 120,000 cells away.
    Far,
    /// So far away that pixels are cast alone.
    Afar,
    /// As high as the highest post, to the last bit.
    AtHighest,
    /// Beyond the border, and lower than all ground.
    Under,
    /// Up to thirty times the ground's length over it.
    HighUp,
}

impl Standing {
    pub(super) const ALL: [Self; 13] = [
        Self::Over,
        Self::HardlyOver,
        Self::OverPost,
        Self::OverLine,
        Self::OverBorder,
        Self::JustOutside,
        Self::Outside,
        Self::ByNeedle,
        Self::Far,
        Self::Afar,
        Self::AtHighest,
        Self::Under,
        Self::HighUp,
    ];

    /// An eye that stands so, in the world's metres.
    pub(super) fn eye(self, ground: &Ground, random: &mut Random) -> DVec3 {
        let mut place = Place { ground, random };
        let cell = ground.grid().cell_length();
        let length = place.extent().max_element();
        match self {
            Self::Over => {
                let at = place.anywhere();
                place.over(at)
            }
            Self::HardlyOver => {
                let at = if place.random.unit() < 0.7 {
                    place.anywhere()
                } else {
                    place.post()
                };
                surface(ground, at) + place.random.octaves(1e-10, 1e-2) * cell * DVec3::Z
            }
            Self::OverPost => {
                let at = place.post();
                place.over(at)
            }
            Self::OverLine => {
                let mut at = place.anywhere();
                let axis = place.axis();
                at[axis] = place.post()[axis];
                place.over(at)
            }
            Self::OverBorder => {
                let mut at = place.anywhere();
                let axis = place.axis();
                at[axis] = place.side(axis, 0.0);
                if place.random.unit() < 0.2 {
                    at[1 - axis] = place.side(1 - axis, 0.0);
                }
                place.over(at)
            }
            Self::JustOutside => {
                let out = place.random.octaves(1e-9, 1.0) * cell;
                place.beside(out)
            }
            Self::Outside => {
                let out = place.random.octaves(0.1 * cell, 3.0 * length);
                place.beside(out)
            }
            Self::ByNeedle => place.by_needle(),
            Self::Far => place.away(1e2, 1.2e5),
            Self::Afar => place.away(2.7e5, 1e7),
            Self::AtHighest => place.anywhere().extend(f64::from(ground.range()[1])),
            Self::Under => {
                let mut at = place.anywhere();
                let axis = place.axis();
                let out = place.random.octaves(1e-2 * cell, length);
                at[axis] = place.side(axis, out);
                let below = place.random.octaves(1e-2, 100.0) * place.relief();
                at.extend(f64::from(ground.range()[0]) - below)
            }
            Self::HighUp => {
                let at = place.anywhere();
                surface(ground, at) + place.random.octaves(0.1, 30.0) * length * DVec3::Z
            }
        }
    }
}

/// The surface at the place of the ground that is nearest to one.
pub(super) fn surface(ground: &Ground, at: DVec2) -> DVec3 {
    let at = at.clamp(DVec2::ZERO, ground.grid().extent());
    let height = ground.height_at(at.x, at.y);
    at.extend(height.expect("the place is on the terrain"))
}

/// Any place in the rectangle of posts.
pub(super) fn anywhere(ground: &Ground, random: &mut Random) -> DVec2 {
    DVec2::new(random.unit(), random.unit()) * ground.grid().extent()
}

/// The ground, and what places on it are drawn from.
struct Place<'a> {
    ground: &'a Ground,
    random: &'a mut Random,
}

impl Place<'_> {
    fn extent(&self) -> DVec2 {
        self.ground.grid().extent()
    }

    /// From the lowest post to the highest; a thousandth of a cell where all lie level.
    fn relief(&self) -> f64 {
        let [low, high] = self.ground.range().map(f64::from);
        (high - low).max(1e-3 * self.ground.grid().cell_length())
    }

    fn anywhere(&mut self) -> DVec2 {
        anywhere(self.ground, self.random)
    }

    fn axis(&mut self) -> usize {
        usize::from(self.random.unit() < 0.5)
    }

    /// A place on one axis that lies so far out beyond its begin or its end.
    fn side(&mut self, axis: usize, out: f64) -> f64 {
        if self.random.unit() < 0.5 {
            -out
        } else {
            self.extent()[axis] + out
        }
    }

    fn post(&mut self) -> DVec2 {
        let grid = self.ground.grid();
        let mut one_of = |posts: u32| (self.random.bits() % u64::from(posts)) as f64;
        DVec2::new(one_of(grid.cols), one_of(grid.rows)) * grid.spacing
    }

    /// A height over ground: of cells, or of the relief.
    fn height(&mut self) -> f64 {
        if self.random.unit() < 0.5 {
            self.random.octaves(1e-2, 30.0) * self.ground.grid().cell_length()
        } else {
            self.random.octaves(1e-2, 3.0) * self.relief()
        }
    }

    fn over(&mut self, at: DVec2) -> DVec3 {
        surface(self.ground, at) + self.height() * DVec3::Z
    }

    /// So far out beyond the border, higher than it or lower.
    fn beside(&mut self, out: f64) -> DVec3 {
        let mut at = self.anywhere();
        let axis = self.axis();
        at[axis] = self.side(axis, out);
        if self.random.unit() < 0.3 {
            at[1 - axis] = self.side(1 - axis, out);
        }
        let height = self.height();
        let height = if self.random.unit() < 0.5 {
            height
        } else {
            -height
        };
        at.extend(surface(self.ground, at).z + height)
    }

    fn by_needle(&mut self) -> DVec3 {
        let grid = self.ground.grid();
        let highest = (0..300)
            .map(|_| surface(self.ground, self.post()))
            .max_by(|a, b| a.z.total_cmp(&b.z))
            .expect("there are some");
        let mut aside = || self.random.between(-3.0, 3.0);
        let at = highest.truncate() + DVec2::new(aside(), aside()) * grid.spacing;
        let below = surface(self.ground, at);
        let up = self.random.between(0.0, 1.2) * (highest.z - below.z).max(0.0)
            + self.random.octaves(1e-3, 1.0) * grid.cell_length();
        below + up * DVec3::Z
    }

    /// So many cells away from some place, in any direction but down.
    fn away(&mut self, least: f64, most: f64) -> DVec3 {
        let from = surface(self.ground, self.anywhere());
        let cells = self.random.octaves(least, most);
        let up = self.random.between(-0.1, 1.57);
        let heading = DVec2::from_angle(self.random.between(0.0, TAU));
        let away = (up.cos() * heading).extend(up.sin());
        from + cells * self.ground.grid().cell_length() * away
    }
}
