//! Text files that people write: small, and in UTF-8.

use crate::RigError;
use std::io::Read;
use std::path::Path;

/// The most that such a file may have, in bytes.
const LIMIT: u64 = 1 << 20;

/// The text of the file at `path`; `unreadable` says whose file the system does not give.
pub(crate) fn read_text(
    path: &Path,
    unreadable: impl Fn(std::io::Error) -> RigError,
) -> Result<String, RigError> {
    let file = std::fs::File::open(path).map_err(&unreadable)?;
    let mut bytes = Vec::new();
    file.take(LIMIT + 1)
        .read_to_end(&mut bytes)
        .map_err(&unreadable)?;
    let size = bytes.len() as u64;
    if size > LIMIT {
        return Err(RigError::TooLarge {
            path: path.to_owned(),
            size,
            limit: LIMIT,
        });
    }
    String::from_utf8(bytes).map_err(|error| {
        let until = error.utf8_error().valid_up_to();
        let lines = error.as_bytes()[..until].iter().filter(|&&b| b == b'\n');
        RigError::Syntax {
            file: path.display().to_string(),
            line: 1 + lines.count(),
            problem: "the text is not UTF-8; save it as such".to_owned(),
        }
    })
}
