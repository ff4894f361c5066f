//! Videos read back, by a parser of our own, by the image crate and, where it is, by ffprobe.

use std::fs;
use std::process::Command;

use super::*;

/// A frame that differs everywhere and from frame to frame, yet smooth enough for JPEG.
fn frame([width, height]: [u32; 2], number: u32) -> Vec<[u8; 4]> {
    let ramp = |at: u32, of: u32| (at * 255 / of.max(2).saturating_sub(1)).min(255) as u8;
    (0..height)
        .flat_map(|y| {
            (0..width).map(move |x| [ramp(x, width), ramp(y, height), (number * 40) as u8, 0])
        })
        .collect()
}

fn write(path: &Path, size: [u32; 2], frames: u32) {
    let mut video = VideoWriter::create(path, size, 25).unwrap();
    for number in 0..frames {
        video.push(&frame(size, number)).unwrap();
    }
    video.finish().unwrap();
}

fn largest_difference(image: &image::RgbImage, pixels: &[[u8; 4]]) -> u8 {
    image
        .pixels()
        .zip(pixels)
        .flat_map(|(a, b)| (0..3).map(|c| a.0[c].abs_diff(b[c])))
        .max()
        .unwrap()
}

fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// The chunks from `at` to `end`: code, where its content begins, its length.
fn chunks(bytes: &[u8], mut at: usize, end: usize) -> Vec<([u8; 4], usize, usize)> {
    let mut found = Vec::new();
    while at < end {
        let length = number(bytes, at + 4) as usize;
        found.push((bytes[at..at + 4].try_into().unwrap(), at + 8, length));
        at += 8 + length + length % 2;
    }
    assert_eq!(at, end, "chunks fill what holds them");
    found
}

#[test]
fn an_avi_reads_back_by_its_sizes_counts_and_index() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.AVI");
    let size = [97, 61];
    write(&path, size, 5);

    let bytes = fs::read(&path).unwrap();
    let riff = chunks(&bytes, 0, bytes.len());
    assert_eq!((riff.len(), riff[0].0), (1, *b"RIFF"));
    assert_eq!(&bytes[8..12], b"AVI ");
    let parts = chunks(&bytes, 12, bytes.len());
    let codes: Vec<_> = parts.iter().map(|p| p.0).collect();
    assert_eq!(codes, [*b"LIST", *b"LIST", *b"idx1"]);

    let (_, header, length) = parts[0];
    assert_eq!(&bytes[header..header + 4], b"hdrl");
    let headers = chunks(&bytes, header + 4, header + length);
    assert_eq!(headers[0].0, *b"avih");
    let main: Vec<u32> = (0..14)
        .map(|i| number(&bytes, headers[0].1 + 4 * i))
        .collect();
    assert_eq!(main[0], 40_000, "microseconds a frame");
    assert_eq!((main[4], main[6]), (5, 1), "frames and streams");
    assert_eq!([main[8], main[9]], size);
    let (_, stream, length) = headers[1];
    let stream = chunks(&bytes, stream + 4, stream + length);
    assert_eq!((stream[0].0, stream[1].0), (*b"strh", *b"strf"));
    assert_eq!(&bytes[stream[0].1..stream[0].1 + 8], b"vidsMJPG");
    assert_eq!(number(&bytes, stream[0].1 + 24), 25, "rate");
    assert_eq!(number(&bytes, stream[0].1 + 32), 5, "length");
    assert_eq!(number(&bytes, stream[1].1 + 4), 97);
    assert_eq!(&bytes[stream[1].1 + 16..stream[1].1 + 20], b"MJPG");

    let (_, movi, length) = parts[1];
    assert_eq!(&bytes[movi..movi + 4], b"movi");
    let frames = chunks(&bytes, movi + 4, movi + length);
    let (_, index, length) = parts[2];
    assert_eq!((frames.len(), length), (5, 5 * 16));
    for (i, &(code, at, length)) in frames.iter().enumerate() {
        let entry = index + 16 * i;
        assert_eq!((&bytes[entry..entry + 4], code), (&b"00dc"[..], *b"00dc"));
        assert_eq!(number(&bytes, entry + 8) as usize, at - 8 - movi, "offset");
        assert_eq!(number(&bytes, entry + 12) as usize, length);
        let image = image::load_from_memory(&bytes[at..at + length])
            .unwrap()
            .to_rgb8();
        assert_eq!([image.width(), image.height()], size);
        let off = largest_difference(&image, &frame(size, i as u32));
        assert!(off <= 8, "frame {i} is off by {off}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_folder_takes_numbered_pngs_that_are_exact() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight/");
    write(&path, [31, 17], 3);
    let mut names: Vec<_> = fs::read_dir(&path)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(
        names,
        ["frame_00000.png", "frame_00001.png", "frame_00002.png"]
    );
    let image = image::open(path.join("frame_00002.png")).unwrap().to_rgb8();
    assert_eq!(largest_difference(&image, &frame([31, 17], 2)), 0);
}

#[test]
fn a_shorter_sequence_replaces_a_longer_one_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight");
    write(&path, [8, 8], 4);
    write(&path, [8, 8], 2);
    assert_eq!(fs::read_dir(&path).unwrap().count(), 2);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_folder_with_other_things_in_it_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("thesis.txt"), "years").unwrap();
    let error = VideoWriter::create(folder.path(), [8, 8], 25)
        .err()
        .unwrap();
    assert!(error.to_string().contains("thesis.txt"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_run_that_breaks_off_leaves_the_earlier_video_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let [avi, stills] = ["a.avi", "stills"].map(|name| folder.path().join(name));
    fs::write(&avi, "earlier").unwrap();
    write(&stills, [8, 8], 4);
    for path in [&avi, &stills] {
        let mut video = VideoWriter::create(path, [8, 8], 25).unwrap();
        video.push(&frame([8, 8], 0)).unwrap();
        drop(video);
    }
    assert_eq!(fs::read_to_string(&avi).unwrap(), "earlier");
    assert_eq!(fs::read_dir(&stills).unwrap().count(), 4);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_run_that_was_killed_does_not_stop_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let [avi, stills] = ["a.avi", "stills"].map(|name| folder.path().join(name));
    fs::write(folder.path().join("a.avi.part"), vec![7; 100_000]).unwrap();
    write(&folder.path().join("stills.part/"), [8, 8], 9);
    for path in [&avi, &stills] {
        write(path, [8, 8], 2);
    }
    let bytes = fs::read(&avi).unwrap();
    chunks(&bytes, 0, bytes.len());
    assert_eq!(fs::read_dir(&stills).unwrap().count(), 2);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn misfits_are_one_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let create = |name: &str, size| VideoWriter::create(&at(name), size, 25).err();
    let says = |error: Option<VideoError>, what: &str| {
        let text = error.expect("it fails").to_string();
        assert!(text.contains(what), "{text}");
    };
    says(create("a.mov", [8, 8]), ".avi, .mp4 and .webm");
    says(create("a.avi", [0, 8]), "0 x 8");
    says(create("a.avi", [65_536, 8]), "65536");
    says(
        VideoWriter::create(&at("a.avi"), [8, 8], 0).err(),
        "0 frames per second",
    );
    says(create("none/a.avi", [8, 8]), "a.avi");
    says(create("none/stills", [8, 8]), "stills");
    says(create("none/a.mp4", [8, 8]), "folder exists");
    fs::create_dir(at("folder.avi")).unwrap();
    says(create("folder.avi", [8, 8]), "folder.avi");

    let mut video = VideoWriter::create(&at("a.avi"), [8, 8], 25).unwrap();
    says(video.push(&[[0; 4]; 63]).err(), "63 pixels");
    says(video.finish().err(), "no frame");
    assert!(!at("a.avi").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.avi");
    std::os::unix::fs::symlink("/dev/full", folder.path().join("a.avi.part")).unwrap();
    let mut video = VideoWriter::create(&path, [64, 64], 25).unwrap();
    let pushed = (0..50).try_for_each(|i| video.push(&frame([64, 64], i)));
    let error = pushed
        .and_then(|()| video.finish())
        .unwrap_err()
        .to_string();
    assert!(error.contains("a.avi") && error.contains("room"), "{error}");
    assert!(!path.exists());
}

#[test]
fn without_ffmpeg_the_error_names_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mp4");
    let error = Ffmpeg::create_with("no-such-ffmpeg", &path, [8, 8], 25, Codec::H264).err();
    let text = error.unwrap().to_string();
    assert!(
        text.contains("apt install ffmpeg") && text.contains(".avi"),
        "{text}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(unix)]
#[test]
fn an_ffmpeg_that_fails_is_quoted() {
    let folder = tempfile::tempdir().unwrap();
    // Anything that does not know ffmpeg's options stands for an ffmpeg that lacks a codec.
    let path = folder.path().join("a.mp4");
    let mut ffmpeg = Ffmpeg::create_with("cat", &path, [256, 256], 25, Codec::H264).unwrap();
    let pushed = (0..4).try_for_each(|i| ffmpeg.push(&frame([256, 256], i)));
    let error = pushed
        .and_then(|()| ffmpeg.finish())
        .unwrap_err()
        .to_string();
    assert!(error.contains("a.mp4: cat: "), "{error}");
    assert!(!path.exists());
}

#[test]
fn players_take_every_form_with_odd_sizes() {
    if Command::new("ffprobe").arg("-version").output().is_err() {
        println!("skipped: there is no ffprobe to play videos with");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (name, codec, size) in [
        ("a.avi", "mjpeg", "97x61"),
        ("a.mp4", "h264", "98x62"),
        ("a.webm", "vp9", "98x62"),
    ] {
        let path = folder.path().join(name);
        write(&path, [97, 61], 6);
        let probe = Command::new("ffprobe")
            .args([
                "-v",
                "warning",
                "-count_frames",
                "-of",
                "csv=p=0:s=x",
                "-show_entries",
            ])
            .arg("stream=codec_name,width,height,r_frame_rate,nb_read_frames")
            .arg(&path)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&probe.stdout);
        assert_eq!(said.trim(), format!("{codec}x{size}x25/1x6"), "{name}");
        assert_eq!(String::from_utf8_lossy(&probe.stderr), "", "{name}");

        // What plays has the colours that were pushed.
        let still = folder.path().join("still.png");
        let played = Command::new("ffmpeg")
            .args(["-v", "error", "-y", "-i"])
            .arg(&path)
            .args([
                "-vf",
                "select=eq(n\\,3),crop=97:61:0:0:exact=1",
                "-frames:v",
                "1",
            ])
            .arg(&still)
            .status()
            .unwrap();
        assert!(played.success());
        let image = image::open(&still).unwrap().to_rgb8();
        let pixels = frame([97, 61], 3);
        let mean = image
            .pixels()
            .zip(&pixels)
            .flat_map(|(a, b)| (0..3).map(|c| f64::from(a.0[c].abs_diff(b[c]))))
            .sum::<f64>()
            / (3 * pixels.len()) as f64;
        assert!(mean < 4.0, "{name} is off by {mean:.1} on average");
    }
}
