//! GPX files, and where in them something is wrong.

use anyhow::{Context, Result, anyhow, bail};
use gpx::Gpx;
use gpx::errors::GpxError;
use std::cell::Cell;
use std::io::{self, Read};
use std::path::Path;

/// Reads a GPX file; an error names the line.
pub(super) fn read(path: &Path) -> Result<Gpx> {
    if path.is_dir() {
        bail!(
            "{} is a folder and no GPX file; name a file in it",
            path.display()
        );
    }
    let text = std::fs::read(path).with_context(|| {
        format!(
            "cannot read the track {}; check that the file is there and may be read",
            path.display()
        )
    })?;
    parse(&text).map_err(|(line, error)| {
        anyhow!(
            "{} is not a GPX file that can be read: line {line}: {}; \
             correct it there, or export the track anew",
            path.display(),
            problem(&error)
        )
    })
}

/// The content of a GPX file, or the line up to which it could be read and what is wrong there.
fn parse(text: &[u8]) -> Result<Gpx, (usize, GpxError)> {
    let read = Cell::new(0);
    gpx::read(Counted { text, read: &read }).map_err(|error| {
        let before = &text[..read.get().saturating_sub(1)];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        (line, error)
    })
}

/// Gives a byte at a time, as the parser takes them, so that it is known how far it came.
struct Counted<'a> {
    text: &'a [u8],
    read: &'a Cell<usize>,
}

impl Read for Counted<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let next = self.text.get(self.read.get());
        let (Some(&byte), Some(into)) = (next, into.first_mut()) else {
            return Ok(0);
        };
        *into = byte;
        self.read.set(self.read.get() + 1);
        Ok(1)
    }
}

/// What is wrong, where the parser's own words do not say it.
fn problem(error: &GpxError) -> String {
    match error {
        GpxError::ParseFloatError(_) | GpxError::ParseIntegerError(_) => {
            "something else stands where a number should".to_owned()
        }
        GpxError::Iso8601Error(_) => "a time is not written as 2026-05-01T10:00:00Z is".to_owned(),
        GpxError::XmlParseError(error) => error.msg().to_owned(),
        GpxError::TrackSegmentError()
        | GpxError::EventParsingError(_)
        | GpxError::MetadataParsingError() => "the XML is broken".to_owned(),
        GpxError::UnknownVersionError(_) => "it is of neither GPX 1.0 nor 1.1".to_owned(),
        error => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(points: &str) -> (usize, String) {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<gpx version=\"1.1\" creator=\"a test\" \
             xmlns=\"http://www.topografix.com/GPX/1/1\"><trk><trkseg>\n\
             <trkpt lat=\"1\" lon=\"2\"><ele>3</ele></trkpt>\n{points}\n</trkseg></trk></gpx>\n"
        );
        let (line, error) = parse(text.as_bytes()).expect_err(points);
        (line, problem(&error))
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (points, line, says) in [
            ("<trkpt lat=\"1,5\" lon=\"2\"/>", 4, "a number"),
            (
                "<trkpt lat=\"1\" lon=\"2\"><ele>high</ele></trkpt>",
                4,
                "a number",
            ),
            ("\n\n<trkpt lat=\"91\" lon=\"2\"/>", 6, "latitude"),
            (
                "<trkpt lat=\"1\" lon=\"2\"><time>noon</time></trkpt>",
                4,
                "a time",
            ),
            ("\n<spot/>", 5, "spot"),
            ("\n& more", 5, ""),
            ("</trkpt>", 4, "broken"),
        ] {
            let (found, said) = refused(points);
            assert_eq!(found, line, "{points}: {said}");
            assert!(said.contains(says), "{points}: {said}");
        }
        assert!(parse(b"no track").is_err() && parse(b"").is_err());
    }
}
