//! What the samples themselves say: direction, distance, clicks, wind, silence, repeatability.

use std::f64::consts::TAU;

use glam::DVec3;
use sandtable_audio::{Listener, Settings, Soundscape, Source, Voice, mixer};

const RATE: u32 = 48_000;
const BLOCKS: [usize; 7] = [64, 128, 256, 512, 1024, 2048, 4096];
const HEAD: DVec3 = DVec3::new(0.1, -0.9, 0.6);

fn tone() -> Settings {
    Settings {
        voice: Voice::Tone { frequency: 440.0 },
        ..Settings::default()
    }
}

fn source_at(position: DVec3) -> Soundscape {
    Soundscape {
        listener: Listener::at_table(HEAD),
        source: Some(Source::at(position)),
        airspeed: 0.0,
    }
}

fn flying(airspeed: f64) -> Soundscape {
    Soundscape {
        airspeed,
        ..Soundscape::default()
    }
}

/// Renders in blocks of `block` frames, asking for the soundscape at each block's first frame.
fn render(
    settings: Settings,
    frames: usize,
    block: usize,
    soundscape: impl Fn(usize) -> Soundscape,
) -> Vec<[f32; 2]> {
    let (mut control, mut mixer) = mixer(settings, RATE);
    let mut out = vec![[0.0; 2]; frames];
    for (i, block_out) in out.chunks_mut(block).enumerate() {
        control.set(soundscape(i * block));
        mixer.render(block_out);
    }
    out
}

/// Root mean square of one side, after the first half second in which all targets are reached.
fn level(frames: &[[f32; 2]], side: usize) -> f64 {
    let settled = &frames[RATE as usize / 2..];
    let sum: f64 = settled.iter().map(|f| f64::from(f[side]).powi(2)).sum();
    (sum / settled.len() as f64).sqrt()
}

fn decibels(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

#[test]
fn the_nearer_side_is_louder_through_a_full_circle() {
    const STEPS: usize = 48;
    let levels: Vec<[f64; 2]> = (0..STEPS)
        .map(|step| {
            // Azimuth from straight ahead (+y), clockwise seen from above.
            let azimuth = TAU * step as f64 / STEPS as f64;
            let towards = DVec3::new(azimuth.sin(), azimuth.cos(), 0.3);
            let scape = source_at(HEAD + towards);
            let frames = render(tone(), RATE as usize, 512, |_| scape);
            [level(&frames, 0), level(&frames, 1)]
        })
        .collect();
    for (step, [left, right]) in levels.iter().enumerate() {
        match step {
            0 | 24 => assert!(decibels(left / right).abs() < 0.01, "middle at {step}"),
            1..24 => assert!(decibels(right / left) > 0.5, "right at {step}"),
            _ => assert!(decibels(left / right) > 0.5, "left at {step}"),
        }
        // The mirrored direction swaps the sides.
        let mirrored = levels[(STEPS - step) % STEPS];
        assert!((left - mirrored[1]).abs() < 1e-6 && (right - mirrored[0]).abs() < 1e-6);
        // Turning by itself changes no loudness.
        let power = left.hypot(*right) / levels[0][0].hypot(levels[0][1]);
        assert!(decibels(power).abs() < 0.05);
    }
    // And it grows louder on its side all the way to the ear.
    for step in 1..12 {
        assert!(levels[step + 1][1] > levels[step][1]);
        assert!(levels[step + 1][0] < levels[step][0]);
    }
}

#[test]
fn a_camera_hears_with_its_own_right_ear() {
    // Flying south, the right wing points west.
    let listener = Listener {
        position: DVec3::new(500.0, 500.0, 900.0),
        right: DVec3::new(-2.0, 0.0, 0.0),
    };
    let scape = Soundscape {
        listener,
        source: Some(Source {
            position: listener.position + DVec3::new(-300.0, 0.0, 0.0),
            level: 1.0,
            reference_distance: 100.0,
        }),
        airspeed: 0.0,
    };
    let frames = render(tone(), RATE as usize, 512, |_| scape);
    assert!(level(&frames, 1) > 0.05 && level(&frames, 0) < 1e-6);
}

#[test]
fn the_level_falls_by_6_db_a_doubling_beyond_the_reference_distance() {
    let loudness = |distance: f64| {
        let scape = source_at(HEAD + DVec3::new(0.48, 0.6, 0.64) * distance);
        let frames = render(tone(), RATE as usize, 512, |_| scape);
        level(&frames, 0).hypot(level(&frames, 1))
    };
    // A sine of amplitude one half at the reference distance.
    let reference = loudness(0.25);
    assert!(decibels(reference / (0.5 / 2.0_f64.sqrt())).abs() < 0.05);
    for doublings in 1..=8 {
        let found = decibels(loudness(0.25 * 2.0_f64.powi(doublings)) / reference);
        let law = -20.0 * 2.0_f64.log10() * f64::from(doublings);
        assert!((found - law).abs() < 0.5, "{doublings}: {found} for {law}");
    }
    for nearer in [0.2, 0.05, 0.0] {
        assert!(decibels(loudness(nearer) / reference).abs() < 0.05);
    }
}

/// The loudest moment above about 5 kHz, in decibels of full scale, where a tone of 440 Hz has
/// nothing and every step or kink has something.
fn loudest_click(frames: &[[f32; 2]]) -> f64 {
    let mut loudest = 0.0_f64;
    for side in 0..2 {
        // Three second-order Butterworth high-passes in a row; the tone is down by 120 dB.
        let mut signal: Vec<f64> = frames.iter().map(|f| f64::from(f[side])).collect();
        let w = (std::f64::consts::PI * 5000.0 / f64::from(RATE)).tan();
        let norm = 1.0 / (1.0 + 2.0_f64.sqrt() * w + w * w);
        let (a1, a2) = (
            2.0 * (w * w - 1.0) * norm,
            (1.0 - 2.0_f64.sqrt() * w + w * w) * norm,
        );
        for _ in 0..3 {
            let (mut x1, mut x2, mut y1, mut y2) = (0.0, 0.0, 0.0, 0.0);
            for sample in &mut signal {
                let x = *sample;
                let y = norm * (x - 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
                (x2, x1, y2, y1) = (x1, x, y1, y);
                *sample = y;
            }
        }
        loudest = signal.iter().fold(loudest, |m, s| m.max(s.abs()));
    }
    decibels(loudest)
}

/// What jumps about as badly as a lost tracker makes it: every 4096 frames, side to side, near and
/// far, on and off.
fn jumping(frame: usize) -> Soundscape {
    match (frame / 4096) % 4 {
        0 => source_at(HEAD + DVec3::new(0.3, 0.0, 0.0)),
        1 => source_at(HEAD - DVec3::new(0.3, 0.0, 0.0)),
        2 => source_at(HEAD + DVec3::new(0.0, 30.0, 0.0)),
        _ => Soundscape::default(),
    }
}

/// A hand that swings past the head once a second.
fn swinging(frame: usize) -> Soundscape {
    let phase = TAU * frame as f64 / f64::from(RATE);
    source_at(HEAD + DVec3::new(0.8 * phase.sin(), 0.2, 0.3 * phase.cos()))
}

#[test]
fn no_click_above_minus_60_db_whatever_the_block_and_the_jump() {
    for block in BLOCKS {
        for soundscape in [jumping, swinging] {
            let frames = render(tone(), 48 * 4096, block, soundscape);
            assert!(frames.iter().any(|f| f[0].abs() > 0.1));
            let click = loudest_click(&frames);
            assert!(click < -60.0, "{click:.1} dB in blocks of {block}");
        }
    }
}

#[test]
fn the_click_finder_finds_clicks() {
    // The same tone, its level switched by 1 % at a block border: −46 dB, and found near that.
    let click_of = |step: f32| {
        let frames: Vec<[f32; 2]> = (0..9000_usize)
            .map(|i| {
                let fade = (i as f32 / 4000.0).min(1.0).powi(3);
                let sample = fade * (TAU * 440.0 * i as f64 / f64::from(RATE)).cos() as f32;
                let gain = if i < 8183 { 0.5 } else { 0.5 - 0.5 * step };
                [gain * sample; 2]
            })
            .collect();
        loudest_click(&frames)
    };
    assert!(click_of(0.01) > -60.0, "{}", click_of(0.01));
    assert!(click_of(0.0) < -80.0, "{}", click_of(0.0));
}

#[test]
fn the_beacon_strikes_without_clicks() {
    // Its onset is sharp on purpose, but nothing in it is a step: at twice the sample rate each
    // difference between samples would halve, and here none comes near the level.
    let settings = Settings {
        voice: Voice::Beacon {
            frequency: 440.0,
            period: 0.3,
        },
        ..Settings::default()
    };
    let scape = source_at(HEAD);
    let frames = render(settings, 2 * RATE as usize, 512, |_| scape);
    let highest = frames.iter().fold(0.0_f32, |m, f| m.max(f[0].abs()));
    let step = frames
        .windows(2)
        .fold(0.0_f32, |m, w| m.max((w[1][0] - w[0][0]).abs()));
    // A sum of the three partials at full level moves by at most 0.17 of the peak a sample.
    assert!(highest > 0.1 && step < 0.17 * 0.36, "{highest} {step}");
    let strokes = frames
        .chunks(RATE as usize * 3 / 10)
        .filter(|c| c.iter().any(|f| f[0].abs() > 0.5 * highest));
    assert!(strokes.count() >= 6);
}

#[test]
fn the_wind_grows_louder_and_brighter_with_speed() {
    let mut last = (0.0, 0.0);
    for speed in [2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 1e4, 1e9] {
        let frames = render(Settings::default(), 4 * RATE as usize, 512, |_| {
            flying(speed)
        });
        let loudness = level(&frames, 0);
        let differences: Vec<[f32; 2]> = frames
            .windows(2)
            .map(|w| [w[1][0] - w[0][0], w[1][1] - w[0][1]])
            .collect();
        // The share of fast changes stands for the spectrum's centre.
        let brightness = level(&differences, 0) / loudness;
        assert!(loudness > last.0 && brightness > last.1, "at {speed} m/s");
        assert!(frames.as_flattened().iter().all(|s| s.abs() < 0.5));
        last = (loudness, brightness);
    }
    // About −21 dB of full scale at most: a wind, not a storm over the source.
    assert!(
        (-26.0..-14.0).contains(&decibels(last.0)),
        "{}",
        decibels(last.0)
    );
}

#[test]
fn half_speed_is_half_the_amplitude() {
    let settings = Settings::default();
    // At a fixed brightness this would be exact; the brighter wind lets more noise through.
    let loudness = |speed| {
        level(
            &render(settings, 4 * RATE as usize, 512, |_| flying(speed)),
            0,
        )
    };
    let ratio = loudness(settings.half_wind_speed) / loudness(1e9);
    assert!((0.3..0.55).contains(&ratio), "{ratio}");
}

#[test]
fn a_jump_of_speed_swells_and_does_not_click() {
    // A swell takes its time: 2 ms after the jump next to nothing is to be heard.
    let jump = RATE as usize;
    let frames = render(Settings::default(), 2 * jump, 480, |frame| {
        flying(if frame < jump { 0.0 } else { 1000.0 })
    });
    let peak = |range: std::ops::Range<usize>| {
        frames[range].iter().fold(0.0_f32, |m, f| m.max(f[0].abs()))
    };
    assert_eq!(peak(0..jump), 0.0);
    assert!(peak(jump..jump + 96) < 1e-3, "{}", peak(jump..jump + 96));
    assert!(peak(jump + jump / 2..2 * jump) > 0.05);
}

#[test]
fn nothing_sounding_is_exactly_silent_also_after_sound() {
    let frames = render(Settings::default(), 3 * RATE as usize, 512, |frame| {
        if frame < RATE as usize {
            Soundscape {
                airspeed: 50.0,
                ..source_at(HEAD)
            }
        } else {
            Soundscape::default()
        }
    });
    assert!(frames[..RATE as usize].iter().any(|f| f[0].abs() > 0.1));
    let tail = &frames[frames.len() - RATE as usize / 4..];
    assert!(tail.as_flattened().iter().all(|s| *s == 0.0));
}

#[test]
fn blocks_of_any_size_give_the_same_samples_and_seeds_differ() {
    let scape = Soundscape {
        airspeed: 50.0,
        ..source_at(HEAD + DVec3::X)
    };
    let whole = render(Settings::default(), 8192, 8192, |_| scape);
    for block in BLOCKS.into_iter().chain([1, 7, 1000]) {
        assert_eq!(render(Settings::default(), 8192, block, |_| scape), whole);
    }
    let reseeded = Settings {
        seed: 2,
        ..Settings::default()
    };
    assert_ne!(render(reseeded, 8192, 8192, |_| scape), whole);
}

#[test]
fn everything_at_its_loudest_stays_within_full_scale() {
    let scape = Soundscape {
        airspeed: f64::MAX,
        ..source_at(HEAD)
    };
    let settings = Settings {
        voice: Voice::Tone { frequency: 440.0 },
        ..Settings::default()
    };
    let frames = render(settings, 10 * RATE as usize, 512, |_| scape);
    let peak = frames
        .as_flattened()
        .iter()
        .fold(0.0_f32, |m, s| m.max(s.abs()));
    assert!(peak < 1.0, "the clamp is never reached: {peak}");
}

#[test]
fn soundscapes_without_meaning_leave_the_sound_as_it_was() {
    let good = Soundscape {
        airspeed: 30.0,
        ..source_at(HEAD + DVec3::X)
    };
    let bad = Soundscape {
        airspeed: f64::NAN,
        ..source_at(DVec3::NAN)
    };
    let expected = render(tone(), 8192, 512, |_| good);
    let found = render(
        tone(),
        8192,
        512,
        |frame| if frame < 512 { good } else { bad },
    );
    assert_eq!(found, expected);
}
