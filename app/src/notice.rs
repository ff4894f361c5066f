//! Lines for people beside a result that goes to a file.

use std::fmt::Display;
use std::io::Write;

/// Prints a line. Where nobody reads it any more, the work goes on: its result is the file.
pub(crate) fn notice(line: impl Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}
