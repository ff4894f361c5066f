//! Terrains and views as raw files, so that figures can be compared with another bench's.
//!
//! For N by N posts, in cells: `tN.f32` has heights (32-bit little-endian floats, row by row from
//! the south), `tN.rgb` a colour for each, and `tN.VIEW.cam`, in text, a view: width and height,
//! eye, direction through the centre of pixel (0, 0), step a column, step a row.

use super::photo::over;
use anyhow::{Context, Result, ensure};
use glam::{DVec2, DVec3};
use sandtable_cast::standpoints::Standpoint;
use sandtable_terrain::{Ground, TiledRaster};
use sandtable_view::{Screen, View};
use std::fs;
use std::path::Path;

/// The views, as we and as the files call them.
const VIEWS: [(&str, &str); 7] = [
    ("wan0", "wan0"),
    ("wan45", "wan45"),
    ("low", "low"),
    ("low45", "low45"),
    ("left", "wbL"),
    ("right", "wbR"),
    ("down", "down"),
];

/// The terrain of `side` by `side` posts in `folder`, with a cell of a metre, and its views.
pub(super) fn scene(folder: &Path, side: u32) -> Result<(Ground, Vec<Standpoint>)> {
    let file = |ending: &str| folder.join(format!("t{side}.{ending}"));
    let at = |col: u32, row: u32| row as usize * side as usize + col as usize;
    let heights = read(&file("f32"), side, 4)?;
    let ground = Ground::from_fn(side, side, DVec2::ONE, |col, row| {
        let bytes = &heights[4 * at(col, row)..][..4];
        f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
    })?;
    let colours = read(&file("rgb"), side, 3)?;
    let pixels = TiledRaster::from_fn(side, side, |col, row| {
        let bytes = &colours[3 * at(col, row)..][..3];
        [bytes[0], bytes[1], bytes[2], 255]
    });
    let views = VIEWS.into_iter().map(|(name, theirs)| {
        let path = file(&format!("{theirs}.cam"));
        let text = fs::read_to_string(&path);
        let view = text.map_err(Into::into).and_then(|text| view(&text));
        Ok(Standpoint {
            name: name.to_owned(),
            view: view.with_context(|| format!("cannot read {}", path.display()))?,
        })
    });
    Ok((over(ground, pixels), views.collect::<Result<_>>()?))
}

/// The whole of a file of `side`² values of `size` bytes.
fn read(path: &Path, side: u32, size: usize) -> Result<Vec<u8>> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let expected = side as usize * side as usize * size;
    ensure!(
        bytes.len() == expected,
        "{} has {} bytes, and {side} by {side} posts take {expected}",
        path.display(),
        bytes.len()
    );
    Ok(bytes)
}

/// The view that the text of a `.cam` file tells.
fn view(text: &str) -> Result<View> {
    let numbers = text.split_whitespace().map(str::parse);
    let numbers = numbers.collect::<Result<Vec<f64>, _>>()?;
    ensure!(
        numbers.len() == 14,
        "14 numbers make a view, not {}",
        numbers.len()
    );
    let vector = |at: usize| DVec3::from_slice(&numbers[at..]);
    let (eye, first, right, down) = (vector(2), vector(5), vector(8), vector(11));
    let upper_left = eye + first - 0.5 * (right + down);
    let lower_left = upper_left + numbers[1] * down;
    Ok(View {
        eye,
        window: Screen {
            lower_left,
            lower_right: lower_left + numbers[0] * right,
            upper_left,
        },
        size: [numbers[0] as u32, numbers[1] as u32],
    })
}
