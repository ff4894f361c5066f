//! Every file of `../shared/data` reads as GDAL reads it, and opens as terrain or photograph.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use sandtable_terrain::{Crs, FileInfo, TerrainSource, info, open};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The folder of real data, or `None` with a message where this checkout has none.
fn data() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: there is no {}", folder.display());
    None
}

fn near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

fn check_numbers(place: &str, found: &Value, expected: &Value, relative: f64) {
    match (found, expected) {
        (Value::Array(found), Value::Array(expected)) => {
            assert_eq!(found.len(), expected.len(), "{place}");
            for (found, expected) in found.iter().zip(expected) {
                check_numbers(place, found, expected, relative);
            }
        }
        (Value::Number(found), Value::Number(expected)) => {
            let (found, expected) = (found.as_f64().unwrap(), expected.as_f64().unwrap());
            assert!(
                near(found, expected, relative),
                "{place}: {found} against {expected}"
            );
        }
        _ => assert_eq!(found, expected, "{place}"),
    }
}

#[test]
fn info_equals_what_gdal_says_of_every_file() {
    let Some(data) = data() else { return };
    let expected: Value =
        serde_json::from_slice(&std::fs::read(data.join("expected.json")).unwrap()).unwrap();
    let files = expected.as_object().unwrap();
    assert_eq!(files.len(), 13);
    for (name, expected) in files {
        let cells: Vec<_> = expected["samples"]
            .as_array()
            .unwrap()
            .iter()
            .map(|sample| {
                let at = |key: &str| sample[key].as_u64().unwrap() as u32;
                (at("col"), at("row"))
            })
            .collect();
        let described = info(&data.join(name), &cells).unwrap();
        let found = serde_json::to_value(&described).unwrap();
        for key in [
            "driver",
            "width",
            "height",
            "bands",
            "dtype",
            "crs",
            "area_or_point",
            "compression",
            "block",
            "overviews",
        ] {
            assert_eq!(found[key], expected[key], "{name}: {key}");
        }
        let expected_epsg = expected["crs"]
            .as_str()
            .and_then(|crs| crs.split_once("(EPSG:"))
            .map(|(_, code)| code.trim_end_matches(')').parse::<u32>().unwrap());
        assert_eq!(described.epsg, expected_epsg, "{name}");
        check_numbers(
            name,
            &found["geotransform"],
            &expected["geotransform"],
            1e-12,
        );
        for edge in ["minx", "miny", "maxx", "maxy"] {
            let key = "extent_outer_pixel_edges";
            check_numbers(name, &found[key][edge], &expected[key][edge], 1e-12);
        }
        let (found_bands, bands) = (
            &found["band_info"],
            expected["band_info"].as_array().unwrap(),
        );
        for (index, band) in bands.iter().enumerate() {
            for (key, expected) in band.as_object().unwrap() {
                let place = format!("{name}: band {index}: {key}");
                check_numbers(&place, &found_bands[index][key], expected, 1e-9);
            }
        }
        for (index, sample) in expected["samples"].as_array().unwrap().iter().enumerate() {
            for (key, expected) in sample.as_object().unwrap() {
                let place = format!("{name}: sample {index}: {key}");
                check_numbers(&place, &found["samples"][index][key], expected, 1e-12);
            }
        }
        assert_text_names_what_matters(name, &described);
    }
}

fn assert_text_names_what_matters(name: &str, described: &FileInfo) {
    let text = described.to_string();
    let crs = described.crs.clone().unwrap();
    let size = format!("{} by {}", described.width, described.height);
    assert!(
        text.contains(&crs) && text.contains(&size),
        "{name}:\n{text}"
    );
}

#[test]
fn datum_and_projection_are_known_where_no_code_is_named() {
    let Some(data) = data() else { return };
    let parameters = |name: &str| info(&data.join(name), &[]).unwrap().crs_parameters.unwrap();
    let (grid, tiff) = (
        parameters("st-helens/sthelens_30m_utm10.asc"),
        parameters("st-helens/sthelens_30m_utm10.tif"),
    );
    assert_eq!((grid.epsg, tiff.epsg), (None, Some(26710)));
    assert_eq!(grid.projection, tiff.projection);
    assert_eq!(grid.datum.name, "NAD27");
    let jacksboro = parameters("jacksboro/jacksboro_srtm3.asc");
    assert!(jacksboro.is_geographic() && jacksboro.datum == Crs::wgs84().datum);
    let olinda = parameters("olinda/olinda_dem_90m.tif");
    assert_eq!(olinda.utm_zone(), Some((25, 'S')));
    assert!(near(
        olinda.datum.inverse_flattening,
        298.257_222_101,
        1e-12
    ));
}

/// Opens a terrain with a photograph.
fn with_photo(terrain: &str, photo: &str) -> Result<sandtable_terrain::Terrain, String> {
    let data = data().unwrap();
    open(
        &TerrainSource::File(data.join(terrain)),
        Some(&data.join(photo)),
    )
    .map_err(|error| error.to_string())
}

#[test]
fn every_dem_opens_with_its_heights_and_holes() {
    let Some(data) = data() else { return };
    for (name, holes, spacing, low, high) in [
        (
            "st-helens/sthelens_30m_utm10.asc",
            4151,
            [30.0, 30.0],
            682.0,
            2543.0,
        ),
        (
            "st-helens/sthelens_30m_utm10.tif",
            4151,
            [30.0, 30.0],
            682.0,
            2543.0,
        ),
        ("pyrenees/N41E001.hgt", 134, [69.58, 92.55], -20.0, 1204.0),
        ("pyrenees/N42E001.hgt", 7652, [68.5, 92.57], 349.0, 3100.0),
        (
            "jacksboro/jacksboro_srtm3.asc",
            0,
            [74.8, 92.5],
            236.0,
            1076.0,
        ),
        (
            "jacksboro/jacksboro_srtm3.tif",
            0,
            [74.8, 92.5],
            236.0,
            1076.0,
        ),
        (
            "ruby-range/ruby_range_10m_nad83_cog.tif",
            0,
            [8.025, 10.279],
            2543.02,
            3946.14,
        ),
        (
            "rmnp/rmnp-dem-utm13.tif",
            900,
            [200.0, 200.0],
            2281.0,
            4233.0,
        ),
        ("rmnp/rmnp-dem.tif", 0, [233.6, 234.3], 2281.0, 4261.0),
        ("olinda/olinda_dem_90m.tif", 0, [89.99, 89.99], -1.0, 88.0),
    ] {
        let terrain = open(&TerrainSource::File(data.join(name)), None).unwrap();
        let ground = &terrain.ground;
        assert_eq!(
            ground.holes().map_or(0, |holes| holes.count()),
            holes,
            "{name}"
        );
        let grid = ground.grid();
        assert!(
            near(grid.spacing.x, spacing[0], 2e-3),
            "{name}: {}",
            grid.spacing
        );
        assert!(
            near(grid.spacing.y, spacing[1], 2e-3),
            "{name}: {}",
            grid.spacing
        );
        // Filling must not leave the range of what was there.
        assert!(
            near(f64::from(ground.range()[0]), low, 1e-5),
            "{name}: {:?}",
            ground.range()
        );
        assert!(
            near(f64::from(ground.range()[1]), high, 1e-5),
            "{name}: {:?}",
            ground.range()
        );
    }
}

#[test]
fn neighbouring_tiles_agree_on_the_row_they_share() {
    let Some(data) = data() else { return };
    let open = |name: &str| {
        open(&TerrainSource::File(data.join(name)), None)
            .unwrap()
            .ground
    };
    let (north, south) = (open("pyrenees/N42E001.hgt"), open("pyrenees/N41E001.hgt"));
    for col in 0..1201 {
        assert_eq!(
            north.heights().post(col, 0),
            south.heights().post(col, 1200)
        );
    }
}

#[test]
fn world_and_coordinates_are_each_others_inverse() {
    let Some(data) = data() else { return };
    let terrain = open(
        &TerrainSource::File(data.join("pyrenees/N42E001.hgt")),
        None,
    )
    .unwrap();
    let map = &terrain.georeference;
    let corner = map.crs_from_world(terrain.ground.grid().extent());
    assert!(
        (corner - glam::DVec2::new(2.0, 43.0)).length() < 1e-9,
        "{corner}"
    );
    let back = map.world_from_crs(corner);
    assert!((back - terrain.ground.grid().extent()).length() < 1e-4);
}

#[test]
fn photographs_of_the_same_place_are_laid_where_they_belong() {
    if data().is_none() {
        return;
    }
    // Same CRS and extent: world (100, 100) m is 100 m from the first 200 m post, so it is the
    // corner of four 100 m pixels; half a pixel south-west of it is a pixel's centre.
    let terrain = with_photo("rmnp/rmnp-dem-utm13.tif", "rmnp/rmnp-rgb-utm13.tif").unwrap();
    let photo = terrain.ground.photo().unwrap();
    assert_eq!((photo.origin.x, photo.origin.y), (-50.0, -50.0));
    assert_eq!(photo.colour_at(-50.0, -50.0), Some([177, 166, 154]));
    assert_eq!(
        photo.colour_at(-50.0 + 180.0 * 100.0, -50.0 + 220.0 * 100.0),
        Some([189, 180, 165])
    );

    // Another extent and resolution; the white collar is nodata.
    let terrain = with_photo("rmnp/rmnp-dem.tif", "rmnp/rmnp-rgb.tif").unwrap();
    let photo = terrain.ground.photo().unwrap();
    let place = terrain
        .georeference
        .world_from_crs(glam::DVec2::new(-105.69285056, 40.33993154));
    assert_eq!(photo.colour_at(place.x, place.y), Some([114, 114, 90]));
    assert_eq!(photo.pixels.post(0, 372), [0; 4]);

    // The terrain's datum is unnamed, the photograph's is SIRGAS 2000 on the same ellipsoid.
    let terrain = with_photo(
        "olinda/olinda_dem_90m.tif",
        "olinda/olinda_landsat7_rgb_28m.tif",
    )
    .unwrap();
    assert!(
        terrain.notes.iter().any(|note| note.contains("name only")),
        "{:?}",
        terrain.notes
    );
}

#[test]
fn photographs_of_another_crs_or_place_are_refused_with_a_remedy() {
    if data().is_none() {
        return;
    }
    let error = with_photo("rmnp/rmnp-dem.tif", "rmnp/rmnp-rgb-utm13.tif").unwrap_err();
    assert!(
        error.contains("EPSG:32613") && error.contains("gdalwarp -t_srs EPSG:4326"),
        "{error}"
    );
    let error = with_photo(
        "rmnp/rmnp-dem-utm13.tif",
        "olinda/olinda_landsat7_rgb_28m.tif",
    )
    .unwrap_err();
    assert!(error.contains("outside"), "{error}");
}
