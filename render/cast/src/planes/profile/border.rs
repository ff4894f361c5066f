//! The ground's colours along its border.

use crate::planes::field::{Axis, Field, Tiles};

/// How many of a stretch's places are looked at.
const PLACES: usize = 8;

/// A border of the ground that rays come over.
#[derive(Clone, Copy, Debug)]
pub(in crate::planes) enum Border {
    /// Where the ground begins along the major axis.
    Front,
    /// Where it begins along the minor axis.
    Side,
}

impl Border {
    /// The border's mean colour from the first place to the second one, in cells of the finest level from the eye
    /// along the border. The ground begins at `begins`, from the eye along the major and the minor axis.
    ///
    /// Long stretches are looked at in the level that has four to eight cells of them.
    pub(in crate::planes) fn mean_colour(
        self,
        fields: &[Field<'_>],
        begins: [f32; 2],
        [from, to]: [f32; 2],
    ) -> [u8; 4] {
        let cells = (0.25 * (to - from)).max(1.0);
        let octaves = (cells.to_bits() >> 23) - 127;
        let level = (octaves as usize).min(fields.len() - 1);
        let field = &fields[level];
        let Some(colours) = field.colours else {
            return [0; 4];
        };
        let across = match self {
            Self::Front => Place::nearest_line(&field.major, begins[0] / field.scale),
            Self::Side => Place::nearest_line(&field.minor, begins[1] / field.scale),
        };
        let mut sums = [0.0; 4];
        for k in 0..PLACES {
            let there = from + (to - from) * (k as f32 + 0.5) / PLACES as f32;
            let (place, share) = match self {
                Self::Front => Place::before(&field.minor, there / field.scale),
                Self::Side => Place::before(&field.major, there / field.scale),
            };
            let [near, far] = [place, place.next()].map(|along| match self {
                Self::Front => colour_at(field, colours, [across, along]),
                Self::Side => colour_at(field, colours, [along, across]),
            });
            for (sum, (near, far)) in sums.iter_mut().zip(near.into_iter().zip(far)) {
                *sum += f32::from(near) + (f32::from(far) - f32::from(near)) * share;
            }
        }
        sums.map(|sum| (sum / PLACES as f32 + 0.5) as u8)
    }
}

/// A post's place along an axis: the mirrored cell that has it, and whether it is the one behind that.
#[derive(Clone, Copy)]
struct Place {
    cell: i32,
    is_far: bool,
}

impl Place {
    /// The line of posts that is nearest to what is `along` from the eye.
    fn nearest_line(axis: &Axis, along: f32) -> Self {
        let cell = axis.cell_alone(along);
        Self {
            cell,
            is_far: axis.inside_alone(along, cell) > 0.5,
        }
    }

    /// The post before what is `along` from the eye, and how far behind it that lies.
    fn before(axis: &Axis, along: f32) -> (Self, f32) {
        let cell = axis.cell_alone(along);
        let place = Self {
            cell,
            is_far: false,
        };
        (place, axis.inside_alone(along, cell))
    }

    /// The next post, of one that is the near one of its cell.
    fn next(self) -> Self {
        Self {
            is_far: true,
            ..self
        }
    }

    /// The ground's cell that has it, and which of the two posts of that it is.
    fn on_ground(self, axis: &Axis) -> [i32; 2] {
        let is_high = self.is_far == (axis.sign > 0);
        [axis.ground_alone(self.cell), i32::from(is_high)]
    }
}

/// The colour of the post at places along the major and the minor axis.
fn colour_at(
    field: &Field<'_>,
    colours: &Tiles<'_, [u8; 4]>,
    [major, minor]: [Place; 2],
) -> [u8; 4] {
    let places = [major.on_ground(&field.major), minor.on_ground(&field.minor)];
    let [[x, east], [y, north]] = if field.major_axis == 0 {
        places
    } else {
        [places[1], places[0]]
    };
    let tile = colours.items.nth(colours.number(x >> 8, y >> 8));
    let within = ((y & 255) + north) * colours.stride as i32 + (x & 255) + east;
    tile[within as usize]
}
