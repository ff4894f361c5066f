//! The mixer: soundscapes in, stereo frames out.

use crate::glide::Glide;
use crate::soundscape::Soundscape;
use crate::voice::{Speaker, Voice};
use crate::wind::Wind;

/// Time constant with which the source's level and direction follow, in seconds: short enough to
/// stay with a moving hand, long enough that no jump clicks.
const FOLLOW_S: f64 = 0.01;

/// What stays the same while the mixer runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Of the wind's noise.
    pub seed: u64,
    /// What the source sounds like.
    pub voice: Voice,
    /// The airspeed, metres per second, at which the wind has half its greatest amplitude. A wind
    /// in true proportion would be faint or deafening over most of the range of a flight, so this
    /// goes with how fast one usually flies; not positive means no wind at all.
    pub half_wind_speed: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 1,
            voice: Voice::default(),
            half_wind_speed: 60.0,
        }
    }
}

/// Builds a mixer at `sample_rate` hertz and the handle by which another thread steers it.
#[must_use]
pub fn mixer(settings: Settings, sample_rate: u32) -> (Control, Mixer) {
    let (control, soundscapes) = control();
    (control, Mixer::new(settings, sample_rate, soundscapes))
}

/// Steers a [`Mixer`] from any thread. Never waits, and works on when the mixer is gone.
#[derive(Debug)]
pub struct Control(triple_buffer::Input<Soundscape>);

impl Control {
    /// Makes `soundscape` what is heard from the next rendered block on, without a click.
    pub fn set(&mut self, soundscape: Soundscape) {
        self.0.write(soundscape);
    }
}

/// The mixer's end of a [`Control`].
pub(crate) type Soundscapes = triple_buffer::Output<Soundscape>;

/// A control and the end that a mixer, built later, will listen to.
pub(crate) fn control() -> (Control, Soundscapes) {
    let (input, output) = triple_buffer::triple_buffer(&Soundscape::default());
    (Control(input), output)
}

/// Renders what a [`Control`] says. Starts from silence.
#[derive(Debug)]
pub struct Mixer {
    soundscapes: Soundscapes,
    speaker: Speaker,
    sides: [Glide; 2],
    wind: Option<Wind>,
}

impl Mixer {
    pub(crate) fn new(settings: Settings, sample_rate: u32, soundscapes: Soundscapes) -> Self {
        let rate = f64::from(sample_rate);
        let side = Glide::new(FOLLOW_S, rate);
        let Settings {
            seed,
            voice,
            half_wind_speed,
        } = settings;
        Self {
            soundscapes,
            speaker: Speaker::new(voice, rate),
            sides: [side.clone(), side],
            wind: (half_wind_speed > 0.0).then(|| Wind::new(seed, half_wind_speed, rate)),
        }
    }

    /// Fills `out` with the next frames, left and right, each within −1 to 1.
    ///
    /// Takes in the newest soundscape once, at the start. Neither allocates nor locks nor waits.
    pub fn render(&mut self, out: &mut [[f32; 2]]) {
        if self.soundscapes.update() {
            self.follow(*self.soundscapes.output_buffer());
        }
        for frame in out {
            *frame = self.frame();
        }
    }

    /// Sets the targets. What is not a number keeps its former target.
    fn follow(&mut self, soundscape: Soundscape) {
        let gains = match soundscape.source {
            Some(source) => source.gains(&soundscape.listener),
            None => Some([0.0; 2]),
        };
        if let Some(gains) = gains {
            for (side, gain) in self.sides.iter_mut().zip(gains) {
                side.set_target(gain);
            }
        }
        if let Some(wind) = &mut self.wind {
            wind.follow(soundscape.airspeed);
        }
    }

    fn frame(&mut self) -> [f32; 2] {
        let mut frame = match &mut self.wind {
            Some(wind) => wind.frame(),
            None => [0.0; 2],
        };
        let voice = self.speaker.sample();
        for (sample, side) in frame.iter_mut().zip(&mut self.sides) {
            *sample += side.advance() * voice;
        }
        // The parts leave headroom; the clamp is for a converter that would wrap around.
        frame.map(|sample| sample.clamp(-1.0, 1.0) as f32)
    }
}
