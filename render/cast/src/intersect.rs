//! The exact meeting of a ray with the solid terrain, cell by cell in f64.

use crate::tally::Tally;
use glam::DVec3;
use sandtable_terrain::Ground;
use sandtable_view::Ray;

/// The ground as rays meet it: what all of them share.
pub(crate) struct GridFrame<'a> {
    ground: &'a Ground,
    /// From world metres to grid coordinates: x and y in posts from the south-west one, z in
    /// metres.
    per_metre: DVec3,
    /// The last post's x and y.
    size: [f64; 2],
    highest: f64,
}

impl<'a> GridFrame<'a> {
    pub(crate) fn new(ground: &'a Ground) -> Self {
        Self::up_to(ground, f64::from(ground.range()[1]))
    }

    /// As `new`, for terrain that reaches up to `highest` metres.
    pub(crate) fn up_to(ground: &'a Ground, highest: f64) -> Self {
        let grid = ground.grid();
        Self {
            ground,
            per_metre: DVec3::new(1.0 / grid.spacing.x, 1.0 / grid.spacing.y, 1.0),
            size: [f64::from(grid.cols - 1), f64::from(grid.rows - 1)],
            highest,
        }
    }

    pub(crate) fn ground(&self) -> &'a Ground {
        self.ground
    }

    /// Clips a world ray to the terrain; `None` where it passes by.
    #[inline]
    pub(crate) fn clip(&self, ray: &Ray) -> Option<GridRay<'_>> {
        let (origin, direction) = (ray.origin * self.per_metre, ray.direction * self.per_metre);
        // Rising above the highest post ends a ray; falling below it begins one. Below there is no
        // end: the terrain reaches down for ever.
        let (mut enter, mut leave) = (0.0, f64::INFINITY);
        if direction.z > 0.0 {
            leave = (self.highest - origin.z) / direction.z;
        } else if origin.z > self.highest {
            if direction.z == 0.0 {
                return None;
            }
            enter = (self.highest - origin.z) / direction.z;
        }
        let inverse = [1.0 / direction.x, 1.0 / direction.y];
        for axis in 0..2 {
            let (o, size) = (origin[axis], self.size[axis]);
            if direction[axis] == 0.0 {
                if o < 0.0 || o > size {
                    return None;
                }
            } else {
                let (a, b) = (-o * inverse[axis], (size - o) * inverse[axis]);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        (enter <= leave).then_some(GridRay {
            frame: self,
            origin,
            direction,
            inverse,
            enter,
            leave,
        })
    }
}

/// A ray in grid coordinates.
///
/// The parameter t is the world ray's own, so that a hit's distance is t times the length of the
/// world direction.
pub(crate) struct GridRay<'a> {
    frame: &'a GridFrame<'a>,
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    /// One over the direction's x and y.
    pub(crate) inverse: [f64; 2],
    /// Where the ray is within the rectangle of posts and not above the highest one, for t ≥ 0.
    pub(crate) enter: f64,
    pub(crate) leave: f64,
}

impl GridRay<'_> {
    /// The x and y of the last post.
    pub(crate) fn last_post(&self) -> [f64; 2] {
        self.frame.size
    }

    /// The ray's x and y at `t`, in posts.
    pub(crate) fn place(&self, t: f64) -> [f64; 2] {
        [
            self.origin.x + t * self.direction.x,
            self.origin.y + t * self.direction.y,
        ]
    }

    /// The ray's height over the ground at `t`, in metres; negative inside the terrain.
    pub(crate) fn clearance(&self, t: f64) -> f64 {
        let [x, y] = self.place(t);
        let (cell, place) = self.frame.ground.heights().locate(x, y);
        self.origin.z + t * self.direction.z - self.surface(cell).at(place)
    }

    /// The t in which the ray covers half a cell along the ground; all of it where the ray is
    /// vertical.
    pub(crate) fn half_cell(&self) -> f64 {
        0.5 / self.direction.x.abs().max(self.direction.y.abs())
    }

    fn surface(&self, cell: [u32; 2]) -> Surface {
        Surface::new(self.frame.ground.heights().cell(cell[0], cell[1]))
    }

    /// The first t in [`from`, `leave`] at which the ray is in the terrain, `from` itself where it
    /// starts inside.
    pub(crate) fn first_hit<T: Tally>(&self, from: f64, tally: &mut T) -> Option<f64> {
        self.first_hit_up_to(from, self.leave, tally)
    }

    /// The same in [`from`, `leave`], which is a part of the ray's way.
    pub(crate) fn first_hit_up_to<T: Tally>(
        &self,
        from: f64,
        leave: f64,
        tally: &mut T,
    ) -> Option<f64> {
        let mut walk = CellWalk::new(self, from, leave);
        loop {
            tally.cell();
            if let Some(t) = self.hit_in_cell(&walk.segment) {
                return Some(t);
            }
            if !walk.advance() {
                return None;
            }
        }
    }

    /// The first hit within one cell's part of the ray.
    fn hit_in_cell(&self, segment: &Segment) -> Option<f64> {
        let Segment { cell, from, to } = *segment;
        let z0 = self.origin.z + from * self.direction.z;
        let z1 = self.origin.z + to * self.direction.z;
        let surface = self.surface(cell);
        if z0.min(z1) > surface.highest() {
            return None;
        }
        // Height over the ground along the cell is a quadratic in s, 0 to `length`.
        let length = to - from;
        let u = self.origin.x + from * self.direction.x - f64::from(cell[0]);
        let v = self.origin.y + from * self.direction.y - f64::from(cell[1]);
        let (du, dv) = (self.direction.x, self.direction.y);
        let c = z0 - surface.at([u, v]);
        if c <= 0.0 {
            return Some(from);
        }
        let b = self.direction.z
            - (surface.east * du + surface.north * dv + surface.twist * (u * dv + v * du));
        let a = -surface.twist * du * dv;
        if let Some(s) = first_root(a, b, c).filter(|&s| s <= length) {
            return Some(from + s);
        }
        // Rounding may hide a root at the very border; then the end itself is inside.
        (length.is_finite() && c + length * (b + length * a) <= 0.0).then_some(to)
    }
}

/// The smallest positive root of a s² + b s + c, where c > 0.
#[inline]
fn first_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    // Of the two roots 2c / (−b ± √D), with c > 0, the first positive one has the larger
    // denominator; and this form neither cancels where b < 0 nor fails where a is 0.
    let root = discriminant.sqrt();
    let denominator = if b < 0.0 {
        root - b
    } else {
        4.0 * a * c / -(root + b)
    };
    (denominator > 0.0).then(|| 2.0 * c / denominator)
}

/// One cell's bilinear surface: sw + east·u + north·v + twist·u·v.
struct Surface {
    posts: [f64; 4],
    east: f64,
    north: f64,
    twist: f64,
}

impl Surface {
    #[inline]
    fn new(posts: [f32; 4]) -> Self {
        let [sw, se, nw, ne] = posts.map(f64::from);
        Self {
            posts: [sw, se, nw, ne],
            east: se - sw,
            north: nw - sw,
            twist: ne - nw - se + sw,
        }
    }

    #[inline]
    fn at(&self, [u, v]: [f64; 2]) -> f64 {
        self.posts[0] + self.east * u + (self.north + self.twist * u) * v
    }

    #[inline]
    fn highest(&self) -> f64 {
        let [sw, se, nw, ne] = self.posts;
        sw.max(se).max(nw.max(ne))
    }
}

/// The part of a ray that lies in one cell.
#[derive(Clone, Copy)]
struct Segment {
    cell: [u32; 2],
    from: f64,
    to: f64,
}

/// The cells under a ray, in order (Amanatides and Woo's walk).
struct CellWalk {
    segment: Segment,
    leave: f64,
    /// For x and y: the cell step and the t of the next grid line.
    step: [i32; 2],
    next: [f64; 2],
    size: [u32; 2],
    origin: [f64; 2],
    direction: [f64; 2],
    inverse: [f64; 2],
}

impl CellWalk {
    fn new(ray: &GridRay<'_>, from: f64, leave: f64) -> Self {
        let grid = ray.frame.ground.grid();
        let size = [grid.cols - 1, grid.rows - 1];
        let origin = [ray.origin.x, ray.origin.y];
        let direction = [ray.direction.x, ray.direction.y];
        let inverse = ray.inverse;
        let place = ray.place(from);
        let cell = std::array::from_fn(|k| {
            // Negative numbers, from rounding at the border, saturate to 0.
            (place[k] as u32).min(size[k] - 1)
        });
        let mut walk = Self {
            segment: Segment {
                cell,
                from,
                to: from,
            },
            leave,
            step: direction.map(|d| if d > 0.0 { 1 } else { -1 }),
            next: [f64::INFINITY; 2],
            size,
            origin,
            direction,
            inverse,
        };
        for axis in 0..2 {
            walk.aim(axis);
        }
        walk.close_segment();
        walk
    }

    /// Sets the t at which the ray crosses the next grid line of `axis`. Computed from the line
    /// itself, not by adding up steps, so that long walks do not drift.
    #[inline]
    fn aim(&mut self, axis: usize) {
        let direction = self.direction[axis];
        if direction != 0.0 {
            let line = self.segment.cell[axis] + u32::from(direction > 0.0);
            self.next[axis] = (f64::from(line) - self.origin[axis]) * self.inverse[axis];
        }
    }

    #[inline]
    fn close_segment(&mut self) {
        let end = self.next[0].min(self.next[1]).min(self.leave);
        self.segment.to = end.max(self.segment.from);
    }

    /// Steps into the next cell; `false` where the ray leaves the terrain.
    #[inline]
    fn advance(&mut self) -> bool {
        let axis = usize::from(self.next[1] < self.next[0]);
        if self.next[axis] >= self.leave {
            return false;
        }
        let cell = self.segment.cell[axis].wrapping_add_signed(self.step[axis]);
        if cell >= self.size[axis] {
            return false;
        }
        self.segment.cell[axis] = cell;
        self.segment.from = self.segment.to;
        self.aim(axis);
        self.close_segment();
        true
    }
}
