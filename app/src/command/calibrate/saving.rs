//! Where a calibration goes: into the rig's own file, the old one kept, or into a new one; what is
//! too much for a rig goes into a file beside it.

use super::dialogue::Dialogue;
use crate::cli::SavingArgs;
use crate::exit::usage;
use crate::partial::Partial;
use crate::{files, rig};
use anyhow::{Context, Result, bail};
use sandtable_config::{Calibrated, FieldCorrection, Rig};
use sandtable_field::Correction;
use sandtable_pose::Rigid;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use time::{Date, OffsetDateTime};

/// What will be written, and where.
pub(super) struct Destination {
    from: From,
    to: To,
    dialogue: Dialogue,
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
    /// measures anything. `rig` is the one called `name`.
    pub(super) fn choose(
        name: &str,
        args: &SavingArgs,
        rig: &Rig,
        dialogue: &Dialogue,
    ) -> Result<Self> {
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
                for (file, text) in rig.files() {
                    let there = beside(path, &file);
                    if std::fs::read(&there).is_ok_and(|found| found != text.as_bytes()) {
                        bail!(
                            "{} exists and is another than the one of {name}; name a file in another folder with -o",
                            there.display()
                        );
                    }
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
        let dialogue = dialogue.clone();
        let destination = Self { from, to, dialogue };
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

    /// The name of the file for a correction of `device`'s field, beside the rig; sees that it can be
    /// written.
    pub(super) fn field_file(&self, device: &str) -> Result<String> {
        let rig = match (&self.to, &self.from) {
            (To::Same(path) | To::New(path), _) | (To::DryRun, From::File(path)) => path,
            (To::DryRun, From::Builtin(name)) => Path::new(name),
        };
        let stem = rig.file_stem().unwrap_or_default().to_string_lossy();
        // As a rig may name it.
        let stem = stem.replace(|c: char| c.is_control() || c == '\\' || c == ':', "-");
        let file = format!("{stem}.{device}-field.toml");
        match &self.to {
            To::DryRun => {}
            To::New(rig) => {
                let path = beside(rig, &file);
                if path.symlink_metadata().is_ok() {
                    bail!(
                        "{} exists and is never overwritten; name another rig with -o",
                        path.display()
                    );
                }
            }
            To::Same(rig) => {
                let path = beside(rig, &file);
                match path.metadata() {
                    Ok(found) if !found.is_file() || found.permissions().readonly() => bail!(
                        "{} is no file that can be replaced; make it writable, or move it away",
                        path.display()
                    ),
                    _ => {}
                }
            }
        }
        Ok(file)
    }

    /// Writes `correction` into `file` and its name into the rig, for the tracker `device`, which
    /// stood at `table_from_tracker`. Whatever goes wrong, the files that were there stay, and what
    /// was measured is printed.
    pub(super) fn save_field(
        &self,
        device: &str,
        file: &str,
        correction: &Correction,
        table_from_tracker: &Rigid,
    ) -> Result<()> {
        let today = OffsetDateTime::now_utc().date();
        let text = FieldCorrection::compose(device, correction, table_from_tracker, today);
        let entry = Calibrated::Field {
            device: device.to_owned(),
            file: file.to_owned(),
        };
        let measured = BTreeMap::from([(file.to_owned(), text)]);
        let saved = self.save_with(&entry, &measured, today);
        if saved.is_err() {
            // Touching all marks again would take far longer than to copy this.
            self.dialogue
                .result(format_args!("this is what was measured, for {file}:"));
            measured
                .values()
                .for_each(|text| self.dialogue.result(text));
        }
        saved
    }

    /// Writes the rig with `entry` in it. Whatever goes wrong, the file that was there stays, and
    /// the measured lines are printed.
    pub(super) fn save(&self, entry: &Calibrated) -> Result<()> {
        let today = OffsetDateTime::now_utc().date();
        self.save_with(entry, &BTreeMap::new(), today)
    }

    /// The same, and before it the files that were measured, by the names that the rig will have
    /// for them.
    fn save_with(
        &self,
        entry: &Calibrated,
        measured: &BTreeMap<String, String>,
        today: Date,
    ) -> Result<()> {
        // As it is now: somebody may have changed it meanwhile.
        let (called, rig) = match &self.from {
            From::Builtin(name) => (format!("the built-in rig `{name}`"), Rig::builtin(name)?),
            From::File(path) => (path.display().to_string(), Rig::load(path)?),
        };
        let old = rig.text();
        let new = entry.write_into(old, &called, today)?;
        let mut files = rig.files();
        files.extend(measured.clone());
        // It reads as it was measured, and names no file that it does not need.
        let files = Rig::parse_with(&new, &called, &files)?.files();
        let written = match &self.to {
            To::DryRun => {
                let mut out = std::io::stdout().lock();
                for line in changes(old, &new) {
                    writeln!(out, "{line}")?;
                }
                for (name, text) in measured {
                    writeln!(out, "+ {name}, a file of {} lines", text.lines().count())?;
                }
                return Ok(());
            }
            To::New(path) => self.write_new(path, &new, &files),
            To::Same(path) => self.replace(path, old, &new, measured, today),
        };
        if written.is_err() {
            self.dialogue
                .result("not written; these are the measured lines:");
            for line in changes(old, &new) {
                self.dialogue.result(line);
            }
        }
        written
    }

    /// Writes a new rig, behind the files that it names.
    fn write_new(&self, path: &Path, rig: &str, files: &BTreeMap<String, String>) -> Result<()> {
        for (name, text) in files {
            let file = beside(path, name);
            match std::fs::read(&file) {
                // The old rig's own, of which the new one is a neighbour.
                Ok(found) if found == text.as_bytes() => continue,
                Ok(_) => bail!("{} exists and is never overwritten", file.display()),
                Err(_) => files::make_folder(&file)?,
            }
            write(&file, text, None)?;
            self.dialogue
                .result(format_args!("{} is written", file.display()));
        }
        write(path, rig, None)?;
        self.dialogue
            .result(format_args!("{} is written", path.display()));
        Ok(())
    }

    /// Writes the rig and, before it, the files that were measured, each in place of its old one, which
    /// is kept: a rig names only what is there.
    fn replace(
        &self,
        path: &Path,
        old: &str,
        new: &str,
        measured: &BTreeMap<String, String>,
        today: Date,
    ) -> Result<()> {
        for (name, text) in measured {
            let file = beside(path, name);
            match std::fs::read(&file) {
                Ok(old) => self.keep_and_write(&file, &old, text, today)?,
                Err(error) if error.kind() == ErrorKind::NotFound => {
                    write(&file, text, None)?;
                    self.dialogue
                        .result(format_args!("{} is written", file.display()));
                }
                Err(error) => {
                    return Err(error).with_context(|| format!("cannot read {}", file.display()));
                }
            }
        }
        if new == old {
            return Ok(());
        }
        self.keep_and_write(path, old.as_bytes(), new, today)
    }

    fn keep_and_write(&self, path: &Path, old: &[u8], new: &str, today: Date) -> Result<()> {
        let kept = keep(path, old, today)?;
        write(path, new, Some(path))?;
        self.dialogue.result(format_args!(
            "{} is written; the old one is kept as {}",
            path.display(),
            kept.display()
        ));
        Ok(())
    }
}

/// The file that a rig calls `name`.
fn beside(rig: &Path, name: &str) -> PathBuf {
    rig.parent().unwrap_or(Path::new("")).join(name)
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

/// Keeps a file as it was, beside itself and under the day's name, and overwrites no older one.
fn keep(path: &Path, old: &[u8], today: Date) -> Result<PathBuf> {
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
        let whole = file.write_all(old).and_then(|()| file.sync_all());
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
    fn a_new_rig_elsewhere_takes_the_files_along_that_it_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let text = Rig::builtin_text("workbench").unwrap();
        let field = Calibrated::Field {
            device: "flock".into(),
            file: "w.flock-field.toml".into(),
        };
        let day = Date::from_calendar_date(2026, time::Month::November, 21).unwrap();
        let named = field.write_into(text, "w.toml", day).unwrap();
        std::fs::write(at("w.toml"), named).unwrap();
        let mut straight = Rig::parse(text, "w.toml").unwrap();
        let device = straight.devices.get_mut("flock").unwrap();
        let place = *device.table_from_tracker_mut().unwrap();
        let correction = FieldCorrection::compose("flock", &Correction::identity(), &place, day);
        std::fs::write(at("w.flock-field.toml"), &correction).unwrap();

        let rig = Rig::load(&at("w.toml")).unwrap();
        let (telling, _heard) = crossbeam_channel::unbounded();
        let never = (crossbeam_channel::never(), crossbeam_channel::never());
        let dialogue = Dialogue::in_window(telling, never.0, never.1);
        let choose = |to: &str| {
            let args = SavingArgs {
                output: Some(at(to)),
                dry_run: false,
            };
            Destination::choose(at("w.toml").to_str().unwrap(), &args, &rig, &dialogue)
        };
        let stylus = Calibrated::Stylus {
            sensor: rig.sensor("flock/2").unwrap(),
            tip: glam::DVec3::X * 0.1,
        };
        for (to, beside) in [
            ("other/new.toml", "other/w.flock-field.toml"),
            ("same.toml", "w.flock-field.toml"),
        ] {
            choose(to).unwrap().save(&stylus).unwrap();
            assert_eq!(std::fs::read_to_string(at(beside)).unwrap(), correction);
            let new = Rig::load(&at(to)).unwrap();
            assert_eq!(new.devices, rig.devices);
        }
        // One of another rig is not taken for this one's.
        std::fs::write(at("other/w.flock-field.toml"), "another").unwrap();
        let refused = choose("other/newer.toml").err().unwrap().to_string();
        assert!(refused.contains("w.flock-field.toml exists"), "{refused}");
        // A tracker that is calibrated anew needs none.
        let tracker = Calibrated::Tracker {
            device: "flock".into(),
            table_from_tracker: place,
        };
        choose("third/new.toml").unwrap().save(&tracker).unwrap();
        assert!(!at("third/w.flock-field.toml").exists());
    }

    #[test]
    fn a_kept_rig_overwrites_no_older_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.toml");
        let day = Date::from_calendar_date(2026, time::Month::November, 21).unwrap();
        let kept: Vec<_> = ["one", "two"]
            .map(|old| keep(&path, old.as_bytes(), day).unwrap())
            .into();
        assert_eq!(kept[0], folder.path().join("r.toml.bak-2026-11-21"));
        assert_eq!(kept[1], folder.path().join("r.toml.bak-2026-11-21-2"));
        assert_eq!(std::fs::read_to_string(&kept[0]).unwrap(), "one");
    }
}
