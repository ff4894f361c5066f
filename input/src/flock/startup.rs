//! Start-up: what is sent in which order, with which silences, and what must come back.
//!
//! A plain table, so that it can be read and tested without a port. Auto-configuration resets each
//! unit's format and scale, and must have silence on both sides; so all settings come after it.

use super::format::Coding;
use sandtable_config::{Addressing, Flock, FlockMode, Hemisphere, Range};
use std::time::Duration;

/// One step of a start-up or a stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// What it does, for logs and errors.
    pub what: &'static str,
    /// What goes over the line.
    pub action: Action,
    /// The silence kept afterwards; what arrives in it is discarded.
    pub silence: Duration,
}

/// What goes over the line in a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Bytes that nothing answers.
    Send(Vec<u8>),
    /// EXAMINE the system status: [`super::system_status_length`] bytes come back.
    ExamineStatus,
    /// RTS high for the time given, then low: holds the units in reset. Without modem lines it is
    /// skipped, its silence too.
    PulseRts(Duration),
}

/// How long an answer may take.
pub(crate) const ANSWER_WITHIN: Duration = Duration::from_millis(500);

/// EXAMINE the system status.
pub(crate) const EXAMINE_STATUS: [u8; 2] = [b'O', 36];

/// EXAMINE the error code, which answers with one byte and forgets the error.
pub(crate) const EXAMINE_ERROR: [u8; 2] = [b'O', 10];

/// POINT, which also ends a stream.
pub(crate) const POINT: u8 = b'B';

/// STREAM until [`POINT`].
pub(crate) const STREAM: u8 = b'@';

/// Turns the transmitter off; sent when the device is left.
pub(crate) const SLEEP: u8 = b'G';

/// RUN, which wakes a unit that sleeps.
pub(crate) const RUN: u8 = b'F';

pub(crate) const HEMISPHERE: u8 = b'L';
pub(crate) const CHANGE: u8 = b'P';
/// BUTTON MODE: whether records bring the state of the buttons.
pub(crate) const BUTTON_MODE: u8 = b'M';
pub(crate) const GROUP_MODE: u8 = 35;
pub(crate) const AUTO_CONFIGURE: u8 = 50;
pub(crate) const POSITION_SCALE: u8 = 3;
/// RS232 TO FBB: the next command goes to the unit whose address is in the low half.
pub(crate) const TO_UNIT: u8 = 0xF0;
/// The same with super-expanded addresses: the unit's is the byte that follows.
pub(crate) const TO_ADDRESS: u8 = 0xA0;

/// The steps that take a rig's Flock from power-up to streaming.
#[must_use]
pub fn startup(flock: &Flock) -> Vec<Step> {
    let mut steps = Vec::new();
    if flock.reset_with_rts {
        steps.push(Step {
            what: "reset by RTS",
            action: Action::PulseRts(Duration::from_millis(600)),
            silence: Duration::from_secs(1),
        });
    }
    let send = |what, bytes: Vec<u8>, silence| Step {
        what,
        action: Action::Send(bytes),
        silence,
    };
    let short = Duration::from_millis(50);
    if flock.group {
        // Everything until the silence is over is discarded: records of a stream left on, too.
        steps.push(send("end any stream", vec![POINT], flock.silence_before));
        steps.push(send(
            "auto-configure",
            vec![CHANGE, AUTO_CONFIGURE, flock.units()],
            flock.silence_after,
        ));
        steps.push(send("group mode", vec![CHANGE, GROUP_MODE, 1], short));
    } else {
        steps.push(send("end any stream", vec![POINT], flock.silence_before));
        steps.push(send("run", vec![RUN], short));
    }
    let addresses = flock.addresses();
    let units: Vec<Option<u8>> = if flock.group {
        addresses.iter().copied().map(Some).collect()
    } else {
        vec![None]
    };
    for unit in units {
        // Each command needs its own prefix.
        let to_unit = |bytes: &[u8]| -> Vec<u8> {
            let mut command = match (unit, flock.addressing) {
                (None, _) => Vec::new(),
                (Some(address), Addressing::SuperExpanded) => vec![TO_ADDRESS, address],
                (Some(address), _) => vec![TO_UNIT + address],
            };
            command.extend(bytes);
            command
        };
        let mut bytes = to_unit(&[Coding::of(flock.format).command]);
        if flock.buttons {
            bytes.extend(to_unit(&[BUTTON_MODE, 1]));
        }
        let [axis, sign] = hemisphere_code(flock.hemisphere);
        bytes.extend(to_unit(&[HEMISPHERE, axis, sign]));
        if flock.range == Range::Inches72 {
            // 36 inches is what auto-configuration leaves, and 144 is the controller's own.
            bytes.extend(to_unit(&[CHANGE, POSITION_SCALE, 1, 0]));
        }
        steps.push(send("format, hemisphere and range", bytes, short));
    }
    if flock.group {
        steps.push(Step {
            what: "check the system status",
            action: Action::ExamineStatus,
            silence: Duration::ZERO,
        });
    }
    if flock.mode == FlockMode::Stream {
        steps.push(send("stream", vec![STREAM], Duration::ZERO));
    }
    steps
}

/// What is sent when the device is left: the stream ends and the transmitter is turned off.
#[must_use]
pub fn stop_bytes() -> [u8; 2] {
    [POINT, SLEEP]
}

/// The data bytes of HEMISPHERE.
#[must_use]
pub fn hemisphere_code(hemisphere: Hemisphere) -> [u8; 2] {
    match hemisphere {
        Hemisphere::Forward => [0x00, 0x00],
        Hemisphere::Aft => [0x00, 0x01],
        Hemisphere::Right => [0x06, 0x00],
        Hemisphere::Left => [0x06, 0x01],
        Hemisphere::Lower => [0x0C, 0x00],
        Hemisphere::Upper => [0x0C, 0x01],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_config::{Device, RecordFormat, Rig};

    fn flock(edit: impl Fn(&mut Flock)) -> Flock {
        let rig = Rig::builtin("workbench").unwrap();
        let Device::Flock(flock) = &rig.devices["flock"] else {
            panic!("the workbench has a Flock");
        };
        let mut flock = flock.clone();
        edit(&mut flock);
        flock
    }

    fn sent(steps: &[Step]) -> Vec<u8> {
        steps
            .iter()
            .flat_map(|step| match &step.action {
                Action::Send(bytes) => bytes.clone(),
                Action::ExamineStatus => EXAMINE_STATUS.to_vec(),
                Action::PulseRts(_) => Vec::new(),
            })
            .collect()
    }

    fn lasting(steps: &[Step]) -> Duration {
        let lasting = |step: &Step| match step.action {
            Action::PulseRts(time) => time + step.silence,
            _ => step.silence,
        };
        steps.iter().map(lasting).sum()
    }

    #[test]
    fn three_birds_get_what_a_well_known_host_sends() {
        let flock = flock(|flock| {
            flock.birds = 3;
            flock.range = Range::Inches36;
            flock.hemisphere = Hemisphere::Forward;
        });
        let expected: &[u8] = &[
            b'B', 0x50, 0x32, 3, 0x50, 0x23, 1, //
            0xF1, 0x5D, 0xF1, 0x4C, 0, 0, 0xF2, 0x5D, 0xF2, 0x4C, 0, 0, 0xF3, 0x5D, 0xF3, 0x4C, 0,
            0, 0x4F, 0x24, b'@',
        ];
        assert_eq!(sent(&startup(&flock)), expected);
    }

    #[test]
    fn a_controller_counts_as_a_unit_but_gets_no_format() {
        let flock = flock(|flock| {
            flock.range = Range::Inches144;
            flock.erc_address = Some(1);
            flock.hemisphere = Hemisphere::Upper;
        });
        let expected: &[u8] = &[
            b'B', 0x50, 0x32, 3, 0x50, 0x23, 1, 0xF2, 0x5D, 0xF2, 0x4C, 0x0C, 1, 0xF3, 0x5D, 0xF3,
            0x4C, 0x0C, 1, 0x4F, 0x24, b'@',
        ];
        assert_eq!(sent(&startup(&flock)), expected);
    }

    #[test]
    fn auto_configuration_has_its_silences_and_settings_follow_it() {
        let flock = flock(|_| {});
        let steps = startup(&flock);
        let auto = steps
            .iter()
            .position(|s| s.what == "auto-configure")
            .unwrap();
        assert_eq!(steps[auto - 1].silence, Duration::from_secs(1));
        assert_eq!(steps[auto].silence, Duration::from_millis(1500));
        assert!(
            sent(&steps[..auto]) == [b'B']
                && steps[0].action == Action::PulseRts(Duration::from_millis(600))
        );
        // The wide range is asked for, bird by bird.
        assert!(
            sent(&steps[auto..])
                .windows(5)
                .any(|w| w == [0xF2, b'P', 3, 1, 0])
        );
        // All of it stays under five seconds.
        let total = lasting(&steps);
        assert!(total < Duration::from_secs(5), "{total:?}");
    }

    #[test]
    fn format_buttons_and_addressing_are_as_the_rig_says() {
        let flock = flock(|flock| {
            flock.birds = 1;
            flock.range = Range::Inches36;
            flock.hemisphere = Hemisphere::Forward;
            flock.format = RecordFormat::PositionAngles;
            flock.buttons = true;
            flock.mode = FlockMode::Point;
            flock.addressing = Addressing::SuperExpanded;
        });
        let expected: &[u8] = &[
            b'B', 0x50, 0x32, 1, 0x50, 0x23, 1, 0xA0, 1, b'Y', 0xA0, 1, b'M', 1, 0xA0, 1, b'L', 0,
            0, 0x4F, 0x24,
        ];
        assert_eq!(sent(&startup(&flock)), expected);
    }

    #[test]
    fn fourteen_birds_start_within_seven_seconds() {
        let flock = flock(|flock| flock.birds = 14);
        assert!(lasting(&startup(&flock)) < Duration::from_secs(7));
    }

    #[test]
    fn a_bird_alone_is_woken_and_needs_no_address() {
        let flock = flock(|flock| {
            flock.birds = 1;
            flock.group = false;
            flock.range = Range::Inches36;
            flock.hemisphere = Hemisphere::Lower;
        });
        assert_eq!(
            sent(&startup(&flock)),
            [b'B', b'F', b']', b'L', 0x0C, 0, b'@']
        );
    }
}
