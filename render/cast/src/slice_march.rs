//! One pixel column's march over terrain slices.

use crate::canvas::Canvas;
use crate::shade::sky;
use crate::slice_depth::DepthRule;
use crate::slice_posts::SlicePosts;
use crate::slices::{Row, Sampling, SliceFrame, Sweep};
use crate::tally::Tally;
use glam::DVec2;

/// The metres from `origin` along `direction` between which a line is within the rectangle from
/// 0 to `last`; none where the first is more than the second.
fn clip(origin: DVec2, direction: DVec2, last: DVec2) -> [f64; 2] {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for axis in 0..2 {
        if direction[axis] == 0.0 {
            if !(0.0..=last[axis]).contains(&origin[axis]) {
                return [f64::INFINITY, f64::NEG_INFINITY];
            }
        } else {
            let a = -origin[axis] / direction[axis];
            let b = (last[axis] - origin[axis]) / direction[axis];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
    }
    [enter, leave]
}

/// How often a column's first pixel is looked up at one slice, where nothing is known yet of the
/// ground's height, until place and height agree.
const SETTLING_LOOKS: u32 = 8;

/// One pixel column's march over one sweep's slices.
pub(crate) struct March<'a, P, T> {
    frame: &'a SliceFrame<'a>,
    sweep: &'a Sweep,
    posts: &'a P,
    canvas: &'a Canvas<'a>,
    tally: &'a mut T,
    column: u32,
    /// The column's offset from the normal's foot in window distances, squared.
    offset_squared: f32,
    /// That offset times a metre to the right, and a metre ahead, in posts.
    side: DVec2,
    ahead: DVec2,
}

impl<'a, 'p, P: SlicePosts<'p>, T: Tally> March<'a, P, T> {
    pub(crate) fn new(
        frame: &'a SliceFrame<'a>,
        sweep: &'a Sweep,
        posts: &'a P,
        canvas: &'a Canvas<'a>,
        tally: &'a mut T,
        column: u32,
    ) -> Self {
        let offset = frame.window.column(column);
        Self {
            frame,
            sweep,
            posts,
            canvas,
            tally,
            column,
            offset_squared: (offset * offset) as f32,
            side: frame.window.right * offset * frame.per_metre,
            ahead: sweep.ahead * frame.per_metre,
        }
    }

    /// Looks the ground up along one line for all rays of the column.
    pub(crate) fn along_track<D: DepthRule>(&mut self) {
        let (frame, sweep) = (self.frame, self.sweep);
        let rows = &sweep.rows;
        let Some(mut row) = rows.first() else { return };
        let (side, ahead) = (self.side, self.ahead);
        let (origin, direction) = if frame.sampling == Sampling::VerticalPlane {
            (frame.eye, ahead + side / sweep.cos)
        } else {
            let foot = (frame.eye_height - frame.base) * frame.window.sin;
            (frame.eye + side * foot, ahead + side * sweep.cos)
        };
        let [enter, leave] = clip(origin, direction, frame.last);
        let mut done = 0;
        for n in sweep.between(enter.max(row.enter), leave, frame.step) {
            let y = sweep.at(n, frame.step);
            if y > row.reach {
                break;
            }
            let place = origin + y * direction;
            let place = self.posts.place(place.x, place.y);
            self.tally.sample();
            let height = self.posts.height(place, self.tally);
            if frame.eye_height + row.slope * y > height {
                continue;
            }
            let colour = self.posts.colour(place);
            loop {
                self.paint::<D>(row, y, height, colour);
                done += 1;
                let Some(next) = rows.get(done) else { return };
                row = next;
                if frame.eye_height + row.slope * y > height {
                    break;
                }
            }
        }
        for row in &rows[done..] {
            self.paint_sky(row);
        }
    }

    /// Looks the ground up where the ray itself is.
    pub(crate) fn at_ray_height<D: DepthRule>(&mut self) {
        let (frame, sweep) = (self.frame, self.sweep);
        let Some(lowest) = sweep.rows.first() else {
            return;
        };
        let (side, ahead) = (self.side, self.ahead);
        let eye_is_outside = frame.eye.clamp(DVec2::ZERO, frame.last) != frame.eye;
        let mut next = sweep.between(lowest.enter, 0.0, frame.step).start;
        let place_at = |y: f64, level: f64| {
            let sideways = y * sweep.cos + (frame.eye_height - level) * frame.window.sin;
            frame.eye + y * ahead + sideways * side
        };
        let mut entered = None;
        let mut floor = frame.base;
        let mut painted = None;
        for row in &sweep.rows {
            // The first slice at which the ray is over the terrain. The ray of the row before may
            // have come later, and has not looked at the slices until it did.
            let enter = if eye_is_outside {
                let direction = ahead + side * row.spread;
                let [enter, leave] = clip(frame.eye, direction, frame.last);
                let slices = sweep.between(enter, leave, frame.step);
                if slices.is_empty() {
                    sweep.slices
                } else {
                    slices.start
                }
            } else {
                0
            };
            let unseen = enter..entered.replace(enter).unwrap_or(enter);
            let mut hit = None;
            let ahead_of_seen = next.max(enter)..sweep.slices;
            next = ahead_of_seen.end;
            'slices: for n in unseen.chain(ahead_of_seen) {
                next = n;
                let y = sweep.at(n, frame.step);
                if y > row.reach {
                    break;
                }
                let z = frame.eye_height + row.slope * y;
                let before = z - row.slope * frame.step.min(y);
                let mut looks = if painted.is_none() { SETTLING_LOOKS } else { 1 };
                let (place, height) = loop {
                    // A ray that fell deep since the slice before met the ground on its way: it
                    // is looked up no lower than the ground was found last.
                    let level = z.max(before.min(floor));
                    let mut place = place_at(y, level);
                    if !self.is_inside(place) {
                        // Before the border, or after it.
                        place = place_at(y, z);
                        if !self.is_inside(place) {
                            break 'slices;
                        }
                    }
                    let place = self.posts.place(place.x, place.y);
                    self.tally.sample();
                    let height = self.posts.height(place, self.tally);
                    looks -= 1;
                    if looks == 0 || height == floor {
                        break (place, height);
                    }
                    floor = height;
                };
                floor = height;
                if z <= height {
                    hit = Some((place, y, height));
                    break;
                }
            }
            let Some((place, y, height)) = hit else {
                self.paint_sky(row);
                continue;
            };
            let colour = match painted {
                Some((at, colour)) if at == place => colour,
                _ => self.posts.colour(place),
            };
            painted = Some((place, colour));
            self.paint::<D>(row, y, height, colour);
        }
    }

    /// Whether a place is on the terrain, give or take rounding.
    #[inline]
    fn is_inside(&self, place: DVec2) -> bool {
        const ROUNDING: f64 = 1e-6;
        let last = self.frame.last;
        place.x >= -ROUNDING
            && place.y >= -ROUNDING
            && place.x <= last.x + ROUNDING
            && place.y <= last.y + ROUNDING
    }

    /// Paints the pixel whose ray ends at the slice `y` metres away, of height `height` there.
    #[inline]
    fn paint<D: DepthRule>(&mut self, row: &Row, y: f64, height: f64, colour: [u8; 3]) {
        self.tally.ray();
        let frame = self.frame;
        let rise = height - frame.eye_height;
        let depth = D::depth(&row.depth, self.offset_squared, y, frame.step, rise);
        self.canvas.set([self.column, row.j], colour, depth);
    }

    #[inline]
    fn paint_sky(&mut self, row: &Row) {
        self.tally.ray();
        let pixel = [self.column, row.j];
        let direction = self.frame.rays.ray(self.column, row.j).direction;
        self.canvas.set(pixel, sky(direction), f32::INFINITY);
    }
}
