//! Input that is empty, cut, odd or absurd: one error that names the file, the place and the remedy.

use crate::program::{Folder, shared_data};

const VIEW: &str = "size = [16, 16]\neye = [500.0, 500.0, 900.0]\n\
                    camera = { pitch = -20.0, horizontal_fov = 60.0 }\n";

/// Every command that opens a terrain refuses this one in the same words.
#[track_caller]
fn refused(folder: &Folder, terrain: &str, says: &[&str]) {
    folder.write("v.toml", VIEW);
    let before = folder.names();
    for command in [
        "render TERRAIN --view v.toml -o i.png",
        "fly TERRAIN --headless --size 16x16 --seconds 0.05 -o f.avi",
        "bench TERRAIN --view v.toml --frames 1",
        "info TERRAIN",
    ] {
        if command.starts_with("info") && terrain.starts_with("builtin:") {
            continue;
        }
        let ended = folder.run(&command.replace("TERRAIN", terrain));
        let code = if terrain.starts_with("builtin:") {
            2
        } else {
            1
        };
        ended.failed(code, says);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn an_empty_file() {
    let folder = Folder::new();
    for name in ["dem.tif", "N42E001.hgt", "dem.asc"] {
        folder.write(name, "");
        refused(
            &folder,
            name,
            &[name, "is empty", "copy or download it again"],
        );
    }
}

#[test]
fn truncated_files() {
    let Some(data) = shared_data() else { return };
    let folder = Folder::new();
    for (file, kept, says) in [
        ("jacksboro/jacksboro_srtm3.tif", 3000, "byte offset"),
        (
            "ruby-range/ruby_range_10m_nad83_cog.tif",
            100_000,
            "byte offset",
        ),
        ("jacksboro/jacksboro_srtm3.tif", 6, "header"),
        ("pyrenees/N42E001.hgt", 100_000, "2884802"),
        ("jacksboro/jacksboro_srtm3.asc", 20_000, "line"),
    ] {
        let bytes = std::fs::read(data.join(file)).unwrap();
        let name = file.split('/').next_back().unwrap();
        folder.write(name, &bytes[..kept]);
        refused(&folder, name, &[name, says]);
    }
}

#[test]
fn a_wrong_magic() {
    let folder = Folder::new();
    folder.write("dem.tif", "PK\u{3}\u{4} an archive");
    refused(&folder, "dem.tif", &["dem.tif", "zip archive", "unpack it"]);
    folder.write("dem.tif", "something else altogether, and more of it");
    refused(
        &folder,
        "dem.tif",
        &["dem.tif", "GeoTIFF", "gdal_translate"],
    );
}

#[test]
fn an_absurd_size() {
    let folder = Folder::new();
    let header = "ncols 4000000000\nnrows 4000000000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n";
    folder.write("dem.asc", header);
    refused(&folder, "dem.asc", &["dem.asc", "4000000000", "131072"]);
    // A little-endian TIFF of one strip, 100,000 by 100,000 values of 64 bits.
    let mut tiff = b"II*\0\x08\0\0\0\x08\0".to_vec();
    for (tag, kind, value) in [
        (256_u16, 4_u16, 100_000_u32),
        (257, 4, 100_000),
        (258, 3, 64),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 200),
        (278, 4, 100_000),
        (279, 4, 100),
    ] {
        tiff.extend(tag.to_le_bytes());
        tiff.extend(kind.to_le_bytes());
        tiff.extend(1_u32.to_le_bytes());
        tiff.extend(value.to_le_bytes());
    }
    tiff.resize(300, 0);
    folder.write("dem.tif", tiff);
    refused(&folder, "dem.tif", &["dem.tif"]);
}

#[test]
fn terrain_that_is_not_there() {
    let folder = Folder::new();
    refused(
        &folder,
        "atlantis.tif",
        &["atlantis.tif", "check that the file is there"],
    );
    refused(
        &folder,
        "builtin:atlantis",
        &["atlantis", "builtin:ridges", "builtin:jacksboro"],
    );
    for (size, says) in [
        ("1", "2 to 16385"),
        ("99999999", "16385"),
        ("big", "whole number"),
    ] {
        let terrain = format!("builtin:ridges?size={size}");
        refused(&folder, &terrain, &["size", says]);
    }
    refused(&folder, "builtin:ridges?sise=65", &["sise", "size"]);
}

#[test]
fn a_word_for_level_of_detail_that_stands_apart_is_told_how_to_join_it() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    for word in ["on", "off"] {
        folder
            .run(&format!("render --lod {word} --view v.toml -o i.png"))
            .failed(2, &[&format!("--lod={word}")]);
    }
    // A file may be called so.
    folder.write(
        "on",
        "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2\n3 4\n",
    );
    folder.run("render --lod on --view v.toml -o i.png").done();
}

#[test]
fn a_photograph_that_is_none_or_lies_elsewhere() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    folder.write("photo.png", "no picture");
    let render = "render builtin:ridges?size=33 --view v.toml -o i.png";
    for photo in ["photo.png", "none.jpg"] {
        let failed = folder.run(&format!("{render} --photo {photo}"));
        failed.failed(1, &[photo]);
    }
    assert_eq!(folder.names(), ["photo.png", "v.toml"]);
}

#[test]
fn a_view_file_that_is_absent_or_odd() {
    let folder = Folder::new();
    let render = "render builtin:ridges?size=33 --view v.toml -o i.png";
    folder.run(render).failed(1, &["v.toml", "No such file"]);
    for (text, says) in [
        (
            format!("{VIEW}zoom = 3\n"),
            &["line 4", "zoom", "expected"][..],
        ),
        (VIEW.replace("size", "sizes"), &["sizes"]),
        (VIEW.replace("[16, 16]", "[0, 16]"), &["size", "1 to 32768"]),
        (VIEW.replace("[16, 16]", "[16, \"x\"]"), &["line 1"]),
        (
            VIEW.replace("60.0 }", "200.0 }"),
            &["horizontal_fov", "180"],
        ),
        (
            VIEW.replace("camera", "#"),
            &["camera", "screen", "neither"],
        ),
        ("size = [".to_owned(), &["line 1"]),
    ] {
        folder.write("v.toml", text);
        let said = folder.run(render).failed(1, says);
        assert!(said.contains("v.toml"), "{said}");
    }
    assert_eq!(folder.names(), ["v.toml"]);
}

#[test]
fn a_rig_with_an_unknown_key_names_file_line_and_key() {
    let folder = Folder::new();
    let rig = "name = \"mine\"\n\n[camera]\nhorizontal_fof = 60.0\n";
    folder.write("rig.toml", rig);
    let fly = "fly --headless --size 16x16 --seconds 0.05 -o f.avi --rig";
    let says = [
        "rig.toml, line 4",
        "camera.horizontal_fof",
        "horizontal_fov",
    ];
    folder.run(&format!("{fly} rig.toml")).failed(1, &says);
    folder.write("rig.toml", "name = \"mine\"\n[camera\n");
    folder
        .run(&format!("{fly} ./rig.toml"))
        .failed(1, &["rig.toml, line 2", "TOML"]);
    folder
        .run(&format!("{fly} none.toml"))
        .failed(1, &["none.toml", "desktop, workbench"]);
    folder
        .run(&format!("{fly} bench"))
        .failed(2, &["bench", "desktop", "workbench"]);
}

#[test]
fn a_port_for_a_device_needs_its_name() {
    let folder = Folder::new();
    let fly = "fly --headless --size 16x16 --seconds 0.05 -o f.avi --rig workbench --device";
    let syntax = ["/dev/ttyUSB1", "NAME=PORT", "flock=/dev/ttyUSB1"];
    folder
        .run(&format!("{fly} /dev/ttyUSB1"))
        .failed(2, &syntax);
    folder
        .run(&format!("{fly} flok=/dev/ttyUSB1"))
        .failed(2, &["flok", "it has: flock"]);
    folder
        .run(&format!("{fly} flock=/dev/x;reboot"))
        .failed(2, &["/dev/x;reboot"]);
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn a_recording_that_is_none_or_holds_nothing() {
    let folder = Folder::new();
    let replay = "fly --headless -o f.avi --replay";
    folder
        .run(&format!("{replay} none.mcap"))
        .failed(1, &["none.mcap", "sandtable record"]);
    folder.write("a.mcap", "");
    folder
        .run(&format!("{replay} a.mcap"))
        .failed(1, &["a.mcap", "no MCAP file"]);
    folder.write("a.mcap", "something else altogether");
    folder
        .run(&format!("{replay} a.mcap"))
        .failed(1, &["a.mcap", "no MCAP file"]);
    // The first bytes of one, torn before anything was told.
    folder.write("a.mcap", b"\x89MCAP0\r\n\x01\x40\0\0\0\0\0\0\0\x02\0\0\0sa");
    folder
        .run(&format!("{replay} a.mcap"))
        .failed(1, &["a.mcap", "breaks off", "byte 8"]);
    assert_eq!(folder.names(), ["a.mcap"]);
}
