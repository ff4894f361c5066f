//! The simulated device: what a Flock answers, byte for byte, by a clock that is handed in.

use super::{Faults, Motion, SimulatorSettings};
use crate::flock::format::{Coding, format_of_command};
use crate::flock::measurement::Scale;
use crate::flock::record::{PHASE, encode_words};
use crate::flock::startup::{
    AUTO_CONFIGURE, BUTTON_MODE, CHANGE, GROUP_MODE, HEMISPHERE, POINT, POSITION_SCALE, RUN, SLEEP,
    STREAM, TO_ADDRESS, TO_UNIT,
};
use crate::flock::status::system_status_length;
use crate::simulator::{SimulatedDevice, SimulatedLine};
use glam::DVec3;
use sandtable_config::{Addressing, QuaternionSign, Range, RecordFormat};
use sandtable_pose::Rigid;
use std::collections::VecDeque;
use std::time::Duration;

/// A Flock of Birds without a port: takes commands, gives what its line has carried so far.
#[derive(Clone, Debug)]
pub struct SimulatedFlock {
    settings: SimulatorSettings,
    units: Vec<Unit>,
    group: bool,
    configured: bool,
    /// Auto-configuring: what arrives before this is lost.
    busy_until: Duration,
    /// The command that is being received, with the unit that it is for.
    command: Vec<u8>,
    unit: Option<usize>,
    /// The next byte is a super-expanded address.
    addressed: bool,
    errors: VecDeque<u8>,
    stream: Option<Stream>,
    /// When the first stream began: motions count from here.
    epoch: Option<Duration>,
    line: SimulatedLine,
    stream_bytes: u64,
    stream_records: u64,
}

#[derive(Clone, Copy, Debug)]
struct Unit {
    /// Whether it is an Extended Range Controller, which has no sensor.
    controller: bool,
    format: RecordFormat,
    full_scale: f64,
    hemisphere: [u8; 2],
    buttons: bool,
    running: bool,
}

#[derive(Clone, Copy, Debug)]
struct Stream {
    began: Duration,
    /// Cycles from one record to the next: 1, 2, 8 or 32.
    every: u32,
    next: u32,
}

impl Unit {
    fn powered_up(range: Range, controller: bool) -> Self {
        Self {
            controller,
            format: RecordFormat::PositionAngles,
            full_scale: range.metres(),
            hemisphere: [0, 0],
            buttons: false,
            running: false,
        }
    }

    /// How it codes what it measures; it derives quaternions from the transposed matrix.
    fn scale(&self) -> Scale {
        Scale {
            format: self.format,
            full_scale: self.full_scale,
            quaternion: QuaternionSign::Conjugate,
        }
    }

    /// The pose as measured: the field does not tell p from −p.
    fn measured(&self, mut pose: Rigid) -> Rigid {
        let axis = match self.hemisphere[0] {
            0x00 => DVec3::X,
            0x06 => DVec3::Y,
            _ => DVec3::Z,
        };
        let side = if self.hemisphere[1] == 0 { axis } else { -axis };
        if pose.translation.dot(side) < 0.0 {
            pose.translation = -pose.translation;
        }
        pose
    }
}

/// Records in a row after which one is a single step off, as in a sensor whose last bit never
/// rests: often enough not to look frozen, seldom enough to leave a held pose what it is.
const FLICKER: u64 = 50;

/// EXAMINE 6 at 40 MHz and 103.3 Hz.
const RATE_COUNT: [u8; 2] = [0xCE, 0x2D];
const INVALID_COMMAND: u8 = 14;

impl SimulatedFlock {
    /// A Flock that has just been switched on.
    #[must_use]
    pub fn new(settings: SimulatorSettings) -> Self {
        Self {
            units: switched_on(&settings),
            group: false,
            configured: false,
            busy_until: Duration::ZERO,
            command: Vec::new(),
            unit: None,
            addressed: false,
            errors: VecDeque::new(),
            stream: None,
            epoch: None,
            line: SimulatedLine::new(settings.baud),
            stream_bytes: 0,
            stream_records: 0,
            settings,
        }
    }

    /// Moves bird `bird`, from 1, otherwise from now on; a bird that is not there stays away.
    pub fn set_motion(&mut self, bird: u32, motion: Motion) {
        let motions = (1..=self.settings.birds)
            .map(|known| {
                if known == bird {
                    motion
                } else {
                    self.settings.motion(known)
                }
            })
            .collect();
        self.settings.motions = motions;
    }

    /// Takes what the host has sent by `now`.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for &byte in bytes {
            if now < self.busy_until {
                self.command.clear();
                self.unit = None;
                continue;
            }
            if std::mem::take(&mut self.addressed) {
                self.unit = usize::from(byte).checked_sub(1);
                continue;
            }
            if self.command.is_empty() && self.is_prefix(byte) {
                continue;
            }
            self.command.push(byte);
            let Some(length) = command_length(&self.command) else {
                self.error(INVALID_COMMAND);
                self.command.clear();
                self.unit = None;
                continue;
            };
            if self.command.len() == length {
                let command = std::mem::take(&mut self.command);
                let unit = self.unit.take().unwrap_or(0);
                if unit < self.units.len() {
                    self.obey(&command, unit, now);
                } else {
                    // 13: no answer from a unit.
                    self.error(13);
                }
            }
        }
    }

    /// Whether a byte says which unit the next command is for.
    fn is_prefix(&mut self, byte: u8) -> bool {
        let address = usize::from(byte & 0x0F);
        match (byte & 0xF0, self.settings.addressing) {
            (TO_UNIT, _) => self.unit = address.checked_sub(1),
            (0xE0, Addressing::Expanded) => self.unit = Some(address + 15),
            (TO_ADDRESS, Addressing::SuperExpanded) => self.addressed = true,
            _ => return false,
        }
        true
    }

    /// The bytes that the line has carried by `now` and not given before.
    pub fn send(&mut self, now: Duration) -> Vec<u8> {
        let mut out = Vec::new();
        while let Some((began, due)) = self.next_cycle().filter(|(_, due)| *due <= now) {
            self.line.carry(due, &mut out);
            self.cycle(began, due);
        }
        self.line.carry(now, &mut out);
        out
    }

    /// How long nothing more comes after `now`, if the host stays silent; `None` for ever.
    #[must_use]
    pub fn quiet_for(&self, now: Duration) -> Option<Duration> {
        let cycle = self.next_cycle().map(|(_, due)| due);
        let next = [cycle, self.line.next()].into_iter().flatten().min()?;
        Some(next.saturating_sub(now))
    }

    /// When the first stream began, which motions count from.
    #[must_use]
    pub fn epoch(&self) -> Option<Duration> {
        self.epoch
    }

    fn next_cycle(&self) -> Option<(Duration, Duration)> {
        let stream = self.stream.as_ref()?;
        let rate = self.settings.cycle_rate;
        // No number at all counts as the least.
        let rate = if rate.is_nan() {
            1.0
        } else {
            rate.clamp(1.0, 1000.0)
        };
        let cycle = Duration::from_secs_f64(1.0 / rate);
        Some((stream.began, stream.began + cycle * stream.next))
    }

    /// One measuring cycle of a stream.
    fn cycle(&mut self, began: Duration, due: Duration) {
        let Some(stream) = self.stream.as_mut() else {
            return;
        };
        let cycle = stream.next;
        stream.next = stream.next.saturating_add(stream.every);
        let time = due.saturating_sub(self.epoch.unwrap_or(began));
        // A line that is still busy with the last cycle gets the next one.
        if self.line.next().is_some() || self.settings.faults.stalled(time) {
            return;
        }
        let bytes = self.records(time, u64::from(cycle));
        for record in bytes.chunk_by(|_, next| next & PHASE == 0) {
            self.stream_records += 1;
            let mut record = record.to_vec();
            self.settings
                .faults
                .damage(self.stream_records, &mut record);
            for byte in record {
                self.stream_bytes += 1;
                let dropped = self
                    .settings
                    .faults
                    .drop_every
                    .is_some_and(|n| n > 0 && self.stream_bytes.is_multiple_of(n));
                if !dropped {
                    self.line.queue(&[byte], due);
                }
            }
        }
    }

    /// A record of each running bird, measured `time` after the first stream began.
    fn records(&self, time: Duration, cycle: u64) -> Vec<u8> {
        let Faults { freeze_at, .. } = self.settings.faults;
        let frozen = freeze_at.is_some_and(|from| time >= from);
        let time = freeze_at.map_or(time, |from| time.min(from));
        let mut bytes = Vec::new();
        let sensors = self.units.iter().zip(1u8..);
        let sensors = sensors.filter(|(unit, _)| !unit.controller);
        for ((unit, address), bird) in sensors.zip(1u32..) {
            if !unit.running || (!self.group && bird > 1) {
                continue;
            }
            let pose = self.settings.pose(bird, time.as_secs_f64());
            let mut words = unit.scale().words(&unit.measured(pose)).to_vec();
            if !frozen
                && cycle % FLICKER == FLICKER - 1
                && let Some(word) = words.first_mut()
            {
                *word ^= 4;
            }
            encode_words(&words, &mut bytes);
            if unit.buttons {
                bytes.push(self.settings.buttons & 0x70);
            }
            if self.group {
                bytes.push(address);
            }
        }
        bytes
    }

    fn obey(&mut self, command: &[u8], unit: usize, now: Duration) {
        match *command {
            [POINT] => self.point(now),
            [STREAM | b'Q'] => self.start_stream(1, now),
            [b'R'] => self.start_stream(2, now),
            [b'S'] => self.start_stream(8, now),
            [b'T'] => self.start_stream(32, now),
            [RUN] => self.units.iter_mut().for_each(|unit| unit.running = true),
            [SLEEP] => self.units.iter_mut().for_each(|unit| unit.running = false),
            [HEMISPHERE, axis, sign] => self.units[unit].hemisphere = [axis, sign],
            [b'O', parameter] => self.examine(parameter, unit, now),
            [CHANGE, AUTO_CONFIGURE, units] => {
                if usize::from(units) > self.units.len() {
                    self.error(13);
                }
                self.units = switched_on(&self.settings);
                self.units.iter_mut().for_each(|unit| unit.running = true);
                self.configured = true;
                self.busy_until = now + self.settings.auto_configuration;
            }
            [CHANGE, GROUP_MODE, on] => self.group = on != 0,
            // A controller's birds have its own range.
            [CHANGE, POSITION_SCALE, wide, _] if self.settings.erc_address.is_none() => {
                let range = if wide == 0 {
                    Range::Inches36
                } else {
                    Range::Inches72
                };
                self.units[unit].full_scale = range.metres();
            }
            [BUTTON_MODE, on] => self.units[unit].buttons = on != 0,
            [command] => {
                if let Some(format) = format_of_command(command)
                    && !self.settings.faults.keep_format
                {
                    self.units[unit].format = format;
                }
            }
            // The rest changes nothing that a host can see here.
            _ => {}
        }
    }

    /// Ends the stream, or gives one record of each bird.
    fn point(&mut self, now: Duration) {
        if self.stream.take().is_none() {
            let time = self
                .epoch
                .map_or(Duration::ZERO, |epoch| now.saturating_sub(epoch));
            let records = self.records(time, 0);
            self.line.queue(&records, now);
        }
    }

    fn start_stream(&mut self, every: u32, now: Duration) {
        self.epoch.get_or_insert(now);
        self.stream = Some(Stream {
            began: now,
            every,
            next: 0,
        });
    }

    fn examine(&mut self, parameter: u8, unit: usize, now: Duration) {
        // A unit that streams examines nothing.
        if self.stream.is_some() {
            return self.error(INVALID_COMMAND);
        }
        let bird = &self.units[unit];
        let answer = match parameter {
            0 => {
                let status = Coding::of(bird.format).number << 1
                    | u16::from(!bird.running) << 5
                    | u16::from(bird.running) << 12
                    | u16::from(!self.errors.is_empty()) << 13
                    | u16::from(self.configured) << 14
                    | u16::from(unit == 0) << 15;
                status.to_le_bytes().to_vec()
            }
            1 => vec![3, 0x43],
            2 => vec![40, 0],
            3 => vec![u8::from(bird.full_scale > 1.0), 0],
            6 => RATE_COUNT.to_vec(),
            10 => vec![self.errors.pop_front().unwrap_or(0)],
            15 if bird.controller => b"6DERC     ".to_vec(),
            15 => b"6DFOB     ".to_vec(),
            19 => vec![match self.settings.addressing {
                Addressing::Normal => 0,
                Addressing::Expanded => 1,
                Addressing::SuperExpanded => 3,
            }],
            21 => vec![unit as u8 + 1],
            22 => bird.hemisphere.to_vec(),
            35 => vec![u8::from(self.group)],
            36 => {
                let mut status = vec![0; system_status_length(self.settings.addressing)];
                for (i, (byte, unit)) in status.iter_mut().zip(&self.units).enumerate() {
                    // Accessible, with a sensor or the controller's transmitter; without a
                    // controller the first one has the transmitter.
                    let kind = if unit.controller { 0x11 } else { 0x20 };
                    let transmitter = i == 0 && self.settings.erc_address.is_none();
                    *byte = 0x80 | kind | u8::from(unit.running) << 6 | u8::from(transmitter);
                }
                status
            }
            _ => return self.error(INVALID_COMMAND),
        };
        self.line.queue(&answer, now);
    }

    fn error(&mut self, code: u8) {
        if self.errors.len() < 16 {
            self.errors.push_back(code);
        }
    }
}

impl SimulatedDevice for SimulatedFlock {
    fn receive(&mut self, bytes: &[u8], now: Duration) {
        self.receive(bytes, now);
    }

    fn send(&mut self, now: Duration) -> Vec<u8> {
        self.send(now)
    }

    fn quiet_for(&self, now: Duration) -> Option<Duration> {
        self.quiet_for(now)
    }
}

impl From<SimulatorSettings> for SimulatedFlock {
    fn from(settings: SimulatorSettings) -> Self {
        Self::new(settings)
    }
}

/// The units that a Flock of these settings has, just switched on.
fn switched_on(settings: &SimulatorSettings) -> Vec<Unit> {
    let birds = settings.birds.clamp(1, 14);
    let range = match settings.erc_address {
        Some(_) => Range::Inches144,
        None => Range::Inches36,
    };
    let mut units = vec![Unit::powered_up(range, false); birds as usize];
    if let Some(address) = settings.erc_address {
        let place = (address.clamp(1, birds + 1) - 1) as usize;
        units.insert(place, Unit::powered_up(range, true));
    }
    units
}

/// How many bytes the command has that begins so, or `None` where there is none.
fn command_length(begun: &[u8]) -> Option<usize> {
    let (&command, data) = begun.split_first()?;
    let data_length = match command {
        POINT | STREAM | RUN | SLEEP | b'Q'..=b'T' | b'V'..=b'Z' | b'\\' | b']' | b'N' | b'/' => 0,
        0x11 | 0x13 => 0,
        b'O' | b'M' | b'0' => 1,
        HEMISPHERE | b'A' => 2,
        b'r' | b'q' => 6,
        b'H' | b'J' => 12,
        CHANGE => match data.first() {
            // Its parameter tells how much follows.
            None => 1,
            Some(3 | 4 | 7 | 22 | 32) => 1 + 2,
            Some(5 | 12 | 13) => 1 + 14,
            Some(23 | 24) => 1 + 6,
            Some(8 | 9 | 11 | 14 | 17 | 18 | 20 | 21 | 35 | 50) => 1 + 1,
            Some(_) => return None,
        },
        _ => return None,
    };
    Some(1 + data_length)
}

#[cfg(test)]
mod tests {
    use super::super::Motion;
    use super::*;
    use crate::flock::{Decoder, Layout};

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    /// A Flock of three that was started as a well known host starts it, at one second.
    fn started(settings: SimulatorSettings) -> SimulatedFlock {
        let mut flock = SimulatedFlock::new(settings);
        flock.receive(b"B", ms(0));
        flock.receive(&[0x50, 0x32, 3], ms(100));
        let settings = [
            0x50, 0x23, 1, 0xF1, 0x5D, 0xF2, 0x5D, 0xF3, 0x5D, 0xF1, 0x4C, 0x0C, 1, 0xF2, 0x4C,
            0x0C, 1, 0xF3, 0x4C, 0x0C, 1,
        ];
        flock.receive(&settings, ms(500));
        assert!(flock.send(ms(600)).is_empty());
        flock.receive(&[0x4F, 0x24], ms(600));
        let status = flock.send(ms(700));
        assert_eq!(status[..4], [0xE1, 0xE0, 0xE0, 0]);
        assert_eq!(status.len(), 14);
        flock.receive(&[0x4F, 2, 0x4F, 6], ms(700));
        assert_eq!(flock.send(ms(800)), [40, 0, 0xCE, 0x2D]);
        flock.receive(b"@", ms(1000));
        flock
    }

    fn three() -> SimulatorSettings {
        SimulatorSettings {
            birds: 3,
            motions: vec![Motion::hold([12.0, 3.0, -5.0], [30.0, 20.0, 10.0])],
            ..SimulatorSettings::default()
        }
    }

    #[test]
    fn it_starts_by_a_well_known_hosts_commands_and_sends_the_worked_record() {
        let mut flock = started(three());
        let bytes = flock.send(ms(1010));
        let worked = [
            0xAA, 0x15, 0x2A, 0x05, 0x0E, 0x77, 0x73, 0x3C, 0x47, 0x7D, 0x71, 0x73, 0x57, 0x70, 1,
        ];
        assert_eq!(bytes[..15], worked);
        assert_eq!((bytes[29], bytes[44]), (2, 3));
    }

    #[test]
    fn its_stream_keeps_to_the_cycle_and_to_the_line() {
        let mut flock = started(three());
        let bytes = flock.send(ms(2000)).len();
        assert!((103 * 45..=104 * 45).contains(&bytes), "{bytes}");
        let mut slow = started(SimulatorSettings {
            baud: 9600,
            ..three()
        });
        let bytes = slow.send(ms(2000)).len();
        assert!((700..=960).contains(&bytes), "{bytes}");
        // The host ends it.
        flock.receive(b"BG", ms(2000));
        flock.send(ms(2100));
        assert!(flock.send(ms(3000)).is_empty());
        assert_eq!(flock.quiet_for(ms(3000)), None);
    }

    #[test]
    fn its_faults_are_those_asked_for() {
        let mut flock = started(SimulatorSettings {
            faults: Faults {
                drop_every: Some(50),
                stalls: vec![(ms(500), ms(1000))],
                ..Faults::default()
            },
            ..three()
        });
        let before = flock.send(ms(1500)).len();
        assert!(
            (52 * 45 * 49 / 50 - 45..=52 * 45 * 49 / 50 + 45).contains(&before),
            "{before}"
        );
        assert!(flock.send(ms(2490)).len() < 45);
        assert!(!flock.send(ms(2520)).is_empty());
    }

    #[test]
    fn a_held_pose_flickers_now_and_then_and_a_frozen_one_never() {
        for (freeze_at, expected) in [(None, 2), (Some(ms(0)), 0)] {
            let mut flock = started(SimulatorSettings {
                faults: Faults {
                    freeze_at,
                    ..Faults::default()
                },
                ..three()
            });
            let bytes = flock.send(ms(2000));
            let mut decoder = Decoder::new(Layout::grouped(
                RecordFormat::PositionQuaternion,
                &[1, 2, 3],
            ));
            let records: Vec<_> = bytes.iter().filter_map(|&b| decoder.push(b)).collect();
            let of_bird_1: Vec<_> = records.iter().filter(|r| r.bird == 1).collect();
            let odd = of_bird_1
                .iter()
                .filter(|r| r.words != of_bird_1[0].words)
                .count();
            assert_eq!(odd, expected);
        }
    }

    #[test]
    fn a_sensor_in_the_other_half_space_is_reported_mirrored() {
        let mut flock = started(three());
        flock.receive(b"B", ms(1100));
        flock.receive(&[0xF1, 0x4C, 0x0C, 0], ms(1110));
        flock.send(ms(1200));
        flock.receive(b"B", ms(1200));
        let bytes = flock.send(ms(1300));
        let record = Layout::grouped(RecordFormat::PositionQuaternion, &[1, 2, 3])
            .decode(&bytes[..15])
            .unwrap();
        let pose = Scale::new(Range::Inches36, RecordFormat::PositionQuaternion)
            .pose(&record.words)
            .unwrap();
        assert!((pose.translation.z - 5.0 * 0.0254).abs() < 2e-4);
    }

    #[test]
    fn what_arrives_while_it_configures_is_lost_and_nonsense_is_an_error() {
        let mut flock = SimulatedFlock::new(three());
        flock.receive(&[0x50, 0x32, 3], ms(0));
        flock.receive(&[0x50, 0x23, 1], ms(100));
        flock.receive(&[0x4F, 35], ms(400));
        assert_eq!(flock.send(ms(500)), [0]);
        flock.receive(&[0x01, 0x4F, 10, 0x4F, 10], ms(500));
        assert_eq!(flock.send(ms(600)), [INVALID_COMMAND, 0]);
    }

    #[test]
    fn a_controller_starts_as_a_well_known_host_starts_it() {
        let mut flock = SimulatedFlock::new(SimulatorSettings {
            birds: 2,
            erc_address: Some(1),
            ..three()
        });
        flock.receive(&[0x50, 0x32, 3], ms(100));
        let settings = [
            0x50, 0x23, 1, 0xF2, 0x5D, 0xF3, 0x5D, 0xF2, 0x4C, 0x0C, 1, 0xF3, 0x4C, 0x0C, 1, 0x4F,
            0x24,
        ];
        flock.receive(&settings, ms(500));
        assert_eq!(flock.send(ms(600))[..4], [0xD1, 0xE0, 0xE0, 0]);
        flock.receive(b"@", ms(700));
        let bytes = flock.send(ms(705));
        // The range is the controller's, and the birds' addresses follow its own.
        let layout = Layout::grouped(RecordFormat::PositionQuaternion, &[2, 3]);
        let scale = Scale::new(Range::Inches144, RecordFormat::PositionQuaternion);
        let record = layout.decode(&bytes[..15]).unwrap();
        let pose = scale.pose(&record.words).unwrap();
        assert_eq!((record.bird, bytes[29]), (1, 3));
        assert!((pose.translation.x - 12.0 * 0.0254).abs() < 5e-4);
    }

    #[test]
    fn expanded_addresses_and_buttons_are_understood() {
        for (addressing, prefix, length) in [
            (Addressing::Normal, [0xF1].as_slice(), 14),
            (Addressing::Expanded, &[0xF1], 30),
            (Addressing::SuperExpanded, &[0xA0, 1], 126),
        ] {
            let mut flock = SimulatedFlock::new(SimulatorSettings {
                addressing,
                buttons: 0x30,
                ..three()
            });
            flock.receive(&[0x50, 0x32, 3], ms(100));
            flock.receive(&[0x50, 0x23, 1], ms(500));
            for command in [[b'Y'].as_slice(), &[b'M', 1]] {
                flock.receive(&[prefix, command].concat(), ms(510));
            }
            flock.receive(&[0x4F, 0x24], ms(520));
            assert_eq!(flock.send(ms(600)).len(), length);
            flock.receive(b"B", ms(600));
            let bytes = flock.send(ms(610));
            assert_eq!(bytes[12..14], [0x30, 1], "{addressing:?}");
        }
    }

    #[test]
    fn no_commands_make_it_panic() {
        let mut flock = SimulatedFlock::new(SimulatorSettings::default());
        let mut state = 1u32;
        for step in 0..20_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            flock.receive(&[(state >> 24) as u8], Duration::from_micros(step * 300));
            flock.send(Duration::from_micros(step * 300));
        }
    }
}
