//! `sandtable info`: JSON against figures from GDAL, and the text for people.

use crate::program::Ended;
use crate::program::{Folder, sandtable, shared_data};
use serde_json::Value;

/// Within a relative 1e-6, list by list.
fn is_near(found: &Value, expected: &Value) -> bool {
    match (found, expected) {
        (Value::Array(found), Value::Array(expected)) => {
            found.len() == expected.len() && found.iter().zip(expected).all(|(f, e)| is_near(f, e))
        }
        _ => match (found.as_f64(), expected.as_f64()) {
            (Some(found), Some(expected)) => {
                (found - expected).abs() <= 1e-6 * expected.abs().max(1e-3)
            }
            _ => found == expected,
        },
    }
}

/// The number of "(EPSG:26710)" in a CRS's text.
fn epsg(crs: &str) -> Option<u64> {
    let (_, code) = crs.split_once("(EPSG:")?;
    code.trim_end_matches(')').parse().ok()
}

#[test]
fn every_shared_file_reads_as_gdal_reads_it() {
    let Some(data) = shared_data() else { return };
    let text = std::fs::read(data.join("expected.json")).unwrap();
    let expected: Value = serde_json::from_slice(&text).unwrap();
    let folder = Folder::new();
    let files = expected.as_object().unwrap();
    assert!(files.len() >= 13);
    for (name, expected) in files {
        let mut command = sandtable(folder.path());
        command.args(["info", "--json"]).arg(data.join(name));
        let samples = expected["samples"].as_array().unwrap();
        for sample in samples {
            command.arg(format!("--cell={},{}", sample["col"], sample["row"]));
        }
        let found: Value = serde_json::from_str(&Ended::of(&mut command).done().out).unwrap();
        for key in ["width", "height", "bands", "dtype", "driver"] {
            assert_eq!(found[key], expected[key], "{name}: {key}");
        }
        for key in ["geotransform", "extent_outer_pixel_edges"] {
            let (found, expected) = (&found[key], &expected[key]);
            let near = match expected.as_object() {
                Some(sides) => sides.iter().all(|(side, e)| is_near(&found[side], e)),
                None => is_near(found, expected),
            };
            assert!(near, "{name}: {key} {found} {expected}");
        }
        let code = epsg(expected["crs"].as_str().unwrap());
        assert!(
            // Some grids name no code, though their CRS has one.
            code.is_none() || found["epsg"].as_u64() == code,
            "{name}: {}",
            found["epsg"]
        );
        let bands = expected["band_info"].as_array().unwrap();
        assert_eq!(found["band_info"].as_array().unwrap().len(), bands.len());
        for (band, expected) in found["band_info"].as_array().unwrap().iter().zip(bands) {
            for key in ["valid", "invalid"] {
                assert_eq!(band[key], expected[key], "{name}: {key}");
            }
            for key in ["nodata", "min", "max", "mean"] {
                let (found, expected) = (&band[key], &expected[key]);
                assert!(is_near(found, expected), "{name}: {key} {found} {expected}");
            }
        }
        let cells = found["samples"].as_array().unwrap();
        assert_eq!(cells.len(), samples.len(), "{name}");
        for (cell, sample) in cells.iter().zip(samples) {
            for key in ["col", "row", "x", "y", "value", "nodata"] {
                let (found, expected) = (&cell[key], &sample[key]);
                assert!(is_near(found, expected), "{name}: {key} {cell} {sample}");
            }
        }
    }
}

/// Two columns, two rows and a hole, in metres.
const GRID: &str = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 100\ncellsize 30\nNODATA_value -1\n\
                    7 8\n-1 12\n";

#[test]
fn people_read_size_extent_statistics_and_cells() {
    let folder = Folder::new();
    folder.write("grid.asc", GRID);
    let said = folder.run("info grid.asc --cell 1,0 --cell 0,1").done().out;
    for line in [
        "AAIGrid, 2 by 2 cells",
        "30 by 30",
        "west 0, south 100, east 60, north 160",
        "7 to 12, mean 9.000, 3 valid, 1 without a value (nodata -1)",
        "cell 1,0 at 45, 145: 8",
        "cell 0,1 at 15, 115: -1 (nodata)",
    ] {
        assert!(said.contains(line), "no {line:?} in\n{said}");
    }
}

#[test]
fn a_builtin_terrain_is_said_to_be_no_file() {
    let folder = Folder::new();
    for name in ["builtin:jacksboro", "builtin:ridges?size=65"] {
        folder
            .run(&format!("info {name}"))
            .failed(2, &[name, "is built in", "render"]);
    }
    folder
        .run("info builtin:alps")
        .failed(2, &["alps", "builtin:jacksboro"]);
}

#[test]
fn a_cell_outside_is_refused_with_the_range() {
    let folder = Folder::new();
    folder.write("grid.asc", GRID);
    let outside = folder.run("info grid.asc --cell 2,0");
    outside.failed(1, &["grid.asc", "2,0", "from 0 to 1"]);
    let odd = folder.run("info grid.asc --cell 2x0");
    odd.failed(2, &["2x0", "COLUMN,ROW"]);
}
