//! Elements of drawings, as SVG.

use std::fmt::Write;

pub(crate) const THIN: &str = "stroke=\"#555\" stroke-dasharray=\"4 3\"";
pub(crate) const EARTH: &str = "fill=\"#d8c8a8\" stroke=\"#806840\"";

/// A drawing of its elements.
pub(crate) fn document([width, height]: [f64; 2], elements: &str) -> String {
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="14">
<rect width="{width}" height="{height}" fill="white"/>
{elements}</svg>
"#
    )
}

/// An element from one place to another.
pub(crate) fn stroke([x1, y1]: [f64; 2], [x2, y2]: [f64; 2], style: &str) -> String {
    format!("<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {style}/>\n")
}

pub(crate) fn label([x, y]: [f64; 2], text: &str, style: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{text}</text>\n")
}

pub(crate) fn dot([x, y]: [f64; 2], fill: &str) -> String {
    format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{fill}\"/>\n")
}

/// A filled outline from a line's places down to the drawing's foot.
pub(crate) fn filled(
    foot: f64,
    places: impl Iterator<Item = [f64; 2]>,
    [from, to]: [f64; 2],
    style: &str,
) -> String {
    let mut path = format!("<path d=\"M{from:.1} {foot:.1}");
    for [x, y] in places {
        // Writing to a string cannot fail.
        let _ = write!(path, " L{x:.1} {y:.1}");
    }
    path + &format!(" L{to:.1} {foot:.1} Z\" {style}/>\n")
}
