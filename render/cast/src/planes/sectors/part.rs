//! Convex parts of the image, and the lines that cut them.

/// a + b·i + c·j of a pixel (i, j): a half-plane of the image where it is not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) at_origin: f64,
    pub(super) along: [f64; 2],
}

impl Line {
    /// The value at a place. Along a row and along a column it never falls and never rises,
    /// whatever rounding does to it.
    pub(super) fn at(&self, [i, j]: [f64; 2]) -> f64 {
        (self.at_origin + self.along[0] * i) + self.along[1] * j
    }
}

/// One side of a line through the vanishing point of the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Side {
    pub(super) line: Line,
    /// Whether the side is that where the line's value is not negative.
    pub(super) positive: bool,
}

/// The convex polygon with these corners where a value that is linear over the image is not negative.
pub(super) fn clipped(corners: &[[f64; 2]], value: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut left = Vec::with_capacity(corners.len() + 1);
    for (k, &from) in corners.iter().enumerate() {
        let to = corners[(k + 1) % corners.len()];
        let (a, b) = (value(from), value(to));
        if a >= 0.0 {
            left.push(from);
        }
        if (a >= 0.0) != (b >= 0.0) {
            let share = a / (a - b);
            left.push([0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])));
        }
    }
    left
}

/// A convex part of the image, while it is being divided.
#[derive(Clone)]
pub(super) struct Part {
    pub(super) corners: Vec<[f64; 2]>,
    /// The sides that cut it, and on which side of each line so far it lies.
    pub(super) sides: Vec<Side>,
    pub(super) signs: Vec<bool>,
}

impl Part {
    /// The part on one side of a line, or `None` where no pixel can be there. One pixel more is
    /// kept, so that rounding loses none.
    pub(super) fn on(&self, side: Side) -> Option<Self> {
        let sign = if side.positive { 1.0 } else { -1.0 };
        let slack = side.line.along[0].abs() + side.line.along[1].abs();
        if slack == 0.0 && (side.line.at_origin >= 0.0) != side.positive {
            // The whole image is on the other side.
            return None;
        }
        let corners = clipped(&self.corners, |corner| sign * side.line.at(corner) + slack);
        let mut part = Self {
            corners,
            sides: self.sides.clone(),
            signs: self.signs.clone(),
        };
        part.signs.push(side.positive);
        part.sides.push(side);
        (!part.corners.is_empty()).then_some(part)
    }

    /// The part cut across the planes into pieces of about the same `work`, each with its first and last
    /// one of the image's `steps` columns or rows: as many as make pieces of about `most`.
    pub(super) fn pieces(
        &self,
        step_axis: usize,
        steps: u32,
        most: f64,
        work: impl Fn(&[[f64; 2]]) -> f64,
    ) -> Vec<(Self, [i32; 2])> {
        let [low, high] = self.range(step_axis);
        let work_before = |step: i32| {
            let before = |corner: [f64; 2]| f64::from(step) - corner[step_axis];
            work(&clipped(&self.corners, before))
        };
        // One more on both sides, as corners do not lie on pixels.
        let last = (high.ceil() as i32 + 1).min(steps as i32 - 1);
        let mut from = (low.floor() as i32 - 1).max(0);
        let all = work(&self.corners);
        let count = (all / most).round().max(1.0);
        let mut pieces = Vec::new();
        let mut done = 0.0;
        for k in 1..count as u32 {
            let share = all * f64::from(k) / count;
            let [mut before, mut cut] = [(from, done), (last, all)];
            while cut.0 - before.0 > 1 {
                // Where it would be if work were even, but well between both.
                let way = f64::from(cut.0 - before.0);
                let part = (share - before.1) / (cut.1 - before.1);
                let further = (part.clamp(0.1, 0.9) * way).round().clamp(1.0, way - 1.0);
                let middle = before.0 + further as i32;
                let work = work_before(middle);
                if work < share {
                    before = (middle, work);
                } else {
                    cut = (middle, work);
                }
            }
            let (cut, work) = cut;
            pieces.push((self.around(step_axis, [from, cut]), [from, cut - 1]));
            (from, done) = (cut, work);
        }
        pieces.push((self.around(step_axis, [from, last]), [from, last]));
        pieces
    }

    /// What lies between two of the image's columns or rows, and one more on both sides.
    fn around(&self, axis: usize, [from, to]: [i32; 2]) -> Self {
        let [low, high] = [f64::from(from) - 1.0, f64::from(to) + 1.0];
        let above = clipped(&self.corners, |corner| corner[axis] - low);
        Self {
            corners: clipped(&above, |corner| high - corner[axis]),
            ..self.clone()
        }
    }

    /// The sides that cut off pixels, those first that do so in most steps.
    pub(super) fn ordered_sides(&self) -> Vec<Side> {
        let touched = |side: &Side| {
            let sign = if side.positive { 1.0 } else { -1.0 };
            let slack = side.line.along[0].abs() + side.line.along[1].abs();
            // Corners lie a pixel outside, where sides make them.
            let touches = |&&corner: &&[f64; 2]| sign * side.line.at(corner) < slack;
            self.corners.iter().filter(touches).count()
        };
        let mut sides = self.sides.clone();
        sides.retain(|side| touched(side) > 0);
        sides.sort_by_key(|side| std::cmp::Reverse(touched(side)));
        sides
    }

    /// The area in pixels.
    pub(super) fn size(&self) -> f64 {
        area(&self.corners)
    }

    /// How large it may seem where it has no pixel, as corners lie up to a pixel outside.
    pub(super) fn rim(&self) -> f64 {
        let [width, height] = [0, 1]
            .map(|axis| self.range(axis))
            .map(|[from, to]| to - from);
        width + height
    }

    /// A place in it.
    pub(super) fn middle(&self) -> [f64; 2] {
        let count = self.corners.len() as f64;
        [0, 1].map(|axis| self.corners.iter().map(|corner| corner[axis]).sum::<f64>() / count)
    }

    pub(super) fn range(&self, axis: usize) -> [f64; 2] {
        self.corners
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], corner| {
                [low.min(corner[axis]), high.max(corner[axis])]
            })
    }
}

/// The area of the polygon with these corners.
pub(super) fn area(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let edges = corners.iter().zip(next);
    let turns = edges.map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
    0.5 * turns.sum::<f64>().abs()
}

/// Parts cut by lines, in turn.
pub(super) fn cut(mut parts: Vec<Part>, lines: &[Line]) -> Vec<Part> {
    for &line in lines {
        let split = |part: &Part| [true, false].map(|positive| part.on(Side { line, positive }));
        parts = parts.iter().flat_map(split).flatten().collect();
    }
    parts
}
