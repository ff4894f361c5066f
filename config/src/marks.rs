//! Marks: places at the table that were measured with a ruler, to be touched or sighted over.

use crate::RigError;
use crate::beside::Beside;
use crate::fields::{Fields, Source};
use crate::rigid::REACH;
use crate::text_file::read_text;
use glam::DVec3;
use std::path::Path;
use toml::de::DeTable;

/// A mark of known place.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What people call it.
    pub name: String,
    /// Where it is: table frame, metres.
    pub place: DVec3,
}

/// Reads a file of marks, in its own order: a table `marks` whose keys are the marks' names and
/// whose values are their places, as `"front left" = [-0.90, -0.55, 0.0]`.
///
/// # Errors
/// Where the file cannot be read, is not TOML, has no marks, or holds anything else.
pub fn load_marks(path: &Path) -> Result<Vec<Mark>, RigError> {
    let text = read_text(path, |source| RigError::MarksUnreadable {
        path: path.to_owned(),
        source,
    })?;
    parse_marks(&text, &path.display().to_string())
}

fn parse_marks(text: &str, file: &str) -> Result<Vec<Mark>, RigError> {
    let source = Source {
        file,
        text,
        beside: Beside::Unread,
    };
    let table = DeTable::parse(text).map_err(|error| source.syntax(&error))?;
    let root = Fields::root(source, table.get_ref());
    let remedy = "write [marks], and below it a mark a line, as \"front left\" = [x, y, z]";
    let value = root.need("marks", remedy)?;
    root.finish()?;
    let fields = value.fields()?;
    let mut marks = Vec::new();
    for name in fields.keys() {
        let Some(value) = fields.get(&name) else {
            continue;
        };
        if name.trim().is_empty() || name.chars().count() > 80 || name.chars().any(char::is_control)
        {
            return Err(value.error(
                "is not a mark's name",
                "write what people call it, on one line",
            ));
        }
        let place = value.numbers::<3>(-REACH..=REACH, "metres")?;
        marks.push(Mark {
            name,
            place: DVec3::from_array(place),
        });
    }
    if marks.is_empty() {
        return Err(value.error("is empty", remedy));
    }
    Ok(marks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_keep_the_files_order_and_their_errors_name_the_line() {
        let text = "[marks]\n\"z first\" = [0, 0.5, 0.25]\na = [1.0, 2.0, 3.0]\n";
        let marks = parse_marks(text, "m.toml").unwrap();
        let names: Vec<&str> = marks.iter().map(|mark| mark.name.as_str()).collect();
        assert_eq!(names, ["z first", "a"]);
        assert_eq!(marks[0].place, DVec3::new(0.0, 0.5, 0.25));

        let error = |text| parse_marks(text, "m.toml").unwrap_err().to_string();
        for (text, says) in [
            ("[marks]\na = [1.0, 2.0\n", &["m.toml, line 2", "TOML"][..]),
            (
                "[marks]\na = [1.0, 2.0]\n",
                &["line 2", "marks.a", "2 elements"],
            ),
            (
                "[marks]\na = [900, 2.0, 1]\n",
                &["line 2", "is 900", "metres"],
            ),
            ("[marks]\n", &["line 1", "is empty"]),
            ("[mraks]\na = [1, 2, 3]\n", &["did you mean `marks`"]),
            ("", &["`marks` is missing", "[x, y, z]"]),
            ("[marks]\n[other]\n", &["`other` is unknown"]),
            ("[marks]\n\"\\n\" = [1, 2, 3]\n", &["not a mark's name"]),
        ] {
            let error = error(text);
            for part in says {
                assert!(error.contains(part), "no {part:?} in {error}");
            }
        }
    }
}
