//! Likenesses: what a ground is known again by, in a recording that holds its name only.

use sandtable_terrain::Ground;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A ground's size, heights, and a sum over all of these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Likeness {
    /// Posts from west to east and from south to north.
    posts: [u32; 2],
    /// Metres from post to post; no finer than JSON brings back to the bit.
    spacing: [f32; 2],
    /// The lowest and the highest height, in metres.
    heights: [f32; 2],
    /// Of all heights' bits; hexadecimal, as not every reader of JSON has 64 bits.
    sum: String,
}

impl Likeness {
    pub(crate) fn of(ground: &Ground) -> Self {
        let (grid, heights) = (ground.grid(), ground.heights());
        let rows = (0..grid.rows).flat_map(|row| (0..grid.cols).map(move |col| (col, row)));
        // Row by row, whatever tiles they lie in: another version's may be of another size.
        let sum = rows.fold(0u64, |sum, (col, row)| {
            let bits = u64::from(heights.post(col, row).to_bits());
            (sum.rotate_left(5) ^ bits).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        });
        Self {
            posts: [grid.cols, grid.rows],
            spacing: grid.spacing.as_vec2().to_array(),
            heights: ground.range(),
            sum: format!("{sum:016x}"),
        }
    }

    /// What tells `self` from `other`, both in words; `None` where they are alike.
    pub(crate) fn difference(&self, other: &Self) -> Option<[String; 2]> {
        if self == other {
            return None;
        }
        let words = [self.to_string(), other.to_string()];
        Some(if words[0] == words[1] {
            [
                words[0].clone(),
                "as many, some of other heights".to_owned(),
            ]
        } else {
            words
        })
    }
}

impl fmt::Display for Likeness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([cols, rows], [lowest, highest]) = (self.posts, self.heights);
        let [x, y] = self.spacing;
        write!(
            f,
            "{cols} x {rows} posts, {x} x {y} m apart, {lowest} to {highest} m high"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn likeness(cols: u32, post: impl Fn(u32, u32) -> f32 + Sync) -> Likeness {
        let ground = Ground::from_fn(cols, 3, DVec2::splat(30.0), post);
        Likeness::of(&ground.expect("a ground"))
    }

    #[test]
    fn a_ground_is_known_again_and_another_is_told_apart() {
        let slope = |col: u32, row: u32| (col * 3 + row) as f32 * 0.1;
        let one = likeness(4, slope);
        assert_eq!(one.difference(&likeness(4, slope)), None);
        let text = serde_json::to_string(&one).expect("JSON");
        assert_eq!(
            serde_json::from_str::<Likeness>(&text).ok(),
            Some(one.clone())
        );

        let wider = likeness(5, slope);
        let [was, is] = one.difference(&wider).expect("it is wider");
        assert!(was.starts_with("4 x 3 posts") && is.starts_with("5 x 3 posts"));
        // The same range and one post's height: a bump in the middle.
        let bumped = likeness(4, |col, row| match (col, row) {
            (1, 1) => 0.5,
            _ => slope(col, row),
        });
        let [_, is] = one.difference(&bumped).expect("one post is higher");
        assert!(is.contains("other heights"), "{is}");
    }
}
