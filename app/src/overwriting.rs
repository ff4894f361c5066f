//! Outputs that would take the place of what is read, or of one another: refused before any work.

use crate::exit::usage;
use crate::partial::Partial;
use anyhow::Result;
use std::io;
use std::path::{Path, PathBuf};

/// A file by what it is to the run, as "the photo" or "--depth", and its path as it was given.
type Named<'a> = (&'static str, &'a Path);

/// Refuses outputs that lie where an input or another output does, however the paths are written
/// and through whatever links, naming both.
pub(crate) fn refuse<'a>(
    inputs: impl IntoIterator<Item = (&'static str, Option<&'a Path>)>,
    outputs: impl IntoIterator<Item = (&'static str, Option<&'a Path>)>,
) -> Result<()> {
    let given = |(name, path): (&'static str, Option<&'a Path>)| {
        Some((name, path.filter(|path| !path.as_os_str().is_empty())?))
    };
    let inputs: Vec<Named> = inputs.into_iter().filter_map(given).collect();
    let outputs: Vec<Named> = outputs.into_iter().filter_map(given).collect();
    for (index, &output) in outputs.iter().enumerate() {
        let unfinished = Partial::beside(output.1);
        let takes = [place(output.1), place(unfinished.unfinished())];
        for &input in &inputs {
            // A folder of frames takes the place of an earlier one, with all frames in it.
            if takes.iter().any(|taken| place(input.1).starts_with(taken)) {
                return Err(clash(output, input, "which is read"));
            }
        }
        for &other in &outputs[..index] {
            if takes.contains(&place(other.1)) {
                return Err(clash(output, other, "which is written too"));
            }
        }
    }
    Ok(())
}

fn clash(output: Named, other: Named, why: &str) -> anyhow::Error {
    usage(format_args!(
        "{} {} would overwrite {} {}, {why}: give another name",
        output.0,
        output.1.display(),
        other.0,
        other.1.display()
    ))
}

/// Where a path leads, without links and dots, as far as that is there already.
fn place(path: &Path) -> PathBuf {
    let whole = || {
        let absolute = std::path::absolute(path)?;
        if let Ok(place) = absolute.canonicalize() {
            return Ok(place);
        }
        let (Some(parent), Some(name)) = (absolute.parent(), absolute.file_name()) else {
            return Ok(absolute);
        };
        Ok::<_, io::Error>(place(parent).join(name))
    };
    // Where there is no working directory, paths are compared as they are written.
    whole().unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(input: &Path, output: &Path) -> bool {
        refuse(
            [("the photo", Some(input)), ("the view", None)],
            [("-o", Some(output)), ("--depth", None)],
        )
        .is_err()
    }

    #[test]
    fn a_file_is_the_same_however_its_path_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("p.png"), "a picture").unwrap();
        std::fs::create_dir(path("more")).unwrap();
        for other in ["p.png", "./p.png", "more/../p.png", "more/.././p.png"] {
            assert!(refused(&path("p.png"), &path(other)), "{other}");
        }
        for other in ["q.png", "more/p.png", "new/p.png", "p.png.png", "p"] {
            assert!(!refused(&path("p.png"), &path(other)), "{other}");
        }
        // Neither is there yet.
        assert!(refused(&path("new/q.png"), &path("more/../new/q.png")));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_is_the_same_through_links() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("p.png"), "a picture").unwrap();
        std::os::unix::fs::symlink("p.png", path("link.png")).unwrap();
        std::os::unix::fs::symlink(".", path("here")).unwrap();
        assert!(refused(&path("link.png"), &path("p.png")));
        assert!(refused(&path("p.png"), &path("link.png")));
        assert!(refused(&path("p.png"), &path("here/p.png")));
        assert!(refused(&path("here/new.png"), &path("new.png")));
    }

    #[test]
    fn unfinished_files_and_folders_of_frames_take_places_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        assert!(refused(&path("p.png.part"), &path("p.png")));
        assert!(refused(&path("frames/frame_00000.png"), &path("frames")));
        assert!(refused(&path("frames/frame_00000.png"), &path("frames/")));
        assert!(!refused(&path("frames-of-old/p.png"), &path("frames")));
    }

    #[test]
    fn two_outputs_in_one_place_are_both_named() {
        let (one, other) = (Path::new("same.png"), Path::new("./same.png"));
        let outputs = [("-o", Some(one)), ("--depth", Some(other))];
        let error = refuse([], outputs).unwrap_err().to_string();
        assert!(
            error.contains("-o same.png") && error.contains("--depth ./same.png"),
            "{error}"
        );
    }
}
