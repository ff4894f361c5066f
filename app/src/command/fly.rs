//! `sandtable fly`: opens the table; without a display, writes a flight to a file instead.

use crate::cli::{FlyArgs, TerrainArgs};
use crate::exit::usage;
use crate::film::Film;
use crate::guide::GuideSetup;
use crate::live::{Live, Timeline, frame_time};
use crate::notice::notice;
use crate::session::Session;
use crate::tape::{self, Tape};
use crate::tour::Tour;
use crate::window::{Display, WindowError, WindowOptions};
use crate::{interrupt, overwriting, rig, scene};
use anyhow::{Context, Result, anyhow};
use sandtable_cast::CastPool;
use sandtable_config::{Rig, StereoMode as RigStereo, Viewing};
use sandtable_input::intent::DeskState;
use sandtable_input::{Clock, Devices, Gamepads, Hub, Replay};
use sandtable_stage::{Composing, StereoMode};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Frames a second of a flight that is written to a file.
const TOUR_RATE: u32 = 30;
/// Frames a second at which a recording is replayed: none is skipped.
const REPLAY_RATE: u32 = 60;
/// The longest film, in seconds.
const LONGEST: f64 = 3600.0;

pub(crate) fn run(args: &FlyArgs) -> Result<()> {
    if !(args.seconds > 0.0 && args.seconds <= LONGEST) {
        return Err(usage("--seconds must be above 0 and at most 3600"));
    }
    // Before anything is opened: a wrong word should not cost a wait.
    scene::caster_at_detail(&args.caster, args.lod, false)?;
    let replay = args.replay.as_deref().map(open_replay).transpose()?;
    let mut age = None;
    let rig = match &replay {
        Some(replay) => replay.rig().clone(),
        None => {
            let rig = rig::open(args.rig.as_deref().unwrap_or("desktop"), &args.device)?;
            let today = time::OffsetDateTime::now_utc().date();
            age = rig::calibration_age(&rig, today);
            if let Some(age) = &age {
                tracing::info!("{age}");
            }
            for doubt in rig.doubts() {
                tracing::warn!("rig {:?}: {doubt}", rig.name);
            }
            rig
        }
    };
    if args.latency && !has_tracked_head(&rig) {
        return Err(usage(
            "--latency needs a table with a tracked head: a rig with [table], and `sensor` under \
             [head], such as --rig workbench",
        ));
    }
    let display = if args.headless {
        Err("asked for with --headless".to_owned())
    } else {
        Display::connect().map_err(|error| error.to_string())
    };
    let terrain = match &replay {
        Some(replay) => tape::terrain(replay, &args.terrain)?,
        None => args.terrain.clone(),
    };
    if display.is_err() {
        refuse_overwriting(args, &terrain)?;
    }
    let is_table = matches!(rig.viewing, Viewing::Table(_));
    let caster = scene::caster_at_detail(&args.caster, args.lod, is_table)?;
    let open = match &args.replay {
        Some(path) => tape::open_terrain(path, &args.terrain, &terrain)?,
        None => scene::open(&terrain)?,
    };
    if let (Some(path), Some(replay)) = (&args.replay, &replay)
        && let Some(warning) = tape::other_ground(path, replay, &terrain, &open.scene.ground)
    {
        tracing::warn!("{warning}");
    }
    let pool = Arc::new(CastPool::new(args.threads).context("cannot start the casting threads")?);
    let hub = Arc::new(Hub::for_rig(&rig));
    let mut session = Session::new(rig, &open, &caster, Arc::clone(&pool), hub)?;
    if let Some(age) = age {
        session.say(format!("{age}; Calibrate, check takes ten seconds"));
    }
    match display {
        Ok(display) => {
            // Listened to before anything is recorded: what is begun is to be ended well.
            let waker = display.waker();
            interrupt::call(move || waker.quit())?;
            let clock = Clock::start();
            let timeline = match replay {
                Some(replay) => Timeline::Replayed {
                    replay: Box::new(replay),
                    begun: Instant::now(),
                    speed: args.replay_speed,
                    repeats: !args.once,
                },
                None => {
                    let tape = args
                        .record
                        .as_deref()
                        .map(|path| {
                            Tape::create(path, &session, &terrain, clock.now()).map(Box::new)
                        })
                        .transpose()?;
                    let recorder = tape.as_ref().map(|tape| tape.recorder());
                    let devices = Devices::start(session.rig(), session.hub(), clock, recorder)?;
                    Timeline::Live {
                        clock,
                        devices: Some(devices),
                        tape,
                    }
                }
            };
            in_window(args, display, session, timeline, pool)
        }
        Err(why) => {
            if args.calibrate.is_some() {
                return Err(usage(format!(
                    "--calibrate needs a display ({why}); without one, use: sandtable calibrate"
                )));
            }
            if args.latency {
                return Err(usage(format!("--latency needs a display ({why})")));
            }
            if args.record.is_some() {
                return Err(usage(format!(
                    "--record needs a display ({why}); without one, use: sandtable record"
                )));
            }
            without_display(args, &why, &mut session, replay, &pool)
        }
    }
}

/// Refuses a flight's files that would take the place of what is read, or of one another.
fn refuse_overwriting(args: &FlyArgs, terrain: &TerrainArgs) -> Result<()> {
    let [terrain, photo] = terrain.files();
    let rig = args.rig.as_deref().filter(|name| rig::is_file(name));
    overwriting::refuse(
        [
            terrain,
            photo,
            ("the rig", rig.map(Path::new)),
            ("the recording", args.replay.as_deref()),
        ],
        [
            ("--output", Some(&*args.output)),
            ("--audio", args.audio.as_deref()),
        ],
    )
}

fn open_replay(path: &Path) -> Result<Replay> {
    let replay = Replay::open(path)?;
    if let Some(cut) = replay.cut() {
        tracing::warn!(
            "the recording {} is torn: {cut}; it is replayed up to there",
            path.display()
        );
    }
    Ok(replay)
}

fn in_window(
    args: &FlyArgs,
    display: Display,
    session: Session,
    timeline: Timeline,
    pool: Arc<CastPool>,
) -> Result<()> {
    let rig = session.rig();
    let options = WindowOptions {
        title: format!("sandtable: {}", session.terrain()),
        size: args.size.unwrap_or(match &rig.viewing {
            Viewing::Table(table) => table.pixels,
            Viewing::Desktop(_) => [1280, 800],
        }),
        full_screen: false,
        composing: Composing {
            mode: args
                .stereo
                .map_or(stage_mode(rig.stereo.mode), |stereo| stereo.mode()),
            swap_eyes: rig.stereo.swap_eyes ^ args.swap_eyes,
        },
        panel: true,
        latency: args.latency,
        screenshots: std::env::current_dir().unwrap_or_default(),
    };
    let gamepads = match Gamepads::open() {
        Ok(gamepads) => Some(gamepads),
        Err(note) => {
            tracing::info!("no gamepads: {note}");
            None
        }
    };
    let setup = GuideSetup {
        rig: args.rig.clone().unwrap_or_else(|| "desktop".to_owned()),
        device: args.device.clone(),
        marks: args.marks.clone(),
    };
    let mut live = Live::new(session, timeline, gamepads, args.mute, setup);
    if let Some(step) = args.calibrate {
        live.begin_guide(step);
    }
    let shown = display.run(options, pool, &mut live);
    let tape = live.end();
    if let (Some(tape), Some(path)) = (tape, &args.record) {
        tape::finish(&tape, path)?;
    }
    match shown {
        Err(error @ (WindowError::NoWindow(_) | WindowError::NoGpu(_))) => Err(anyhow!(
            "{error}. Without a window, `sandtable fly --headless` writes a flight to a file"
        )),
        shown => Ok(shown?),
    }
}

/// Writes a flight to a file: a tour over the terrain, or the replay.
fn without_display(
    args: &FlyArgs,
    why: &str,
    session: &mut Session,
    replay: Option<Replay>,
    pool: &CastPool,
) -> Result<()> {
    let rig = session.rig();
    let stereo = args.stereo.map_or_else(
        || match stage_mode(rig.stereo.mode) {
            // A rig that shows one eye still shows here what stereo is.
            StereoMode::Mono => StereoMode::SideBySide,
            mode => mode,
        },
        |stereo| stereo.mode(),
    );
    let table_pixels = match &rig.viewing {
        Viewing::Table(table) => Some(table.pixels),
        Viewing::Desktop(_) => None,
    };
    let seconds = replay.as_ref().map_or(args.seconds, |replay| {
        replay
            .end()
            .since(replay.start())
            .div_f64(args.replay_speed)
            .as_secs_f64()
            .min(LONGEST)
    });
    let rate = if replay.is_some() {
        REPLAY_RATE
    } else {
        TOUR_RATE
    };
    let film = Film {
        output: args.output.clone(),
        audio: args.audio.clone(),
        eye_size: args.size.or(table_pixels).unwrap_or([960, 540]),
        stereo,
        swap_eyes: rig.stereo.swap_eyes ^ args.swap_eyes,
        rate,
        frames: (seconds * f64::from(rate)).ceil().max(1.0) as u32,
    };
    notice(format_args!(
        "no window: {why}\nwriting a flight ({} frames, {seconds:.1} s, {stereo}) over {} to {}",
        film.frames,
        session.terrain(),
        film.output.display()
    ));
    if replay.is_none() && !session.rig().devices.is_empty() {
        let names: Vec<_> = session.rig().devices.keys().map(String::as_str).collect();
        notice(format_args!(
            "the rig's devices are not used for it ({}): the flight is a tour of its own; \
             `sandtable record` listens to them",
            names.join(", ")
        ));
    }
    match replay {
        Some(mut replay) => {
            let start = replay.start();
            let mut problem = Ok(());
            film.shoot(session, pool, |session, frame| {
                let time = frame_time(start, frame, REPLAY_RATE, args.replay_speed);
                let recalled = tape::recall(&mut replay, session, time, &DeskState::default());
                if problem.is_ok() {
                    problem = recalled.map(drop);
                }
            })?;
            problem?;
        }
        None => {
            let tour = Tour::over(session.ground());
            let share = |frame: u32| {
                // A steady pace: a full round takes a minute.
                f64::from(frame) / f64::from(TOUR_RATE) / 60.0
            };
            tour.guide(session, share(0), 0.0);
            film.shoot(session, pool, |session, frame| {
                tour.guide(session, share(frame), 1.0 / f64::from(TOUR_RATE));
            })?;
        }
    }
    let how = if film.output.is_dir() {
        "a folder of images"
    } else {
        "play it with any video player"
    };
    notice(format_args!("{} is written: {how}", film.output.display()));
    if let Some(audio) = &film.audio {
        notice(format_args!("its sound is in {}", audio.display()));
    }
    Ok(())
}

/// Whether what a rig shows follows a head that a sensor tells.
fn has_tracked_head(rig: &Rig) -> bool {
    let sensor = rig.head.as_ref().and_then(|head| head.sensor.as_ref());
    matches!(rig.viewing, Viewing::Table(_)) && sensor.is_some()
}

/// The stage's word for a rig's stereo mode.
fn stage_mode(mode: RigStereo) -> StereoMode {
    match mode {
        RigStereo::Mono => StereoMode::Mono,
        RigStereo::SideBySide => StereoMode::SideBySide,
        RigStereo::TopBottom => StereoMode::TopBottom,
        RigStereo::Anaglyph => StereoMode::Anaglyph,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stereo_mode_of_a_rig_has_the_stages_name() {
        for mode in StereoMode::ALL {
            let text = format!("name = \"r\"\n[camera]\n[stereo]\nmode = \"{mode}\"\n");
            let rig = Rig::parse(&text, "r.toml").unwrap();
            assert_eq!(stage_mode(rig.stereo.mode), mode);
        }
    }
}
