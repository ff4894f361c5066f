//! The simulated box: what it answers and sends, byte for byte, by a clock that is handed in.

use super::{Motion, SimulatorSettings};
use crate::pinch::{ContactGroups, ContactMessage, encode_text};
use crate::simulator::{SimulatedDevice, SimulatedLine};
use std::time::Duration;

/// A box of PINCH gloves without a port: takes commands, gives what its line has carried so far.
#[derive(Clone, Debug)]
pub struct SimulatedPinch {
    settings: SimulatorSettings,
    /// The first byte of a command of which the second is awaited.
    first: Option<u8>,
    timestamps: bool,
    /// When the first command was obeyed: the motion counts from here.
    epoch: Option<Duration>,
    next_change: u64,
    /// What was joined by [`SimulatedPinch::join`] and has not been told.
    joined: Option<ContactGroups>,
    told: Duration,
    contact_bytes: u64,
    line: SimulatedLine,
}

impl SimulatedPinch {
    /// A box that has just been switched on.
    #[must_use]
    pub fn new(settings: SimulatorSettings) -> Self {
        Self {
            first: None,
            timestamps: false,
            epoch: None,
            next_change: 0,
            joined: None,
            told: Duration::ZERO,
            contact_bytes: 0,
            line: SimulatedLine::new(settings.baud),
            settings,
        }
    }

    /// When the first command was obeyed, which the motion counts from.
    #[must_use]
    pub fn epoch(&self) -> Option<Duration> {
        self.epoch
    }

    /// Joins these fingers, and no others, from the next look at the line on; the motion has ended
    /// then. Before a host has been heard, nobody is told.
    pub fn join(&mut self, groups: ContactGroups) {
        self.settings.motion = Motion::Open;
        self.joined = Some(groups);
    }

    fn stalled(&self, now: Duration) -> bool {
        let epoch = self.epoch;
        epoch.is_some_and(|epoch| self.settings.faults.stalled(now.saturating_sub(epoch)))
    }

    fn obey(&mut self, command: [u8; 2], now: Duration) {
        let glove = |hand: usize, letter| match self.settings.gloves[hand] {
            true => letter,
            false if hand == 0 => "L NO GLOVE",
            false => "R NO GLOVE",
        };
        let tick = self.settings.tick.as_micros().to_string();
        let answer = match &command {
            b"T0" => "0",
            b"T1" => "1",
            b"V0" => "0",
            b"V1" => "1",
            b"CT" => &tick,
            b"CL" => glove(0, "L"),
            b"CR" => glove(1, "R"),
            b"CP" => "V1 simulated",
            _ => "?",
        };
        let mut bytes = Vec::new();
        encode_text(answer, &mut bytes);
        if command[0] == b'T' && answer != "?" {
            self.timestamps = answer == "1";
        }
        if answer != "?" && self.epoch.is_none() {
            self.epoch = Some(now);
            self.told = now;
        }
        self.line.queue(&bytes, now);
    }

    fn due_change(&self) -> Option<Duration> {
        let (time, _) = self.settings.motion.change(self.next_change)?;
        Some(self.epoch? + time)
    }

    /// Tells the next change, which is due.
    fn change(&mut self, due: Duration) {
        let Some((_, groups)) = self.settings.motion.change(self.next_change) else {
            return;
        };
        self.next_change += 1;
        self.tell(groups, due);
    }

    /// Tells what is joined from `due` on.
    fn tell(&mut self, groups: ContactGroups, due: Duration) {
        if self.stalled(due) {
            return;
        }
        let groups = groups.of_gloves(self.settings.gloves);
        let ticks = due.saturating_sub(self.told).as_nanos() / self.settings.tick.as_nanos().max(1);
        self.told = due;
        let message = ContactMessage {
            groups,
            ticks: self
                .timestamps
                .then(|| u16::try_from(ticks).unwrap_or(u16::MAX)),
        };
        let mut bytes = Vec::new();
        message.encode(&mut bytes);
        for byte in bytes {
            self.contact_bytes += 1;
            let nth = self.settings.faults.drop_every;
            let dropped = nth.is_some_and(|n| n > 0 && self.contact_bytes.is_multiple_of(n));
            if !dropped {
                self.line.queue(&[byte], due);
            }
        }
    }
}

impl SimulatedDevice for SimulatedPinch {
    fn receive(&mut self, bytes: &[u8], now: Duration) {
        if self.stalled(now) {
            self.first = None;
            return;
        }
        for &byte in bytes {
            match self.first.take() {
                None => self.first = Some(byte),
                Some(first) => self.obey([first, byte], now),
            }
        }
    }

    fn send(&mut self, now: Duration) -> Vec<u8> {
        let mut out = Vec::new();
        while let Some(due) = self.due_change().filter(|due| *due <= now) {
            self.line.carry(due, &mut out);
            self.change(due);
        }
        if self.epoch.is_some()
            && let Some(groups) = self.joined.take()
        {
            self.tell(groups, now);
        }
        self.line.carry(now, &mut out);
        out
    }

    fn quiet_for(&self, now: Duration) -> Option<Duration> {
        let next = [self.due_change(), self.line.next()];
        let next = next.into_iter().flatten().min()?;
        Some(next.saturating_sub(now))
    }
}

impl From<SimulatorSettings> for SimulatedPinch {
    fn from(settings: SimulatorSettings) -> Self {
        Self::new(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Faults;
    use super::*;
    use crate::Fingers;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    /// A box, asked as a host asks, and what it has answered.
    fn asked(settings: SimulatorSettings, commands: &[u8]) -> (SimulatedPinch, Vec<u8>) {
        let mut device = SimulatedPinch::new(settings);
        device.receive(commands, ms(0));
        let answers = device.send(ms(200));
        (device, answers)
    }

    fn still() -> SimulatorSettings {
        SimulatorSettings {
            motion: Motion::Open,
            ..SimulatorSettings::default()
        }
    }

    #[test]
    fn it_answers_as_the_box_does() {
        let (_, answers) = asked(still(), b"T0T1V1CTCL");
        assert_eq!(answers[..6], [0x82, 0x30, 0x8F, 0x82, 0x31, 0x8F]);
        assert!(answers.ends_with(b"\x821\x8F\x821000\x8F\x82L\x8F"));
        let settings = SimulatorSettings {
            gloves: [false, true],
            ..still()
        };
        let (_, answers) = asked(settings, b"CLCRXX");
        assert_eq!(answers, b"\x82L NO GLOVE\x8F\x82R\x8F\x82?\x8F");
    }

    #[test]
    fn a_single_byte_gets_it_into_step() {
        let (mut device, _) = asked(still(), b"T");
        device.receive(b"*", ms(200));
        assert_eq!(device.send(ms(300)), [0x82, 0x3F, 0x8F]);
        device.receive(b"T0", ms(300));
        assert_eq!(device.send(ms(400)), [0x82, 0x30, 0x8F]);
    }

    #[test]
    fn changes_come_by_themselves_at_the_lines_speed() {
        let settings = SimulatorSettings {
            motion: Motion::named("pinch").unwrap(),
            ..SimulatorSettings::default()
        };
        let mut device = SimulatedPinch::new(settings.clone());
        assert_eq!(device.quiet_for(ms(0)), None);
        assert!(device.send(ms(5000)).is_empty());
        device.receive(b"T0", ms(5000));
        // An answer of three bytes and four of contacts, 1.04 ms each.
        assert_eq!(device.send(ms(5003)), [0x82, 0x30]);
        assert_eq!(device.send(ms(5900)), [0x8F, 0x80, 0x00, 0x18, 0x8F]);
        assert_eq!(device.quiet_for(ms(5900)), Some(ms(100)));
        assert_eq!(device.send(ms(6500)), [0x80, 0x8F]);
        let (mut timed, _) = asked(settings, b"T1");
        // 1000 ticks of a millisecond: 0x68 + 128 * 7.
        assert_eq!(timed.send(ms(1500)), [0x81, 0x68, 0x07, 0x8F]);
    }

    #[test]
    fn fingers_are_joined_when_told_and_the_motion_ends() {
        let settings = SimulatorSettings {
            motion: Motion::named("pinch").unwrap(),
            ..SimulatorSettings::default()
        };
        let mut device = SimulatedPinch::new(settings);
        let middle = [Fingers::THUMB.with(Fingers::MIDDLE), Fingers::default()];
        device.join(ContactGroups::new(&[middle]).unwrap());
        // Nobody has asked for anything yet.
        assert!(device.send(ms(100)).is_empty());
        device.receive(b"T0", ms(100));
        let bytes = [0x82, 0x30, 0x8F, 0x80, 0x14, 0x00, 0x8F];
        assert!(device.send(ms(100)).is_empty());
        assert_eq!(device.send(ms(110)), bytes);
        device.join(ContactGroups::default());
        assert!(device.send(ms(110)).is_empty());
        assert_eq!(device.send(ms(9000)), [0x80, 0x8F]);
    }

    #[test]
    fn a_glove_that_is_missing_touches_nothing() {
        let settings = SimulatorSettings {
            motion: Motion::named("pinch").unwrap(),
            gloves: [true, false],
            ..SimulatorSettings::default()
        };
        let (_, sent) = asked(settings, b"T0");
        assert_eq!(sent, [0x82, 0x30, 0x8F, 0x80, 0x8F]);
    }

    #[test]
    fn its_faults_are_those_asked_for() {
        let settings = SimulatorSettings {
            motion: Motion::named("pinch").unwrap(),
            faults: Faults {
                drop_every: Some(2),
                stalls: vec![(ms(900), ms(200))],
            },
            ..SimulatorSettings::default()
        };
        let (mut device, answer) = asked(settings, b"T0");
        assert_eq!(answer, [0x82, 0x30, 0x8F, 0x80, 0x18]);
        // The change at one second falls into the stall, and so does a command.
        device.receive(b"T0", ms(1000));
        assert!(device.send(ms(1900)).is_empty());
        device.receive(b"T0", ms(1900));
        assert_eq!(device.send(ms(1950)), [0x82, 0x30, 0x8F]);
    }

    #[test]
    fn no_commands_make_it_panic() {
        let mut device = SimulatedPinch::new(SimulatorSettings {
            tick: Duration::ZERO,
            ..SimulatorSettings::default()
        });
        let mut state = 1u32;
        for step in 0..20_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            device.receive(&[(state >> 24) as u8], Duration::from_micros(step * 300));
            device.send(Duration::from_micros(step * 300));
        }
    }
}
