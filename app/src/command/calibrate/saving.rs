//! Where a calibration goes: into the rig's own file, the old one kept, or into a new one.

use crate::cli::SavingArgs;
use crate::exit::usage;
use crate::notice::notice;
use crate::partial::Partial;
use crate::{files, rig};
use anyhow::{Context, Result, bail};
use sandtable_config::{Calibrated, Rig};
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use time::{Date, OffsetDateTime};

/// What will be written, and where.
pub(super) struct Destination {
    from: From,
    to: To,
}

/// The rig that is changed.
enum From {
    Builtin(String),
    File(PathBuf),
}

enum To {
    /// Standard output: the changed lines.
    DryRun,
    /// The rig's own file.
    Same(PathBuf),
    New(PathBuf),
}

impl Destination {
    /// Decides where the result goes, and sees that it can be written there before anybody
    /// measures anything.
    pub(super) fn choose(name: &str, args: &SavingArgs) -> Result<Self> {
        let from = if rig::is_file(name) {
            From::File(PathBuf::from(name))
        } else {
            From::Builtin(name.to_owned())
        };
        let to = match (&args.output, &from) {
            _ if args.dry_run => To::DryRun,
            (Some(path), _) => {
                if path.symlink_metadata().is_ok() {
                    bail!(
                        "{} exists and is never overwritten; calibrate it with --rig {0}, or name another file with -o",
                        path.display()
                    );
                }
                To::New(path.clone())
            }
            (None, From::Builtin(name)) => {
                return Err(usage(format!(
                    "the rig `{name}` is built in and stays as it is; name the file for yours with -o"
                )));
            }
            (None, From::File(path)) => {
                // A link stays one: the file that it leads to is replaced.
                let path = path
                    .canonicalize()
                    .with_context(|| format!("cannot find the rig file {}", path.display()))?;
                if path.metadata().is_ok_and(|m| m.permissions().readonly()) {
                    bail!(
                        "the rig file {} is read-only; make it writable, or name another file with -o",
                        path.display()
                    );
                }
                To::Same(path)
            }
        };
        let destination = Self { from, to };
        if let To::Same(path) | To::New(path) = &destination.to {
            files::make_folder(path)?;
            let partial = Partial::beside(path);
            File::create(partial.unfinished()).with_context(|| cannot_write(path))?;
        }
        Ok(destination)
    }

    /// What `Enter` will do, for a prompt.
    pub(super) fn enter(&self) -> String {
        match &self.to {
            To::DryRun => "Enter shows the lines that would change".to_owned(),
            To::Same(path) | To::New(path) => format!("Enter writes {}", path.display()),
        }
    }

    /// Writes the rig with `entry` in it. Whatever goes wrong, the file that was there stays, and
    /// the measured lines are printed.
    pub(super) fn save(&self, entry: &Calibrated) -> Result<()> {
        // As it is now: somebody may have changed it meanwhile.
        let (file, old) = match &self.from {
            From::Builtin(name) => (
                format!("the built-in rig `{name}`"),
                Rig::builtin_text(name)?.to_owned(),
            ),
            From::File(path) => (
                path.display().to_string(),
                Rig::load(path)?.text().to_owned(),
            ),
        };
        let today = OffsetDateTime::now_utc().date();
        let new = entry.write_into(&old, &file, today)?;
        let written = match &self.to {
            To::DryRun => {
                let mut out = std::io::stdout().lock();
                for line in changes(&old, &new) {
                    writeln!(out, "{line}")?;
                }
                return Ok(());
            }
            To::New(path) => write(path, &new, None).map(|()| {
                notice(format_args!("{} is written", path.display()));
            }),
            To::Same(path) => keep(path, &old, today).and_then(|kept| {
                write(path, &new, Some(path))?;
                notice(format_args!(
                    "{} is written; the old one is kept as {}",
                    path.display(),
                    kept.display()
                ));
                Ok(())
            }),
        };
        if written.is_err() {
            notice("not written; these are the measured lines:");
            for line in changes(&old, &new) {
                notice(line);
            }
        }
        written
    }
}

/// Writes a file that takes its name only when it is whole and on the disk, with the permissions of
/// the one that it replaces.
fn write(path: &Path, text: &str, replaced: Option<&Path>) -> Result<()> {
    let partial = Partial::beside(path);
    (|| {
        let mut file = File::create(partial.unfinished())?;
        if let Some(replaced) = replaced {
            file.set_permissions(replaced.metadata()?.permissions())?;
        }
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        drop(file);
        partial.complete()
    })()
    .with_context(|| cannot_write(path))
}

/// Keeps the rig as it was, beside itself and under the day's name, and overwrites no older one.
fn keep(path: &Path, old: &str, today: Date) -> Result<PathBuf> {
    for number in 1..1000 {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".bak-{today}"));
        if number > 1 {
            name.push(format!("-{number}"));
        }
        let kept = path.with_file_name(name);
        let created = OpenOptions::new().write(true).create_new(true).open(&kept);
        let mut file = match created {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
            created => created.with_context(|| cannot_write(&kept))?,
        };
        let whole = file
            .write_all(old.as_bytes())
            .and_then(|()| file.sync_all());
        if whole.is_err() {
            // Half a copy would only mislead.
            let _ = std::fs::remove_file(&kept);
        }
        whole.with_context(|| cannot_write(&kept))?;
        return Ok(kept);
    }
    bail!(
        "there are 999 copies of {} of {today}; move some away",
        path.display()
    )
}

fn cannot_write(path: &Path) -> String {
    format!(
        "cannot write {}; is the folder there, writable and not full?",
        path.display()
    )
}

/// The lines that `new` lacks, each behind a `-`, and those that it adds, each behind a `+`.
fn changes(old: &str, new: &str) -> Vec<String> {
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    let (mut old, mut new) = (old.as_slice(), new.as_slice());
    let mut changes = Vec::new();
    while let ([before, old_rest @ ..], [after, new_rest @ ..]) = (old, new) {
        if before == after {
            (old, new) = (old_rest, new_rest);
        } else if old_rest.contains(after) {
            changes.push(format!("- {before}"));
            old = old_rest;
        } else {
            // An entry that is changed in place: what it was, then what it is.
            if !new_rest.contains(before) {
                changes.push(format!("- {before}"));
                old = old_rest;
            }
            changes.push(format!("+ {after}"));
            new = new_rest;
        }
    }
    changes.extend(old.iter().map(|line| format!("- {line}")));
    changes.extend(new.iter().map(|line| format!("+ {line}")));
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_changed_lines_are_shown() {
        for (old, new, shown) in [
            ("a\nb\nc\n", "a\nB\nc\n", &["- b", "+ B"][..]),
            ("a\nb\nc\n", "a\nc\n", &["- b"]),
            ("a\nc\n", "a\nb\nc\n", &["+ b"]),
            ("a\n", "a\n\nb\n", &["+ ", "+ b"]),
            (
                "a\nb\nc\nd\n",
                "a\nB\nc\nD\n",
                &["- b", "+ B", "- d", "+ D"],
            ),
            ("a\n", "a\n", &[]),
        ] {
            assert_eq!(changes(old, new), shown, "{old:?} to {new:?}");
        }
    }

    #[test]
    fn a_kept_rig_overwrites_no_older_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.toml");
        let day = Date::from_calendar_date(2026, time::Month::November, 21).unwrap();
        let kept: Vec<_> = ["one", "two"]
            .map(|old| keep(&path, old, day).unwrap())
            .into();
        assert_eq!(kept[0], folder.path().join("r.toml.bak-2026-11-21"));
        assert_eq!(kept[1], folder.path().join("r.toml.bak-2026-11-21-2"));
        assert_eq!(std::fs::read_to_string(&kept[0]).unwrap(), "one");
    }
}
