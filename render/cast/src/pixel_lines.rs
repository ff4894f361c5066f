//! Lines of pixels along which rays are coherent.

use glam::{DMat3, DVec2, DVec3};
use sandtable_view::View;

/// An image cut into lines of pixels that run up the image, each pixel in one line.
///
/// The lines are columns, or for a rolled image parallel lines along the projected vertical: one
/// Bresenham line kept as a bit array, which all lines share shifted (Wan, Qu and Kaufman 1999;
/// papers' row W8). Along a line pixels are visited in the order in which coherence runs: from the
/// point straight below the eye outwards, or towards the point straight above it.
pub(crate) struct PixelLines {
    size: [u32; 2],
    layout: Layout,
    /// How far aside each step of the first line lies: the bit array's running sum.
    offsets: Vec<u32>,
    /// Where each line begins: the step, and how far aside.
    starts: Vec<[u32; 2]>,
    turn: Turn,
}

/// How steps along a line and aside lie in the image. Lines move aside towards larger numbers.
#[derive(Clone, Copy)]
struct Layout {
    /// Steps go along rows rather than along columns.
    along_rows: bool,
    /// The first step is at the right or lower edge.
    from_far_edge: bool,
    /// The first place aside is at the right or lower edge.
    aside_from_far_edge: bool,
}

/// Where lines are cut in two, as coherence runs apart or together there.
#[derive(Clone, Copy)]
enum Turn {
    /// Nowhere: neither nadir nor zenith lies within the lines' length.
    None,
    /// From this step coherence runs both ways: the nadir.
    Apart(u32),
    /// To this step coherence runs from both ends: the zenith.
    Together(u32),
}

impl PixelLines {
    /// The columns of `view`'s image, whatever its roll.
    pub(crate) fn columns(view: &View) -> Self {
        let up = if rise(view).y > 0.0 { 1.0 } else { -1.0 };
        Self::along(view, DVec2::new(0.0, up))
    }

    /// Lines along the vertical of the world as it appears in the middle of the image.
    pub(crate) fn rolled(view: &View) -> Self {
        Self::along(view, rise(view))
    }

    /// Lines in the direction `up` of the image.
    fn along(view: &View, up: DVec2) -> Self {
        let along_rows = up.x.abs() > up.y.abs();
        let (major, minor) = if along_rows {
            (up.x, up.y)
        } else {
            (up.y, up.x)
        };
        let layout = Layout {
            along_rows,
            from_far_edge: major < 0.0,
            aside_from_far_edge: minor < 0.0,
        };
        let [steps, width] = layout.extent(view.size);
        let shifts = bresenham(minor.abs(), major.abs(), steps);
        // Lines that enter at the side come first, the last to enter before all others, so that
        // lines lie beside each other in order.
        let entering = shifts.iter().enumerate().rev();
        let mut starts: Vec<_> = entering
            .filter(|&(_, &shift)| shift)
            .map(|(step, _)| [step as u32, 0])
            .collect();
        starts.extend((0..width).map(|aside| [0, aside]));
        let mut moved = 0;
        let offsets = shifts.iter().map(|&shift| {
            moved += u32::from(shift);
            moved
        });
        Self {
            size: view.size,
            layout,
            offsets: offsets.collect(),
            starts,
            turn: turn(view, layout),
        }
    }

    /// How many lines there are.
    pub(crate) fn len(&self) -> usize {
        self.starts.len()
    }

    /// Calls `visit(pixel, afresh)` for each pixel of one line. `afresh` is true for the first, and
    /// wherever coherence begins anew.
    #[inline]
    pub(crate) fn walk(&self, line: usize, mut visit: impl FnMut([u32; 2], bool)) {
        let [first, aside] = self.starts[line];
        let aside_at =
            |step: u32| aside + self.offsets[step as usize] - self.offsets[first as usize];
        let [_, width] = self.layout.extent(self.size);
        let leaves = width + self.offsets[first as usize];
        let end = self
            .offsets
            .partition_point(|&offset| aside + offset < leaves) as u32;
        let (up, down) = match self.turn {
            Turn::None => (first..end, 0..0),
            Turn::Apart(nadir) => {
                let nadir = nadir.clamp(first, end);
                (nadir..end, first..nadir)
            }
            Turn::Together(zenith) => {
                let zenith = zenith.clamp(first, end);
                (first..zenith, zenith..end)
            }
        };
        for (step, count) in up.zip(0..) {
            visit(
                self.layout.pixel(self.size, step, aside_at(step)),
                count == 0,
            );
        }
        for (step, count) in down.rev().zip(0..) {
            visit(
                self.layout.pixel(self.size, step, aside_at(step)),
                count == 0,
            );
        }
    }
}

impl Layout {
    /// How many steps there are along lines, and places aside.
    fn extent(self, [width, height]: [u32; 2]) -> [u32; 2] {
        if self.along_rows {
            [width, height]
        } else {
            [height, width]
        }
    }

    #[inline]
    fn pixel(self, size: [u32; 2], step: u32, aside: u32) -> [u32; 2] {
        let [steps, width] = self.extent(size);
        let step = if self.from_far_edge {
            steps - 1 - step
        } else {
            step
        };
        let aside = if self.aside_from_far_edge {
            width - 1 - aside
        } else {
            aside
        };
        if self.along_rows {
            [step, aside]
        } else {
            [aside, step]
        }
    }

    /// The step in which image coordinates lie; it may be off the image.
    fn step_of(self, size: [u32; 2], point: DVec2) -> f64 {
        let [steps, _] = self.extent(size);
        let along = if self.along_rows { point.x } else { point.y };
        if self.from_far_edge {
            f64::from(steps) - along
        } else {
            along
        }
    }
}

/// Bresenham's line of slope `minor / major`, at most 1, as a bit array: for each of `steps`
/// whether the line moves aside before it.
fn bresenham(minor: f64, major: f64, steps: u32) -> Vec<bool> {
    const MAJOR: u64 = 1 << 24;
    let minor = if major > 0.0 {
        (minor / major * MAJOR as f64).round() as u64
    } else {
        0
    };
    let mut error = MAJOR / 2;
    let mut shifts = vec![false; steps as usize];
    for shift in shifts.iter_mut().skip(1) {
        error += minor;
        *shift = error >= MAJOR;
        error %= MAJOR;
    }
    shifts
}

/// The direction in the image (x right, y down) in which the vertical of the world rises in its
/// middle; up the columns where it has none, as straight below the eye.
fn rise(view: &View) -> DVec2 {
    let [w, h] = view.size.map(f64::from);
    let corner = view.direction(0.0, 0.0);
    let right = view.direction(1.0, 0.0) - corner;
    let down = view.direction(0.0, 1.0) - corner;
    // Z = a·right + b·down + c·corner: the vertical's vanishing point is (a, b) / c, and moving a
    // pixel's direction upwards moves the pixel by (a − c·x, b − c·y).
    let frame = DMat3::from_cols(right, down, corner);
    let [a, b, c] = (frame.inverse() * DVec3::Z).to_array();
    let rise = DVec2::new(a - c * 0.5 * w, b - c * 0.5 * h);
    // A ten-thousandth of a pixel's own size is rounding.
    let scale = 1e-9 * (a.abs() + b.abs() + (c * w).abs() + (c * h).abs());
    if rise.is_finite() && rise.length() > scale {
        rise
    } else {
        DVec2::NEG_Y
    }
}

/// Where lines are cut: at the step in which the nadir, or else the zenith, appears.
fn turn(view: &View, layout: Layout) -> Turn {
    let [steps, _] = layout.extent(view.size);
    let step_of = |point| {
        let step = layout.step_of(view.size, view.pixel_of(point)?).floor();
        (0.0..f64::from(steps))
            .contains(&step)
            .then_some(step as u32)
    };
    if let Some(nadir) = step_of(view.eye - DVec3::Z) {
        Turn::Apart(nadir)
    } else if let Some(zenith) = step_of(view.eye + DVec3::Z) {
        Turn::Together(zenith)
    } else {
        Turn::None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_view::{Attitude, Camera, Screen};

    fn camera(yaw: f64, pitch: f64, roll: f64, size: [u32; 2]) -> View {
        let attitude = Attitude {
            yaw: yaw.to_radians(),
            pitch: pitch.to_radians(),
            roll: roll.to_radians(),
        };
        Camera {
            eye: DVec3::new(3.0, 4.0, 50.0),
            attitude,
            horizontal_fov: 1.2,
        }
        .view(size)
    }

    fn views() -> Vec<View> {
        let mut views = Vec::new();
        for pitch in [-90.0, -80.0, -50.0, -30.0, 0.0, 20.0, 70.0, 90.0] {
            for roll in [
                0.0, 10.0, 30.0, 45.0, 60.0, 90.0, 135.0, 180.0, -45.0, -100.0,
            ] {
                for size in [[31, 20], [20, 31], [1, 9], [9, 1], [1, 1]] {
                    views.push(camera(37.0, pitch, roll, size));
                }
            }
        }
        let table = Screen::horizontal(1.8, 1.1);
        for eye in [DVec3::new(0.1, -0.9, 0.6), DVec3::new(0.1, 0.1, 0.6)] {
            views.push(View {
                eye,
                window: table,
                size: [36, 22],
            });
        }
        views
    }

    #[test]
    fn every_pixel_lies_in_one_line() {
        for view in views() {
            for lines in [PixelLines::columns(&view), PixelLines::rolled(&view)] {
                let [w, h] = view.size.map(|n| n as usize);
                let mut seen = vec![0; w * h];
                for line in 0..lines.len() {
                    lines.walk(line, |[i, j], _| seen[j as usize * w + i as usize] += 1);
                }
                assert!(seen.iter().all(|&count| count == 1), "{view:?}");
            }
        }
    }

    #[test]
    fn rays_rise_along_a_line_until_it_begins_afresh() {
        let elevation = |view: &View, [i, j]: [u32; 2]| {
            let direction = view.ray(i, j).direction;
            direction.z / direction.length()
        };
        for view in views() {
            let lines = PixelLines::rolled(&view);
            for line in 0..lines.len() {
                let mut last = f64::NEG_INFINITY;
                let mut begun = false;
                lines.walk(line, |pixel, afresh| {
                    assert!(begun || afresh, "a line begins afresh");
                    begun = true;
                    let now = elevation(&view, pixel);
                    // The cut lies within a pixel of the nadir or zenith; lines are parallel
                    // though verticals are not, and slant by up to half a pixel.
                    assert!(afresh || now > last - 0.08, "{last} then {now} in {view:?}");
                    last = now;
                });
            }
        }
    }

    #[test]
    fn a_level_image_has_columns_and_a_rolled_one_more_lines() {
        let level = camera(0.0, -30.0, 0.0, [500, 400]);
        assert_eq!(PixelLines::rolled(&level).len(), 500);
        let rolled = camera(0.0, -30.0, 45.0, [500, 400]);
        // At 45 degrees each of the 399 steps after the first moves aside.
        assert_eq!(PixelLines::rolled(&rolled).len(), 899);
        assert_eq!(PixelLines::columns(&rolled).len(), 500);
    }

    #[test]
    fn the_bit_array_is_bresenhams() {
        let shifts = bresenham(2.0, 5.0, 11);
        let mut at = 0;
        for (step, &shift) in shifts.iter().enumerate() {
            at += u32::from(shift);
            assert_eq!(at, (step as f64 * 0.4 + 0.5).floor() as u32);
        }
    }
}
