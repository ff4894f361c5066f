//! What is told about a paper: prose, tables and figures, in the order of reading.

use image::RgbaImage;

/// A report on one paper.
pub(super) struct Report {
    /// What was done again.
    pub(super) title: String,
    /// Authors, title, where and when.
    pub(super) citation: &'static str,
    pub(super) blocks: Vec<Block>,
}

/// A piece of a report.
pub(super) enum Block {
    Heading(String),
    Paragraph(String),
    Table(Table),
    /// Pictures that belong together, in rows of `across`.
    Figure {
        across: usize,
        pictures: Vec<Picture>,
    },
}

/// One image of a figure.
pub(super) struct Picture {
    /// Its file in the report's folder.
    pub(super) file: String,
    pub(super) caption: String,
    pub(super) image: RgbaImage,
}

/// Numbers under headings. Each row has as many cells as there are columns.
pub(super) struct Table {
    pub(super) title: String,
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<Vec<Cell>>,
}

/// One place in a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    Text(String),
    /// A number and how many digits of it are shown after the point.
    Number(f64, usize),
    /// Nothing: the paper, or we, have no such number.
    Empty,
    /// Why there is no number; told under the table.
    Refused(String),
}

impl Cell {
    /// A paper's number, where it gives one.
    pub(super) fn quoted(number: Option<f64>, digits: usize) -> Self {
        number.map_or(Self::Empty, |number| Self::Number(number, digits))
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<usize> for Cell {
    fn from(number: usize) -> Self {
        Self::Number(number as f64, 0)
    }
}

impl Table {
    /// A table without rows.
    pub(super) fn new(title: impl Into<String>, columns: &[&str]) -> Self {
        Self {
            title: title.into(),
            columns: columns.iter().map(|&column| column.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Why numbers are missing, each reason once, in the order of the rows.
    pub(super) fn reasons(&self) -> Vec<&str> {
        let mut reasons = Vec::new();
        for cell in self.rows.iter().flatten() {
            if let Cell::Refused(reason) = cell
                && !reasons.contains(&reason.as_str())
            {
                reasons.push(reason);
            }
        }
        reasons
    }

    /// Adds a row.
    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        let cells: Vec<_> = cells.into_iter().collect();
        debug_assert_eq!(cells.len(), self.columns.len(), "in {}", self.title);
        self.rows.push(cells);
    }
}

impl Report {
    /// A report in which nothing is told yet.
    pub(super) fn new(title: impl Into<String>, citation: &'static str) -> Self {
        Self {
            title: title.into(),
            citation,
            blocks: Vec::new(),
        }
    }

    pub(super) fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading(text.into()));
    }

    pub(super) fn paragraph(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Paragraph(text.into()));
    }

    pub(super) fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    pub(super) fn figure(&mut self, across: usize, pictures: Vec<Picture>) {
        if !pictures.is_empty() {
            self.blocks.push(Block::Figure { across, pictures });
        }
    }

    /// All tables, in order.
    pub(super) fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        })
    }

    /// All pictures, in order.
    pub(super) fn pictures(&self) -> impl Iterator<Item = &Picture> {
        self.blocks.iter().flat_map(|block| match block {
            Block::Figure { pictures, .. } => pictures.as_slice(),
            _ => &[],
        })
    }
}
