//! `sandtable fly` without a display: a flight to a file.

use crate::formats::{avi, wav_seconds};
use crate::program::Folder;

/// How far two pictures are apart, on average over pixels and colours.
fn difference(one: &image::RgbImage, other: &image::RgbImage) -> f64 {
    let total: u64 = one
        .iter()
        .zip(other.iter())
        .map(|(a, b)| u64::from(a.abs_diff(*b)))
        .sum();
    total as f64 / one.len() as f64
}

#[test]
fn without_a_display_a_stereo_flight_is_written_and_said_where() {
    let folder = Folder::new();
    // No argument says where: it must work in an empty folder.
    let said = folder
        .run("fly --size 64x48 --seconds 0.1 --audio f.wav")
        .done()
        .out;
    for part in [
        "no display",
        "DISPLAY",
        "out/flight.avi",
        "side-by-side",
        "f.wav",
    ] {
        assert!(said.contains(part), "no {part:?} in {said}");
    }
    let film = avi(&folder.read("out/flight.avi"));
    assert_eq!(
        (film.size, film.frames, film.frames_per_second),
        ([128, 48], 3, 30)
    );
    let seconds = wav_seconds(&folder.read("f.wav"));
    assert!((seconds - 0.1).abs() < 1e-3, "{seconds} s of sound");
    for picture in &film.pictures {
        let eye = |x| image::imageops::crop_imm(picture, x, 0, 64, 48).to_image();
        let apart = difference(&eye(0), &eye(64));
        assert!(apart > 1.0, "both eyes see the same: {apart}");
        let [top, bottom] = [picture.get_pixel(5, 1), picture.get_pixel(32, 44)];
        assert!(top[2] > top[0], "no sky above: {top:?}");
        assert_ne!(top, bottom);
    }
}

#[test]
fn asking_for_no_window_gives_none_and_images_where_a_folder_is_named() {
    let folder = Folder::new();
    let said = folder
        .run("builtin:ridges?size=65 --headless --size 40x30 --seconds 0.05 --stereo mono -o film/")
        .done()
        .out;
    assert!(
        said.contains("--headless") && said.contains("film"),
        "{said}"
    );
    for frame in ["film/frame_00000.png", "film/frame_00001.png"] {
        let size = image::image_dimensions(folder.file(frame)).unwrap();
        assert_eq!(size, (40, 30));
    }
    let images = std::fs::read_dir(folder.file("film")).unwrap().count();
    assert_eq!(images, 2);
}

#[test]
fn at_a_table_the_head_sways_over_it() {
    let folder = Folder::new();
    // A minute is one sway; its first seconds move the head to the right.
    let arguments = "fly --rig workbench --headless --size 90x55 --seconds 3 -o film";
    let said = folder.run(arguments).done().out;
    assert!(said.contains("not used for it (flock)"), "{said}");
    let frame = |number: u32| {
        let name = format!("film/frame_{number:05}.png");
        image::open(folder.file(&name)).unwrap().into_rgb8()
    };
    let [first, last] = [frame(0), frame(89)];
    assert_eq!(first.dimensions(), (180, 55));
    assert!(!folder.file("film/frame_00090.png").exists());
    let moved = difference(&first, &last);
    assert!(moved > 1.0, "the head rests: {moved}");
}

#[test]
fn a_flight_that_fails_leaves_what_was_there() {
    let folder = Folder::new();
    folder.write("flight.avi", "an earlier flight");
    folder.write("frames.txt", "a file of mine");
    for (arguments, code, says) in [
        ("nowhere.tif -o flight.avi", 1, "nowhere.tif"),
        ("--caster fast -o flight.avi", 2, "coherent"),
        ("--seconds 0 -o flight.avi", 2, "--seconds"),
        ("--size 5x5 -o flight.avi", 2, "16"),
        ("-o frames.txt", 2, ".mp4"),
        ("--record r.mcap -o flight.avi", 2, "sandtable record"),
        ("--latency -o flight.avi", 2, "tracked head"),
        ("--latency --rig workbench -o flight.avi", 2, "a display"),
        ("--latency --replay r.mcap -o flight.avi", 2, "--replay"),
    ] {
        let failed = folder.run(&format!("fly --headless {arguments}"));
        failed.failed(code, &[says]);
    }
    assert_eq!(folder.read("flight.avi"), b"an earlier flight");
    assert_eq!(folder.names(), ["flight.avi", "frames.txt"]);
}

#[cfg(unix)]
#[test]
fn a_flight_that_is_interrupted_leaves_what_was_there_and_says_so() {
    use crate::program::{Running, sandtable, wait_for};
    for output in ["flight.avi", "flight"] {
        let folder = Folder::new();
        let mut command = sandtable(folder.path());
        let arguments = format!("builtin:ridges?size=65 --headless --seconds 3600 -o {output}");
        command.args(arguments.split(' '));
        let said = std::fs::File::create(folder.file("said")).expect("a file");
        command.stdout(std::process::Stdio::null()).stderr(said);
        let mut flight = Running(command.spawn().expect("the program starts"));
        let unfinished = folder.file(&format!("{output}.part"));
        wait_for("the film", || unfinished.exists().then_some(()));
        flight.signal("TERM");
        assert_eq!(flight.end().code(), Some(1));
        let said = String::from_utf8_lossy(&folder.read("said")).into_owned();
        for part in ["interrupted", "108000 frames", output, "is not written"] {
            assert!(said.contains(part), "no {part:?} in {said}");
        }
        assert_eq!(folder.names(), ["said"]);
    }
}
