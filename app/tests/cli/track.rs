//! `sandtable render --path`: flights along GPX tracks.

use crate::formats::{avi, wav_seconds};
use crate::program::{Folder, shared_data};

const VIEW: &str = "size = [40, 30]\neye = [0.0, 0.0, 0.0]\n\
                    camera = { horizontal_fov = 70.0 }\n\
                    stereo = { separation = 30.0, screen_distance = 2000.0 }\n";

/// A track of points: degrees of latitude and longitude, and what else is known of them.
fn track(points: &[(f64, f64, &str)]) -> String {
    let points: String = points
        .iter()
        .map(|(lat, lon, more)| format!("<trkpt lat=\"{lat}\" lon=\"{lon}\">{more}</trkpt>"))
        .collect();
    format!(
        "<?xml version=\"1.0\"?><gpx version=\"1.1\" creator=\"a test\" \
         xmlns=\"http://www.topografix.com/GPX/1/1\"><trk><trkseg>{points}</trkseg></trk></gpx>"
    )
}

/// What a film of `terrain` along hike.gpx is made by.
fn film(terrain: &str, more: &str) -> String {
    format!("render {terrain} --path hike.gpx --view v.toml -o hike.avi --audio hike.wav{more}")
}

/// A park's terrain in two coordinate systems, if it is there.
fn park() -> Option<[String; 2]> {
    let data = shared_data()?;
    Some(["rmnp-dem-utm13.tif", "rmnp-dem.tif"].map(|name| {
        let path = data.join("rmnp").join(name);
        path.to_str().expect("a path without oddities").to_owned()
    }))
}

#[test]
fn a_track_with_times_lasts_as_long_as_it_took() {
    let Some(park) = park() else { return };
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    let at = |second| format!("<ele>4400</ele><time>2026-05-01T10:00:0{second}Z</time>");
    let [first, last] = [at(0), at(2)];
    let points = [(40.30, -105.70, &*first), (40.32, -105.69, &*last)];
    folder.write("hike.gpx", track(&points));
    for terrain in park {
        let said = folder.run(&film(&terrain, "")).done().out;
        assert!(said.contains("hike.avi: 60 frames, 2.0 s"), "{said}");
        let film = avi(&folder.read("hike.avi"));
        assert_eq!((film.size, film.frames), ([40, 30], 60), "{terrain}");
        assert_eq!((film.frames_per_second, film.pictures.len()), (30, 60));
        assert_ne!(film.pictures[0], film.pictures[59], "it stands still");
        let seconds = wav_seconds(&folder.read("hike.wav"));
        assert!((seconds - 2.0).abs() < 1e-3, "{seconds} s of sound");
    }
}

/// Receivers note several points a second; an earlier time than before is an error of theirs.
#[test]
fn points_at_the_same_time_leave_the_times_and_earlier_ones_do_not() {
    let Some([terrain, _]) = park() else { return };
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    let at = |second| format!("<ele>4400</ele><time>2026-05-01T10:00:0{second}Z</time>");
    for (seconds, is_timed) in [([0, 0, 2], true), ([0, 2, 1], false)] {
        let [a, b, c] = seconds.map(at);
        let points = [
            (40.30, -105.70, &*a),
            (40.301, -105.70, &*b),
            (40.302, -105.69, &*c),
        ];
        folder.write("hike.gpx", track(&points));
        let ran = folder.run(&film(&terrain, " --flight 20000 300")).done();
        let said = format!("{}{}", ran.out, ran.err);
        let film = avi(&folder.read("hike.avi"));
        assert_eq!(
            film.frames == 60,
            is_timed,
            "{} frames: {said}",
            film.frames
        );
        let note = "the times in hike.gpx are left out";
        assert_eq!(said.contains(note), !is_timed, "{said}");
    }
}

#[test]
fn a_track_without_times_is_flown_at_the_speed_and_height_asked_for() {
    let Some([terrain, _]) = park() else { return };
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    // 0.018 degrees of latitude: 2 km, in a second at 2 km a second.
    let points = [(40.300, -105.70, ""), (40.318, -105.70, "")];
    folder.write("hike.gpx", track(&points));
    let stereo = " --flight 2000 300 --stereo side-by-side";
    folder.run(&film(&terrain, stereo)).done();
    let film = avi(&folder.read("hike.avi"));
    assert_eq!(film.size, [80, 30]);
    // The ground rises along the way: a little longer than on the map.
    assert!((30..=33).contains(&film.frames), "{} frames", film.frames);
    let seconds = wav_seconds(&folder.read("hike.wav"));
    assert!((seconds - f64::from(film.frames) / 30.0).abs() < 1e-3);
}

#[test]
fn tracks_that_cannot_be_flown_are_refused_and_the_last_film_stays() {
    let Some([terrain, _]) = park() else { return };
    let folder = Folder::new();
    folder.write("v.toml", VIEW);
    folder.write("hike.avi", "an earlier film");
    let here = (40.3, -105.7, "");
    for (points, says) in [
        (
            &[(47.0, 8.0, ""), (47.1, 8.0, "")][..],
            "lies over the terrain",
        ),
        (&[here][..], "two points or more"),
        // A hundred kilometres at a metre a second.
        (&[here, (41.3, -105.7, "")][..], "--flight SPEED HEIGHT"),
    ] {
        folder.write("hike.gpx", track(points));
        let refused = folder.run(&film(&terrain, " --flight 1 300"));
        refused.failed(1, &["hike.gpx", says]);
    }
    folder.write("hike.gpx", "no track");
    let refused = folder.run(&film(&terrain, ""));
    refused.failed(1, &["hike.gpx", "not a GPX file"]);
    let refused = folder.run(&film(&terrain, " --flight 0 300"));
    refused.failed(2, &["--flight", "above 0"]);
    assert_eq!(folder.read("hike.avi"), b"an earlier film");
    assert_eq!(folder.names(), ["hike.avi", "hike.gpx", "v.toml"]);
}

/// Posts around 46.005 N, 8.005 E, all at sea level.
const FLAT: &str = "ncols 3\nnrows 3\nxllcorner 8\nyllcorner 46\ncellsize 0.004\n\
                    0 0 0\n0 0 0\n0 0 0\n";

#[test]
fn an_elevation_that_no_place_has_is_refused_by_its_point() {
    let folder = Folder::new();
    folder.write("flat.asc", FLAT);
    folder.write("v.toml", VIEW);
    for odd in ["1e400", "1e300", "-100001", "NaN", "inf"] {
        let odd = format!("<ele>{odd}</ele>");
        // Times, so that the film is short however far it is.
        let at = |ele: &str, second| format!("{ele}<time>2026-05-01T10:00:0{second}Z</time>");
        let [first, last] = [at("<ele>90</ele>", 0), at(&odd, 1)];
        let points = [(46.005, 8.005, &*first), (46.006, 8.006, &*last)];
        folder.write("hike.gpx", track(&points));
        let refused = folder.run(&film("flat.asc", ""));
        refused.failed(
            1,
            &["hike.gpx", "point 2", "46.006 N, 8.006 E", "elevation"],
        );
    }
    let refused = folder.run(&film("flat.asc", " --flight 100 1e300"));
    refused.failed(2, &["--flight", "100000 m"]);
}

#[test]
fn a_track_that_takes_longer_than_a_film_may_is_told_what_shortens_it() {
    let folder = Folder::new();
    folder.write("flat.asc", FLAT);
    folder.write("v.toml", VIEW);
    let at = |hour| format!("<ele>90</ele><time>2026-05-01T{hour}:00:00Z</time>");
    let [first, last] = [at("10"), at("12")];
    let points = [(46.005, 8.005, &*first), (46.006, 8.006, &*last)];
    folder.write("hike.gpx", track(&points));
    let refused = folder.run(&film("flat.asc", ""));
    let said = refused.failed(1, &["hike.gpx", "7200 s", "take its times out"]);
    assert!(!said.contains("higher speed"), "{said}");
    folder.write(
        "hike.gpx",
        track(&points.map(|(lat, lon, _)| (lat, lon, ""))),
    );
    let refused = folder.run(&film("flat.asc", " --flight 0.001 100"));
    let said = refused.failed(1, &["hike.gpx", "higher speed"]);
    assert!(!said.contains("times"), "{said}");
}

#[test]
fn a_track_that_cannot_be_read_is_told_where() {
    let folder = Folder::new();
    folder.write("flat.asc", FLAT);
    folder.write("v.toml", VIEW);
    folder.write("hike.gpx", track(&[(46.0, 8.0, "<ele>\n\nhigh</ele>")]));
    let refused = folder.run(&film("flat.asc", ""));
    refused.failed(
        1,
        &["hike.gpx", "line 3", "a number", "export the track anew"],
    );
    std::fs::create_dir(folder.file("hikes")).unwrap();
    let refused = folder.run("render flat.asc --path hikes -o hike.avi");
    refused.failed(1, &["hikes is a folder", "name a file in it"]);
}

#[test]
fn a_film_in_an_unknown_form_is_refused() {
    let Some([terrain, _]) = park() else { return };
    let folder = Folder::new();
    let points = [(40.30, -105.70, ""), (40.32, -105.69, "")];
    folder.write("hike.gpx", track(&points));
    let refused = folder.run(&format!("render {terrain} --path hike.gpx -o hike.gif"));
    refused.failed(2, &["hike.gif", ".avi", ".mp4", "folder"]);
}
