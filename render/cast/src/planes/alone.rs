//! Rays that are cast alone, in 64 bits, for eyes that the kernels are not made for: as brute force does it,
//! but past blocks of ground over whose roofs they pass.

use super::field::Tiles;
use super::frame::Frame;
use super::roofs::{FINEST, LEVEL_BEGIN, Roof, TOP, numbers};
use crate::brute;
use crate::canvas::Canvas;
use crate::intersect::{GridFrame, GridRay};
use crate::tally::Tally;
use glam::{DVec2, DVec3};
use sandtable_terrain::{Ground, Rgb, TILE_CELLS};

/// Heights over the eye, as a share of both, that are no more than rounding.
const ROUNDING: f64 = 1e-9;

/// How far from the ground's surface an eye must be for the kernels to tell in which direction parts of it lie that are
/// no farther away, as a share of how much higher or lower than the eye ground is near by: some ten thousand times
/// a height's last digit.
const TELLS: f64 = 1e-3;

/// Whether an eye (metres) is in the ground, or too close for the kernels to its surface or a wall's upper edge.
pub(super) fn is_close(ground: &Ground, eye: DVec3) -> bool {
    let grid = ground.grid();
    let nearest = eye.truncate().clamp(DVec2::ZERO, grid.extent());
    let ([column, row], _) =
        (ground.heights()).locate(nearest.x / grid.spacing.x, nearest.y / grid.spacing.y);
    let Some(height) = ground.height_at(nearest.x, nearest.y) else {
        return false;
    };
    let is_over = nearest == eye.truncate();
    if is_over && eye.z <= height {
        return true;
    }
    // From the edge of a cell a wall may go down beside it.
    let around = |at: u32, posts: u32| at.saturating_sub(1)..(at + 2).min(posts - 1);
    around(row, grid.rows)
        .flat_map(|row| around(column, grid.cols).map(move |column| [column, row]))
        .any(|cell| is_close_to(ground, cell, eye))
}

/// The same for one cell, of an eye that is not in the ground.
fn is_close_to(ground: &Ground, [column, row]: [u32; 2], eye: DVec3) -> bool {
    let spacing = ground.grid().spacing;
    let corner = |column: u32, row: u32| DVec2::new(f64::from(column), f64::from(row)) * spacing;
    let nearest = eye
        .truncate()
        .clamp(corner(column, row), corner(column + 1, row + 1));
    let posts = ground.heights().cell(column, row).map(f64::from);
    let relief = posts
        .into_iter()
        .fold(0.0, |relief: f64, post| relief.max((post - eye.z).abs()));
    let height = ground.height_at(nearest.x, nearest.y);
    height.is_some_and(|height| eye.distance(nearest.extend(height)) <= TELLS * relief)
}

/// What is known of a view whose pixels are cast alone.
pub(super) struct Alone<'a> {
    grid: GridFrame<'a>,
    /// The ground's colour at the eye, where it is in the ground: all that there is to see, right before it.
    at_the_eye: Option<Rgb>,
}

impl<'a> Alone<'a> {
    pub(super) fn new(ground: &'a Ground, eye: DVec3) -> Self {
        let is_inside = eye.truncate().cmpgt(DVec2::ZERO).all()
            && eye.truncate().cmplt(ground.grid().extent()).all();
        let height = ground.height_at(eye.x, eye.y).filter(|_| is_inside);
        let is_in_it =
            height.is_some_and(|height| height - eye.z > ROUNDING * height.abs().max(eye.z.abs()));
        Self {
            grid: GridFrame::new(ground),
            at_the_eye: is_in_it.then(|| ground.colour_at(eye.x, eye.y)),
        }
    }
}

/// Casts each pixel of a row alone.
pub(super) fn cast_row<T: Tally>(
    frame: &Frame<'_>,
    alone: &Alone<'_>,
    row: u32,
    canvas: &Canvas<'_>,
    tally: &mut T,
) {
    if let Some(colour) = alone.at_the_eye {
        for i in 0..frame.view.size[0] {
            tally.ray();
            canvas.set([i, row], colour, 0.0);
        }
        return;
    }
    let blocks = Blocks {
        roofs: &frame.levels[0].roofs,
        cells: frame.levels[0].cells,
        rounding: f64::from(frame.rounding),
    };
    let first_hit = |ray: &GridRay<'_>, tally: &mut T| blocks.first_hit(ray, tally);
    brute::cast_row(&alone.grid, frame.view, row, canvas, tally, first_hit);
}

/// The ground's blocks.
struct Blocks<'a> {
    roofs: &'a Tiles<'a, Roof>,
    cells: [i32; 2],
    /// By how much a ray must be over a roof, in metres.
    rounding: f64,
}

impl Blocks<'_> {
    /// The first t at which a ray is in the terrain, as brute force finds it.
    fn first_hit<T: Tally>(&self, ray: &GridRay<'_>, tally: &mut T) -> Option<f64> {
        let direction = [ray.direction.x, ray.direction.y];
        let origin = [ray.origin.x, ray.origin.y];
        let mut t = ray.enter;
        // Counted from block to block, as a place on a line may be rounded to either side of it.
        let place = ray.place(t);
        let mut cell: [i32; 2] =
            std::array::from_fn(|axis| (place[axis] as i32).clamp(0, self.cells[axis] - 1));
        let mut level = TOP;
        loop {
            let begin = cell.map(|cell| cell >> level << level);
            let line =
                |axis: usize| begin[axis] + if direction[axis] > 0.0 { 1 << level } else { 0 };
            // As brute force does it, to the last bit.
            let end = |axis: usize| match direction[axis] {
                0.0 => f64::INFINITY,
                _ => (f64::from(line(axis)) - origin[axis]) * ray.inverse[axis],
            };
            let ends = [end(0), end(1)];
            let end = ends[0].min(ends[1]).min(ray.leave).max(t);
            tally.cell();
            if !self.passes_over(ray, level, begin, [t, end]) {
                if level > FINEST {
                    level -= 1;
                    continue;
                }
                if let Some(hit) = ray.first_hit_up_to(t, end, tally) {
                    return Some(hit);
                }
            }
            let axis = usize::from(ends[1] < ends[0]);
            if ends[axis] >= ray.leave {
                return None;
            }
            t = end;
            let next = if direction[axis] > 0.0 {
                line(axis)
            } else {
                line(axis) - 1
            };
            if !(0..self.cells[axis]).contains(&next) {
                return None;
            }
            cell[axis] = next;
            let across = 1 - axis;
            let most = (begin[across] + (1 << level)).min(self.cells[across]) - 1;
            cell[across] = (ray.place(t)[across] as i32).clamp(begin[across], most);
            level = (level + 1).min(TOP);
        }
    }

    /// Whether a ray passes over all ground of the block of `level` that begins with a cell.
    fn passes_over(&self, ray: &GridRay<'_>, level: u32, begin: [i32; 2], ends: [f64; 2]) -> bool {
        let tile = begin.map(|cell| cell / TILE_CELLS as i32);
        let within = begin.map(|cell| (cell % TILE_CELLS as i32) >> level);
        let side = TILE_CELLS as i32 >> level;
        let at = LEVEL_BEGIN[level as usize] + within[1] * side + within[0];
        let place = self.roofs.tile(tile[0], tile[1]) + at as u32;
        let Some(&roof) = self.roofs.items.from_place(place).first() else {
            return false;
        };
        let [height, east, north] = numbers(roof).map(f64::from);
        let half = 0.5 * f64::from(1 << level);
        ends.into_iter().all(|t| {
            let [x, y] = ray.place(t);
            let [x, y] = [
                x - f64::from(begin[0]) - half,
                y - f64::from(begin[1]) - half,
            ];
            let above = ray.origin.z + t * ray.direction.z - self.rounding;
            above > height + east * x + north * y
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute::Brute;
    use crate::lanes::Isa;
    use crate::planes::PlanesScene;
    use crate::tally::Uncounted;
    use crate::units::UnitCaster;
    use crate::{Caster, Image, Scene, Scheme};
    use sandtable_view::{Attitude, Camera, View};
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    /// Hills of all sizes, with walls and spikes, of cells that are not square, over several tiles of which the
    /// last ones are not whole.
    fn ground() -> Ground {
        let height = |col: u32, row: u32| {
            let [x, y] = [col, row].map(f64::from);
            let hills = 60.0 * (0.011 * x).sin() * (0.017 * y).cos() + 9.0 * (0.13 * (x + y)).sin();
            let wall = if col % 97 == 50 { 25.0 } else { 0.0 };
            let spike = if (col * 31 + row * 17).is_multiple_of(997) {
                40.0
            } else {
                0.0
            };
            (hills + wall + spike) as f32
        };
        Ground::from_fn(601, 530, DVec2::new(5.0, 4.0), height).expect("a sound grid")
    }

    fn view(eye: [f64; 3], [yaw, pitch, roll]: [f64; 3], horizontal_fov: f64) -> View {
        let attitude = Attitude { yaw, pitch, roll };
        Camera {
            eye: DVec3::from_array(eye),
            attitude,
            horizontal_fov,
        }
        .view([161, 121])
    }

    #[test]
    fn it_is_what_brute_force_sees() {
        let scene = Scene::new(ground());
        let surface = scene.ground.height_at(1500.0, 1000.0).expect("it is there");
        let (middle_x, middle_y) = (1500.0, 1058.0);
        let far = 3e6 / 2.0_f64.sqrt();
        let views = [
            // Over the ground, level, rolled, down, and along grid lines.
            view([700.0, 300.0, 90.0], [0.7, -0.1, 0.0], 1.2),
            view([2000.0, 1500.0, 120.0], [3.6, -0.4, 0.9], 1.2),
            view([1200.0, 900.0, 400.0], [0.3, -FRAC_PI_2, 0.2], 1.6),
            view([1000.0, 40.0, 80.0], [0.0, -0.1, 0.0], 0.9),
            view([2995.0, 1600.0, 100.0], [-FRAC_PI_2, -0.2, 0.0], 0.9),
            // Beside it, lower than its border, and in it.
            view([-400.0, -300.0, 200.0], [FRAC_PI_4, -0.2, 0.1], 0.9),
            view([1500.0, -30.0, -90.0], [0.1, 0.3, 0.0], 1.4),
            view([1500.0, 1000.0, -300.0], [1.0, 0.5, 0.0], 1.0),
            // In it, as far as rounding tells; on its border; and at its corner.
            view([1500.0, 1000.0, surface], [1.0, -0.1, 0.0], 1.0),
            view([1500.0, 1000.0, surface.next_down()], [1.0, 0.3, 0.0], 1.0),
            view([0.0, 1000.0, -300.0], [0.2, 0.5, 0.4], 1.4),
            view([3000.0, 2116.0, -300.0], [-2.5, 0.5, 0.0], 1.4),
            // From afar.
            view(
                [middle_x, middle_y - far, far],
                [0.0, -FRAC_PI_4, 0.4],
                1e-3,
            ),
            view(
                [middle_x - 3e6, middle_y, 3e5],
                [FRAC_PI_2, -0.0997, 0.0],
                4e-4,
            ),
            view([middle_x, middle_y, 2e6], [0.0, -FRAC_PI_2, 0.0], 1.4e-3),
        ];
        let prepared = PlanesScene::new(Isa::best(), None, scene.clone());
        let brute = Brute.prepare(scene.clone()).expect("any scene will do");
        for view in views {
            let mut expected = [Image::default()];
            brute
                .cast(&[view], &mut expected, Scheme::default())
                .expect("accepted");
            let [expected] = expected;
            let mut image = Image::default();
            image.reset(view);
            let frame = prepared.frame(&view).expect("a proper view");
            let alone = Alone::new(&scene.ground, view.eye);
            let canvas = Canvas::new(&mut image);
            for row in 0..view.size[1] {
                cast_row(&frame, &alone, row, &canvas, &mut Uncounted);
            }
            let ground = image.depth.iter().filter(|depth| depth.is_finite()).count();
            assert!(ground > 2000, "{ground} of {view:?}");
            assert_eq!(image.depth, expected.depth, "{view:?}");
            assert_eq!(image.colour(), expected.colour(), "{view:?}");
        }
    }
}
