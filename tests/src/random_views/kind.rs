//! The kinds of random views: where the eye is, and how it looks.

use crate::random::Random;
use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Placement, Screen, View};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;

/// Where the eye is, and how it looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Over the ground, without roll.
    Level,
    /// Over the ground, rolled by any angle.
    Rolled,
    /// Over the ground, with any pitch and roll.
    AnyAttitude,
    /// Over the ground, straight down, rolled by any angle.
    StraightDown,
    /// Over the ground, steeply down: the point straight below lies in the image.
    NadirInside,
    /// From where the ground rises near by, up towards the zenith or straight at it.
    ToTheZenith,
    /// Over the ground, through a window that is off the axis, askew and not of square pixels.
    OffAxis,
    /// Before a table's glass; the relief may be stretched.
    Table,
    /// Leaning over a table's glass: the point straight below lies in the image.
    LeaningOver,
    /// On the ground, or up to a cell above it.
    LowOver,
    /// A little beyond the border.
    Outside,
    /// Many times the terrain's length away.
    FarOutside,
    /// Beyond the border and lower than the ground there: in front of the wall.
    UnderTheBorder,
    /// Inside the solid terrain.
    Buried,
    /// Along grid lines, with a column or row of pixels right in the line.
    AlongGridLines,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Level,
        Self::Rolled,
        Self::AnyAttitude,
        Self::StraightDown,
        Self::NadirInside,
        Self::ToTheZenith,
        Self::OffAxis,
        Self::Table,
        Self::LeaningOver,
        Self::LowOver,
        Self::Outside,
        Self::FarOutside,
        Self::UnderTheBorder,
        Self::Buried,
        Self::AlongGridLines,
    ];

    /// A view of this kind of `ground`, of `size` pixels.
    pub(super) fn view(self, ground: &Ground, random: &mut Random, size: [u32; 2]) -> View {
        let mut place = Place { ground, random };
        match self {
            Self::Level => {
                let eye = place.over_the_ground();
                let pitch = place.random.between(-0.8, 0.2);
                place.camera(eye, pitch, 0.0).view(size)
            }
            Self::Rolled => {
                let eye = place.over_the_ground();
                let pitch = place.random.between(-1.0, 0.4);
                let roll = place.any_roll();
                place.camera(eye, pitch, roll).view(size)
            }
            Self::AnyAttitude => {
                let eye = place.over_the_ground();
                let pitch = place.random.between(-FRAC_PI_2, FRAC_PI_2);
                let roll = place.any_roll();
                place.camera(eye, pitch, roll).view(size)
            }
            Self::StraightDown => {
                let eye = place.over_the_ground();
                let roll = place.any_roll();
                place.camera(eye, -FRAC_PI_2, roll).view(size)
            }
            Self::NadirInside => {
                let eye = place.over_the_ground();
                let roll = place.any_roll();
                let mut camera = place.camera(eye, 0.0, roll);
                camera.attitude.pitch = -FRAC_PI_2 + place.within_half_height(&camera, size);
                camera.view(size)
            }
            Self::ToTheZenith => {
                let eye = place.hemmed_in();
                let roll = place.any_roll();
                let mut camera = place.camera(eye, 0.0, roll);
                camera.horizontal_fov = place.random.between(1.4, 2.4);
                let straight = place.random.unit() < 0.5;
                let below = place.within_half_height(&camera, size);
                camera.attitude.pitch = if straight {
                    FRAC_PI_2
                } else {
                    FRAC_PI_2 - below
                };
                camera.view(size)
            }
            Self::OffAxis => place.off_axis(size),
            Self::Table => {
                let eye = DVec3::new(
                    place.random.between(-0.6, 0.6),
                    place.random.between(-1.2, -0.6),
                    place.random.between(0.3, 0.8),
                );
                place.table(eye, size)
            }
            Self::LeaningOver => {
                let eye = DVec3::new(
                    place.random.between(-0.8, 0.8),
                    place.random.between(-0.5, 0.5),
                    place.random.between(0.2, 0.7),
                );
                place.table(eye, size)
            }
            Self::LowOver => place.low_over(size),
            Self::Outside => place.outside(size),
            Self::FarOutside => place.far_outside(size),
            Self::UnderTheBorder => place.under_the_border(size),
            Self::Buried => {
                let at = place.on_the_ground();
                let depth = place
                    .random
                    .octaves(0.1 * place.cell(), 2.0 * place.relief());
                let pitch = place.random.between(-FRAC_PI_2, FRAC_PI_2);
                let roll = place.any_roll();
                place.camera(at - depth * DVec3::Z, pitch, roll).view(size)
            }
            Self::AlongGridLines => place.along_grid_lines(size),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Level => "level",
            Self::Rolled => "rolled",
            Self::AnyAttitude => "any attitude",
            Self::StraightDown => "straight down",
            Self::NadirInside => "nadir inside",
            Self::ToTheZenith => "to the zenith",
            Self::OffAxis => "off axis",
            Self::Table => "table",
            Self::LeaningOver => "leaning over",
            Self::LowOver => "low over",
            Self::Outside => "outside",
            Self::FarOutside => "far outside",
            Self::UnderTheBorder => "under the border",
            Self::Buried => "buried",
            Self::AlongGridLines => "along grid lines",
        })
    }
}

/// The ground on which a view is drawn, with what it is drawn from.
struct Place<'a> {
    ground: &'a Ground,
    random: &'a mut Random,
}

impl Place<'_> {
    fn extent(&self) -> DVec2 {
        self.ground.grid().extent()
    }

    /// The terrain's length, in metres.
    fn length(&self) -> f64 {
        self.extent().max_element()
    }

    fn cell(&self) -> f64 {
        self.ground.grid().cell_length()
    }

    fn range(&self) -> [f64; 2] {
        self.ground.range().map(f64::from)
    }

    /// From the lowest to the highest post in metres; a cell where all lie level.
    fn relief(&self) -> f64 {
        let [low, high] = self.range();
        (high - low).max(self.cell())
    }

    /// The surface at a place in the rectangle of posts.
    fn surface(&self, at: DVec2) -> DVec3 {
        let at = at.clamp(DVec2::ZERO, self.extent());
        let height = self.ground.height_at(at.x, at.y);
        at.extend(height.expect("the place is on the terrain"))
    }

    /// Any place on the surface.
    fn on_the_ground(&mut self) -> DVec3 {
        let share = DVec2::new(self.random.unit(), self.random.unit());
        self.surface(share * self.extent())
    }

    /// From half a cell above the surface to half the terrain's length, low as often as high.
    fn over_the_ground(&mut self) -> DVec3 {
        let above = self.random.octaves(0.5 * self.cell(), 0.5 * self.length());
        self.on_the_ground() + above * DVec3::Z
    }

    /// Of a few places the one from which the ground near by rises highest, up to two cells above
    /// the surface.
    fn hemmed_in(&mut self) -> DVec3 {
        let mut steepest = (f64::NEG_INFINITY, DVec3::ZERO);
        for _ in 0..40 {
            let at = self.on_the_ground();
            for k in 0..16 {
                let way = f64::from(1 + k / 8) * 1.5 * self.cell();
                let near = self.surface(at.truncate() + way * DVec2::from_angle(f64::from(k)));
                let slope = (near.z - at.z) / way;
                if slope > steepest.0 {
                    steepest = (slope, at);
                }
            }
        }
        let above = self.random.octaves(0.01, 2.0) * self.cell();
        steepest.1 + above * DVec3::Z
    }

    fn any_roll(&mut self) -> f64 {
        self.random.between(-PI, PI)
    }

    /// A camera that heads for some place on the ground, from telephoto to wide angle.
    fn camera(&mut self, eye: DVec3, pitch: f64, roll: f64) -> Camera {
        let way = self.on_the_ground() - eye;
        Camera {
            eye,
            attitude: Attitude {
                yaw: way.x.atan2(way.y),
                pitch,
                roll,
            },
            horizontal_fov: self.random.octaves(0.05, 2.0),
        }
    }

    /// An angle by which the camera may turn in any direction and keep its centre in the image.
    fn within_half_height(&mut self, camera: &Camera, size: [u32; 2]) -> f64 {
        let aspect = f64::from(size[1]) / f64::from(size[0]);
        let half = ((0.5 * camera.horizontal_fov).tan() * aspect).atan();
        self.random.between(0.0, 0.9 * half)
    }

    fn off_axis(&mut self, size: [u32; 2]) -> View {
        let eye = self.over_the_ground();
        let pitch = self.random.between(-1.2, 0.3);
        let roll = self.any_roll();
        let mut camera = self.camera(eye, pitch, roll);
        camera.horizontal_fov = self.random.between(0.2, 1.6);
        let mut view = camera.view(size);
        let (across, upwards) = (view.window.across(), view.window.upwards());
        let shift =
            self.random.between(-1.5, 1.5) * across + self.random.between(-1.5, 1.5) * upwards;
        let skew = self.random.between(-0.3, 0.3) * across;
        let stretch = self.random.between(0.5, 2.0);
        let corner = view.window.lower_left + shift;
        view.window = Screen {
            lower_left: corner,
            lower_right: corner + across,
            upper_left: corner + stretch * upwards + skew,
        };
        view
    }

    /// A horizontal glass over all of the ground or a part of it, which may lie below the surface,
    /// and an eye in table metres.
    fn table(&mut self, eye: DVec3, size: [u32; 2]) -> View {
        let glass = Screen::horizontal(1.8, 1.1);
        let exaggeration = *self.random.choose(&[1.0, 1.0, 1.7, 4.0]);
        let mut placement =
            Placement::fitted(self.extent(), self.range(), &glass, 0.05, exaggeration);
        placement.yaw = self.random.between(0.0, TAU);
        let share = self.random.octaves(0.1, 1.2);
        placement.scale *= share;
        let sideways = DVec2::new(
            self.random.between(-0.4, 0.4),
            self.random.between(-0.4, 0.4),
        );
        placement.anchor += ((1.0 - share).max(0.0) * sideways * self.extent())
            .extend(self.random.between(0.0, 0.6) * self.relief());
        View {
            eye: placement.world_from_table(eye),
            window: glass.map(|corner| placement.world_from_table(corner)),
            size,
        }
    }

    /// Now and then right on the surface.
    fn low_over(&mut self, size: [u32; 2]) -> View {
        let at = self.on_the_ground();
        let above = if self.random.unit() < 0.2 {
            0.0
        } else {
            self.random.octaves(1e-3, 1.0) * self.cell()
        };
        let pitch = self.random.between(-0.3, 0.3);
        let roll = self.random.between(-0.5, 0.5);
        self.camera(at + above * DVec3::Z, pitch, roll).view(size)
    }

    /// A place beyond the border by a part of the terrain's length, and the place of the border
    /// that is nearest to it.
    fn beyond_the_border(&mut self, nearest: f64, farthest: f64) -> (DVec2, DVec3) {
        let share = DVec2::new(self.random.unit(), self.random.unit());
        let out = self.random.octaves(nearest, farthest);
        let mut at = share * self.extent();
        let side = (self.random.bits() % 4) as usize;
        at[side / 2] = if side.is_multiple_of(2) {
            -out
        } else {
            self.extent()[side / 2] + out
        };
        (at, self.surface(at))
    }

    /// The view from `eye` whose centre is `target`, of any roll.
    fn towards(&mut self, eye: DVec3, target: DVec3, horizontal_fov: f64) -> Camera {
        let way = target - eye;
        let roll = self.any_roll();
        Camera {
            eye,
            attitude: Attitude {
                yaw: way.x.atan2(way.y),
                pitch: way.z.atan2(way.truncate().length()),
                roll,
            },
            horizontal_fov,
        }
    }

    fn outside(&mut self, size: [u32; 2]) -> View {
        let (at, _) = self.beyond_the_border(0.1 * self.cell(), 0.5 * self.length());
        let [low, high] = self.range();
        let z = self.random.between(low, high + self.relief());
        let target = self.on_the_ground();
        let fov = self.random.octaves(0.1, 2.0);
        self.towards(at.extend(z), target, fov).view(size)
    }

    fn far_outside(&mut self, size: [u32; 2]) -> View {
        let target = self.on_the_ground();
        let (heading, height) = (
            self.random.between(0.0, TAU),
            self.random.between(-0.1, 1.2),
        );
        let direction = (height.cos() * DVec2::from_angle(heading)).extend(height.sin());
        let distance = self.random.octaves(5.0, 40.0) * self.length();
        let seen = self.random.octaves(0.05, 1.2) * self.length();
        let fov = 2.0 * (0.5 * seen / distance).atan();
        self.towards(target + distance * direction, target, fov)
            .view(size)
    }

    fn under_the_border(&mut self, size: [u32; 2]) -> View {
        let (at, border) = self.beyond_the_border(0.5 * self.cell(), 0.2 * self.length());
        let below = self.random.octaves(0.01, 2.0) * self.relief();
        let eye = at.extend(border.z - below);
        // Anywhere around the wall's edge: above it the terrain and the sky may be seen.
        let spread = (eye - border).length();
        let mut off = || self.random.between(-spread, spread);
        let target = border + DVec3::new(off(), off(), off());
        let target = target
            .truncate()
            .clamp(DVec2::ZERO, self.extent())
            .extend(target.z);
        let fov = self.random.between(0.3, 1.8);
        self.towards(eye, target, fov).view(size)
    }

    fn along_grid_lines(&mut self, size: [u32; 2]) -> View {
        let grid = self.ground.grid();
        let post = (self.on_the_ground().truncate() / grid.spacing).round();
        let above = self.random.octaves(0.5 * self.cell(), 0.3 * self.length());
        let eye = self.surface(post * grid.spacing) + above * DVec3::Z;
        let attitude = Attitude {
            yaw: *self.random.choose(&[0.0, FRAC_PI_2, PI, -FRAC_PI_2]),
            pitch: *self.random.choose(&[0.0, -0.3, -0.8, -FRAC_PI_2]),
            roll: *self.random.choose(&[0.0, FRAC_PI_2]),
        };
        let camera = Camera {
            eye,
            attitude,
            horizontal_fov: self.random.octaves(0.3, 1.8),
        };
        let mut view = camera.view(size);
        // Half a pixel each way, so that the middle pixels' centres lie straight ahead.
        let half = 0.5 * view.window.across() / f64::from(size[0])
            + 0.5 * view.window.upwards() / f64::from(size[1]);
        view.window = view.window.map(|corner| corner + half);
        view
    }
}
