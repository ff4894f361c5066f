//! Bad files: one clear error each, which names the file, the place and the remedy; never a panic.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use sandtable_terrain::{TerrainError, TerrainSource, info, open};
use std::path::{Path, PathBuf};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures")
}

/// Writes `bytes` to a file of that name and opens it as terrain.
fn open_bytes(name: &str, bytes: &[u8]) -> Result<sandtable_terrain::Terrain, TerrainError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    open(&TerrainSource::File(path), None)
}

/// The message of the error, which must name the file and each part.
fn message(name: &str, bytes: &[u8], parts: &[&str]) -> String {
    let error = open_bytes(name, bytes).expect_err(name).to_string();
    for part in [name].iter().chain(parts) {
        assert!(error.contains(part), "{part:?} is not in: {error}");
    }
    error
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let source = TerrainSource::File("no/such/dem.tif".into());
    let error = open(&source, None).unwrap_err().to_string();
    assert!(
        error.contains("no/such/dem.tif") && error.contains("check"),
        "{error}"
    );
}

#[test]
fn empty_files_and_foreign_formats_are_named() {
    for name in ["dem.tif", "dem.asc", "N42E001.hgt"] {
        message(name, b"", &["empty"]);
    }
    message(
        "dem.tif",
        b"GIF89a and so on",
        &["unknown format", "gdal_translate"],
    );
    message("dem.dat", b"\x89PNG\r\n\x1a\n", &["PNG", "gdal_translate"]);
    message("dem.zip", b"PK\x03\x04", &["zip", "unpack"]);
}

#[test]
fn folders_and_pipes_are_no_files() {
    let ground = TerrainSource::File(fixtures().join("bigtiff.tif"));
    let folder = tempfile::tempdir().unwrap();
    let mut odd = vec![(folder.path().to_owned(), "is a folder")];
    if cfg!(target_os = "linux") {
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        odd.push((pipe, "is a pipe"));
    }
    for (path, what) in odd {
        for error in [
            open(&TerrainSource::File(path.clone()), None).unwrap_err(),
            open(&ground, Some(&path)).unwrap_err(),
            info(&path, &[]).unwrap_err(),
        ] {
            let error = error.to_string();
            let named = error.contains(path.to_str().unwrap());
            assert!(named && error.contains(what), "{error}");
            assert!(!error.contains("gdal_translate"), "{error}");
        }
    }
}

#[test]
fn truncated_tiffs_are_refused_wherever_they_end() {
    for name in [
        "int16_strips_deflate_2.tif",
        "float32_tiles_lzw_3.tif",
        "bigtiff.tif",
    ] {
        let whole = std::fs::read(fixtures().join(name)).unwrap();
        for end in (1..whole.len()).step_by(37).chain([whole.len() - 1]) {
            let error = open_bytes("cut.tif", &whole[..end])
                .expect_err(name)
                .to_string();
            assert!(error.contains("cut.tif"), "{error}");
        }
    }
    // Of 12 bits, too, of which two samples take three bytes.
    let whole = std::fs::read(fixtures().join("twelve_bits.tif")).unwrap();
    message("cut.tif", &whole[..whole.len() - 100], &["beyond"]);
    // Where the data end early, the strip and its byte offset are named.
    let whole = std::fs::read(fixtures().join("int16_strips_none_1.tif")).unwrap();
    message(
        "cut.tif",
        &whole[..whole.len() - 100],
        &["strip", "byte offset", "beyond"],
    );
}

/// A little-endian TIFF of one deflate strip with the given tags overwritten.
fn tiff(width: u32, height: u32, rows_per_strip: u32, count: u32) -> Vec<u8> {
    let entries = [
        (256_u16, 4_u16, width),
        (257, 4, height),
        (258, 3, 16),
        (259, 3, 8),
        (262, 3, 1),
        (273, 4, 8),
        (277, 3, 1),
        (278, 4, rows_per_strip),
        (279, 4, count),
    ];
    let mut bytes = b"II\x2a\0".to_vec();
    bytes.extend(24_u32.to_le_bytes());
    bytes.extend([0; 16]);
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, value) in entries {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    bytes
}

#[test]
fn absurd_sizes_are_refused_before_memory_is_taken() {
    message(
        "huge.tif",
        &tiff(1_000_000, 1_000_000, 1, 16),
        &["1000000", "gdal_translate"],
    );
    message(
        "huge.tif",
        &tiff(20_000, 20_000, 20_000, 16),
        &["800000000 bytes", "strip", "-co TILED=YES"],
    );
    message("huge.tif", &tiff(5_000, 5_000, 5_000, 16), &["cannot hold"]);
    message(
        "huge.tif",
        &tiff(100_000, 5_000, 10, 16),
        &["500", "offsets"],
    );
    message("none.tif", &tiff(0, 5, 5, 16), &["0 columns"]);
    let head = |cols: &str, rows: &str| {
        format!("ncols {cols}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n")
    };
    message(
        "huge.asc",
        head("1000000000000000000", "2").as_bytes(),
        &["1000000000000000000"],
    );
    message(
        "huge.asc",
        head("1000000", "1000000").as_bytes(),
        &["1000000"],
    );
    message(
        "huge.asc",
        head("20000", "20000").as_bytes(),
        &["line 6", "cannot hold"],
    );
    message("huge.asc", head("1e400", "2").as_bytes(), &["line 1"]);
}

#[test]
fn an_hgt_of_another_size_or_name_is_refused() {
    message("N42E001.hgt", &[0; 1000], &["1000", "2884802", "25934402"]);
    message("andorra.hgt", &vec![0; 1201 * 1201 * 2], &["N42E001.hgt"]);
}

const GRID: &str = "ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 5\nNODATA_value -9\n";

#[test]
fn an_ascii_grid_may_be_laid_out_in_any_way() {
    let plain = open_bytes("dem.asc", format!("{GRID}1 2 3\n4 -9 6\n").as_bytes()).unwrap();
    assert_eq!(plain.ground.heights().post(0, 0), 4.0);
    assert_eq!(plain.ground.heights().post(2, 1), 3.0);
    assert!(plain.ground.holes().unwrap().contains(1, 0));
    for text in [
        format!("{GRID}1\n2\n3\n4\n-9\n6"),
        format!("{GRID}1 2 3 4 -9 6").replace('\n', "\r\n"),
        format!("\u{feff}{GRID}1 2 3\n4 -9 6"),
        "NROWS 2\tNCOLS 3 XLLCENTER 12.5 YLLCENTER 22.5 DX 5 DY 5 nodata_value -9 1 2 3 4 -9 6"
            .into(),
    ] {
        let terrain = open_bytes("dem.asc", text.as_bytes()).unwrap();
        assert_eq!(
            terrain.georeference.origin, plain.georeference.origin,
            "{text}"
        );
        for tile in plain.ground.heights().tile_indices() {
            assert_eq!(
                terrain.ground.heights().tile_posts(tile),
                plain.ground.heights().tile_posts(tile),
                "{text}"
            );
        }
    }
}

#[test]
fn an_ascii_grid_without_a_nodata_line_is_asked_for_one() {
    let head = GRID.replace("NODATA_value -9\n", "");
    let grid = format!("{head}1 2 3\n4 -9999 6\n");
    let terrain = open_bytes("dem.asc", grid.as_bytes()).unwrap();
    assert_eq!(terrain.ground.range()[0], -9999.0);
    let notes = terrain.notes.join("\n");
    assert!(notes.contains("the line NODATA_value -9999"), "{notes}");
}

#[test]
fn a_wrong_line_of_an_ascii_grid_is_named() {
    let grid = |rows: &str| format!("{GRID}{rows}").into_bytes();
    message(
        "dem.asc",
        &grid("1 2\n4 5 6\n"),
        &["line 7", "2 values", "3"],
    );
    message("dem.asc", &grid("1 2 3\n4 5 6 7\n"), &["line 8"]);
    message("dem.asc", &grid("1 2 3\n4 five 6\n"), &["line 8", "five"]);
    message("dem.asc", &grid("1 2 3\n"), &["line 7", "cannot hold"]);
    message("dem.asc", b"ncols three\nnrows 2\n", &["line 1", "three"]);
    message(
        "dem.asc",
        b"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\n1 2 3\n",
        &["cellsize"],
    );
    message(
        "dem.asc",
        b"ncols 3\nrows 2\n",
        &["line 2", "rows", "nrows"],
    );
    message(
        "dem.asc",
        b"ncols 3\nnrows 2.5\nxllcorner 0\nyllcorner 0\ncellsize 1\n",
        &["line 2", "nrows is 2.5"],
    );
    message(
        "dem.asc",
        b"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize -1\n1 2 3 4 5 6",
        &["line 5", "cellsize is -1", "above 0"],
    );
    message(
        "dem.asc",
        &grid("-9 -9 -9 -9 -9 -9"),
        &["no height", "sandtable info"],
    );
    message(
        "dem.asc",
        b"ncols -4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n1",
        &["line 1", "ncols is -4"],
    );
    let small = message(
        "dem.asc",
        b"ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3",
        &["2 by 2", "larger part"],
    );
    // There is nothing to cut out of it.
    assert!(!small.contains("-srcwin"), "{small}");
}

#[test]
fn a_cell_outside_is_named_with_the_bounds() {
    let error = info(&fixtures().join("bigtiff.tif"), &[(3, 3), (40, 0)])
        .unwrap_err()
        .to_string();
    for part in ["bigtiff.tif", "40,0", "0 to 39", "0 to 32"] {
        assert!(error.contains(part), "{error}");
    }
}

/// Opens a fixture with a photograph of that name and content.
fn with_picture(
    name: &str,
    bytes: &[u8],
    sidecars: &[(&str, &str)],
) -> Result<Vec<String>, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    for (name, text) in sidecars {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let source = TerrainSource::File(fixtures().join("bigtiff.tif"));
    open(&source, Some(&path))
        .map(|terrain| terrain.notes)
        .map_err(|error| error.to_string())
}

fn png() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_fn(8, 6, |x, y| image::Rgb([30 * x as u8, 40 * y as u8, 9]))
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}

#[test]
fn a_torn_jpeg_is_refused_wherever_it_ends() {
    let mut whole = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_fn(64, 48, |x, y| image::Rgb([4 * x as u8, 5 * y as u8, 9]))
        .write_to(&mut whole, image::ImageFormat::Jpeg)
        .unwrap();
    let whole = whole.into_inner();
    with_picture("photo.jpg", &whole, &[]).unwrap();
    // What follows the picture, as phones append a second one, is not looked at.
    with_picture("photo.jpg", &[&whole[..], b"more"].concat(), &[]).unwrap();
    for kept in [whole.len() - 2, whole.len() - 40, whole.len() / 2] {
        let error = with_picture("photo.jpg", &whole[..kept], &[]).unwrap_err();
        for part in ["photo.jpg", "copy or download it again"] {
            assert!(error.contains(part), "{kept} bytes: {error}");
        }
    }
}

#[test]
fn pictures_are_stretched_or_laid_by_their_world_file() {
    let notes = with_picture("photo.png", &png(), &[]).unwrap();
    assert!(
        notes.iter().any(|note| note.contains("stretched")),
        "{notes:?}"
    );
    let world = [("photo.pgw", "50\n0\n0\n-50\n500025\n4000800\n")];
    let notes = with_picture("photo.png", &png(), &world).unwrap();
    assert!(
        notes.iter().any(|note| note.contains("assumed")),
        "{notes:?}"
    );
}

#[test]
fn pictures_that_do_not_fit_are_refused() {
    let world = [("photo.pgw", "50\n0\n0\n-50\n900025\n4000800\n")];
    assert!(
        with_picture("photo.png", &png(), &world)
            .unwrap_err()
            .contains("outside")
    );
    let turned = [("photo.pgw", "50\n7\n7\n-50\n500025\n4000800\n")];
    assert!(
        with_picture("photo.png", &png(), &turned)
            .unwrap_err()
            .contains("gdalwarp")
    );
    let error = with_picture("photo.png", &png()[..60], &[]).unwrap_err();
    assert!(
        error.contains("photo.png") && error.contains("decoded"),
        "{error}"
    );
    let error = with_picture("photo.bmp", b"BM and so on", &[]).unwrap_err();
    assert!(
        error.contains("PNG") && error.contains("gdal_translate"),
        "{error}"
    );
    assert!(
        with_picture("photo.png", b"", &[])
            .unwrap_err()
            .contains("empty")
    );
    // A header that announces what the bytes cannot hold: 60000 by 1000 pixels.
    let mut huge = png();
    huge[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0x03, 0xe8]);
    assert!(with_picture("photo.png", &huge, &[]).is_err());
}

const UTM: &str = r#"PROJCS["UTM",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",CENTRAL],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]]"#;

#[test]
fn a_photograph_of_the_same_place_in_another_system_is_to_be_warped() {
    // The terrain is at 3° east, 36.15° north, in zone 31; these coordinates are zone 30's.
    let system = UTM.replace("CENTRAL", "-3");
    let sidecars = [
        ("photo.pgw", "50\n0\n0\n-50\n1040300\n4017000\n"),
        ("photo.prj", system.as_str()),
    ];
    let error = with_picture("photo.png", &png(), &sidecars).unwrap_err();
    for part in ["photo.png", "gdalwarp -t_srs EPSG:32631"] {
        assert!(error.contains(part), "{part:?} is not in: {error}");
    }
    assert!(!error.contains("outside"), "{error}");
    // In zone 35 they would be 30° farther east, which no warping brings back.
    let system = UTM.replace("CENTRAL", "27");
    let sidecars = [sidecars[0], ("photo.prj", system.as_str())];
    let error = with_picture("photo.png", &png(), &sidecars).unwrap_err();
    assert!(error.contains("outside"), "{error}");
}

#[test]
fn a_system_without_words_is_taken_from_the_terrains_file() {
    let folder = tempfile::tempdir().unwrap();
    let [grid, photo] = ["dem.asc", "photo.png"].map(|name| folder.path().join(name));
    std::fs::write(&grid, format!("{GRID}1 2 3\n4 -9 6\n")).unwrap();
    std::fs::write(&photo, png()).unwrap();
    let system = UTM.replace("CENTRAL", "3");
    std::fs::write(folder.path().join("photo.prj"), &system).unwrap();
    let bonne = system.replace("Transverse_Mercator", "Bonne");
    std::fs::write(folder.path().join("dem.prj"), bonne).unwrap();
    std::fs::write(folder.path().join("photo.pgw"), "2\n0\n0\n-2\n11\n29\n").unwrap();
    let error = open(&TerrainSource::File(grid), Some(&photo)).unwrap_err();
    let error = error.to_string();
    for part in [
        "gdalsrsinfo -o wkt2",
        "dem.asc > terrain.wkt && gdalwarp -t_srs terrain.wkt",
    ] {
        assert!(error.contains(part), "{part:?} is not in: {error}");
    }
}

#[test]
fn longitudes_from_another_meridian_are_to_be_turned() {
    let folder = tempfile::tempdir().unwrap();
    let [grid, photo] = ["dem.asc", "photo.png"].map(|name| folder.path().join(name));
    let text = "ncols 3\nnrows 2\nxllcorner -105\nyllcorner 40\ncellsize 0.1\n1 2 3\n4 5 6\n";
    std::fs::write(&grid, text).unwrap();
    std::fs::write(&photo, png()).unwrap();
    let world = folder.path().join("photo.pgw");
    std::fs::write(world, "0.0625\n0\n0\n-0.0625\n255.03125\n40.21875\n").unwrap();
    let error = open(&TerrainSource::File(grid), Some(&photo)).unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("gdal_translate -a_ullr -105 40.25 -104.5 39.875"),
        "{error}"
    );
}

/// A small generator of its own, so that the same mutations come again (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }
}

#[test]
fn mutated_files_never_panic() {
    let mut random = Random(0x5eed_1e55_0dd5_ba11);
    let folder = tempfile::tempdir().unwrap();
    let ascii = format!("{GRID}1 2 3\n4 -9 6\n").into_bytes();
    let mut originals = vec![
        ("dem.asc".to_owned(), ascii),
        ("photo.png".to_owned(), png()),
    ];
    for name in [
        "int16_strips_deflate_2.tif",
        "float32_tiles_lzw_3.tif",
        "bigtiff.tif",
        "big_endian.tif",
        "zstd.tif",
        "sparse.tif",
        "overviews.tif",
        "photo_planar.tif",
        "photo_mask.tif",
        "feet.tif",
        "photo_alpha.tif",
        "us_feet.tif",
    ] {
        originals.push((
            name.to_owned(),
            std::fs::read(fixtures().join(name)).unwrap(),
        ));
    }
    let ground = TerrainSource::File(fixtures().join("bigtiff.tif"));
    let mut opened = 0;
    for round in 0..3000 {
        let (name, original) = &originals[round % originals.len()];
        let mut bytes = original.clone();
        for _ in 0..=random.below(3) {
            let at = if random.below(2) == 0 {
                // Headers sit at either end.
                random.below(bytes.len().min(300))
            } else {
                bytes.len() - 1 - random.below(bytes.len().min(700))
            };
            match random.below(12) {
                0..=3 => bytes[at] = random.below(256) as u8,
                4..=7 => bytes[at] ^= 1 << random.below(8),
                8..=10 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)],
                _ => bytes.truncate(at.max(1)),
            }
        }
        let path = folder.path().join(name);
        std::fs::write(&path, &bytes).unwrap();
        let source = TerrainSource::File(path.clone());
        let described = info(&path, &[(0, 0)]);
        opened += usize::from(described.is_ok());
        let _ = open(&source, None);
        if name.starts_with("photo") {
            let _ = open(&ground, Some(&path));
        }
    }
    // Mutations that all fail at once would test nothing.
    assert!(opened > 300, "{opened} of 3000 could still be described");
}
