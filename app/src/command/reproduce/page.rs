//! A report as one HTML page: style inline, no script, images beside it.

use super::report::{Block, Picture, Report, Table};
use super::table::{has_words, shown};
use std::fmt::Write;

const STYLE: &str = "\
:root { color-scheme: light dark; --ink: #23282f; --soft: #5d6672; --line: #d9dee4; --back: #fff; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #dfe4ea; --soft: #9aa4b0; --line: #39414b; --back: #14181d; }
}
body { margin: 0 auto; max-width: 66rem; padding: 2rem 1.25rem 4rem; color: var(--ink);
  background: var(--back); font: 1rem/1.55 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .4rem; }
h2 { font-size: 1.2rem; margin: 2.4rem 0 .6rem; }
p { max-width: 46rem; }
.citation { color: var(--soft); margin-top: 0; }
.note { color: var(--soft); font-size: .9rem; margin: .3rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--soft); padding-bottom: .35rem; }
th, td { padding: .3rem .8rem; border-bottom: 1px solid var(--line); text-align: right; }
th { font-weight: 600; vertical-align: bottom; }
.words { text-align: left; }
.figure { display: grid; gap: 1rem; margin: 1rem 0; }
figure { margin: 0; }
img { display: block; width: 100%; height: auto; border-radius: 3px; }
figcaption { color: var(--soft); font-size: .9rem; padding-top: .3rem; }
";

/// The page.
pub(super) fn html(report: &Report) -> String {
    let mut body = String::new();
    for block in &report.blocks {
        body += &match block {
            Block::Heading(text) => format!("<h2>{}</h2>\n", escaped(text)),
            Block::Paragraph(text) => format!("<p>{}</p>\n", escaped(text)),
            Block::Table(table) => table_html(table),
            Block::Figure { across, pictures } => figure_html(*across, pictures),
        };
    }
    let title = escaped(&report.title);
    let citation = escaped(report.citation);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"citation\">{citation}</p>\n{body}</body>\n</html>\n"
    )
}

fn table_html(table: &Table) -> String {
    let mut text = format!(
        "<div class=\"wide\"><table>\n<caption>{}</caption>\n",
        escaped(&table.title)
    );
    let class = |place| match has_words(table, place) {
        true => " class=\"words\"",
        false => "",
    };
    // Writing to a string does not fail.
    let mut line = |name: &str, cells: &[String]| {
        text += "<tr>";
        for (place, cell) in cells.iter().enumerate() {
            let _ = write!(text, "<{name}{}>{}</{name}>", class(place), escaped(cell));
        }
        text += "</tr>\n";
    };
    line("th", &table.columns);
    for row in &table.rows {
        let cells: Vec<_> = row.iter().map(|cell| shown(table, cell)).collect();
        line("td", &cells);
    }
    text += "</table></div>\n";
    for (place, reason) in table.reasons().iter().enumerate() {
        let _ = writeln!(
            text,
            "<p class=\"note\">({}) {}</p>",
            place + 1,
            escaped(reason)
        );
    }
    text
}

fn figure_html(across: usize, pictures: &[Picture]) -> String {
    let mut text =
        format!("<div class=\"figure\" style=\"grid-template-columns: repeat({across}, 1fr)\">\n");
    for picture in pictures {
        let caption = escaped(&picture.caption);
        let (width, height) = picture.image.dimensions();
        let _ = writeln!(
            text,
            "<figure><img src=\"{}\" width=\"{width}\" height=\"{height}\" alt=\"{caption}\"/>\
             <figcaption>{caption}</figcaption></figure>",
            escaped(&picture.file)
        );
    }
    text + "</div>\n"
}

/// Text as it may stand in HTML, within quotes too.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_cannot_end_its_element() {
        let mut report = Report::new("a < b", "\"q\" & r");
        report.paragraph("</p><script>");
        let page = html(&report);
        assert!(page.contains("<h1>a &lt; b</h1>"));
        assert!(page.contains("&quot;q&quot; &amp; r"));
        assert!(page.contains("<p>&lt;/p&gt;&lt;script&gt;</p>"));
        assert!(!page.contains("<script"));
    }
}
