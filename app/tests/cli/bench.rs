//! `sandtable bench`: the shape of its figures, for programs and for people.

use crate::formats::xml_text;
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
    assert_eq!(lines[0]["caster"], "planes");
    assert_eq!(lines[0].get("check"), None);

    let said = folder.run(bench).done().out;
    for part in [
        "65 by 65 posts",
        "planes",
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
        ("--scheme tiles", 2, "interleave"),
        ("--rival brute", 2, "--caster 'brute'"),
    ] {
        let refused = folder.run(&format!("bench builtin:ridges?size=65 {arguments}"));
        refused.failed(code, &[says]);
    }
}

#[test]
fn schemes_and_the_work_of_rays_are_told_and_the_speeds_drawn() {
    let folder = Folder::new();
    folder.write("a.toml", VIEW.replace("[24, 16]", "[96, 64]"));
    let lines = figures(
        &folder,
        "bench builtin:ridges?size=65 --view a.toml --caster brute --caster coherent --threads 2 \
         --scheme pool --scheme interleave --frames 1 --json --plot charts/speeds.svg",
    );
    let seen: Vec<_> = lines
        .iter()
        .map(|line| [&line["caster"], &line["scheme"]].map(|it| it.as_str().unwrap()))
        .collect();
    assert_eq!(
        seen,
        [
            ["brute", "pool"],
            ["brute", "interleave"],
            ["coherent", "pool"],
            ["coherent", "interleave"]
        ]
    );
    let cells = |line: &Value| line["cells_per_ray"].as_f64().unwrap();
    for line in &lines {
        assert_eq!(line["rays"], 96 * 64, "{line}");
        assert_eq!(line["rays_per_pixel"], 1.0);
        assert_eq!(line["samples_per_ray"], 0.0);
        assert!(line["prepare_ms"].as_f64().unwrap() >= 0.0);
        assert_eq!(line.get("refused"), None);
    }
    // The work is the caster's; no scheme changes it.
    assert!(cells(&lines[0]) > 0.0);
    assert_eq!(cells(&lines[0]), cells(&lines[1]));
    assert_eq!(cells(&lines[2]), cells(&lines[3]));
    assert_ne!(cells(&lines[0]), cells(&lines[2]));

    let text = xml_text(&folder.read("charts/speeds.svg"));
    for part in [
        "builtin:ridges?size=65",
        "a.toml",
        "brute",
        "coherent",
        "2 threads, pool",
        "2 threads, interleave",
        "Mpix/s",
    ] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
}

#[test]
fn ratios_are_to_the_rival_that_is_asked_for() {
    let folder = Folder::new();
    folder.write("a.toml", VIEW);
    let bench = "bench builtin:ridges?size=65 --view a.toml --caster brute --caster coherent \
                 --threads 1 --frames 1";
    let said = folder.run(bench).done().out;
    assert!(
        said.contains("coherent on 1 threads (stealing) is"),
        "{said}"
    );
    assert!(said.contains("as fast as brute over 1 views"), "{said}");
    let said = folder.run(&format!("{bench} --rival coherent")).done().out;
    assert!(said.contains("brute on 1 threads (stealing) is"), "{said}");
    assert!(said.contains("as fast as coherent over 1 views"), "{said}");
}

#[test]
fn a_refused_view_has_its_line_and_the_others_are_timed() {
    let folder = Folder::new();
    folder.write("pitched.toml", VIEW);
    folder.write("level.toml", VIEW.replace("-20.0", "0.0"));
    let bench = "bench builtin:ridges?size=65 --view pitched.toml --view level.toml --caster \
                 floating-horizon --caster coherent --threads 1 --frames 1 --check --plot p.svg";
    let lines = figures(&folder, &format!("{bench} --json"));
    assert_eq!(lines.len(), 4);
    let refused = &lines[0];
    assert!(!refused["refused"].as_str().unwrap().is_empty());
    for key in ["median_ms", "p5_ms", "p95_ms", "mpix_per_s", "rays"] {
        assert!(refused[key].is_null(), "{key}: {refused}");
    }
    for line in &lines[1..] {
        assert_eq!(line.get("refused"), None, "{line}");
        assert!(line["median_ms"].as_f64().unwrap() > 0.0, "{line}");
    }
    assert!(xml_text(&folder.read("p.svg")).contains("refused: "));
    let said = folder.run(bench).done().out;
    assert!(said.contains(" refused: "), "{said}");

    // Where an image is all that was asked for, there is none.
    let render = "render builtin:ridges?size=65 --view pitched.toml --caster floating-horizon";
    let refused = folder.run(&format!("{render} -o i.png"));
    refused.failed(1, &["floating-horizon cannot cast this view"]);
    assert!(!folder.file("i.png").exists());
}

#[test]
fn casters_are_listed_with_what_can_be_set() {
    let folder = Folder::new();
    let said = folder.run("casters").done().out;
    assert!(said.starts_with("planes (the default)\n"), "{said}");
    assert!(said.contains("\nbrute\n"), "{said}");
    let listed = folder.run("casters --json").done().out;
    let json: Value = serde_json::from_str(&listed).unwrap();
    let horizon = json.as_array().unwrap().iter();
    let horizon = horizon
        .clone()
        .find(|caster| caster["name"] == "floating-horizon")
        .expect("the floating horizon");
    let options = horizon["options"].as_array().unwrap().iter();
    assert!(options.clone().any(|option| option["name"] == "depth"));
}
