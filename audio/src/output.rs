//! Live output: the mixer on the default sound card, or silence with a note where there is none.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{ErrorKind, FromSample, Sample, SampleFormat, SizedSample, StreamConfig};

use crate::mixer::{Control, Mixer, Settings, Soundscapes, control};

/// Frames rendered at a time on the callback's stack, before they are spread over the channels.
const CHUNK: usize = 128;

/// Plays a [`Mixer`] on the default output until dropped.
///
/// Opening a sound card can take seconds (a sound server that starts, a driver that hangs), so it
/// happens on a thread of its own: neither starting nor dropping an `Output` waits for it.
#[derive(Debug)]
pub struct Output {
    state: Arc<State>,
    events: mpsc::SyncSender<Event>,
}

/// How an [`Output`] fares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Playback {
    /// The device is being opened; nothing sounds yet.
    Opening,
    /// The device plays.
    Playing {
        /// As the system names it.
        device: String,
        /// Hertz.
        sample_rate: u32,
    },
    /// Nothing will sound; all else goes on.
    Silent {
        /// Why, and what to do about it.
        note: String,
    },
}

impl Output {
    /// Starts playing on the default output and returns at once.
    ///
    /// With no card, or one that refuses, the sound is silence and [`Output::playback`] says why:
    /// that is a note, not an error, since everything but the sound works.
    #[must_use]
    pub fn start(settings: Settings) -> (Control, Self) {
        let (control, soundscapes) = control();
        let (events, inbox) = mpsc::sync_channel(2);
        let state = Arc::new(State {
            playback: Mutex::new(Playback::Opening),
            gaps: AtomicU64::new(0),
        });
        let started = std::thread::Builder::new().name("sound".into()).spawn({
            let (state, events) = (Arc::clone(&state), events.clone());
            move || hold_stream(settings, soundscapes, &state, events, &inbox)
        });
        if let Err(error) = started {
            state.fall_silent(&format!("no thread for it: {error}"));
        }
        (control, Self { state, events })
    }

    /// How it fares now.
    #[must_use]
    pub fn playback(&self) -> Playback {
        self.state
            .playback
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// How often the device ran out of sound, each time heard as a gap.
    #[must_use]
    pub fn gaps(&self) -> u64 {
        self.state.gaps.load(Ordering::Relaxed)
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        // A full inbox holds an event that ends the stream as well.
        let _ = self.events.try_send(Event::Stop);
    }
}

/// A sound output that the system knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputDevice {
    /// As the system describes it.
    pub name: String,
    /// What the system calls it in its configuration.
    pub id: String,
    /// Whether [`Output::start`] takes it.
    pub is_default: bool,
    /// Its preferred channels and sample rate in hertz, or why it cannot be opened.
    pub format: Result<(u16, u32), String>,
}

/// The sound system did not answer.
#[derive(Debug, thiserror::Error)]
#[error("cannot list the sound outputs: {0}; is the sound system (on Linux: ALSA) installed?")]
pub struct OutputError(#[from] cpal::Error);

/// Lists the sound outputs that the system names, whether or not they can be opened.
///
/// This asks each device for its format, which may take some tenths of a second.
///
/// # Errors
/// If the sound system itself is not there.
pub fn list_outputs() -> Result<Vec<OutputDevice>, OutputError> {
    // On a thread of its own, as hushing the sound system lasts as long as its thread.
    std::thread::scope(|scope| {
        let listing = scope.spawn(|| {
            hush();
            list()
        });
        listing
            .join()
            .unwrap_or_else(|_| Err(cpal::Error::new(ErrorKind::BackendError).into()))
    })
}

fn list() -> Result<Vec<OutputDevice>, OutputError> {
    let host = cpal::default_host();
    let id = |device: &cpal::Device| {
        device
            .id()
            .map_or_else(|_| String::new(), |i| i.to_string())
    };
    let default = host.default_output_device().map(|d| id(&d));
    let describe = |device: cpal::Device| {
        let id = id(&device);
        OutputDevice {
            name: name(&device),
            is_default: default.as_ref() == Some(&id),
            format: device
                .default_output_config()
                .map(|c| (c.channels(), c.sample_rate()))
                .map_err(|e| e.to_string()),
            id,
        }
    };
    Ok(host.output_devices()?.map(describe).collect())
}

/// What both sides of an [`Output`] know; the callback touches only the atomic.
#[derive(Debug)]
struct State {
    playback: Mutex<Playback>,
    gaps: AtomicU64,
}

impl State {
    fn set(&self, playback: Playback) {
        *self.playback.lock().unwrap_or_else(PoisonError::into_inner) = playback;
    }

    fn fall_silent(&self, reason: &str) {
        let reason = reason.trim_end_matches('.');
        let note = format!("no sound: {reason}; `sandtable doctor` lists the sound outputs");
        tracing::info!("{note}");
        self.set(Playback::Silent { note });
    }
}

/// Why the thread that holds the stream should let go of it.
#[derive(Debug)]
enum Event {
    Stop,
    Broken(ErrorKind),
}

/// Opens the default output and keeps its stream until the first event.
fn hold_stream(
    settings: Settings,
    soundscapes: Soundscapes,
    state: &Arc<State>,
    events: mpsc::SyncSender<Event>,
    inbox: &mpsc::Receiver<Event>,
) {
    hush();
    let stream = match open(settings, soundscapes, state, events) {
        Ok(stream) => stream,
        Err(error) => return state.fall_silent(&error.to_string()),
    };
    if let Ok(Event::Broken(kind)) = inbox.recv() {
        state.fall_silent(&kind.to_string());
    }
    drop(stream);
}

fn open(
    settings: Settings,
    soundscapes: Soundscapes,
    state: &Arc<State>,
    events: mpsc::SyncSender<Event>,
) -> Result<cpal::Stream, cpal::Error> {
    let device = cpal::default_host()
        .default_output_device()
        .ok_or(ErrorKind::DeviceNotAvailable)?;
    let supported = device.default_output_config()?;
    let config = supported.config();
    let mixer = Mixer::new(settings, config.sample_rate, soundscapes);
    let on_error = {
        let state = Arc::clone(state);
        move |error: cpal::Error| report(&error, &state.gaps, &events)
    };
    let stream = match supported.sample_format() {
        SampleFormat::F32 => stream::<f32>(&device, config, mixer, on_error),
        SampleFormat::F64 => stream::<f64>(&device, config, mixer, on_error),
        SampleFormat::I16 => stream::<i16>(&device, config, mixer, on_error),
        SampleFormat::I24 => stream::<cpal::I24>(&device, config, mixer, on_error),
        SampleFormat::I32 => stream::<i32>(&device, config, mixer, on_error),
        SampleFormat::U8 => stream::<u8>(&device, config, mixer, on_error),
        SampleFormat::U16 => stream::<u16>(&device, config, mixer, on_error),
        _ => Err(ErrorKind::UnsupportedConfig.into()),
    }?;
    stream.play()?;
    state.set(Playback::Playing {
        device: name(&device),
        sample_rate: config.sample_rate,
    });
    Ok(stream)
}

fn stream<T: SizedSample + FromSample<f32>>(
    device: &cpal::Device,
    config: StreamConfig,
    mut mixer: Mixer,
    on_error: impl FnMut(cpal::Error) + Send + 'static,
) -> Result<cpal::Stream, cpal::Error> {
    let channels = usize::from(config.channels);
    device.build_output_stream(
        config,
        move |out: &mut [T], _| fill(&mut mixer, out, channels),
        on_error,
        None,
    )
}

/// Renders into interleaved samples: stereo on the first two channels, silence on the others, and
/// on a single channel the two sides' mean.
fn fill<T: Sample + FromSample<f32>>(mixer: &mut Mixer, out: &mut [T], channels: usize) {
    let mut frames = [[0.0_f32; 2]; CHUNK];
    for block in out.chunks_mut(CHUNK * channels.max(1)) {
        let frames = &mut frames[..block.len() / channels.max(1)];
        mixer.render(frames);
        for (samples, &[left, right]) in block.chunks_exact_mut(channels.max(1)).zip(&*frames) {
            match samples {
                [mono] => *mono = T::from_sample(0.5 * (left + right)),
                [l, r, others @ ..] => {
                    *l = T::from_sample(left);
                    *r = T::from_sample(right);
                    others.fill(T::EQUILIBRIUM);
                }
                [] => {}
            }
        }
    }
}

/// Tells gaps and trifles, after which the stream goes on, from its end.
fn report(error: &cpal::Error, gaps: &AtomicU64, events: &mpsc::SyncSender<Event>) {
    match error.kind() {
        ErrorKind::Xrun => {
            gaps.fetch_add(1, Ordering::Relaxed);
        }
        ErrorKind::DeviceChanged | ErrorKind::RealtimeDenied => {}
        // The inbox may be full of such: one is enough.
        kind => drop(events.try_send(Event::Broken(kind))),
    }
}

/// Keeps ALSA from writing a page of its own to standard error, on this thread, for each device
/// that cannot be opened: the reason comes back as an error and is told once.
fn hush() {
    #[cfg(target_os = "linux")]
    drop(alsa::Output::local_error_handler());
}

fn name(device: &cpal::Device) -> String {
    device
        .description()
        .map_or_else(|_| "unnamed".to_owned(), |d| d.name().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Soundscape, Source, Voice, mixer};
    use glam::DVec3;
    use std::time::{Duration, Instant};

    fn sounding_mixer() -> (Control, Mixer) {
        let settings = Settings {
            voice: Voice::Tone { frequency: 440.0 },
            ..Settings::default()
        };
        let (mut control, mixer) = mixer(settings, 48_000);
        control.set(Soundscape {
            source: Some(Source::at(DVec3::new(0.6, 0.8, 0.0))),
            airspeed: 40.0,
            ..Soundscape::default()
        });
        (control, mixer)
    }

    #[test]
    fn any_number_of_channels_and_any_block_carry_the_same_sound() {
        const FRAMES: usize = 1000;
        let mut stereo = [[0.0; 2]; FRAMES];
        sounding_mixer().1.render(&mut stereo);
        for channels in [1, 2, 6] {
            let (_control, mut mixer) = sounding_mixer();
            let mut out = vec![9.0_f32; FRAMES * channels];
            fill(&mut mixer, &mut out, channels);
            for (samples, [l, r]) in out.chunks(channels).zip(stereo) {
                match channels {
                    1 => assert_eq!(samples, [0.5 * (l + r)]),
                    2 => assert_eq!(samples, [l, r]),
                    _ => assert_eq!(samples, [l, r, 0.0, 0.0, 0.0, 0.0]),
                }
            }
        }
    }

    #[test]
    fn unsigned_samples_rest_at_their_middle() {
        let (_control, mut mixer) = mixer(Settings::default(), 48_000);
        let mut out = [0_u16; 64];
        fill(&mut mixer, &mut out, 2);
        assert_eq!(out, [0x8000; 64]);
    }

    #[test]
    fn gaps_are_counted_and_only_a_real_breakdown_ends_the_stream() {
        let gaps = AtomicU64::new(0);
        let (events, inbox) = mpsc::sync_channel(2);
        let tell = |kind: ErrorKind| report(&kind.into(), &gaps, &events);
        tell(ErrorKind::Xrun);
        tell(ErrorKind::DeviceChanged);
        tell(ErrorKind::Xrun);
        assert_eq!(gaps.load(Ordering::Relaxed), 2);
        assert!(inbox.try_recv().is_err());
        // More breakdowns than the inbox holds must not make the audio thread wait.
        for _ in 0..5 {
            tell(ErrorKind::DeviceNotAvailable);
        }
        assert!(matches!(
            inbox.try_recv(),
            Ok(Event::Broken(ErrorKind::DeviceNotAvailable))
        ));
    }

    /// With a card this plays some blocks of silence, without one it falls silent with a note;
    /// either way it must come to one of the two and go away again.
    #[test]
    fn live_output_plays_or_falls_silent_with_a_note() {
        let (mut control, output) = Output::start(Settings::default());
        control.set(Soundscape::default());
        let deadline = Instant::now() + Duration::from_secs(20);
        while output.playback() == Playback::Opening {
            assert!(Instant::now() < deadline, "opening hangs");
            std::thread::sleep(Duration::from_millis(5));
        }
        if let Playback::Silent { note } = output.playback() {
            assert!(note.contains("doctor"), "{note}");
        }
        drop(output);
        control.set(Soundscape::default());
    }
}
