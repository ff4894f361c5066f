//! Wind: filtered noise that grows louder and brighter with the speed of flight.

use crate::glide::Glide;
use crate::noise::Noise;

/// Amplitude of the strongest wind. Its peaks stay under half of full scale.
const STRONGEST: f64 = 0.4;
/// Cut-off of the faintest breath, in hertz.
const DARKEST_HZ: f64 = 120.0;
/// By how much the strongest wind's cut-off lies above that, in hertz.
const BRIGHTENING_HZ: f64 = 2400.0;
/// Below this the noise is only rumble that loudspeakers waste their stroke on.
const RUMBLE_HZ: f64 = 25.0;
/// Time constant with which the wind follows the speed, in seconds.
const FOLLOW_S: f64 = 0.1;
/// A gust swells and falls with this time constant, in seconds.
const GUST_S: f64 = 0.5;
/// How far gusts raise and lower the wind: by a fifth most of the time, never by half.
const GUST_DEPTH: f64 = 1.4;

/// The wind in the listener's ears.
///
/// White noise through two one-pole low-passes whose cut-off rises with speed, and slow gusts. The
/// ears share most of the noise, so that the wind is wide but in front of nobody.
#[derive(Clone, Debug)]
pub(crate) struct Wind {
    half_speed: f64,
    /// The speed, with all speeds from none to infinite brought into 0 to 1.
    rush: Glide,
    sample_rate: f64,
    shared: Noise,
    sides: Noise,
    gusts: Noise,
    gust: [f64; 2],
    ears: [Ear; 2],
}

/// The filters' memory of one ear.
#[derive(Clone, Debug, Default)]
struct Ear {
    first: f64,
    second: f64,
    rumble: f64,
}

impl Wind {
    /// A wind at half its amplitude when the speed is `half_speed` (metres per second).
    pub(crate) fn new(seed: u64, half_speed: f64, sample_rate: f64) -> Self {
        let mut seeds = Noise::new(seed);
        let mut stream = || Noise::new(seeds.sample().to_bits());
        Self {
            half_speed,
            rush: Glide::new(FOLLOW_S, sample_rate),
            sample_rate,
            shared: stream(),
            sides: stream(),
            gusts: stream(),
            gust: [0.0; 2],
            ears: [Ear::default(), Ear::default()],
        }
    }

    /// Follows a new airspeed in metres per second; one that is no number is ignored.
    pub(crate) fn follow(&mut self, airspeed: f64) {
        let slowness = self.half_speed / airspeed.abs();
        self.rush.set_target(1.0 / (1.0 + slowness));
    }

    /// The next frame, left and right.
    ///
    /// The amplitude rises with the square of the speed at first and levels out.
    pub(crate) fn frame(&mut self) -> [f64; 2] {
        let rush = self.rush.advance();
        // With the speed s in half speeds, rush = s / (1 + s) and this is s² / (1 + s²).
        let amplitude = STRONGEST * rush * rush / (rush * rush + (1.0 - rush) * (1.0 - rush));

        let swell = self.swell();
        let cutoff = (DARKEST_HZ + BRIGHTENING_HZ * rush) * swell;
        let share = self.share(cutoff);
        let rumble = self.share(RUMBLE_HZ);
        let (shared, sides) = (self.shared.sample(), self.sides.sample());
        // A higher sample rate spreads the noise's power over more bandwidth; keep what is heard.
        let scale = amplitude * swell * (self.sample_rate / 48_000.0).sqrt();
        let mut frame = [0.92 * shared + 0.39 * sides, 0.92 * shared - 0.39 * sides];
        for (sample, ear) in frame.iter_mut().zip(&mut self.ears) {
            ear.first += share * (*sample - ear.first);
            ear.second += share * (ear.first - ear.second);
            ear.rumble += rumble * (ear.second - ear.rumble);
            *sample = scale * (ear.second - ear.rumble);
        }
        frame
    }

    /// The gusts' factor, around 1: very slow noise.
    fn swell(&mut self) -> f64 {
        let share = 1.0 / (GUST_S * self.sample_rate);
        // So slow a filter leaves little of white noise; this brings back what is lost, to a
        // standard deviation of 0.29 at any sample rate.
        let drive = share.sqrt().recip();
        self.gust[0] += share * (self.gusts.sample() * drive - self.gust[0]);
        self.gust[1] += share * (self.gust[0] - self.gust[1]);
        1.0 + 0.5 * (GUST_DEPTH * self.gust[1]).tanh()
    }

    /// A one-pole low-pass's share of the new sample for a cut-off in hertz.
    fn share(&self, cutoff_hz: f64) -> f64 {
        1.0 - (-std::f64::consts::TAU * cutoff_hz / self.sample_rate).exp()
    }
}
