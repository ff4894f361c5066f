//! Tables as plain text and as JSON.

use super::report::{Cell, Table};
use serde_json::{Value, json};
use std::fmt::Write;

/// A cell of `table` as people read it.
pub(super) fn shown(table: &Table, cell: &Cell) -> String {
    match cell {
        Cell::Refused(reason) => {
            let reasons = table.reasons();
            let place = reasons.iter().position(|other| other == reason);
            format!("({})", place.unwrap_or(reasons.len()) + 1)
        }
        Cell::Text(text) => text.clone(),
        Cell::Number(number, digits) => format!("{number:.digits$}"),
        Cell::Empty => "–".to_owned(),
    }
}

/// The table in columns, numbers to the right and words to the left; under it why some are missing.
pub(super) fn text(table: &Table) -> String {
    let cells: Vec<Vec<String>> = table
        .rows
        .iter()
        .map(|row| row.iter().map(|cell| shown(table, cell)).collect())
        .collect();
    let width = |place: usize| {
        let lengths = cells.iter().map(|row| row[place].chars().count());
        lengths.fold(table.columns[place].chars().count(), usize::max)
    };
    let widths: Vec<_> = (0..table.columns.len()).map(width).collect();
    let words: Vec<_> = (0..table.columns.len())
        .map(|place| has_words(table, place))
        .collect();
    let mut text = format!("{}\n", table.title);
    for line in std::iter::once(&table.columns).chain(&cells) {
        let mut written = String::new();
        for (place, cell) in line.iter().enumerate() {
            let width = widths[place];
            // Writing to a string does not fail.
            let _ = if words[place] {
                write!(written, "  {cell:<width$}")
            } else {
                write!(written, "  {cell:>width$}")
            };
        }
        text += written.trim_end();
        text.push('\n');
    }
    for (place, reason) in table.reasons().iter().enumerate() {
        let _ = writeln!(text, "  ({}) {reason}", place + 1);
    }
    text
}

/// Whether a column begins with words, so that it reads from the left.
pub(super) fn has_words(table: &Table, place: usize) -> bool {
    let first = table.rows.first().map(|row| &row[place]);
    matches!(first, Some(Cell::Text(_)))
}

/// The table's title, columns and rows; what is missing is null.
pub(super) fn json(table: &Table) -> Value {
    let cell = |cell: &Cell| match cell {
        Cell::Text(text) => json!(text),
        Cell::Refused(reason) => json!({ "refused": reason }),
        Cell::Number(number, _) => json!(number),
        Cell::Empty => Value::Null,
    };
    let rows: Vec<Vec<_>> = table
        .rows
        .iter()
        .map(|row| row.iter().map(cell).collect())
        .collect();
    json!({ "title": table.title, "columns": table.columns, "rows": rows })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_to_the_right_and_words_to_the_left() {
        let mut table = Table::new("Times", &["caster", "paper s", "ours ms"]);
        table.row(["brute".into(), Cell::Number(4.697, 3), Cell::Empty]);
        table.row(["inclined".into(), Cell::Empty, Cell::Number(12.25, 1)]);
        let refused = || Cell::Refused("it leans".to_owned());
        table.row(["naive".into(), refused(), refused()]);
        assert_eq!(
            text(&table),
            "Times\n  caster    paper s  ours ms\n  brute       4.697        –\n  \
             inclined        –     12.2\n  naive         (1)      (1)\n  (1) it leans\n"
        );
        let rows = &json(&table)["rows"];
        assert_eq!(rows[0], json!(["brute", 4.697, null]));
        assert_eq!(rows[2][1], json!({ "refused": "it leans" }));
    }
}
