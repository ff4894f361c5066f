//! `--help` and `--version`.

use crate::program::Folder;

#[test]
fn every_command_that_takes_something_has_an_example() {
    let folder = Folder::new();
    for command in [
        "fly",
        "info",
        "render",
        "casters",
        "bench",
        "reproduce",
        "simulate",
        "simulate flock",
        "record",
        "serve-vrpn",
        "calibrate",
        "calibrate tracker",
        "calibrate stylus",
        "calibrate eyes",
        "calibrate check",
    ] {
        let said = folder.run(&format!("{command} --help")).done().out;
        let (_, examples) = said
            .split_once("\nExample")
            .unwrap_or_else(|| panic!("no example in\n{said}"));
        assert!(
            examples.contains(&format!("  sandtable {command}")),
            "{examples}"
        );
    }
}

#[test]
fn the_simulated_flocks_help_lists_its_motions() {
    let said = Folder::new().run("simulate flock --help").done().out;
    for motion in ["still", "circle", "sway-right"] {
        assert!(said.contains(motion), "no {motion:?} in\n{said}");
    }
}

#[test]
fn renders_help_says_that_a_view_or_a_path_is_needed_and_how_a_view_is_written() {
    let folder = Folder::new();
    let said = folder.run("render --help").done().out;
    let usage = said.lines().find(|line| line.starts_with("Usage:"));
    assert!(
        usage.is_some_and(|line| line.contains("<--view <FILE>|--path <FILE>>")),
        "{said}"
    );
    assert!(said.contains("docs/views.md"), "{said}");
    // The view in the help is one.
    let lines = said.lines().map(str::trim_start);
    let keys = ["size = ", "eye = ", "camera = "];
    let view = lines.filter(|line| keys.iter().any(|key| line.starts_with(key)));
    folder.write("v.toml", view.collect::<Vec<_>>().join("\n"));
    folder
        .run("render builtin:ridges?size=33 --view v.toml -o i.png")
        .done();
}

#[test]
fn the_program_lists_its_commands_and_tells_its_version() {
    let folder = Folder::new();
    let said = folder.run("--help").done().out;
    for command in [
        "fly",
        "info",
        "render",
        "casters",
        "bench",
        "reproduce",
        "simulate",
        "record",
        "calibrate",
        "doctor",
    ] {
        let listed = said
            .lines()
            .any(|line| line.trim_start().starts_with(command));
        assert!(listed, "no {command} in\n{said}");
        folder.run(&format!("{command} --help")).done();
    }
    let said = folder.run("--version").done().out;
    assert_eq!(
        said.trim(),
        concat!("sandtable ", env!("CARGO_PKG_VERSION"))
    );
}

#[test]
fn what_is_not_an_argument_is_bad_usage() {
    let folder = Folder::new();
    folder
        .run("fly --stereo cross-eyed")
        .failed(2, &["anaglyph"]);
    folder.run("render --veiw v.toml").failed(2, &["--veiw"]);
    folder
        .run("render --scheme tiles")
        .failed(2, &["interleave"]);
    folder.run("reproduce he2009").failed(2, &["wan1999"]);
    folder
        .run("fly --replay a.mcap --rig desktop")
        .failed(2, &["--replay", "--rig"]);
}
