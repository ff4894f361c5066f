//! `sandtable reproduce`: tables, and a page with every image that it links to.

use crate::formats::{xml_attributes, xml_text};
use crate::program::Folder;
use serde_json::Value;

/// Runs a paper at small sizes; gives its tables as JSON and the page's text, its images checked.
fn reproduced(folder: &Folder, paper: &str) -> (Value, String) {
    let said = folder
        .run(&format!(
            "reproduce {paper} --size 65 --frames 1 --threads 2 --out {paper} --json"
        ))
        .done()
        .out;
    let json: Value = serde_json::from_str(&said).unwrap_or_else(|e| panic!("{e} in {said}"));
    let page = folder.read(&format!("{paper}/index.html"));
    let links = xml_attributes(&page, "img", "src");
    assert!(xml_attributes(&page, "script", "src").is_empty());
    assert!(!links.is_empty(), "{paper} has no figure");
    for link in &links {
        assert!(!link.contains("//") && !link.starts_with('/'), "{link}");
        let image = image::open(folder.file(&format!("{paper}/{link}")));
        let colours = image.expect("an image").into_rgb8();
        let first = colours.get_pixel(0, 0);
        assert!(colours.pixels().any(|pixel| pixel != first), "{link}");
    }
    let listed: Vec<_> = json["images"].as_array().expect("a list").iter().collect();
    assert_eq!(listed, links.iter().collect::<Vec<_>>());
    (json, xml_text(&page))
}

/// The row of a table that begins with `first`.
fn row<'a>(table: &'a Value, first: &str) -> &'a [Value] {
    let rows = table["rows"].as_array().expect("rows").iter();
    let found = rows.clone().find(|row| row[0] == first);
    found
        .and_then(Value::as_array)
        .unwrap_or_else(|| panic!("no {first:?} in {table}"))
}

/// A number of a row.
fn number(row: &[Value], place: usize) -> f64 {
    row[place]
        .as_f64()
        .unwrap_or_else(|| panic!("no number at {place} in {row:?}"))
}

#[test]
fn wan_1999() {
    let folder = Folder::new();
    let (json, page) = reproduced(&folder, "wan1999");
    assert!(page.contains("Kaufman") && page.contains("1999"));
    let times = &json["tables"][0];
    let conventional = row(times, "conventional: each ray from the eye");
    assert_eq!(number(conventional, 1), 6.71);
    assert!(number(conventional, 3) > 0.0);
    let accurate = row(times, "accurate: coherent rays through the volume");
    assert_eq!(number(accurate, 4), 1.0);
    let roll = json["tables"].as_array().unwrap().last().unwrap();
    assert_eq!(roll["rows"].as_array().unwrap().len(), 11);
    assert_eq!(number(row(roll, "mean"), 1), 0.96);
    assert!(number(row(roll, "mean"), 4) > 0.0);
}

#[test]
fn szenberg_1997() {
    let folder = Folder::new();
    let (json, page) = reproduced(&folder, "szenberg1997");
    assert!(page.contains("Szenberg") && page.contains("1997"));
    let steps = &json["tables"][0];
    let casting = row(steps, "floating horizon, colour and depth");
    assert_eq!((number(casting, 1), number(casting, 6)), (0.05, 1.0));
    let upload = row(steps, "depth upload");
    assert!((number(upload, 2) - 2.2).abs() < 1e-9);
    // A number, or why there is none.
    assert!(upload[5].is_number() || upload[5]["refused"].is_string());
}

#[test]
fn guedes_1997() {
    let folder = Folder::new();
    let (json, page) = reproduced(&folder, "guedes1997");
    assert!(page.contains("Guedes") && page.contains("1997"));
    let times = &json["tables"][0];
    assert_eq!(number(row(times, "brute force"), 1), 4697.0);
    assert!(number(row(times, "brute force"), 4) > 1.0);
    // Correction brings the image nearer to brute force, on terrain inclined by 30°.
    let errors = json["tables"][1]["rows"].as_array().unwrap().iter();
    let error = |caster: &str| {
        let is_it = |row: &&Value| row[0] == "terrain" && row[1] == 30.0 && row[2] == caster;
        let row = errors.clone().find(is_it).expect("the caster's row");
        row[3].as_f64().expect("a share of pixels")
    };
    assert!(error("with correction") < error("without correction"));
    assert!(error("without correction") < error("naive"));
}

#[test]
fn cohen_or_1996() {
    let folder = Folder::new();
    let (json, page) = reproduced(&folder, "cohenor1996");
    assert!(page.contains("Cohen-Or") && page.contains("1996"));
    let rates = &json["tables"][0];
    let flat = rates["rows"][0].as_array().unwrap();
    assert_eq!((number(flat, 0), number(flat, 1)), (14.6, 11.0));
    assert!(number(flat, 6) > 0.0 && number(flat, 7) > 0.0);
    let schemes = &json["tables"][2];
    assert!(number(row(schemes, "column pool"), 4) > 0.0);
    assert!(number(row(&json["tables"][3], "levels, blended"), 1) > 0.0);
}

#[test]
fn nothing_is_timed_without_frames() {
    let folder = Folder::new();
    let refused = folder.run("reproduce wan1999 --frames 0");
    refused.failed(2, &["at least 1"]);
    let refused = folder.run("reproduce wan1999 --size 4");
    refused.failed(2, &["33"]);
    assert!(folder.names().is_empty());
}
