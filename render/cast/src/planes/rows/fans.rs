//! Plane by plane: with level of detail, far ground is cast along vertical planes that lie about a
//! pixel apart, and pixels lie between these.

mod between;
mod corners;
mod fan;
mod march;
mod paint;
mod rays;
mod resolution;
mod sight;
mod walls;

use self::march::PLANES;
use super::March;
use super::directions::STEEP;
use super::scratch::{MARGIN, MEMORY, Scratch};
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes};
use crate::planes::shade::Shader;

impl<L: Lanes> March<'_, L> {
    /// Casts the steps of a sector from `begin` on; gives how many rays they have.
    pub(super) fn cast_fans(
        &self,
        begin: u32,
        shader: &Shader<'_>,
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
    ) -> u32 {
        let l = self.l;
        let mut rays = 0;
        let mut fans = Vec::new();
        let mut to = self.sector.steps;
        while to > begin {
            let fan = self.fan(begin, to);
            to = fan.from;
            fans.push(fan);
        }
        while let Some(fan) = fans.pop() {
            // One more, as scratch.
            let mut seen = scratch.take_seen((fan.to - fan.from) as usize * fan.room() + 1);
            let mut skies = std::mem::take(&mut scratch.skies);
            skies.clear();
            for first in (0..fan.planes()).step_by(PLANES) {
                skies.push(self.march(&fan, first, scratch, &mut seen));
            }
            (scratch.seen, scratch.skies) = (seen, skies);
            for step in fan.from..fan.to {
                for (number, &sky_from) in scratch.skies.iter().enumerate() {
                    if sky_from <= step {
                        let at = fan.place(step, number * PLANES);
                        scratch.seen[at..at + PLANES].fill([0; 2]);
                    }
                }
                let lanes = fan.lanes(step);
                scratch.lanes[step as usize % MEMORY] = lanes;
                if lanes[0] < lanes[1] {
                    rays += (lanes[1] - lanes[0]) as u32;
                    l.vectorize(
                        #[inline(always)]
                        || self.between(&fan, step, shader, canvas, scratch),
                    );
                }
                scratch
                    .pixels
                    .finish_step(l, canvas, self.sector, step, lanes);
            }
        }
        rays
    }

    /// Whether most rays of a step came, so far, to where a pixel covers so many posts that it may lie
    /// between planes.
    pub(super) fn is_far(&self, step: u32, scratch: &Scratch) -> bool {
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        let at = self.slot(step) + MARGIN;
        let (Ok(first), Ok(behind)) = (usize::try_from(from), usize::try_from(to)) else {
            return false;
        };
        let width = self.pixel_width(step, 0.5 * f64::from(from + to)) as f32;
        let some = || {
            scratch.reached[at + first..at + behind]
                .iter()
                .step_by(LANES)
        };
        let least = self.frame.detail.as_ref().map_or(0.0, |detail| detail.far);
        let far = some().filter(|t| t.abs() * width > least).count();
        2 * far > some().len()
    }

    /// How many cells a pixel covers across its ray, for each 1 of t: of the longer of their sides.
    fn pixel_width(&self, step: u32, lane: f64) -> f64 {
        let v = self.directions.lane;
        let d = self.directions.at_place(step, lane);
        let major = d.x.max(self.steep());
        let advance = d.y.max(0.0) / major;
        let turned = (1.0 + (self.oblong * advance).powi(2)).sqrt();
        self.oblong.min(1.0) * (v.y * d.x - v.x * d.y).abs() / (major * major * turned)
    }

    /// As much of the major axis as directions have at least.
    fn steep(&self) -> f64 {
        STEEP * self.frame.rays.first.length()
    }
}
