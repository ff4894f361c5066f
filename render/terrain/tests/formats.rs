//! Every sample type, layout, compression and predictor reads as it was written. `fixtures/make.py`
//! says what the files hold.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use sandtable_terrain::{
    FileInfo, Ground, PixelIs, SampleType, SampleValue, Terrain, TerrainError, TerrainSource, info,
    open,
};
use std::path::{Path, PathBuf};

const COLS: u32 = 40;
const ROWS: u32 = 33;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fixtures")
        .join(name)
        .with_extension("tif")
}

fn terrain(name: &str) -> Terrain {
    open(&TerrainSource::File(fixture(name)), None).unwrap()
}

fn all_cells() -> Vec<(u32, u32)> {
    (0..ROWS)
        .flat_map(|row| (0..COLS).map(move |col| (col, row)))
        .collect()
}

fn described(name: &str) -> FileInfo {
    info(&fixture(name), &all_cells()).unwrap()
}

fn in_disc(col: u32, row: u32) -> bool {
    (col as i32 - 20).pow(2) + (row as i32 - 16).pow(2) < 10
}

/// The value of a cell, by its type's base.
fn value(base: f64, col: u32, row: u32) -> f64 {
    let shape = f64::from((37 * col + 101 * row) % 211 + (col * row) % 7) / 2.0 + base;
    if base.fract() == 0.0 {
        shape.floor()
    } else {
        shape
    }
}

const TYPES: [(&str, SampleType, f64); 8] = [
    ("int8", SampleType::Int8, -70.0),
    ("uint8", SampleType::Byte, 20.0),
    ("int16", SampleType::Int16, -1000.0),
    ("uint16", SampleType::UInt16, 40_000.0),
    ("int32", SampleType::Int32, -100_000.0),
    ("uint32", SampleType::UInt32, 3e9),
    ("float32", SampleType::Float32, -1000.125),
    ("float64", SampleType::Float64, -1000.0625),
];

fn check(name: &str, sample: SampleType, base: f64) {
    let found = described(name);
    assert_eq!(found.dtype, [sample], "{name}");
    assert_eq!(
        (found.band_info[0].valid, found.band_info[0].invalid),
        (1291, 29),
        "{name}"
    );
    for cell in &found.samples {
        let (col, row) = (cell.col, cell.row);
        assert_eq!(cell.nodata, in_disc(col, row), "{name} at {col}, {row}");
        if !cell.nodata {
            let expected = value(base, col, row);
            let expected = if sample.is_integer() {
                SampleValue::Integer(expected as i64)
            } else {
                SampleValue::Real(expected)
            };
            assert_eq!(cell.value, expected, "{name} at {col}, {row}");
        }
    }
    let ground = terrain(name).ground;
    let holes = ground.holes().unwrap();
    for (col, row) in all_cells() {
        let north_up = ROWS - 1 - row;
        assert_eq!(
            holes.contains(col, north_up),
            in_disc(col, row),
            "{name} at {col}, {row}"
        );
        if !in_disc(col, row) {
            let height = ground.heights().post(col, north_up);
            assert_eq!(
                height,
                value(base, col, row) as f32,
                "{name} at {col}, {row}"
            );
        }
    }
}

#[test]
fn every_type_layout_compression_and_predictor_reads_as_written() {
    let mut files = 0;
    for (kind, sample, base) in TYPES {
        for layout in ["strips", "tiles"] {
            for (compression, predictors) in [("none", 1..=1), ("lzw", 1..=3), ("deflate", 1..=3)] {
                for predictor in predictors {
                    let name = format!("{kind}_{layout}_{compression}_{predictor}");
                    // Only floating-point samples have the third predictor.
                    if predictor < 3 || !sample.is_integer() {
                        check(&name, sample, base);
                        files += 1;
                    }
                }
            }
        }
    }
    assert_eq!(files, 88);
}

#[test]
fn byte_order_big_files_zstd_and_overviews_change_nothing() {
    check("big_endian", SampleType::Int16, -1000.0);
    check("big_endian_float", SampleType::Float32, -1000.125);
    check("bigtiff", SampleType::Int16, -1000.0);
    check("zstd", SampleType::Float32, -1000.125);
    check("overviews", SampleType::Float32, -1000.125);
    assert_eq!(described("overviews").overviews, 1);
}

#[test]
fn pixel_is_point_files_lie_where_pixel_is_area_files_do() {
    let (point, area) = (described("point"), described("int16_strips_deflate_2"));
    assert_eq!(point.area_or_point, Some(PixelIs::Point));
    assert_eq!(area.area_or_point, Some(PixelIs::Area));
    assert_eq!(point.geotransform, area.geotransform);
    check("point", SampleType::Int16, -1000.0);
    // The world's origin is the south-west post, half a cell within the outer edge.
    let origin = terrain("point").georeference.origin;
    assert_eq!((origin.x, origin.y), (500_012.5, 4_000_012.5));
}

#[test]
fn scale_offset_and_feet_are_applied_and_said() {
    let terrain = terrain("feet");
    let height = terrain.ground.heights().post(3, ROWS - 1);
    let expected = (value(-1000.0, 3, 0) * 0.1 + 10.0) * 0.3048;
    assert!(
        (f64::from(height) - expected).abs() < 1e-4,
        "{height} against {expected}"
    );
    assert!(
        terrain.notes.iter().any(|note| note.contains("0.1")),
        "{:?}",
        terrain.notes
    );
    assert!(
        terrain.notes.iter().any(|note| note.contains("ft")),
        "{:?}",
        terrain.notes
    );
    // What is stored is what info tells.
    let stored = described("feet");
    assert_eq!(
        stored.samples[3].value,
        SampleValue::Integer(value(-1000.0, 3, 0) as i64)
    );
}

#[test]
fn a_description_says_scale_offset_and_guesses() {
    let text = described("feet").to_string();
    assert!(text.contains("multiplied by 0.1, then 10 added"), "{text}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dem.asc");
    let grid = "ncols 2\nnrows 2\nxllcorner 7\nyllcorner 46\ncellsize 0.1\n1 2 3 4\n";
    std::fs::write(&path, grid).unwrap();
    let text = info(&path, &[]).unwrap().to_string();
    assert!(text.contains("note         no .prj lies beside"), "{text}");
}

#[test]
fn coordinates_in_survey_feet_become_metres() {
    let spacing = terrain("us_feet").ground.grid().spacing;
    assert!(
        (spacing.x - 25.0 * 1200.0 / 3937.0).abs() < 1e-9 && spacing.x == spacing.y,
        "{spacing}"
    );
}

#[test]
fn heights_in_the_feet_of_a_vertical_crs_become_metres() {
    let terrain = terrain("vertical_us_feet");
    let height = f64::from(terrain.ground.heights().post(3, ROWS - 1));
    let expected = value(-1000.0, 3, 0) * 1200.0 / 3937.0;
    assert!((height - expected).abs() < 1e-4, "{height}, {expected}");
    let notes = terrain.notes.join("\n");
    assert!(notes.contains("US survey foot"), "{notes}");
    let described = described("vertical_us_feet");
    let name = "NAVD88 height (ftUS) (EPSG:6360)";
    assert_eq!(described.vertical_crs.as_deref(), Some(name));
    assert!(described.to_string().contains(name));
}

#[test]
fn heights_without_a_unit_on_a_map_in_feet_are_remarked_on() {
    let notes = terrain("us_feet").notes.join("\n");
    for part in ["0.3048 m", "taken for metres", "gdal_edit.py -units ft"] {
        assert!(notes.contains(part), "{notes}");
    }
}

#[test]
fn a_map_that_is_not_true_to_scale_is_remarked_on() {
    let notes = terrain("web_mercator").notes.join("\n");
    for part in [
        "1.30 m of the map eastwards and 1.31 m northwards",
        "gdalwarp -t_srs EPSG:32613",
    ] {
        assert!(notes.contains(part), "{part:?} is not in: {notes}");
    }
    let notes = terrain("us_feet").notes.join("\n");
    assert!(!notes.contains("scale"), "{notes}");
}

#[test]
fn a_map_that_is_not_true_to_scale_places_longitudes_and_latitudes_all_the_same() {
    let georeference = terrain("web_mercator").georeference;
    let world = georeference.world_from_wgs84(glam::DVec2::new(-105.0, 40.0));
    // By cs2cs, less the coordinates of the south-west post.
    let expected = glam::DVec2::new(387.467, 400.080);
    assert!((world.unwrap() - expected).length() < 0.01);
}

#[test]
fn samples_of_twelve_bits_read_as_written() {
    for name in ["twelve_bits", "twelve_bits_deflate"] {
        for cell in described(name).samples {
            let expected = value(2000.0, cell.col, cell.row) as i64;
            let nodata = in_disc(cell.col, cell.row);
            assert_eq!(cell.nodata, nodata, "{name}");
            let expected = SampleValue::Integer(if nodata { 0 } else { expected });
            assert_eq!(cell.value, expected, "{name} at {}, {}", cell.col, cell.row);
        }
    }
    let (ground, _) = photographed("photo_12");
    let pixels = &ground.photo().unwrap().pixels;
    assert_eq!(pixels.post(0, ROWS - 1)[..2], [0, 0]);
    assert!(pixels.post(COLS - 1, 0)[0] > 250);
}

#[test]
fn values_that_seem_to_stand_for_none_are_remarked_on() {
    let said = |name: &str| terrain(name).notes.join("\n");
    let notes = said("untagged");
    for part in ["lowest value, -32768", "gdal_edit.py -a_nodata -32768"] {
        assert!(notes.contains(part), "{part:?} is not in: {notes}");
    }
    // These fixtures' own values are beyond any height; the tag's is none of them.
    let notes = said("uint16_strips_none_1");
    let advice = "gdalwarp -srcnodata 40000 -dstnodata 65535";
    assert!(notes.contains(advice), "{notes}");
    for name in ["int16_strips_none_1", "float32_strips_none_1"] {
        assert!(!said(name).contains("unlikely"), "{name}");
    }
}

#[test]
fn nodata_counts_without_geographic_tags() {
    let found = described("nowhere_nodata");
    let band = &found.band_info[0];
    assert_eq!((band.valid, band.invalid), (1291, 29));
    assert_eq!(band.nodata, Some(-32_768.0));
}

#[test]
fn blocks_that_are_left_out_are_nodata() {
    let found = described("sparse");
    assert_eq!(found.band_info[0].valid, 256);
    for cell in found.samples {
        assert_eq!(cell.nodata, cell.col >= 16 || cell.row >= 16);
    }
    assert_eq!(
        terrain("sparse").ground.holes().unwrap().count(),
        1320 - 256
    );
}

fn refusal(name: &str) -> TerrainError {
    open(&TerrainSource::File(fixture(name)), None).unwrap_err()
}

#[test]
fn what_cannot_be_terrain_is_refused_with_a_remedy() {
    assert!(matches!(refusal("rotated"), TerrainError::Rotated { .. }));
    assert!(refusal("rotated").to_string().contains("gdalwarp"));
    assert!(matches!(
        refusal("nowhere"),
        TerrainError::NoGeoreference { .. }
    ));
    for name in ["half_float", "complex"] {
        let error = refusal(name).to_string();
        assert!(error.contains("gdal_translate -ot Float32"), "{error}");
    }
    let furlongs = refusal("furlongs").to_string();
    assert!(
        furlongs.contains("gdal_edit.py -scale FACTOR -units m"),
        "{furlongs}"
    );
    assert!(matches!(
        refusal("all_nodata"),
        TerrainError::AllNodata { cells: 1320, .. }
    ));
    // A raster that is no terrain can be described all the same.
    assert_eq!(described("nowhere").geotransform, None);
    assert_eq!(described("all_nodata").band_info[0].mean, None);
}

#[test]
fn a_world_file_lays_a_terrain_that_does_not_say_where_it_lies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dem.tif");
    std::fs::copy(fixture("nowhere"), &path).unwrap();
    let world = "25\n0\n0\n-25\n500012.5\n4000812.5\n";
    std::fs::write(folder.path().join("dem.tfw"), world).unwrap();
    let transform = [500_000.0, 25.0, 0.0, 4_000_825.0, 0.0, -25.0];
    assert_eq!(info(&path, &[]).unwrap().geotransform, Some(transform));
    let origin = open(&TerrainSource::File(path), None)
        .unwrap()
        .georeference
        .origin;
    assert_eq!((origin.x, origin.y), (500_012.5, 4_000_012.5));
}

/// The ground under a photograph, on the same 40 by 33 cells.
fn photographed(name: &str) -> (Ground, Vec<String>) {
    let source = TerrainSource::File(fixture("int16_tiles_none_1"));
    let terrain = open(&source, Some(&fixture(name))).unwrap();
    (terrain.ground, terrain.notes)
}

#[test]
fn photographs_in_every_arrangement_give_their_colours() {
    for name in ["photo_pixel", "photo_planar"] {
        let (ground, _) = photographed(name);
        let photo = ground.photo().unwrap();
        assert_eq!((photo.origin.x, photo.origin.y), (0.0, 0.0));
        for (col, row) in all_cells() {
            let expected = [5 * col as u8, 6 * row as u8, 7, 255];
            assert_eq!(
                photo.pixels.post(col, ROWS - 1 - row),
                expected,
                "{name} at {col}, {row}"
            );
        }
    }
    let (ground, _) = photographed("photo_grey");
    assert_eq!(ground.photo().unwrap().pixels.post(9, 0), [45, 45, 45, 255]);
}

#[test]
fn transparent_and_masked_pixels_are_not_covered() {
    for name in ["photo_alpha", "photo_mask"] {
        let (ground, _) = photographed(name);
        let photo = ground.photo().unwrap();
        for (col, row) in all_cells() {
            let [red, .., cover] = photo.pixels.post(col, ROWS - 1 - row);
            assert_eq!(cover == 0, in_disc(col, row), "{name} at {col}, {row}");
            // JPEG keeps colours roughly.
            assert!(
                cover == 0 || red.abs_diff(5 * col as u8) < 12,
                "{name}: {red} at {col}, {row}"
            );
        }
    }
}

#[test]
fn sixteen_bits_are_stretched_and_said() {
    let (ground, notes) = photographed("photo_16");
    let photo = ground.photo().unwrap();
    assert_eq!(photo.pixels.post(0, ROWS - 1)[..3], [0, 0, 0]);
    let brightest = photo.pixels.post(COLS - 1, 0);
    assert!(brightest[0] > 250 && brightest[3] == 255, "{brightest:?}");
    assert!(
        notes
            .iter()
            .any(|note| note.contains("16-bit") && note.contains("1000")),
        "{notes:?}"
    );
}

#[test]
fn pixels_that_are_not_there_count_in_no_stretch() {
    for name in ["photo_16_alpha", "photo_16_mask"] {
        let (ground, notes) = photographed(name);
        let notes = notes.join("\n");
        // Columns 10 to 39 and all rows are there.
        assert!(notes.contains("from 1000 to 4120"), "{name}: {notes}");
        let photo = ground.photo().unwrap();
        assert_eq!(photo.pixels.post(9, 0), [0; 4], "{name}");
        assert_eq!(photo.pixels.post(COLS - 1, ROWS - 1), [255, 0, 33, 255]);
    }
    let picture = image::ImageBuffer::from_fn(COLS, ROWS, |col, row| {
        image::Rgba(if col < 10 {
            [0; 4]
        } else {
            [
                1000 + 80 * col as u16,
                1000 + 96 * row as u16,
                1400,
                u16::MAX,
            ]
        })
    });
    let notes = pictured(picture).1.join("\n");
    assert!(notes.contains("from 1000 to 4120"), "{notes}");
}

#[test]
fn a_photograph_of_which_nothing_is_seen_is_remarked_on() {
    let (ground, notes) = photographed("photo_16_faint");
    assert_eq!(ground.photo().unwrap().pixels.post(3, 3), [0; 4]);
    let notes = notes.join("\n");
    for part in ["nothing is seen", "gdal_translate -b 1 -b 2 -b 3"] {
        assert!(notes.contains(part), "{part:?} is not in: {notes}");
    }
    let (_, notes) = photographed("photo_16_alpha");
    assert!(!notes.join("\n").contains("nothing is seen"));
}

#[test]
fn nodata_of_a_palette_is_an_index_and_no_colour() {
    let (ground, _) = photographed("photo_palette");
    let photo = ground.photo().unwrap();
    for (col, row) in all_cells() {
        let expected = match col % 2 {
            _ if in_disc(col, row) => [0; 4],
            0 => [0, 0, 0, 255],
            _ => [250, 0, 0, 255],
        };
        assert_eq!(
            photo.pixels.post(col, ROWS - 1 - row),
            expected,
            "{col}, {row}"
        );
    }
}

/// The ground under a picture that is written as a PNG, on the same cells.
fn pictured(picture: impl Into<image::DynamicImage>) -> (Ground, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("photo.png");
    picture.into().save(&path).unwrap();
    let source = TerrainSource::File(fixture("int16_tiles_none_1"));
    let terrain = open(&source, Some(&path)).unwrap();
    (terrain.ground, terrain.notes)
}

#[test]
fn sixteen_bits_look_the_same_in_a_png_as_in_a_tiff() {
    let value = |step: u32, at: u32| (1000 + 16 * step * at) as u16;
    let rgb = |col, row| [value(5, col), value(6, row), value(5, col)];
    let (tiff, said) = photographed("photo_16");
    let (png, notes) = pictured(image::ImageBuffer::from_fn(COLS, ROWS, |col, row| {
        image::Rgb(rgb(col, row))
    }));
    let [tiff, png] = [&tiff, &png].map(|ground| &ground.photo().unwrap().pixels);
    for (col, row) in all_cells() {
        assert_eq!(png.post(col, row), tiff.post(col, row), "at {col}, {row}");
    }
    let stretch = said.iter().find(|note| note.contains("16-bit")).unwrap();
    assert!(notes.contains(stretch), "{notes:?}");
}

#[test]
fn sixteen_bits_may_be_grey_and_have_holes() {
    let (ground, _) = pictured(image::ImageBuffer::from_fn(COLS, ROWS, |col, row| {
        let cover = if in_disc(col, row) { 0 } else { u16::MAX };
        image::LumaA([(1000 + 50 * col) as u16, cover])
    }));
    let photo = ground.photo().unwrap();
    for (col, row) in all_cells() {
        let [red, green, blue, cover] = photo.pixels.post(col, ROWS - 1 - row);
        assert_eq!(cover == 0, in_disc(col, row), "at {col}, {row}");
        assert!(red == green && green == blue && (cover == 0 || red >= 6 * col as u8));
    }
    // All white is white.
    let white = image::ImageBuffer::from_pixel(COLS, ROWS, image::Luma([u16::MAX]));
    let photo = pictured(white).0;
    assert_eq!(photo.photo().unwrap().pixels.post(3, 3), [255; 4]);
}
