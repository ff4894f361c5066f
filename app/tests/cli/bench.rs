//! `sandtable bench`: the shape of its figures, for programs and for people.

use crate::program::Folder;
use serde_json::Value;

const VIEW: &str = "size = [24, 16]\neye = [500.0, -200.0, 900.0]\n\
                    camera = { pitch = -20.0, horizontal_fov = 60.0 }\n";

fn figures(folder: &Folder, arguments: &str) -> Vec<Value> {
    let said = folder.run(arguments).done().out;
    let json: Value = serde_json::from_str(&said).unwrap_or_else(|e| panic!("{e} in {said}"));
    json.as_array().expect("a list").clone()
}

#[test]
fn json_is_a_list_with_the_names_that_other_programs_read() {
    let folder = Folder::new();
    folder.write("a.toml", VIEW);
    folder.write("b.toml", VIEW.replace("-20.0", "-60.0"));
    let lines = figures(
        &folder,
        "bench builtin:ridges?size=65 --view a.toml --view b.toml --caster brute \
         --caster coherent --threads 1 --threads 2 --frames 2 --check --json",
    );
    let mut seen = Vec::new();
    for line in &lines {
        let text = |key: &str| {
            line[key]
                .as_str()
                .unwrap_or_else(|| panic!("{key}: {line}"))
        };
        let number = |key: &str| {
            line[key]
                .as_f64()
                .unwrap_or_else(|| panic!("{key}: {line}"))
        };
        seen.push((text("view"), number("threads") as u32, text("caster")));
        assert!(!text("isa").is_empty());
        assert!(number("p5_ms") <= number("median_ms"), "{line}");
        assert!(number("median_ms") <= number("p95_ms"), "{line}");
        let speed = 24.0 * 16.0 / number("median_ms") / 1e3;
        assert!((number("mpix_per_s") / speed - 1.0).abs() < 1e-9, "{line}");
        assert!(number("shade_only_ms") > 0.0);
        let check = line["check"].as_object().expect("a check");
        assert!(check["over_0_1_cell"].is_u64(), "{line}");
        assert!(check.contains_key("max_cells"), "{line}");
        let psnr = &check["psnr_db"];
        assert!(
            psnr.is_null() || psnr.as_f64().is_some_and(|db| db > 20.0),
            "{line}"
        );
        if text("caster") == "brute" {
            // Against itself.
            assert_eq!(
                (&check["max_cells"], psnr),
                (&Value::from(0.0), &Value::Null)
            );
        }
    }
    let expected = ["a.toml", "b.toml"].into_iter().flat_map(|view| {
        [1, 2]
            .into_iter()
            .flat_map(move |threads| ["brute", "coherent"].map(|c| (view, threads, c)))
    });
    assert_eq!(seen, expected.collect::<Vec<_>>());
}

#[test]
fn without_a_check_there_is_none_and_without_a_caster_the_default_one() {
    let folder = Folder::new();
    folder.write("a.toml", VIEW);
    let bench = "bench builtin:ridges?size=65 --view a.toml --threads 1 --frames 1";
    let lines = figures(&folder, &format!("{bench} --json"));
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0]["caster"], "coherent");
    assert_eq!(lines[0].get("check"), None);

    let said = folder.run(bench).done().out;
    for part in [
        "65 by 65 posts",
        "coherent",
        "a.toml",
        "Mpix/s",
        "--check",
        "first picture",
    ] {
        assert!(said.contains(part), "no {part:?} in\n{said}");
    }
}

#[test]
fn what_cannot_be_timed_is_refused() {
    let folder = Folder::new();
    folder.write("a.toml", VIEW);
    for (arguments, code, says) in [
        ("--frames 0", 2, "at least 1"),
        ("--caster fast", 2, "brute"),
        ("--view none.toml", 1, "none.toml"),
    ] {
        let refused = folder.run(&format!("bench builtin:ridges?size=65 {arguments}"));
        refused.failed(code, &[says]);
    }
}
