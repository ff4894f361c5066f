//! What sixteen planes see of the ground: light, pixel by pixel, over a horizon that rises.

use super::paint::{Paint, packed, straight};
use super::rays::{Each, PARTS, Rays};
use super::walls::Walls;
use crate::lanes::Lanes;
use crate::planes::field::Field;
use crate::planes::profile::{
    Bend, BentColours, Mark, Outlook, PlaneGroup, Station, Stretch, Texels, between, coarse_halves,
    either, fine_halves, halves, parts,
};

/// How many pixels wide apart two hits may lie along the ground that are taken for one piece of it.
pub(super) const SAME: f32 = 5.0;

/// How many pixels ahead of the next one the memory of a plane's pixels is asked for.
const AHEAD: i32 = 4;

/// What all planes of a fan begin with.
pub(super) struct Start {
    /// As much of the major axis as directions have at least.
    pub(super) steep: f32,
    /// Places at a smaller t are taken to lie there: their slopes have no end, and in what lies between them and
    /// the next place digits would be lost.
    pub(super) nearest: f32,
    /// How far behind a pixel's number among what is seen that of the next one in its plane lies.
    pub(super) period: usize,
}

/// Where sixteen planes cross a line of posts, or are between two.
pub(super) struct Line<L: Lanes> {
    station: Station<L>,
    /// The heights over the eye of the posts around planes, and of the ground between them.
    posts: [L::F; 2],
    height: L::F,
    /// The slope from the eye, and 1 / t.
    slope: L::F,
    inverse: f32,
}

/// A place on each plane's profile.
#[derive(Clone, Copy)]
struct Place<L: Lanes> {
    t: L::F,
    inverse: L::F,
    height: L::F,
    slope: L::F,
}

/// A straight piece of sixteen profiles, as far as there is ground.
struct Piece<L: Lanes> {
    /// At both ends the slopes from the eye, and 1 / t.
    slopes: [L::F; 2],
    inverses: [L::F; 2],
    /// The higher slope: where the ground begins over the horizon, its side is seen, too.
    top: L::F,
    /// Which planes come over the ground between the places, if some may, and how much of the way that is there.
    begin: Option<(L::M, L::F)>,
    /// Which planes are over ground there.
    here: L::M,
    /// Which planes see some of it.
    visible: L::M,
}

impl<L: Lanes> Piece<L> {
    /// One over how much the slope grows.
    #[inline(always)]
    fn per_rise(&self, l: L) -> L::F {
        let rise = l.max(
            l.sub(self.slopes[1], self.slopes[0]),
            l.splat(f32::MIN_POSITIVE),
        );
        l.div(l.splat(1.0), rise)
    }
}

/// How the ground rises from one place to the next.
#[derive(Clone, Copy)]
pub(super) struct Rise<L: Lanes> {
    /// Slopes from the eye: of the first place and of the horizon, and of the next place.
    from: [L::F; 2],
    to: L::F,
    /// Parts of a pixel for each 1 of slope.
    per_slope: L::F,
    live: L::M,
}

impl<L: Lanes> Rise<L> {
    /// Whether some planes see more of it than so many pixels.
    #[inline(always)]
    pub(super) fn is_tall(&self, l: L, pixels: f32) -> bool {
        let seen = l.sub(self.to, l.max(self.from[0], self.from[1]));
        let is_tall = l.lt(l.splat(pixels * PARTS), l.mul(seen, self.per_slope));
        l.bits(l.and(self.live, is_tall)) != 0
    }
}

/// What sixteen planes have seen so far.
pub(super) struct Sight<L: Lanes> {
    pub(super) planes: PlaneGroup<L>,
    /// Directions of pixels' borders, as [`Rays`] has them.
    up: [L::F; 2],
    major: [L::F; 2],
    steep: L::F,
    /// As [`Start`] has it.
    nearest: f32,
    all_parts: L::F,
    steps: L::F,
    enter: L::F,
    leave: L::F,
    over_ground: [f32; 2],
    /// The t from which on planes may meet ground, and the largest of them.
    begin: L::F,
    last_begin: f32,
    /// Which planes go on.
    pub(super) live: L::M,
    /// Borders that the horizon has come over, where the pixel under the next one goes, and from
    /// there to the next pixel.
    pub(super) border: L::F,
    place: L::I,
    period: i32,
    /// That pixel's light so far, and its parts.
    red_blue: L::I,
    green_alpha: L::I,
    parts: L::I,
    /// Its lowest and highest slope, parts for each 1 of slope, and the next border's major axis.
    low: L::F,
    high: L::F,
    per_slope: L::F,
    run: L::F,
    /// Of the last border, one over how many of its direction's lengths away the ground is, which is
    /// affine in the image of a plane; and 1 / t of the horizon.
    near: L::F,
    far: L::F,
    horizon: L::F,
    /// The last line's heights, slopes and colours, and whether these have been read.
    height: L::F,
    slope: L::F,
    colours: [L::I; 2],
    has_colours: bool,
    /// The colours of walls, and which planes may see one.
    wall: L::I,
    has_wall: L::M,
    /// Where profiles are bent between lines: how planes cross the last one, the posts around them, and
    /// these posts' colours, if those have been read.
    station: Station<L>,
    posts: [L::F; 2],
    texels: Texels<L>,
}

impl<L: Lanes> Sight<L> {
    /// Of planes that have seen nothing yet.
    #[inline(always)]
    pub(super) fn new(l: L, field: &Field<'_>, rays: &Rays, walls: &Walls, start: &Start) -> Self {
        let load = |numbers: &Each| l.load(numbers);
        let (zero, none) = (l.splat(0.0), l.splat_i(0));
        let steep = l.splat(start.steep);
        let up = [load(&rays.up[0]), load(&rays.up[1])];
        let major = [load(&rays.major[0]), load(&rays.major[1])];
        let run = l.max(major[0], steep);
        let planes = PlaneGroup::new(l, &rays.advance);
        Self {
            station: Station::on_line(l, field, &planes, field.major.cells[0], 0),
            posts: [zero; 2],
            texels: [[none; 2]; 4],
            planes,
            up,
            major,
            steep,
            nearest: start.nearest,
            all_parts: load(&rays.parts),
            steps: load(&rays.steps),
            enter: load(&rays.enter),
            leave: load(&rays.leave),
            over_ground: rays.over_ground(),
            begin: load(&rays.begin),
            last_begin: rays.begin.iter().copied().fold(0.0, f32::max),
            live: l.mask(rays.live),
            border: zero,
            place: l.load_i(&rays.place),
            period: start.period as i32,
            red_blue: none,
            green_alpha: none,
            parts: none,
            low: zero,
            high: l.div(up[0], run),
            per_slope: zero,
            run,
            near: zero,
            far: zero,
            horizon: load(&rays.horizon),
            height: zero,
            slope: zero,
            colours: [none; 2],
            has_colours: false,
            wall: l.load_i(&walls.colours),
            has_wall: l.mask(walls.seen),
        }
    }

    /// Goes on from a mirrored line, at t, without a look at what lies before it.
    #[inline(always)]
    pub(super) fn skip_to<const BENT: bool>(&mut self, l: L, field: &Field<'_>, line: i32, t: f32) {
        let there = self.line::<BENT>(l, field, line, t);
        self.leave_behind::<BENT>(there, false);
        self.stay_over_ground(l, t);
    }

    /// Leaves planes behind that have left the ground before t.
    #[inline(always)]
    pub(super) fn stay_over_ground(&mut self, l: L, t: f32) {
        self.live = l.and(self.live, l.lt(l.splat(t), self.leave));
    }

    /// What tells which ground is hidden.
    #[inline(always)]
    pub(super) fn outlook(&self) -> Outlook<L> {
        Outlook::new(&self.planes, self.live, self.horizon)
    }

    /// The mirrored line `line`, at t.
    #[inline(always)]
    pub(super) fn line<const BENT: bool>(
        &self,
        l: L,
        field: &Field<'_>,
        line: i32,
        t: f32,
    ) -> Line<L> {
        l.share(
            #[inline(always)]
            || {
                let station = Station::on_line(l, field, &self.planes, line, i32::from(BENT));
                self.at(l, field, station, t)
            },
        )
    }

    /// A place between two lines, at t.
    #[inline(always)]
    pub(super) fn place(&self, l: L, field: &Field<'_>, mark: Mark, t: f32) -> Line<L> {
        l.share(
            #[inline(always)]
            || {
                let station = Station::between(l, field, &self.planes, mark);
                self.at(l, field, station, t)
            },
        )
    }

    #[inline(always)]
    fn at(&self, l: L, field: &Field<'_>, station: Station<L>, t: f32) -> Line<L> {
        let planes = &self.planes;
        let posts = station.posts(l, field, planes);
        let height = station.crossing.heights(l, posts);
        let inverse = 1.0 / t.max(self.nearest);
        Line {
            station,
            posts,
            height,
            slope: l.mul(height, l.splat(inverse)),
            inverse,
        }
    }

    /// How planes see the ground rise to a line.
    #[inline(always)]
    pub(super) fn rise(&self, line: &Line<L>) -> Rise<L> {
        Rise {
            from: [self.slope, self.horizon],
            to: line.slope,
            per_slope: self.per_slope,
            live: self.live,
        }
    }

    /// Takes the last line's colours from another level with the same ground, of which it is the mirrored line `line`.
    #[inline(always)]
    pub(super) fn recolour(&mut self, l: L, field: &Field<'_>, line: i32) {
        if let Some(colours) = field.colours {
            let station = Station::on_line(l, field, &self.planes, line, 0);
            self.colours = station.crossing.colours(l, field, &self.planes, colours);
        }
    }

    /// The way from the last line to the next one.
    #[inline(always)]
    pub(super) fn stretch(&self, line: &Line<L>) -> Stretch<L> {
        Stretch {
            planes: self.planes,
            stations: [self.station, line.station],
            posts: [self.posts, line.posts],
            live: self.live,
        }
    }

    /// The places on the last line, at `t`, and on the next one, at `end`.
    #[inline(always)]
    fn ends(&self, l: L, line: &Line<L>, [t, end]: [f32; 2]) -> [Place<L>; 2] {
        [
            Place {
                t: l.splat(t),
                inverse: l.splat(1.0 / t.max(self.nearest)),
                height: self.height,
                slope: self.slope,
            },
            Place {
                t: l.splat(end),
                inverse: l.splat(line.inverse),
                height: line.height,
                slope: line.slope,
            },
        ]
    }

    /// Looks at what lies between the last line, at the first t, and the next one, at the second, and goes
    /// on from there. Hits that are `same` times as far as others are taken for the same piece of ground.
    /// Gives whether planes see some of it. There are `to_a_cell` places between two lines.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "what lies between two places")]
    pub(super) fn look<const BENT: bool>(
        &mut self,
        l: L,
        field: &Field<'_>,
        line: Line<L>,
        between: [f32; 2],
        to_a_cell: f32,
        same: f32,
        seen: &mut [[i32; 2]],
    ) -> bool {
        let is_seen = l.share(
            #[inline(always)]
            || {
                if BENT {
                    let ([first, mut second], bend) = self.bent(l, &line, between, to_a_cell);
                    let is_seen = l.bits(l.or(first.visible, second.visible)) != 0;
                    if is_seen {
                        let colours = self.bent_colours(l, field, &line, &bend);
                        let paint = self.paint_bent(l, &colours, 0, &first);
                        self.add::<true>(l, first, paint, same, seen);
                        self.look_again(l, &mut second);
                        let paint = self.paint_bent(l, &colours, 1, &second);
                        self.add::<true>(l, second, paint, same, seen);
                    }
                    is_seen
                } else {
                    let piece = self.piece(l, &line, between);
                    let is_seen = l.bits(piece.visible) != 0;
                    if is_seen {
                        let paint = self.paint(l, field, &line, &piece);
                        self.add::<false>(l, piece, paint, same, seen);
                    }
                    is_seen
                }
            },
        );
        self.leave_behind::<BENT>(line, is_seen);
        is_seen
    }

    /// Whether the ground begins or ends between two t.
    #[inline(always)]
    fn is_at_border(&self, [t, end]: [f32; 2]) -> bool {
        let [last_enter, first_leave] = self.over_ground;
        t <= last_enter || first_leave < end
    }

    /// Whether some planes only begin behind t.
    #[inline(always)]
    fn is_at_begin(&self, [t, _]: [f32; 2]) -> bool {
        t < self.last_begin
    }

    /// The piece from the last line, at the first t, to the next one, at the second. Planes that have left
    /// the ground before go on no further.
    #[inline(always)]
    fn piece(&mut self, l: L, line: &Line<L>, between: [f32; 2]) -> Piece<L> {
        let ends = self.ends(l, line, between);
        self.straight(
            l,
            ends,
            self.is_at_border(between),
            self.is_at_begin(between),
        )
    }

    /// As `piece`, in two straight ones.
    #[inline(always)]
    fn bent(
        &mut self,
        l: L,
        line: &Line<L>,
        between: [f32; 2],
        to_a_cell: f32,
    ) -> ([Piece<L>; 2], Bend<L>) {
        let crossings = [&self.station.crossing, &line.station.crossing];
        let bend = Bend::new(l, &self.planes, crossings, to_a_cell);
        let [from, to] = self.ends(l, line, between);
        let t = l.add(from.t, l.mul(bend.share, l.sub(to.t, from.t)));
        let height = bend.heights(l, self.posts, line.posts);
        let inverse = l.div(l.splat(1.0), l.max(t, l.splat(self.nearest)));
        let middle = Place {
            t,
            inverse,
            height,
            slope: l.mul(height, inverse),
        };
        let (is_at_border, is_at_begin) = (self.is_at_border(between), self.is_at_begin(between));
        let pieces = [
            self.straight(l, [from, middle], is_at_border, is_at_begin),
            self.straight(l, [middle, to], is_at_border, is_at_begin),
        ];
        (pieces, bend)
    }

    /// A straight piece from place to place, of which some may lie beside the ground where it
    /// `is_at_border`, and some before planes begin where it `is_at_begin`.
    #[inline(always)]
    fn straight(
        &mut self,
        l: L,
        [from, to]: [Place<L>; 2],
        is_at_border: bool,
        is_at_begin: bool,
    ) -> Piece<L> {
        let mut here = self.live;
        let mut inverses = [from.inverse, to.inverse];
        let mut slopes = [from.slope, to.slope];
        let mut begins = None;
        if is_at_border {
            let one = l.splat(1.0);
            let begin = l.max(from.t, self.enter);
            let end = l.min(to.t, self.leave);
            self.live = l.and(self.live, l.lt(begin, self.leave));
            here = l.and(self.live, l.lt(begin, end));
            let way = l.max(l.sub(to.t, from.t), l.splat(f32::MIN_POSITIVE));
            let per_way = l.div(one, way);
            let comes = l.le(from.t, self.enter);
            begins = Some((comes, l.mul(l.sub(begin, from.t), per_way)));
            let rise = l.mul(l.sub(to.height, from.height), per_way);
            let heights = [
                l.add(from.height, l.mul(rise, l.sub(begin, from.t))),
                l.add(from.height, l.mul(rise, l.sub(end, from.t))),
            ];
            let nearest = l.splat(self.nearest);
            inverses = [
                l.div(one, l.max(begin, nearest)),
                l.div(one, l.max(end, nearest)),
            ];
            slopes = [
                l.mul(heights[0], inverses[0]),
                l.mul(heights[1], inverses[1]),
            ];
        }
        if is_at_begin {
            here = l.and(here, l.lt(self.begin, to.t));
        }
        let top = l.max(slopes[0], slopes[1]);
        Piece {
            slopes,
            inverses,
            top,
            begin: begins,
            here,
            visible: l.and(here, l.lt(self.horizon, top)),
        }
    }

    /// Looks again which planes see some of a piece, after the one before it has been looked at.
    #[inline(always)]
    fn look_again(&self, l: L, piece: &mut Piece<L>) {
        let here = l.and(piece.here, self.live);
        piece.visible = l.and(here, l.lt(self.horizon, piece.top));
    }

    /// The colours of a piece that ends at a line.
    #[inline(always)]
    fn paint(&mut self, l: L, field: &Field<'_>, line: &Line<L>, piece: &Piece<L>) -> Paint<L> {
        let end = match field.colours {
            Some(colours) => line
                .station
                .crossing
                .colours(l, field, &self.planes, colours),
            None => [l.splat_i(0); 2],
        };
        // Where the line before was not seen, all that is seen lies close to this one.
        let slope = piece.slopes[0];
        let seen = l.and(l.le(slope, self.horizon), l.le(self.horizon, slope));
        let seen = l.and(seen, l.mask(if self.has_colours { u16::MAX } else { 0 }));
        let mut begin = either(l, seen, self.colours, end);
        if let Some((comes, _)) = piece.begin {
            begin = either(l, l.and(comes, self.has_wall), halves(l, self.wall), begin);
        }
        self.colours = end;
        Paint {
            ends: [begin, end],
            control: end,
            per_rise: piece.per_rise(l),
            done: l.splat(0.0),
        }
    }

    /// The colours between the last line and the next one of profiles that are bent there.
    #[inline(always)]
    fn bent_colours(
        &mut self,
        l: L,
        field: &Field<'_>,
        line: &Line<L>,
        bend: &Bend<L>,
    ) -> BentColours<L> {
        let Some(colours) = field.colours else {
            let none = [l.splat_i(0); 2];
            return BentColours {
                ends: [none; 3],
                controls: [none; 2],
            };
        };
        if !self.has_colours {
            self.texels = self.station.texels(l, field, &self.planes, colours);
        }
        let texels = line.station.texels(l, field, &self.planes, colours);
        let lines = [&self.station.crossing, &line.station.crossing];
        let bent = bend.colours(l, lines, [&self.texels, &texels]);
        self.texels = texels;
        self.colours = bent.ends[2];
        bent
    }

    /// The colours of the first or the second piece of a bent profile.
    #[inline(always)]
    fn paint_bent(
        &self,
        l: L,
        colours: &BentColours<L>,
        number: usize,
        piece: &Piece<L>,
    ) -> Paint<L> {
        let per_rise = piece.per_rise(l);
        let hidden = l.mul(l.sub(self.horizon, piece.slopes[0]), per_rise);
        let mut ends = [colours.ends[number], colours.ends[number + 1]];
        let mut control = colours.controls[number];
        if let Some((comes, share)) = piece.begin {
            // The rest of the parabola.
            let share = parts(l, share);
            let first = between(l, ends[0], control, share);
            control = between(l, control, ends[1], share);
            ends[0] = between(l, first, control, share);
            let wall = fine_halves(l, self.wall);
            ends[0] = either(l, l.and(comes, self.has_wall), wall, ends[0]);
        }
        Paint {
            ends,
            control,
            per_rise,
            done: l.max(l.min(hidden, l.splat(1.0)), l.splat(0.0)),
        }
    }

    /// Goes on with straight profiles, of which colours and sums of light are in other parts.
    #[inline(always)]
    pub(super) fn straighten(&mut self, l: L) {
        self.colours = coarse_halves(l, self.colours);
        [self.red_blue, self.green_alpha] =
            straight(l, [self.red_blue, self.green_alpha], self.parts);
    }

    /// Over which planes' next borders a piece rises.
    #[inline(always)]
    fn over(&self, l: L, piece: &Piece<L>) -> L::M {
        l.and(piece.visible, l.le(self.high, piece.top))
    }

    /// Finishes the pixels of the planes `over` whose next borders a piece rises; `same` as `look` has it.
    #[inline(always)]
    fn finish<const BENT: bool>(
        &mut self,
        l: L,
        over: L::M,
        piece: &mut Piece<L>,
        paint: &mut Paint<L>,
        same: f32,
        seen: &mut [[i32; 2]],
    ) {
        let (zero, none) = (l.splat(0.0), l.splat_i(0));
        let share = l.mul(l.sub(self.high, piece.slopes[0]), paint.per_rise);
        let share = l.max(share, zero);
        let all = l.splat_i(PARTS as i32);
        let rest = l.sub_i(all, self.parts);
        let more = paint.light::<BENT>(l, l.add(paint.done, share), rest);
        let whole = [
            l.add_i(self.red_blue, more[0]),
            l.add_i(self.green_alpha, more[1]),
        ];
        let whole = if BENT { straight(l, whole, all) } else { whole };
        paint.done = l.select(over, share, paint.done);
        let [from, to] = piece.inverses;
        let crossed = l.add(from, l.mul(l.sub(to, from), share));
        let crossed = l.mul(crossed, self.run);
        let is_one = l.le(self.near, l.mul(crossed, l.splat(same)));
        let between = l.mul(l.add(self.near, crossed), l.splat(0.5));
        let at = l.bits_of_float(l.select(is_one, between, self.near));
        let pixel = l.and(over, l.lt(zero, self.border));
        l.scatter_pairs(pixel, self.place, [packed(l, whole), at], seen);
        let [first, last] = l.ends(self.place);
        for place in [first, last] {
            l.prefetch_write(seen, (place + AHEAD * self.period) as usize);
        }
        self.place = l.add_i_where(pixel, self.place, l.splat_i(self.period));
        self.border = l.select(over, l.add(self.border, l.splat(1.0)), self.border);
        self.near = l.select(over, crossed, self.near);
        self.low = l.select(over, self.high, self.low);
        let run = l.add(self.major[0], l.mul(self.border, self.major[1]));
        let run = l.max(run, self.steep);
        let per_slope = l.mul(l.mul(self.run, run), self.all_parts);
        self.per_slope = l.select(over, per_slope, self.per_slope);
        self.run = run;
        self.high = l.div(l.add(self.up[0], l.mul(self.border, self.up[1])), run);
        self.red_blue = l.select_i(over, none, self.red_blue);
        self.green_alpha = l.select_i(over, none, self.green_alpha);
        self.parts = l.select_i(over, none, self.parts);
        let is_done = l.lt(self.steps, self.border);
        piece.visible = l.and_not(piece.visible, is_done);
        self.live = l.and_not(self.live, is_done);
    }

    /// Adds what planes see of a piece to their pixels. Of these it finishes sixteen at once: more would
    /// seldom have as many borders to pass as each other.
    #[inline(always)]
    fn add<const BENT: bool>(
        &mut self,
        l: L,
        mut piece: Piece<L>,
        mut paint: Paint<L>,
        same: f32,
        seen: &mut [[i32; 2]],
    ) {
        loop {
            let over = self.over(l, &piece);
            if l.bits(over) == 0 {
                break;
            }
            self.finish::<BENT>(l, over, &mut piece, &mut paint, same, seen);
        }
        // What is left lies under the next borders.
        let up_to = l.mul(l.sub(piece.top, self.low), self.per_slope);
        let up_to = l.to_int(l.max(l.min(up_to, l.splat(PARTS)), l.splat(0.0)));
        let up_to = l.max_i(up_to, self.parts);
        let up_to = l.select_i(piece.visible, up_to, self.parts);
        let more = l.sub_i(up_to, self.parts);
        let more = paint.light::<BENT>(l, l.add(paint.done, l.splat(1.0)), more);
        self.red_blue = l.add_i(self.red_blue, more[0]);
        self.green_alpha = l.add_i(self.green_alpha, more[1]);
        self.parts = up_to;
        self.horizon = l.select(piece.visible, piece.top, self.horizon);
        self.far = l.select(piece.visible, piece.inverses[1], self.far);
    }

    /// Goes on from a line, of which the colours have been read or not.
    #[inline(always)]
    fn leave_behind<const BENT: bool>(&mut self, line: Line<L>, has_colours: bool) {
        self.height = line.height;
        self.slope = line.slope;
        self.has_colours = has_colours;
        if BENT {
            self.station = line.station;
            self.posts = line.posts;
        }
    }

    /// Writes the pixels in which the ground ends. Gives for each plane how many of its pixels come
    /// before the sky.
    #[inline(always)]
    pub(super) fn end(&self, l: L, seen: &mut [[i32; 2]]) -> L::I {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let colours = packed(l, [self.red_blue, self.green_alpha]);
        // The ground half-way up the pixel.
        let parts = l.to_float(self.parts);
        let end = l.add(l.sub(self.border, one), l.mul(parts, l.splat(1.0 / PARTS)));
        let end = l.add(self.major[0], l.mul(end, self.major[1]));
        let far = l.mul(self.far, end);
        let half = l.div(l.splat(0.5 * PARTS), l.max(parts, one));
        let middle = l.add(self.near, l.mul(l.sub(far, self.near), half));
        // The alpha is the uppermost byte.
        let is_ground = l.gt_i(l.splat_i(0), colours);
        let at = l.bits_of_float(l.select(is_ground, middle, zero));
        let has_pixel = l.and(l.lt(zero, self.border), l.le(self.border, self.steps));
        l.scatter_pairs(has_pixel, self.place, [colours, at], seen);
        l.to_int(l.min(self.border, self.steps))
    }
}
