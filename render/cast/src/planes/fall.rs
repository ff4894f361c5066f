//! Where a clearance that changes as a quadratic comes down to 0.

use crate::lanes::Lanes;

/// A ray's clearance over one cell's ground: `here` + 2 `half_rate` s − `bend` s², s further on.
#[derive(Clone, Copy)]
pub(super) struct Fall<L: Lanes> {
    /// 0 where the ray is in the ground, which it has only just come into.
    pub(super) here: L::F,
    pub(super) half_rate: L::F,
    pub(super) bend: L::F,
}

impl<L: Lanes> Fall<L> {
    /// What roots are taken of: below 0 where the clearance never is 0.
    #[inline(always)]
    pub(super) fn discriminant(&self, l: L) -> L::F {
        let square = l.mul(self.half_rate, self.half_rate);
        l.add(square, l.mul(self.here, self.bend))
    }

    /// Where the clearance first comes down to 0: at once where it is 0 already; far off, or at no number, where it
    /// never does.
    #[inline(always)]
    pub(super) fn first_zero(&self, l: L) -> L::F {
        let zero = l.splat(0.0);
        let Self {
            here,
            half_rate,
            bend,
        } = *self;
        // Both parts have one sign, so that nothing cancels: of a ray that grazes a crest and rises behind it, all
        // digits would.
        let root = l.add(l.abs(half_rate), l.sqrt(self.discriminant(l)));
        let rises = l.and(l.lt(zero, half_rate), l.lt(zero, here));
        let share = l.select(rises, root, here);
        // Where there is no root, there are no numbers. Where it lies behind the ray, the bend is not above 0, and that
        // place is far off instead.
        let of = l.max(l.splat(f32::MIN_POSITIVE), l.select(rises, bend, root));
        l.div(share, of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Portable;

    /// Rays that graze crests and rise behind them by much, up and down again over twisted ground, or fall.
    #[test]
    fn rays_meet_the_ground_where_the_quadratic_says() {
        let l = Portable;
        let (mut met, mut grazed) = (0, 0);
        for k in 0..40_000_u32 {
            let share = |by: f64| (f64::from(k + 1) * by).fract();
            let here = 10.0_f32.powf(-9.0 + 9.0 * share(0.618_034) as f32);
            let half_rate = 40.0 * (2.0 * share(0.414_213_6) - 1.0) as f32;
            let bend = 200.0 * (2.0 * share(0.271_828) - 1.0) as f32;
            let fall = Fall {
                here: l.splat(here),
                half_rate: l.splat(half_rate),
                bend: l.splat(bend),
            };
            let found = f64::from(fall.first_zero(l)[0]);
            let [here, half_rate, bend] = [here, half_rate, bend].map(f64::from);
            let discriminant = half_rate * half_rate + here * bend;
            if discriminant.abs() < 1e-4 * half_rate * half_rate {
                continue;
            }
            let roots = [-1.0, 1.0].map(|sign| (half_rate + sign * discriminant.sqrt()) / bend);
            let truth = roots
                .into_iter()
                .filter(|&root| root > 0.0)
                .fold(f64::INFINITY, f64::min);
            if truth < 1.0 {
                met += 1;
                assert!((found / truth - 1.0).abs() < 1e-3, "{found}, truly {truth}");
            } else if truth > 1.0001 {
                grazed += u32::from(half_rate > 0.0 && here < 1e-6 * half_rate);
                assert!(found.is_nan() || found > 1.0, "{found}, truly {truth}");
            }
        }
        assert!(met > 10_000 && grazed > 1000, "{met} met, {grazed} grazed");
    }
}
