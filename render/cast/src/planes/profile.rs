//! Profiles of the ground along vertical planes: its heights and colours where planes cross lines of
//! posts.

use super::field::{Axis, Field, Tiles};
use super::roofs::LEVEL_BEGIN;
use super::walk::corners;
use crate::lanes::{LANES, Lanes, group};

/// Sixteen neighbouring vertical planes through the eye.
pub(super) struct PlaneGroup<L: Lanes> {
    /// Cells along the minor axis for each one along the major axis.
    pub(super) advance: L::F,
    /// One over that.
    per_advance: L::F,
    /// Of the first and the last plane.
    pub(super) outer: [f32; 2],
    /// How many cells aside they go until the line for whose memory they ask.
    drift: i32,
}

impl<L: Lanes> PlaneGroup<L> {
    #[inline(always)]
    pub(super) fn new(l: L, advance: &[f32; LANES]) -> Self {
        let outer = [advance[0], advance[LANES - 1]];
        let advance = l.load(advance);
        Self {
            advance,
            per_advance: l.div(l.splat(1.0), l.max(advance, l.splat(f32::MIN_POSITIVE))),
            outer,
            drift: (0.5 * (outer[0] + outer[1]) * ROWS_AHEAD as f32) as i32,
        }
    }
}

/// From which to which mirrored cell of the minor axis planes reach, of which the outermost advance by
/// `outer`, up to where they come in `to` cells from where they are in `from` cells.
#[inline(always)]
fn cells_of(field: &Field<'_>, [first, last]: [f32; 2], [from, to]: [f32; 2]) -> [i32; 2] {
    [
        field.minor.cell_alone(first.min(last) * from),
        field.minor.cell_alone(first.max(last) * to),
    ]
}

/// Levels of blocks that planes may pass at once, as [`roofs`](super::roofs) has them: the larger
/// first.
pub(super) const PASSED: [usize; 3] = [6, 5, 4];

/// The smallest of them.
const LEAST_PASSED: usize = PASSED[PASSED.len() - 1];

/// How high over the eye, in metres, the ground rises at most that two neighbouring groups of planes, of
/// which the outermost advance by `outer`, pass between the mirrored line `line` and the one that lies
/// 2 ^ `level` cells further; `None` where blocks do not begin at that line, or the ground ends before.
#[inline(always)]
pub(super) fn ceiling(
    field: &Field<'_>,
    outer: [[f32; 2]; 2],
    line: i32,
    level: usize,
) -> Option<f32> {
    let (major, minor) = (&field.major, &field.minor);
    let size = 1 << level;
    let post = major.post(line);
    if post & (size - 1) != 0 || line < major.cells[0] || line + size > major.cells[1] + 1 {
        return None;
    }
    let from = line as f32 - major.fraction;
    let [one, other] = outer.map(|outer| cells_of(field, outer, [from, from + size as f32]));
    let cells = [one[0].min(other[0]), one[1].max(other[1])];
    let cells = cells.map(|cell| minor.ground_alone(cell) >> level);
    let along = major.ground_alone(line);
    let half = size as f32 * 0.5;
    let mut most = f32::MIN;
    for block in cells[0].min(cells[1])..=cells[0].max(cells[1]) {
        let aside = block << level;
        let (x, y) = if field.major_axis == 0 {
            (along, aside)
        } else {
            (aside, along)
        };
        let within = (((y & 255) >> level) << (8 - level)) + ((x & 255) >> level);
        let place = field.roofs.tile(x >> 8, y >> 8) + (LEVEL_BEGIN[level] + within) as u32;
        let [height, rise] = *field.roofs.items.from_place(place).first()?;
        let [east, north] = [rise << 16, rise & 0xffff_0000].map(|rise| f32::from_bits(rise).abs());
        most = most.max(f32::from_bits(height) + half * (east + north));
    }
    Some(most - field.eye_height + field.rounding)
}

/// A mirrored line of posts, and where planes cross it.
pub(super) struct Crossing<L: Lanes> {
    line: i32,
    /// The mirrored cells of the minor axis in which planes cross it, and how far into them.
    cell: L::I,
    share: L::F,
    /// What to take a cell's number from for the place of its near post in the window, or to take
    /// from that.
    from: i32,
    /// Where the posts around them lie, if they are few enough.
    window: Option<Window>,
}

/// Neighbouring posts of one line, as many as there is [`ROOM`] for: heights and colours alike, which
/// lie in the same places of their tiles.
#[derive(Clone, Copy)]
struct Window {
    /// The number of the tile that has the first post, and where in it that lies.
    tile: usize,
    first: usize,
    /// Where in a tile its line begins, if that is a row; else how far into one it lies.
    line: usize,
    /// Posts of this tile, of which the last one is the next tile's first.
    left: i32,
    /// How many posts count.
    count: i32,
}

/// Posts that are read at once.
const ROOM: i32 = 2 * LANES as i32;

/// How many lines of posts ahead memory is asked for, where lines are rows.
const ROWS_AHEAD: i32 = 3;

/// The same where they are columns: as many as there are in a line of the processor's cache.
const COLUMNS_AHEAD: i32 = 16;

impl Axis {
    /// The post on a mirrored line.
    fn post(&self, line: i32) -> i32 {
        if self.sign > 0 {
            self.base + line
        } else {
            self.base + 1 - line
        }
    }

    /// The number of the ground's last post.
    fn last_post(&self) -> i32 {
        self.cells[1] - self.cells[0] + 1
    }

    /// Whether at a mirrored line blocks begin that planes may pass.
    pub(super) fn is_block(&self, line: i32) -> bool {
        self.post(line) & ((1 << LEAST_PASSED) - 1) == 0
    }

    /// The ground's cell that is a mirrored one.
    fn ground_alone(&self, cell: i32) -> i32 {
        if self.sign > 0 {
            self.base + cell
        } else {
            self.base - cell
        }
    }

    /// As `cell`, of one place.
    fn cell_alone(&self, along: f32) -> i32 {
        let cell = (along + self.fraction) as i32;
        cell.min(self.cells[1]).max(self.cells[0])
    }
}

impl<L: Lanes> Crossing<L> {
    /// Where planes cross the mirrored line `line`; as many posts `beside` those around them are to be known,
    /// too.
    #[inline(always)]
    pub(super) fn new(
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        line: i32,
        beside: i32,
    ) -> Self {
        let t = line as f32 - field.major.fraction;
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

    /// The heights of the posts around planes, the near and the far ones.
    #[inline(always)]
    pub(super) fn posts(&self, l: L, field: &Field<'_>, planes: &PlaneGroup<L>) -> [L::F; 2] {
        let posts = match &self.window {
            Some(window) => window.read(l, field, planes, field.heights),
            None => None,
        };
        match posts {
            Some(posts) => {
                let [near, far] = self.around(l, field, posts);
                [l.float_of_bits(near), l.float_of_bits(far)]
            }
            None => self.heights_apart(l, field),
        }
    }

    /// The ground's heights over the eye, in metres, between posts. Beside the ground its outermost
    /// cells' slopes go on.
    #[inline(always)]
    pub(super) fn heights(&self, l: L, field: &Field<'_>, [near, far]: [L::F; 2]) -> L::F {
        let height = l.add(near, l.mul(l.sub(far, near), self.share));
        l.sub(height, l.splat(field.eye_height))
    }

    /// The ground's colours between posts, beside the ground those of its border: red and blue, green
    /// and alpha, in 16 bits each.
    #[inline(always)]
    pub(super) fn colours(
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
    /// and the one behind; in halves, [`FINE`] times as large. Such as there is not are any.
    #[inline(always)]
    pub(super) fn texels(
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
                let ends = [l.splat_i(0), l.splat_i(window.count - 1)];
                let before = l.sub_i(at, l.splat_i(next));
                let before = l.max_i(l.min_i(before, ends[1]), ends[0]);
                let behind = l.add_i(at, l.splat_i(2 * next));
                let behind = l.max_i(l.min_i(behind, ends[1]), ends[0]);
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
    pub(super) fn mixed(&self, l: L, near: [L::I; 2], far: [L::I; 2]) -> [L::I; 2] {
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

/// How many times as large colours of bent profiles are, so that little is lost between them.
pub(super) const FINE: i32 = 64;

/// Colours of four neighbouring posts of a line for each plane, in halves.
pub(super) type Texels<L> = [[<L as Lanes>::I; 2]; 4];

/// A place of each plane between two neighbouring lines of posts. From there to either of these its
/// profile is straight, or nearly so: it is where the plane goes from one cell to the next along the minor
/// axis, or else half-way, where what bends is the cell's surface alone.
pub(super) struct Bend<L: Lanes> {
    /// How much of the way from line to line it is to there.
    pub(super) share: L::F,
    /// Which planes go from one cell to the next.
    crosses: L::M,
    /// How far into its cell the place lies along the minor axis, of the cell that the plane comes from, and
    /// of the one that it goes to.
    aside: [L::F; 2],
}

/// The colours of a bent profile: where its two pieces begin and end, and the middles of the parabolas'
/// polygons that they are, of cells that are twisted.
pub(super) struct BentColours<L: Lanes> {
    pub(super) ends: [[L::I; 2]; 3],
    pub(super) controls: [[L::I; 2]; 2],
}

impl<L: Lanes> Bend<L> {
    /// Between a line and the next one.
    #[inline(always)]
    pub(super) fn new(
        l: L,
        planes: &PlaneGroup<L>,
        before: &Crossing<L>,
        behind: &Crossing<L>,
    ) -> Self {
        let (zero, half, one) = (l.splat(0.0), l.splat(0.5), l.splat(1.0));
        let crosses = l.gt_i(behind.cell, before.cell);
        let there = l.mul(l.sub(one, before.share), planes.per_advance);
        let there = l.max(l.min(there, one), zero);
        let middle = l.mul(l.add(before.share, behind.share), half);
        Self {
            share: l.select(crosses, there, half),
            crosses,
            aside: [
                l.select(crosses, one, middle),
                l.select(crosses, zero, middle),
            ],
        }
    }

    /// The ground's height there over the eye, of which the posts of both lines are known.
    #[inline(always)]
    pub(super) fn heights(
        &self,
        l: L,
        field: &Field<'_>,
        before: [L::F; 2],
        behind: [L::F; 2],
    ) -> L::F {
        // A line of the minor axis leads from the far post of the one line to the near one of the other.
        let first = l.select(self.crosses, before[1], before[0]);
        let near = l.add(first, l.mul(l.sub(behind[0], first), self.share));
        let far = l.add(before[1], l.mul(l.sub(behind[1], before[1]), self.share));
        let height = l.add(near, l.mul(l.sub(far, near), self.aside[1]));
        l.sub(height, l.splat(field.eye_height))
    }

    /// The colours of both pieces, of the posts around `before` and `behind` and what lies between them there.
    #[inline(always)]
    pub(super) fn colours(
        &self,
        l: L,
        [before, behind]: [&Crossing<L>; 2],
        [from, to]: [&Texels<L>; 2],
    ) -> BentColours<L> {
        let half = parts(l, l.splat(0.5));
        let share = parts(l, self.share);
        let begin = before.mixed(l, from[1], from[2]);
        let end = behind.mixed(l, to[1], to[2]);
        // The bend's places along the minor axis, on both lines.
        let near = between(l, from[1], from[2], parts(l, self.aside[0]));
        let far = between(l, to[1], to[2], parts(l, self.aside[1]));
        // A piece's polygon has its middle between the two other corners of the rectangle around it.
        let across = before.mixed(
            l,
            among(l, self.crosses, to[0], to[1]),
            among(l, self.crosses, to[1], to[2]),
        );
        let first = between(l, near, between(l, begin, across, share), half);
        let across = behind.mixed(
            l,
            among(l, self.crosses, from[2], from[1]),
            among(l, self.crosses, from[3], from[2]),
        );
        let second = between(l, far, between(l, across, end, share), half);
        BentColours {
            ends: [begin, between(l, near, far, share), end],
            controls: [first, second],
        }
    }
}

/// One or the other colours in halves.
#[inline(always)]
fn among<L: Lanes>(l: L, mask: L::M, yes: [L::I; 2], no: [L::I; 2]) -> [L::I; 2] {
    [
        l.select_i(mask, yes[0], no[0]),
        l.select_i(mask, yes[1], no[1]),
    ]
}

/// Colours in halves, [`FINE`] times as large.
#[inline(always)]
fn fine_halves<L: Lanes>(l: L, colours: L::I) -> [L::I; 2] {
    let [red_blue, green_alpha] = halves(l, colours);
    let shift = l.splat_i(FINE.trailing_zeros() as i32);
    [l.shl_i(red_blue, shift), l.shl_i(green_alpha, shift)]
}

/// Colours in halves so much of the way from one to another.
#[inline(always)]
pub(super) fn between<L: Lanes>(l: L, from: [L::I; 2], to: [L::I; 2], share: L::I) -> [L::I; 2] {
    [
        l.lerp_halves(from[0], to[0], share),
        l.lerp_halves(from[1], to[1], share),
    ]
}

/// The bytes 0 and 2 of each lane, and 1 and 3, in 16 bits each.
#[inline(always)]
pub(super) fn halves<L: Lanes>(l: L, colours: L::I) -> [L::I; 2] {
    let mask = l.splat_i(0x00ff_00ff);
    [
        l.and_i(colours, mask),
        l.and_i(l.shr_i(colours, l.splat_i(8)), mask),
    ]
}

/// A number below 2¹⁶ in both halves of each lane.
#[inline(always)]
pub(super) fn twice<L: Lanes>(l: L, number: L::I) -> L::I {
    l.add_i(number, l.shl_i(number, l.splat_i(16)))
}

/// A share of 1 in both halves of each lane, as [`Lanes::lerp_halves`] takes it; one below 0 or above
/// 1 is taken for that.
#[inline(always)]
pub(super) fn parts<L: Lanes>(l: L, share: L::F) -> L::I {
    let share = l.max(l.min(share, l.splat(1.0)), l.splat(0.0));
    twice(l, l.to_int(l.mul(share, l.splat(32767.0))))
}

/// Numbers in halves, divided by 256 and rounded.
#[inline(always)]
pub(super) fn upper_bytes<L: Lanes>(l: L, numbers: L::I) -> L::I {
    let rounded = l.add_i(numbers, l.splat_i(0x0080_0080));
    l.and_i(l.shr_i(rounded, l.splat_i(8)), l.splat_i(0x00ff_00ff))
}

impl Window {
    /// The posts of a mirrored line that mirrored cells from the first to the last of `cells` have.
    #[inline(always)]
    fn around(field: &Field<'_>, line: i32, [first, last]: [i32; 2]) -> Option<Self> {
        let count = last - first + 2;
        if count > ROOM {
            return None;
        }
        let minor = &field.minor;
        let minor = minor.post(first).min(minor.post(last + 1));
        let major = field.major.post(line);
        // The last post of an axis belongs to the cell before it.
        let tile = major.min(field.major.last_post() - 1) >> 8;
        let (along, aside) = (major - (tile << 8), minor & 255);
        let stride = field.heights.stride as usize;
        let (tile, line, first) = if field.major_axis == 0 {
            let tile = field.heights.number(tile, minor >> 8);
            (tile, along as usize, aside as usize * stride)
        } else {
            let tile = field.heights.number(minor >> 8, tile);
            (tile, along as usize * stride, aside as usize)
        };
        Some(Self {
            tile,
            first: line + first,
            line,
            left: 256 - aside,
            count,
        })
    }

    /// The posts' numbers in a raster on the field's grid; `None` where there is no room behind
    /// them to read as many. Asks for the memory of those that `planes` cross some lines later.
    #[inline(always)]
    fn read<L: Lanes, T: bytemuck::Pod>(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        tiles: &Tiles<'_, T>,
    ) -> Option<[L::I; 2]> {
        if field.major_axis == 0 {
            Some(self.read_column(l, field, tiles))
        } else {
            self.read_row(l, field, planes, tiles)
        }
    }

    #[inline(always)]
    fn read_row<L: Lanes, T: bytemuck::Pod>(
        &self,
        l: L,
        field: &Field<'_>,
        planes: &PlaneGroup<L>,
        tiles: &Tiles<'_, T>,
    ) -> Option<[L::I; 2]> {
        let tile = tiles.items.nth(self.tile);
        let crosses = self.count > self.left + 1;
        if field.ahead.is_some() {
            let further = field.major.sign * ROWS_AHEAD * tiles.stride as i32
                + field.minor.sign * planes.drift;
            let at = self.first.wrapping_add_signed(further as isize);
            l.prefetch_read(tile, at);
            l.prefetch_read(tile, at.wrapping_add(15));
            if crosses {
                let at = self.line.wrapping_add_signed(further as isize);
                l.prefetch_read(tiles.items.nth(self.tile + 1), at);
            } else {
                l.prefetch_read(tile, at.wrapping_add(ROOM as usize - 1));
            }
        }
        let posts = line(l, tile, self.first)?;
        if !crosses {
            return Some(posts);
        }
        let next = tiles.items.nth(self.tile + 1);
        let next = line(l, next, self.line.checked_sub(self.left as usize)?)?;
        let numbers = l.load_i(&NUMBERS);
        let left = l.splat_i(self.left);
        let is_low = l.gt_i(left, numbers);
        let is_high = l.gt_i(left, l.add_i(numbers, l.splat_i(LANES as i32)));
        Some([
            l.select_i(is_low, posts[0], next[0]),
            l.select_i(is_high, posts[1], next[1]),
        ])
    }

    #[inline(always)]
    fn read_column<L: Lanes, T: bytemuck::Pod>(
        &self,
        l: L,
        field: &Field<'_>,
        tiles: &Tiles<'_, T>,
    ) -> [L::I; 2] {
        let stride = tiles.stride as usize;
        let tile = tiles.items.nth(self.tile);
        if field.ahead.is_some() {
            // A third of the lines that the next sixteen columns lie in.
            let row = 3 * (self.line & 7);
            let further = (field.major.sign * COLUMNS_AHEAD) as isize;
            for row in row..row + 3 {
                let at = self.first + row.min(self.count as usize) * stride;
                l.prefetch_read(tile, at.wrapping_add_signed(further));
            }
        }
        let items: &[i32] = bytemuck::cast_slice(tile.get(self.first..).unwrap_or_default());
        let mut posts = [0; ROOM as usize];
        if self.count <= self.left + 1 && items.len() > (ROOM as usize - 1) * stride {
            for k in 0..LANES {
                posts[k] = items[k * stride];
            }
            if self.count > LANES as i32 {
                for k in LANES..ROOM as usize {
                    posts[k] = items[k * stride];
                }
            }
        } else {
            let here = self.count.min(self.left + 1) as usize;
            for (post, &item) in posts[..here].iter_mut().zip(items.iter().step_by(stride)) {
                *post = item;
            }
            if here < self.count as usize {
                let next = tiles.items.nth(tiles.above(self.tile));
                let items: &[i32] = bytemuck::cast_slice(next.get(self.line..).unwrap_or_default());
                let posts = &mut posts[self.left as usize..self.count as usize];
                for (post, &item) in posts.iter_mut().zip(items.iter().step_by(stride)) {
                    *post = item;
                }
            }
        }
        [l.load_i(group(&posts, 0)), l.load_i(group(&posts, LANES))]
    }
}

const NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The numbers in a tile from a place on, as many as there is [`ROOM`] for.
#[inline(always)]
fn line<L: Lanes, T: bytemuck::Pod>(l: L, tile: &[T], from: usize) -> Option<[L::I; 2]> {
    let posts: &[T; ROOM as usize] = tile.get(from..)?.first_chunk()?;
    let posts: &[i32] = bytemuck::cast_slice(posts);
    Some([l.load_i(group(posts, 0)), l.load_i(group(posts, LANES))])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;
    use crate::planes::field::Axis;
    use crate::planes::frame::Level;
    use crate::planes::roofs::Roofs;
    use crate::planes::steepness::Steepness;
    use glam::DVec2;
    use sandtable_terrain::{Ground, TiledRaster};

    /// Rough ground of more tiles than one with its colours, and an eye beside it; the sign of its
    /// rays along either axis, and which of the ground's axes the major one is, for each way that
    /// there is.
    fn each_field(check: impl Fn(&Field<'_>, &Ground, &TiledRaster<[u8; 4]>)) {
        let height = |col: u32, row: u32| {
            let rough = ((col * 37 + row * 91) % 113) as f32;
            60.0 + 0.02 * rough
                + 30.0 * (0.04 * col as f32).sin()
                + 20.0 * (0.03 * row as f32).cos()
        };
        let ground = Ground::from_fn(600, 540, DVec2::ONE, height).expect("a sound grid");
        let colours = TiledRaster::from_fn(600, 540, |col, row| {
            let code = |k: u32| ((col * (31 + k) + row * (17 + 3 * k)) % 251) as u8;
            [code(0), code(1), code(2), 255]
        });
        let roofs = Roofs::new(ground.heights());
        let steepness = Steepness::new(ground.heights());
        let level = Level::new(ground.heights(), &roofs, &steepness).with_colours(&colours);
        for k in 0..8 {
            let major_axis = k & 1;
            let axis = |axis: usize, sign: i32| {
                let cells = level.cells[axis];
                let eye = if sign > 0 {
                    -3.3
                } else {
                    f64::from(cells) + 2.6
                };
                Axis::new(eye, cells, sign)
            };
            let sign = |bit: usize| if k & bit == 0 { 1 } else { -1 };
            let axes = [axis(major_axis, sign(2)), axis(1 - major_axis, sign(4))];
            let mut field = Field::of_level(&level, axes, major_axis);
            field.eye_height = 7.0;
            // Memory is asked for as it is of large grounds.
            field.ahead = (k & 2 == 0).then_some(0);
            check(&field, &ground, &colours);
        }
    }

    /// Planes from one that advances by `first` on, each by `more` more.
    fn planes(first: f32, more: f32) -> PlaneGroup<Portable> {
        PlaneGroup::new(Portable, &std::array::from_fn(|k| first + more * k as f32))
    }

    /// Close together and far apart, inside of tiles and across their borders.
    const GROUPS: [[f32; 2]; 4] = [[0.3, 1e-4], [0.9, -0.004], [0.05, 0.02], [0.0, 0.06]];

    /// Where on the ground a place of a field lies.
    fn place(field: &Field<'_>, major: f64, minor: f64) -> [f64; 2] {
        let along = |axis: &Axis, at: f64| {
            // Line 0 lies `fraction` before the eye.
            let lines = at + f64::from(axis.fraction);
            f64::from(axis.post(0)) + f64::from(axis.sign) * lines
        };
        let (major, minor) = (along(&field.major, major), along(&field.minor, minor));
        if field.major_axis == 0 {
            [major, minor]
        } else {
            [minor, major]
        }
    }

    fn ground_height(field: &Field<'_>, ground: &Ground, major: f64, minor: f64) -> Option<f64> {
        let [x, y] = place(field, major, minor);
        ground.height_at(x, y)
    }

    #[test]
    fn profiles_are_the_grounds() {
        each_field(|field, ground, colours| {
            for [first, more] in GROUPS {
                let planes = planes(first, more);
                let mut found = 0;
                for line in field.major.cells[0]..=field.major.cells[1] + 1 {
                    let t = line as f32 - field.major.fraction;
                    let crossing = Crossing::new(Portable, field, &planes, line, 0);
                    let posts = crossing.posts(Portable, field, &planes);
                    let heights = crossing.heights(Portable, field, posts);
                    let tiles = field.colours.expect("they were given");
                    let halves = crossing.colours(Portable, field, &planes, tiles);
                    for (k, (height, advance)) in heights.iter().zip(planes.advance).enumerate() {
                        let (t, aside) = (f64::from(t), f64::from(advance) * f64::from(t));
                        let Some(truth) = ground_height(field, ground, t, aside) else {
                            continue;
                        };
                        let height = f64::from(height + field.eye_height);
                        assert!((height - truth).abs() < 0.05, "{height} and {truth} at {t}");
                        let [x, y] = place(field, t, aside);
                        let ([col, row], [u, v]) = colours.locate(x, y);
                        let [sw, se, nw, ne] = colours.cell(col, row);
                        for channel in 0..4 {
                            let code = |texel: [u8; 4]| f64::from(texel[channel]);
                            let south = code(sw) + (code(se) - code(sw)) * u;
                            let north = code(nw) + (code(ne) - code(nw)) * u;
                            let truth = south + (north - south) * v;
                            let half = halves[channel % 2][k] >> (channel / 2 * 16) & 0xffff;
                            let off = (f64::from(half) - truth).abs();
                            assert!(off < 2.5, "{half} and {truth} at {t}");
                        }
                        found += 1;
                    }
                }
                assert!(found > 4000, "{found}");
            }
        });
    }

    /// The colours of a bent profile's pieces are the ground's, however cells are twisted.
    #[test]
    fn bent_colours_are_the_grounds() {
        each_field(|field, _, colours| {
            let tiles = field.colours.expect("they were given");
            let (mut found, mut crossing) = (0, 0);
            for [first, more] in [[0.3, 1e-3], [0.9, -0.004], [0.05, 0.02]] {
                let planes = planes(first, more);
                let line = |line: i32| {
                    let crossing = Crossing::new(Portable, field, &planes, line, 1);
                    let texels = crossing.texels(Portable, field, &planes, tiles);
                    (crossing, texels)
                };
                for number in (field.major.cells[0]..=field.major.cells[1]).step_by(3) {
                    let [before, behind] = [line(number), line(number + 1)];
                    let lines = [&before.0, &behind.0];
                    let bend = Bend::new(Portable, &planes, lines[0], lines[1]);
                    let bent = bend.colours(Portable, lines, [&before.1, &behind.1]);
                    let t = number as f32 - field.major.fraction;
                    for (k, &advance) in planes.advance.iter().enumerate() {
                        let at = |share: f64| {
                            let t = f64::from(t) + share;
                            place(field, t, f64::from(advance) * t)
                        };
                        let inside = |[x, y]: [f64; 2]| {
                            let last = [colours.cols(), colours.rows()].map(|n| f64::from(n - 1));
                            (0.0..=last[0]).contains(&x) && (0.0..=last[1]).contains(&y)
                        };
                        if !inside(at(0.0)) || !inside(at(1.0)) {
                            continue;
                        }
                        crossing += usize::from(bend.crosses[k] != 0);
                        let share = f64::from(bend.share[k]);
                        let red = |halves: &[[i32; LANES]; 2]| {
                            f64::from(halves[0][k] & 0xffff) / f64::from(FINE)
                        };
                        for (piece, ends) in [[0.0, share], [share, 1.0]].into_iter().enumerate() {
                            let [begin, end] = [&bent.ends[piece], &bent.ends[piece + 1]].map(red);
                            let control = red(&bent.controls[piece]);
                            for s in [0.0, 0.3, 0.5, 0.8, 1.0] {
                                let [one, other] = [[begin, control], [control, end]]
                                    .map(|[a, b]| a + (b - a) * s);
                                let seen = one + (other - one) * s;
                                let [x, y] = at(ends[0] + (ends[1] - ends[0]) * s);
                                let ([col, row], [u, v]) = colours.locate(x, y);
                                let [sw, se, nw, ne] =
                                    colours.cell(col, row).map(|texel| f64::from(texel[0]));
                                let (south, north) = (sw + (se - sw) * u, nw + (ne - nw) * u);
                                let truth = south + (north - south) * v;
                                assert!((seen - truth).abs() < 0.5, "{seen}, {truth} at {s}");
                                found += 1;
                            }
                        }
                    }
                }
            }
            assert!(found > 10_000 && crossing > 500, "{found}, {crossing}");
        });
    }

    /// Bends lie on the ground, too, and nowhere is it far from the straight pieces between: where cells
    /// are not twisted it is on them.
    #[test]
    fn bends_are_the_grounds() {
        // Ridges and valleys along both axes, of which no cell is twisted.
        let folded = |col: u32, row: u32| 50.0 + (col * 7 % 5) as f32 + (row * 5 % 7) as f32;
        let ground = Ground::from_fn(80, 70, DVec2::ONE, folded).expect("a sound grid");
        let codes = |col: u32, row: u32| (10 + 20 * (col * 7 % 5) + 15 * (row * 5 % 7)) as u8;
        let colours = TiledRaster::from_fn(80, 70, |col, row| [codes(col, row), 0, 200, 255]);
        let roofs = Roofs::new(ground.heights());
        let steepness = Steepness::new(ground.heights());
        let level = Level::new(ground.heights(), &roofs, &steepness).with_colours(&colours);
        for k in 0..8 {
            let major_axis = k & 1;
            let axis = |axis: usize, sign: i32| {
                let cells = level.cells[axis];
                let eye = if sign > 0 {
                    -3.3
                } else {
                    f64::from(cells) + 2.6
                };
                Axis::new(eye, cells, sign)
            };
            let sign = |bit: usize| if k & bit == 0 { 1 } else { -1 };
            let axes = [axis(major_axis, sign(2)), axis(1 - major_axis, sign(4))];
            let mut field = Field::of_level(&level, axes, major_axis);
            field.eye_height = 7.0;
            let tiles = field.colours.expect("they were given");
            let (mut found, mut crossing) = (0, 0);
            for [first, more] in [[0.3, 1e-3], [0.9, -0.01], [0.05, 0.02]] {
                let planes = planes(first, more);
                let line = |line: i32| {
                    let crossing = Crossing::new(Portable, &field, &planes, line, 1);
                    let posts = crossing.posts(Portable, &field, &planes);
                    let heights = crossing.heights(Portable, &field, posts);
                    let texels = crossing.texels(Portable, &field, &planes, tiles);
                    (crossing, posts, heights, texels)
                };
                for number in field.major.cells[0]..=field.major.cells[1] {
                    let [before, behind] = [line(number), line(number + 1)];
                    let bend = Bend::new(Portable, &planes, &before.0, &behind.0);
                    let heights = bend.heights(Portable, &field, before.1, behind.1);
                    let lines = [&before.0, &behind.0];
                    let bent = bend.colours(Portable, lines, [&before.3, &behind.3]);
                    let halves = bent.ends[1];
                    let t = number as f32 - field.major.fraction;
                    for (k, &advance) in planes.advance.iter().enumerate() {
                        let at = |share: f32| {
                            let t = f64::from(t + share);
                            ground_height(&field, &ground, t, f64::from(advance) * t)
                                .map(|height| height - f64::from(field.eye_height))
                        };
                        let share = bend.share[k];
                        crossing += usize::from(bend.crosses[k] != 0);
                        let ends = [(0.0, before.2[k]), (share, heights[k]), (1.0, behind.2[k])];
                        for [(from, low), (to, high)] in [[ends[0], ends[1]], [ends[1], ends[2]]] {
                            for part in 0..=4 {
                                let part = part as f32 / 4.0;
                                let Some(truth) = at(from + (to - from) * part) else {
                                    continue;
                                };
                                let height = f64::from(low + (high - low) * part);
                                assert!((height - truth).abs() < 2e-3, "{height}, {truth}");
                                found += 1;
                            }
                        }
                        // Colours rise and fall as heights do, so they tell the place.
                        let [x, y] = {
                            let t = f64::from(t + share);
                            place(&field, t, f64::from(advance) * t)
                        };
                        if ground.height_at(x, y).is_some() {
                            let ([col, row], [u, v]) = colours.locate(x, y);
                            let [sw, se, nw, ne] =
                                colours.cell(col, row).map(|texel| f64::from(texel[0]));
                            let (south, north) = (sw + (se - sw) * u, nw + (ne - nw) * u);
                            let truth = south + (north - south) * v;
                            let red = f64::from(halves[0][k] & 0xffff) / f64::from(FINE);
                            assert!((red - truth).abs() < 2.5, "{red}, {truth}");
                        }
                    }
                }
            }
            assert!(found > 10_000 && crossing > 500, "{found}, {crossing}");
        }
    }

    #[test]
    fn no_ground_is_above_ceilings() {
        each_field(|field, ground, _| {
            for ([first, more], level) in GROUPS.into_iter().zip([4, 6, 4, 6]) {
                let groups = [0.0, 16.0].map(|k| planes(first + more * k, more));
                let outer = groups.each_ref().map(|planes| planes.outer);
                let (mut found, mut highest) = (0, 0.0_f64);
                for line in field.major.cells[0]..=field.major.cells[1] + 1 {
                    let Some(most) = ceiling(field, outer, line, level) else {
                        continue;
                    };
                    let most = f64::from(most + field.eye_height);
                    let from = line as f32 - field.major.fraction;
                    for part in 0..=50 {
                        let t = from + (part << level) as f32 / 50.0;
                        for advance in groups.iter().flat_map(|planes| planes.advance) {
                            let (t, aside) = (f64::from(t), f64::from(advance * t));
                            let Some(height) = ground_height(field, ground, t, aside) else {
                                continue;
                            };
                            assert!(height < most + 0.01, "{height} over {most} at {t}");
                            highest = highest.max(height / most);
                        }
                    }
                    found += 1;
                }
                assert!(found >= 600 >> level >> 2, "{found} blocks");
                assert!(highest > 0.5, "{highest}");
            }
        });
    }
}
