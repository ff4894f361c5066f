//! Sound files: what is written reads back, and a failure names the file and harms none.

use std::fs;
use std::path::Path;

use glam::DVec3;
use sandtable_audio::{
    Settings, Soundscape, Source, WAV_SAMPLE_RATE, WavWriter, mixer, render_to_wav,
};

fn passing(t: f64) -> Soundscape {
    Soundscape {
        source: Some(Source::at(DVec3::new(2.0 * t - 1.0, 0.5, 0.0))),
        airspeed: 60.0 * t,
        ..Soundscape::default()
    }
}

#[test]
fn a_file_holds_the_rendered_samples_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pass.wav");
    let frames = 48_000 + 77;
    render_to_wav(&path, frames, Settings::default(), passing).unwrap();

    let mut reader = hound::WavReader::open(&path).unwrap();
    assert_eq!(reader.spec().sample_rate, WAV_SAMPLE_RATE);
    assert_eq!(reader.spec().channels, 2);
    assert_eq!(u64::from(reader.duration()), frames);
    let found: Vec<f32> = reader.samples().map(Result::unwrap).collect();

    let (mut control, mut mixer) = mixer(Settings::default(), WAV_SAMPLE_RATE);
    let mut expected = vec![[0.0; 2]; 48_000 + 77];
    for (i, block) in expected.chunks_mut(256).enumerate() {
        control.set(passing((i * 256) as f64 / 48_000.0));
        mixer.render(block);
    }
    assert_eq!(found, expected.as_flattened());
    // From left to right as time goes by.
    let side = |range: std::ops::Range<usize>, side: usize| {
        expected[range].iter().map(|f| f[side].powi(2)).sum::<f32>()
    };
    assert!(side(2000..12_000, 0) > 2.0 * side(2000..12_000, 1));
    assert!(side(38_000..48_000, 1) > side(38_000..48_000, 0));
}

#[test]
fn no_frames_make_a_valid_empty_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.wav");
    render_to_wav(&path, 0, Settings::default(), passing).unwrap();
    assert_eq!(hound::WavReader::open(&path).unwrap().duration(), 0);
}

#[test]
fn an_error_names_the_file() {
    let path = Path::new("/nonexistent/folder/flight.wav");
    let error = render_to_wav(path, 100, Settings::default(), passing).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("/nonexistent/folder/flight.wav"), "{text}");
    assert!(text.contains("folder exists"), "{text}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.wav");
    // What is written there meets a device that is always full.
    std::os::unix::fs::symlink("/dev/full", folder.path().join("flight.wav.part")).unwrap();
    let error = render_to_wav(&path, 48_000, Settings::default(), passing).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("flight.wav") && text.contains("room"),
        "{text}"
    );
    assert!(!path.exists());
}

#[test]
fn a_run_that_breaks_off_leaves_the_earlier_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.wav");
    fs::write(&path, "earlier").unwrap();
    let mut writer = WavWriter::create(&path).unwrap();
    writer.write(&[[0.5; 2]; 1000]).unwrap();
    drop(writer);
    assert_eq!(fs::read_to_string(&path).unwrap(), "earlier");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A device stays one: no file takes its place.
#[cfg(unix)]
#[test]
fn a_device_is_written_as_it_is() {
    use std::os::unix::fs::FileTypeExt;
    let null = std::path::Path::new("/dev/null");
    render_to_wav(null, 100, Settings::default(), passing).unwrap();
    assert!(null.metadata().unwrap().file_type().is_char_device());
    assert!(!std::path::Path::new("/dev/null.part").exists());
}
