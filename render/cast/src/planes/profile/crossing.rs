//! Where planes cross a line of posts.

use super::PlaneGroup;
use super::halves::{between, fine_halves, halves, parts};
use super::window::Window;
use crate::lanes::{LANES, Lanes};
use crate::planes::field::{Field, Tiles};
use crate::planes::walk::corners;

/// A mirrored line of posts, and where planes cross it.
#[derive(Clone, Copy)]
pub(in crate::planes) struct Crossing<L: Lanes> {
    line: i32,
    /// The mirrored cells of the minor axis in which planes cross it, and how far into them.
    pub(super) cell: L::I,
    pub(super) share: L::F,
    /// What to take a cell's number from for the place of its near post in the window, or to take
    /// from that.
    from: i32,
    /// Where the posts around them lie, if they are few enough.
    window: Option<Window>,
}

/// Colours of four neighbouring posts of a line for each plane, in halves.
pub(in crate::planes) type Texels<L> = [[<L as Lanes>::I; 2]; 4];

impl<L: Lanes> Crossing<L> {
    /// Where planes cross the mirrored line `line`; as many posts `beside` those around them are to be known,
    /// too.
    #[inline(always)]
    pub(in crate::planes) fn new(
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        line: i32,
        beside: i32,
    ) -> Self {
        Self::at(
            l,
            field,
            planes,
            line,
            line as f32 - field.major.fraction,
            beside,
        )
    }

    /// The posts of the mirrored line `line` around planes that are at t, in cells: as if they crossed the
    /// line there.
    #[inline(always)]
    pub(super) fn at(
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        line: i32,
        t: f32,
        beside: i32,
    ) -> Self {
        let line = line.max(field.major.cells[0]).min(field.major.cells[1] + 1);
        let along = l.mul(planes.advance, l.splat(t));
        let cell = field.minor.cell(l, along);
        let share = l.sub(
            l.add(along, l.splat(field.minor.fraction)),
            l.to_float(cell),
        );
        // Planes lie in order.
        let [first, last] = l.ends(cell);
        let ends = field.minor.cells;
        let cells = [
            (first.min(last) - beside).max(ends[0]),
            (first.max(last) + beside).min(ends[1]),
        ];
        Self {
            line,
            cell,
            share,
            from: if field.minor.sign > 0 {
                cells[0]
            } else {
                cells[1] + 1
            },
            window: Window::around(field, line, cells),
        }
    }

    /// The heights over the eye of the posts around planes, the near and the far ones, in metres.
    #[inline(always)]
    pub(in crate::planes) fn posts(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
    ) -> [L::F; 2] {
        let posts = match &self.window {
            Some(window) => window.read(l, field, planes, field.heights),
            None => None,
        };
        let posts = match posts {
            Some(posts) => {
                let [near, far] = self.around(l, field, posts);
                [l.float_of_bits(near), l.float_of_bits(far)]
            }
            None => self.heights_apart(l, field),
        };
        over_the_eye(l, field, posts)
    }

    /// The same of the posts before and behind those around planes; at the ground's border, of any posts.
    #[inline(always)]
    pub(super) fn outer_posts(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
    ) -> Option<[L::F; 2]> {
        let window = self.window.as_ref()?;
        let posts = window.read(l, field, planes, field.heights)?;
        let [before, behind] = self.outer(l, field, window);
        let posts = [
            l.float_of_bits(l.among(posts, before)),
            l.float_of_bits(l.among(posts, behind)),
        ];
        Some(over_the_eye(l, field, posts))
    }

    /// The ground's heights over the eye, in metres, between posts. Beside the ground its outermost
    /// cells' slopes go on.
    #[inline(always)]
    pub(in crate::planes) fn heights(&self, l: L, [near, far]: [L::F; 2]) -> L::F {
        l.add(near, l.mul(l.sub(far, near), self.share))
    }

    /// The ground's colours between posts, beside the ground those of its border: red and blue, green
    /// and alpha, in 16 bits each.
    #[inline(always)]
    pub(in crate::planes) fn colours(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        colours: &Tiles<'_, [u8; 4]>,
    ) -> [L::I; 2] {
        let posts = match &self.window {
            Some(window) => window.read(l, field, planes, colours),
            None => None,
        };
        let [near, far] = match posts {
            Some(posts) => self.around(l, field, posts),
            None => [
                self.texel_apart(l, field, colours, 0),
                self.texel_apart(l, field, colours, 1),
            ],
        };
        self.mixed(l, halves(l, near), halves(l, far))
    }

    /// The colours of four posts of each plane's line: the one before the near one, that and the far one,
    /// and the one behind; in halves, [`FINE`](super::FINE) times as large. Where there is no such post, it
    /// is any number.
    #[inline(always)]
    pub(in crate::planes) fn texels(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        colours: &Tiles<'_, [u8; 4]>,
    ) -> Texels<L> {
        let posts = match &self.window {
            Some(window) => window.read(l, field, planes, colours),
            None => None,
        };
        let [before, near, far, behind] = match (&self.window, posts) {
            (Some(window), Some(posts)) => {
                let (at, next) = self.place(l, field);
                let [before, behind] = self.outer(l, field, window);
                [
                    l.among(posts, before),
                    l.among(posts, at),
                    l.among(posts, l.add_i(at, l.splat_i(next))),
                    l.among(posts, behind),
                ]
            }
            _ => [
                self.texel_apart(l, field, colours, -1),
                self.texel_apart(l, field, colours, 0),
                self.texel_apart(l, field, colours, 1),
                self.texel_apart(l, field, colours, 2),
            ],
        };
        [
            fine_halves(l, before),
            fine_halves(l, near),
            fine_halves(l, far),
            fine_halves(l, behind),
        ]
    }

    /// Colours so much of the way from the near posts' to the far ones' as planes lie between them.
    #[inline(always)]
    pub(in crate::planes) fn mixed(&self, l: L, near: [L::I; 2], far: [L::I; 2]) -> [L::I; 2] {
        between(l, near, far, parts(l, self.share))
    }

    /// The near and the far posts around planes, among those of the window.
    #[inline(always)]
    fn around(&self, l: L, field: &Field<'_>, posts: [L::I; 2]) -> [L::I; 2] {
        let (at, next) = self.place(l, field);
        [
            l.among(posts, at),
            l.among(posts, l.add_i(at, l.splat_i(next))),
        ]
    }

    /// Where among the window's posts the near ones are, and how much further the next ones.
    #[inline(always)]
    fn place(&self, l: L, field: &Field<'_>) -> (L::I, i32) {
        let from = l.splat_i(self.from);
        if field.minor.sign > 0 {
            (l.sub_i(self.cell, from), 1)
        } else {
            (l.sub_i(from, self.cell), -1)
        }
    }

    /// Where those are that come before and behind the posts around planes, as far as there are such.
    #[inline(always)]
    fn outer(&self, l: L, field: &Field<'_>, window: &Window) -> [L::I; 2] {
        let (at, next) = self.place(l, field);
        let ends = [l.splat_i(0), l.splat_i(window.count - 1)];
        let before = l.sub_i(at, l.splat_i(next));
        let behind = l.add_i(at, l.splat_i(2 * next));
        [
            l.max_i(l.min_i(before, ends[1]), ends[0]),
            l.max_i(l.min_i(behind, ends[1]), ends[0]),
        ]
    }

    /// The near and the far posts around planes, wherever they lie.
    #[inline(always)]
    fn heights_apart(&self, l: L, field: &Field<'_>) -> [L::F; 2] {
        let Self { line, cell, .. } = *self;
        l.vectorize(
            #[inline(always)]
            move || {
                // A line's posts are the near ones of the cell behind it; the last one's the far
                // ones of the last cell.
                let last = field.major.cells[1];
                let place = field.place(l, [l.splat_i(line.min(last)), cell]);
                let mut places = [0; LANES];
                l.store_i(place, &mut places);
                let posts = l.cells(&field.heights.items, &places, field.heights.stride);
                let [near, far_major, far_minor, both] = corners::<L>(field, posts);
                if line > last {
                    [far_major, both]
                } else {
                    [near, far_minor]
                }
            },
        )
    }

    /// The colours of posts, wherever they lie: of each plane's near ones, or so many behind these.
    #[inline(always)]
    fn texel_apart(
        &self,
        l: L,
        field: &Field<'_>,
        colours: &Tiles<'_, [u8; 4]>,
        post: i32,
    ) -> L::I {
        let Self { line, cell, .. } = *self;
        l.vectorize(
            #[inline(always)]
            move || {
                // The far posts are those of their cells, and of the next ones.
                let is_far = post > 0;
                let [first_cell, last_cell] = field.minor.cells;
                let cell = l.add_i(cell, l.splat_i(post - i32::from(is_far)));
                let cell = l.min_i(cell, l.splat_i(last_cell));
                let cell = l.max_i(cell, l.splat_i(first_cell));
                let last = field.major.cells[1];
                let [x, y] = field.cells(l, l.splat_i(line.min(last)), cell);
                let mut places = [0; LANES];
                l.store_i(colours.place(l, x, y), &mut places);
                // All the way to a post along both axes.
                let [zero, one] = [l.splat(0.0), l.splat(1.0)];
                let is_high = (line > last) == (field.major.sign > 0);
                let major = if is_high { one } else { zero };
                let is_high = is_far == (field.minor.sign > 0);
                let minor = if is_high { one } else { zero };
                let [east, north] = if field.major_axis == 0 {
                    [major, minor]
                } else {
                    [minor, major]
                };
                l.texels(&colours.items, &places, colours.stride, east, north)
            },
        )
    }
}

/// Heights over the eye: its own is taken from them before they are mixed, as it is what high ground's digits are
/// lost in.
#[inline(always)]
fn over_the_eye<L: Lanes>(l: L, field: &Field<'_>, [near, far]: [L::F; 2]) -> [L::F; 2] {
    let (eye, rest) = (l.splat(field.eye_height), l.splat(field.eye_rest));
    [l.sub(l.sub(near, eye), rest), l.sub(l.sub(far, eye), rest)]
}
