//! Other programs that sandtable calls.

use std::io;
use std::process::{Command, Stdio};

use serde_json::json;

use super::finding::{Finding, Item};
use super::remedy::install;

pub(super) fn examine() -> Result<Finding, String> {
    let output = Command::new("ffmpeg")
        .arg("-version")
        .stdin(Stdio::null())
        .output();
    let version = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    Ok(judge(version))
}

/// Judges what `ffmpeg -version` said, or why it could not be asked.
fn judge(version: io::Result<String>) -> Finding {
    let mut finding = Finding::default();
    match version {
        Ok(said) => {
            // "ffmpeg version 5.1.9-0+deb12u1 Copyright ..."
            let version = said.split_whitespace().nth(2).unwrap_or("unknown");
            finding.found(Item::new("ffmpeg", version, json!({ "version": version })));
        }
        Err(error) => finding.advise(format!(
            "There is no ffmpeg ({error}), so flights cannot be written as .mp4 or .webm (but as \
             .avi): {}.",
            install(&["ffmpeg"])
        )),
    }
    finding
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ffmpeg_is_named_with_its_version_or_its_package() {
        let found = judge(Ok("ffmpeg version 7.1 Copyright (c) 2000-2024\n".to_owned()));
        assert_eq!(found.json()[0]["version"], "7.1");
        let missing = judge(Err(io::ErrorKind::NotFound.into()));
        assert!(missing.advice[0].contains("ffmpeg") && missing.is_empty());
    }
}
