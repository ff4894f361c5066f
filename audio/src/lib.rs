//! Sound: how it sounds from where the listener is.
//!
//! ```text
//! navigation --Soundscape--> Control ~~wait-free~~> Mixer --frames--> Output (sound card)
//!                            (any thread)             |  |            WavWriter (file)
//!                                        voice → gains + wind         tests
//! ```
//!
//! A [`Soundscape`] says what sounds from where: the listener, one source and the air that rushes
//! by. The [`Mixer`] turns it into stereo frames; one `render` serves the sound card, the file
//! writer and the tests, so that what is tested is what is heard.
//!
//! * **Frame**: the table's, in metres: x right, y away from the user, z up. A camera's flight uses
//!   any frame it likes, as only the listener's place and right-hand direction matter.
//! * **Direction**: constant-power panning by the sine of the azimuth. Front and back sound alike.
//! * **Distance**: amplitude is inverse to distance, −6 dB a doubling, from the source's reference
//!   distance outwards; within it the level holds and the source widens to the centre.
//! * **Time**: the same seed, sample rate and soundscapes give the same samples, whatever the size
//!   of the blocks they are rendered in.
//! * **Real time**: `render` neither allocates nor locks nor waits.
//! * **Level**: the parts are scaled so that their sum stays within full scale; there is no limiter
//!   that could pump.
//!
//! ```
//! use glam::DVec3;
//! use sandtable_audio::{Listener, Settings, Soundscape, Source, mixer};
//!
//! let (mut control, mut mixer) = mixer(Settings::default(), 48_000);
//! control.set(Soundscape {
//!     listener: Listener::at_table(DVec3::new(0.0, -0.9, 0.6)),
//!     source: Some(Source::at(DVec3::new(0.8, -0.9, 0.6))),
//!     airspeed: 0.0,
//! });
//! let mut frames = [[0.0_f32; 2]; 48_000];
//! mixer.render(&mut frames);
//! let energy = |side: usize| frames.iter().map(|f| f[side] * f[side]).sum::<f32>();
//! assert!(energy(1) > 100.0 * energy(0), "a source on the right sounds on the right");
//! ```

mod glide;
mod mixer;
mod noise;
mod output;
mod soundscape;
mod voice;
mod wav;
mod wind;

pub use mixer::{Control, Mixer, Settings, mixer};
pub use output::{Output, OutputDevice, OutputError, Playback, list_outputs};
pub use soundscape::{Listener, Soundscape, Source};
pub use voice::Voice;
pub use wav::{WAV_SAMPLE_RATE, WavError, WavWriter, render_to_wav};
