//! Outputs that would take the place of what is read, or of one another.

use crate::program::Folder;

const VIEW: &str = "size = [16, 16]\neye = [50.0, 50.0, 90.0]\n\
                    camera = { pitch = -20.0, horizontal_fov = 60.0 }\n";
const GRID: &str = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2\n3 4\n";

#[test]
fn no_output_takes_the_place_of_what_is_read() {
    let folder = Folder::new();
    let inputs = [
        ("v.toml", VIEW),
        ("f.asc", GRID),
        ("f.tif", GRID),
        ("p.png", "a photo"),
        ("v.png", VIEW),
        ("track.avi", "a track"),
        ("track.wav", "a track"),
    ];
    for (name, text) in inputs {
        folder.write(name, text);
    }
    for (arguments, named) in [
        ("render f.asc --photo p.png --view v.toml -o p.png", "p.png"),
        (
            "render f.asc --photo p.png --view v.toml -o ./p.png",
            "p.png",
        ),
        ("render f.asc --view v.png -o v.png", "v.png"),
        ("render f.tif --view v.toml -o i.png --depth f.tif", "f.tif"),
        ("render f.asc --path track.avi -o track.avi", "track.avi"),
        (
            "render f.asc --path track.wav -o film.avi --audio track.wav",
            "track.wav",
        ),
        ("bench f.asc --plot f.asc", "f.asc"),
        ("bench f.asc --view v.toml --plot v.toml", "v.toml"),
        (
            "fly f.asc --photo track.avi --headless -o track.avi",
            "track.avi",
        ),
        ("fly f.asc --headless -o f.avi --audio f.asc", "f.asc"),
    ] {
        folder
            .run(arguments)
            .failed(2, &[named, "would overwrite", "which is read"]);
    }
    for (name, text) in inputs {
        assert_eq!(folder.read(name), text.as_bytes(), "{name}");
    }
    assert_eq!(folder.names().len(), inputs.len());
}

#[test]
fn no_output_takes_the_place_of_another() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    for (arguments, named) in [
        (
            "render --view v.toml -o same.png --depth same.png",
            ["--output same.png", "--depth same.png"],
        ),
        (
            "fly --headless -o same.avi --audio ./same.avi",
            ["--output same.avi", "--audio ./same.avi"],
        ),
    ] {
        folder.run(arguments).failed(2, &named);
    }
    assert_eq!(folder.names(), ["v.toml"]);
}

#[test]
fn a_plot_is_written_under_no_name_that_says_otherwise() {
    let folder = Folder::new();
    folder.write("p.tif", "another's photo");
    for odd in ["p.tif", "p", "p.svg.txt"] {
        let arguments = format!("bench --frames 1 --plot {odd}");
        folder.run(&arguments).failed(2, &[odd, "end in .svg"]);
    }
    assert_eq!(folder.read("p.tif"), b"another's photo");
}

#[test]
fn depth_is_written_under_no_name_that_says_otherwise() {
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    for odd in ["d.png", "d", "d.tif.txt"] {
        folder
            .run(&format!("render --view v.toml -o i.png --depth {odd}"))
            .failed(2, &[odd, ".tif"]);
    }
    assert_eq!(folder.names(), ["v.toml"]);
}
