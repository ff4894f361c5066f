//! How pixels make colours at posts that lie about as far apart, but elsewhere.

/// How many pixels count along an axis at most.
pub(super) const TAPS: usize = 12;

/// How many places there are from one pixel to the next, and that one.
const PHASES: usize = 256;

/// What counts for less than half a code of the widest step is left out: the less reaches over a photograph's
/// border, the better.
const LEAST: f64 = 1.0 / 512.0;

/// For places from pixel to pixel how much the pixels around them count: of twelve, the place lies between
/// the sixth and the seventh.
pub(super) struct Kernel(Vec<[f32; TAPS]>);

impl Kernel {
    /// Of the photograph itself, which is linear between pixels.
    pub(super) fn linear() -> Self {
        Self::of(|away| (1.0 - away.abs()).max(0.0))
    }

    /// Of posts so many pixels apart: what is linear between these comes as near to the photograph as it may, in
    /// the mean of squares.
    ///
    /// The photograph is a sum of hats a pixel wide, what lies between posts one of hats a post wide. How much of
    /// the one is in the other is a cubic spline; what neighbouring posts' hats have in common is taken from that
    /// (Unser, Aldroubi and Eden 1995, "Enlargement or reduction of digital images with minimum loss of
    /// information").
    pub(super) fn nearest(posts: f64) -> Self {
        let common = |away: f64| {
            if away.abs() >= 1.0 + posts {
                return 0.0;
            }
            let part = |i: f64, j: f64| {
                let sign = if i == 0.0 { -2.0 } else { 1.0 } * if j == 0.0 { -2.0 } else { 1.0 };
                sign * (away + i + j * posts).max(0.0).powi(3)
            };
            let ends = [-1.0, 0.0, 1.0];
            let sum: f64 = (ends.iter())
                .flat_map(|&i| ends.iter().map(move |&j| part(i, j)))
                .sum();
            sum / (6.0 * posts * posts)
        };
        // Hats overlap by a sixth; these are the numbers that undo it.
        let undo = |n: i32| 3.0_f64.sqrt() * (3.0_f64.sqrt() - 2.0).powi(n.abs());
        Self::of(|away| {
            (-12..=12)
                .map(|n| undo(n) * common(away - f64::from(n) * posts))
                .sum()
        })
    }

    /// A kernel that is `at` a distance so high.
    fn of(at: impl Fn(f64) -> f64) -> Self {
        let weights = |phase: usize| {
            let part = phase as f64 / PHASES as f64;
            let exact: [f64; TAPS] = std::array::from_fn(|tap| {
                let weight = at(part - (tap as f64 - (TAPS / 2 - 1) as f64));
                if weight.abs() < LEAST { 0.0 } else { weight }
            });
            let sum: f64 = exact.iter().sum();
            exact.map(|weight| (weight / sum) as f32)
        };
        Self((0..=PHASES).map(weights).collect())
    }

    /// How much the pixels around a place count: the pixel before it is the sixth.
    pub(super) fn weights(&self, at: f64) -> &[f32; TAPS] {
        // The nearest place; of no number the first.
        let phase = (at - at.floor()) * PHASES as f64 + 0.5;
        &self.0[phase as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Colours at posts `posts` pixels apart, the first of which lies at `first`.
    fn at_posts(kernel: &Kernel, pixels: &[f64], first: f64, posts: f64, count: usize) -> Vec<f64> {
        let post = |n: usize| {
            let at = first + n as f64 * posts;
            let from = at.floor() as usize - (TAPS / 2 - 1);
            let around = kernel.weights(at).iter().zip(&pixels[from..]);
            around
                .map(|(&weight, pixel)| f64::from(weight) * pixel)
                .sum()
        };
        (0..count).map(post).collect()
    }

    fn linear(values: &[f64], at: f64) -> f64 {
        let n = at.floor() as usize;
        values[n] + (values[n + 1] - values[n]) * at.fract()
    }

    #[test]
    fn what_is_left_out_has_nothing_that_posts_could_show() {
        let pixels: Vec<f64> = (0..200_u32)
            .map(|n| f64::from(n.wrapping_mul(2_654_435_769) >> 24))
            .collect();
        for posts in [0.4, 0.7, 1.0, 1.3] {
            let [off, off_linear] = [Kernel::nearest(posts), Kernel::linear()].map(|kernel| {
                let colours = at_posts(&kernel, &pixels, 30.3, posts, 81);
                // How much of each post's hat is in the difference, and how large that is.
                let mut most = 0.0_f64;
                let mut squares = 0.0;
                for n in 10..70 {
                    let mut inside = 0.0;
                    for k in -500..500 {
                        let away = f64::from(k) / 500.0;
                        let post = n as f64 + away;
                        let off = linear(&pixels, 30.3 + post * posts) - linear(&colours, post);
                        inside += off * (1.0 - away.abs()) / 500.0;
                        squares += off * off / 60_000.0;
                    }
                    most = most.max(inside.abs());
                }
                println!("{posts} pixels: {most:.3}, {:.2}", squares.sqrt());
                [most, squares.sqrt()]
            });
            // Codes of 256; places are told apart by the 256th part of a pixel.
            assert!(off[0] < 0.7, "{off:?}");
            assert!(off[1] < 0.95 * off_linear[1], "{off:?}, {off_linear:?}");
        }
    }

    #[test]
    fn pixels_on_posts_are_seen_as_they_are() {
        let pixels: Vec<f64> = (0..80).map(|n| f64::from(n * n % 97)).collect();
        for (posts, every) in [(1.0, 1), (0.5, 2), (0.25, 4)] {
            let colours = at_posts(&Kernel::nearest(posts), &pixels, 20.0, posts, 40);
            for (n, colour) in colours.iter().enumerate() {
                let expected = linear(&pixels, 20.0 + n as f64 / f64::from(every));
                assert!((colour - expected).abs() < 0.5, "{colour} is {expected}");
            }
        }
    }
}
