//! `sandtable render`: sizes, depth, colours, and what it refuses.

use crate::formats::depth;
use crate::program::{Ended, Folder, sandtable, shared_data};

/// A camera straight above `[x, y, z]` metres, with a narrow view.
fn above([x, y, z]: [f64; 3]) -> String {
    format!(
        "size = [33, 33]\neye = [{x:?}, {y:?}, {z:?}]\n\
         camera = {{ pitch = -90.0, horizontal_fov = 0.5 }}\n"
    )
}

/// Column and row from the top left of the highest post of builtin:jacksboro, and its metres.
const PEAK: [f64; 3] = [219.0, 297.0, 1076.0];

/// From south of builtin:jacksboro, with sky and ground in view, for two eyes.
const VIEW: &str = "size = [48, 36]\neye = [15000.0, -500.0, 3000.0]\n\
                    camera = { pitch = -8.0, horizontal_fov = 60.0 }\n\
                    stereo = { separation = 300.0, screen_distance = 8000.0 }\n";

fn size(folder: &Folder, name: &str) -> (u32, u32) {
    image::image_dimensions(folder.file(name)).expect("an image")
}

#[test]
fn each_eye_keeps_its_full_size() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    for (mode, expected) in [
        ("mono", (48, 36)),
        ("anaglyph", (48, 36)),
        ("side-by-side", (96, 36)),
        ("top-bottom", (48, 72)),
    ] {
        let name = format!("{mode}.png");
        let arguments = format!("render --view v.toml --stereo {mode} -o {name}");
        let said = folder.run(&arguments).done();
        assert_eq!(said.out, "", "{mode}");
        assert_eq!(size(&folder, &name), expected, "{mode}");
    }
    // The same eyes, whichever way they share the image; and two different ones.
    let beside = image::open(folder.file("side-by-side.png"))
        .unwrap()
        .into_rgb8();
    let above = image::open(folder.file("top-bottom.png"))
        .unwrap()
        .into_rgb8();
    let red_cyan = image::open(folder.file("anaglyph.png"))
        .unwrap()
        .into_rgb8();
    let mut differ = 0;
    for (x, y) in (0..48).flat_map(|x| (0..36).map(move |y| (x, y))) {
        let [left, right] = [beside.get_pixel(x, y), beside.get_pixel(48 + x, y)];
        assert_eq!(
            (left, right),
            (above.get_pixel(x, y), above.get_pixel(x, 36 + y))
        );
        assert_eq!(red_cyan.get_pixel(x, y)[2], right[2]);
        differ += u32::from(left != right);
    }
    assert!(differ > 100, "{differ} pixels differ between the eyes");
}

#[test]
fn two_eyes_need_a_view_that_says_where_they_are() {
    let folder = Folder::new();
    folder.write("v.toml", above([15_000.0, 15_000.0, 5000.0]));
    for mode in ["anaglyph", "side-by-side", "top-bottom"] {
        let refused = folder.run(&format!("render --view v.toml --stereo {mode} -o i.png"));
        refused.failed(
            2,
            &["v.toml", "no `stereo`", "separation", "screen_distance"],
        );
    }
    assert_eq!(folder.names(), ["v.toml"]);
}

#[test]
fn depth_is_metres_from_the_eye_and_infinite_for_sky() {
    let folder = Folder::new();
    // The world position of the post on Cross Mountain, by the ellipsoid at the data's mid-latitude:
    // 344 rows of posts, 3 arc-seconds apart, from 36.16° north.
    let step = (3.0_f64 / 3600.0).to_radians();
    let middle = 36.16_f64.to_radians() + 0.5 * 343.0 * step;
    let (a, f) = (6_378_137.0, 1.0 / 298.257_223_563);
    let e2 = f * (2.0 - f);
    let w2 = 1.0 - e2 * middle.sin().powi(2);
    let [dx, dy] = [
        a / w2.sqrt() * middle.cos() * step,
        a * (1.0 - e2) / w2.powf(1.5) * step,
    ];
    let [col, row, height] = PEAK;
    let eye = [col * dx, (343.0 - row) * dy, 5000.0];
    folder.write("v.toml", above(eye));
    folder
        .run("render --view v.toml -o i.png --depth d.tif")
        .done();
    let (size, values) = depth(&folder.file("d.tif"));
    assert_eq!(size, [33, 33]);
    let middle = f64::from(values[16 * 33 + 16]);
    assert!((middle - (5000.0 - height)).abs() < 0.01, "{middle} m");

    folder.write("v.toml", VIEW);
    folder
        .run("render --view v.toml -o i.png --depth d.tif")
        .done();
    let (size, values) = depth(&folder.file("d.tif"));
    assert_eq!(size, [48, 36]);
    assert!(values[..48].iter().all(|&depth| depth == f32::INFINITY));
    assert!(
        values[35 * 48..]
            .iter()
            .all(|&depth| depth > 1000.0 && depth.is_finite())
    );
}

#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    for caster in ["coherent", "brute"] {
        for threads in ["1", "2", "5"] {
            let arguments = format!(
                "render builtin:ridges?size=129&seed=3 --view v.toml --caster {caster} \
                 --threads {threads} --stereo anaglyph -o {threads}.png --depth {threads}.tif"
            );
            folder.run(&arguments).done();
        }
        for other in ["2", "5"] {
            for ending in ["png", "tif"] {
                let [one, more] = ["1", other].map(|n| folder.read(&format!("{n}.{ending}")));
                assert!(one == more, "{caster}: {other} threads, .{ending}");
            }
        }
    }
}

#[test]
fn a_photograph_colours_the_ground() {
    let Some(data) = shared_data() else { return };
    let folder = Folder::new();
    let [dem, photo] = ["rmnp/rmnp-dem-utm13.tif", "rmnp/rmnp-rgb-utm13.tif"].map(|f| data.join(f));
    for [col, row] in [[180, 221], [100, 300]] {
        let mut info = sandtable(folder.path());
        info.args(["info", "--json"]).arg(&photo);
        let said = Ended::of(info.arg(format!("--cell={col},{row}")))
            .done()
            .out;
        let said: serde_json::Value = serde_json::from_str(&said).unwrap();
        let cell = &said["samples"][0];
        // The world's origin is the centre of the DEM's south-west cell, 200 m wide.
        let [x, y] = [("x", 422_300.0), ("y", 4_445_700.0)]
            .map(|(axis, origin)| cell[axis].as_f64().unwrap() - origin);
        folder.write("v.toml", above([x, y, 9000.0]));
        let mut render = sandtable(folder.path());
        render.arg("render").arg(&dem).arg("--photo").arg(&photo);
        Ended::of(render.args(["--view", "v.toml", "-o", "i.png"])).done();
        let image = image::open(folder.file("i.png")).unwrap().into_rgb8();
        for (band, &found) in image.get_pixel(16, 16).0.iter().enumerate() {
            let expected = cell["value"][band].as_i64().unwrap();
            let off = (i64::from(found) - expected).abs();
            assert!(
                off <= 2,
                "cell {col},{row} band {band}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn the_ending_says_which_kind_of_image() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    folder.run("render --view v.toml -o deep/er/i.JPG").done();
    let bytes = folder.read("deep/er/i.JPG");
    let format = image::guess_format(&bytes).unwrap();
    assert_eq!(format, image::ImageFormat::Jpeg);
    for odd in ["i.gif", "i", "i.png.txt"] {
        let refused = folder.run(&format!("render --view v.toml -o {odd}"));
        refused.failed(2, &[odd, ".png or .jpg"]);
    }
    assert_eq!(folder.names(), ["deep", "v.toml"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_terrains_name_need_not_be_unicode() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    let name = std::ffi::OsStr::from_bytes(b"fl\xe4che.asc");
    let grid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2\n3 4\n";
    std::fs::write(folder.path().join(name), grid).unwrap();
    folder.write("v.toml", VIEW);
    for arguments in [
        "render --view v.toml -o i.png",
        "bench --view v.toml --threads 1 --frames 1",
        "fly --headless --size 16x16 --seconds 0.05 -o f.avi",
    ] {
        let mut command = sandtable(folder.path());
        Ended::of(command.args(arguments.split(' ')).arg(name)).done();
    }
    let mut command = sandtable(folder.path());
    let odd = std::ffi::OsStr::from_bytes(b"builtin:fl\xe4che");
    let arguments = ["render", "--view", "v.toml", "-o", "i.png"];
    Ended::of(command.args(arguments).arg(odd)).failed(2, &["no builtin terrain"]);
}

#[test]
fn the_views_that_the_documentation_shows_see_the_terrain() {
    let folder = Folder::new();
    let page = include_str!("../../../docs/views.md");
    let views: Vec<_> = page.split("```toml\n").skip(1).collect();
    assert_eq!(views.len(), 2);
    for view in views {
        let (view, _) = view.split_once("```").expect("its end");
        folder.write("v.toml", view);
        folder
            .run("render --view v.toml --stereo side-by-side -o i.png --depth d.tif")
            .done();
        let (_, values) = depth(&folder.file("d.tif"));
        let ground = values.iter().filter(|depth| depth.is_finite()).count();
        assert!(
            2 * ground > values.len(),
            "{ground} pixels of ground:\n{view}"
        );
    }
}

#[test]
fn an_unknown_caster_is_told_the_casters() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    let refused = folder.run("render --view v.toml --caster fast -o i.png");
    refused.failed(2, &["fast", "coherent", "brute"]);
    folder.run("render -o i.png").failed(2, &["--view"]);
}
