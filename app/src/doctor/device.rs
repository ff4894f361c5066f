//! The devices of a rig: whether each one speaks, how fast, how evenly, and what is lost.

use super::finding::{Finding, Item};
use sandtable_config::{Device, Rig, SensorName};
use sandtable_input::{Clock, Condition, DeviceState, Devices, Hub, StreamCounts};
use sandtable_pose::Nanos;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A Flock's start-up is the longest, and takes up to 7 s; that a bird is missing shows 2 s later.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long each device is listened to.
const LISTENING: Duration = Duration::from_secs(2);

pub(super) fn examine(rig: &Rig) -> Result<Finding, String> {
    let hub = Arc::new(Hub::for_rig(rig));
    let clock = Clock::start();
    let devices = Devices::start(rig, &hub, clock, None).map_err(|error| error.to_string())?;
    let start = Instant::now();
    // One that is not there says so at once, and may yet come.
    let is_waited_for =
        |state: &DeviceState| state.condition == Condition::Starting && state.trouble.is_none();
    while start.elapsed() < PATIENCE && devices.states().iter().any(is_waited_for) {
        std::thread::sleep(Duration::from_millis(50));
    }
    let (from, before) = (clock.now(), devices.states());
    std::thread::sleep(LISTENING);
    let after = devices.states();
    let mut finding = Finding::default();
    if after.is_empty() {
        finding.advise(format!(
            "The rig {:?} has none; write [devices.NAME] into its file.",
            rig.name
        ));
    }
    for (before, after) in before.iter().zip(&after) {
        let Some(device) = rig.devices.get(&after.name) else {
            continue;
        };
        let sensors: Vec<_> = hub
            .sensors()
            .filter(|sensor| sensor.device == after.name)
            .map(|sensor| Heard::of(&hub, device, &sensor, from))
            .collect();
        report(&mut finding, device, before, after, &sensors);
    }
    devices.stop();
    Ok(finding)
}

/// How one kind of a sensor's samples came in.
struct Pace {
    samples: usize,
    /// Samples a second, and the standard deviation of the time from one to the next; known from
    /// three samples on.
    rate_and_jitter: Option<(f64, Duration)>,
}

impl Pace {
    fn of(times: &[Nanos]) -> Self {
        Self {
            samples: times.len(),
            rate_and_jitter: pace(times),
        }
    }

    /// `what` are the samples, as `poses`.
    fn in_words(&self, what: &str) -> String {
        match self.rate_and_jitter {
            Some((rate, jitter)) => {
                let jitter = 1e3 * jitter.as_secs_f64();
                format!("{rate:.1} {what} a second, ± {jitter:.2} ms")
            }
            None => format!("{} {what}", self.samples),
        }
    }

    fn json(&self) -> Value {
        let (rate, jitter) = self.rate_and_jitter.unzip();
        json!({
            "samples": self.samples,
            "rate_hz": rate,
            "jitter_ms": jitter.map(|jitter| 1e3 * jitter.as_secs_f64()),
        })
    }
}

/// What came of a sensor.
struct Heard {
    number: u32,
    /// Of a tracker, and of a glove that tells where it is.
    poses: Option<Pace>,
    /// Of a glove, with what is to be said of its fingers.
    hands: Option<(Pace, Option<&'static str>)>,
    /// Where there were any.
    buttons: Option<Pace>,
}

impl Heard {
    fn of(hub: &Hub, device: &Device, sensor: &SensorName, from: Nanos) -> Self {
        let poses = hub.poses_since(sensor, from);
        let poses: Vec<Nanos> = poses.iter().map(|pose| pose.time).collect();
        let hands = hub.hands_since(sensor, from);
        let buttons = hub.buttons_since(sensor, from);
        let is_glove = device.gestures().is_some();
        let remark = match device {
            Device::Pinch(_) if hands.is_empty() => Some("it tells changes only"),
            _ if hands.is_empty() || hub.hand_at(sensor, Nanos(u64::MAX)).is_some() => None,
            _ => Some("its fingers are not known yet: open and close the hand a few times"),
        };
        Self {
            number: sensor.number,
            poses: (!is_glove || !poses.is_empty()).then(|| Pace::of(&poses)),
            hands: is_glove.then(|| (Pace::of(&hands), remark)),
            buttons: (!buttons.is_empty()).then(|| Pace::of(&buttons)),
        }
    }

    fn in_words(&self) -> String {
        let mut parts: Vec<String> = self.poses.iter().map(|p| p.in_words("poses")).collect();
        if let Some((hands, remark)) = &self.hands {
            let remark = remark.map_or(String::new(), |remark| format!(" ({remark})"));
            parts.push(hands.in_words("hands") + &remark);
        }
        parts.extend(self.buttons.iter().map(|b| b.in_words("states of buttons")));
        format!("sensor {}: {}", self.number, parts.join("; "))
    }

    /// The poses' numbers stand in the sensor itself, those of hands and buttons in their own.
    fn json(&self) -> Value {
        let mut sensor = json!({ "number": self.number });
        if let Some(poses) = &self.poses {
            let told = poses.json();
            sensor["poses"] = told["samples"].clone();
            sensor["rate_hz"] = told["rate_hz"].clone();
            sensor["jitter_ms"] = told["jitter_ms"].clone();
        }
        if let Some((hands, _)) = &self.hands {
            sensor["hands"] = hands.json();
        }
        if let Some(buttons) = &self.buttons {
            sensor["buttons"] = buttons.json();
        }
        sensor
    }
}

fn pace(times: &[Nanos]) -> Option<(f64, Duration)> {
    let [first, _, .., last] = times else {
        return None;
    };
    let mean = last.since(*first).as_secs_f64() / (times.len() - 1) as f64;
    let intervals = times
        .windows(2)
        .map(|pair| pair[1].since(pair[0]).as_secs_f64());
    let squares: f64 = intervals.map(|interval| (interval - mean).powi(2)).sum();
    let jitter = (squares / (times.len() - 1) as f64).sqrt();
    (mean > 0.0).then(|| (1.0 / mean, Duration::from_secs_f64(jitter)))
}

/// How a device's bytes come here, as far as that tells who loses some.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Serial,
    Vrpn,
    Dtrack,
    Hid,
}

impl Way {
    fn of(device: &Device) -> Self {
        match device {
            Device::Flock(_) | Device::Pinch(_) => Self::Serial,
            Device::Vrpn(_) => Self::Vrpn,
            Device::Dtrack(_) => Self::Dtrack,
            Device::DataGlove(_) | Device::HidGlove(_) => Self::Hid,
        }
    }

    /// Records that were lost or not believed. One that stood alone is none: so begins whatever comes
    /// into a tracker's sight.
    fn lost(self, counts: &StreamCounts) -> u64 {
        let StreamCounts {
            cut_records,
            overlong_records,
            implausible,
            refused,
            ..
        } = counts;
        let foreign = match self {
            // Nobody else is on its line: an address that nobody has is a damaged one.
            Self::Serial => counts.foreign_records,
            _ => 0,
        };
        cut_records + overlong_records + implausible + refused + foreign
    }

    /// Records of others who share the network's connection, which is no loss.
    fn of_others(self, counts: &StreamCounts) -> u64 {
        match self {
            Self::Vrpn | Self::Dtrack => counts.foreign_records,
            Self::Serial | Self::Hid => 0,
        }
    }

    /// What helps against losses.
    fn against_losses(self) -> &'static str {
        match self {
            Self::Serial => {
                "bytes are lost or altered on its line; check the cable, its length and its \
                 shield, and keep it away from screens and motors"
            }
            Self::Vrpn => {
                "its server tells what is not believed: poses that jump, or numbers that are no \
                 pose; look at them there (vrpn_print_devices shows them), or write a higher \
                 `max_speed` and `max_turn` in the rig if they are right"
            }
            Self::Dtrack => {
                "datagrams come late, twice or damaged, or bodies jump; send DTrack's output to \
                 this computer once only, by a cable and not by radio, and look at the bodies' \
                 calibration there"
            }
            Self::Hid => {
                "reports come that are none of such a glove; compare the rig's description of \
                 them with the glove's own"
            }
        }
    }

    /// What helps where sensors tell no poses though their device speaks.
    fn against_silence(self) -> &'static str {
        match self {
            Self::Serial => {
                "check that each sensor and the transmitter are plugged in, and that the sensors \
                 are near enough to it"
            }
            Self::Vrpn => {
                "its server tells none of them: start the tracker behind it, or write fewer \
                 `sensors` in the rig"
            }
            Self::Dtrack => {
                "the cameras see none of them: bring them into view, or write fewer `bodies` and \
                 `flysticks` in the rig"
            }
            Self::Hid => "move the hand",
        }
    }
}

fn report(
    finding: &mut Finding,
    device: &Device,
    before: &DeviceState,
    after: &DeviceState,
    sensors: &[Heard],
) {
    let name = &after.name;
    let way = Way::of(device);
    let counts = after.counts.since(&before.counts);
    let (lost, of_others) = (way.lost(&counts), way.of_others(&counts));
    let condition = match &after.condition {
        Condition::Starting => "starting",
        Condition::Streaming => "streaming",
        Condition::Waiting(_) => "waiting",
    };
    let problem = match &after.condition {
        Condition::Waiting(why) => Some(why.clone()),
        Condition::Starting => Some(after.trouble.clone().unwrap_or_else(|| {
            let seconds = (PATIENCE + LISTENING).as_secs();
            format!(
                "it has been starting for {seconds} s, and has told nothing that its kind says; \
                 check that it is on, and what the rig says of it"
            )
        })),
        Condition::Streaming => None,
    };
    let mut detail = condition.to_owned();
    if !matches!(after.condition, Condition::Waiting(_)) {
        let StreamCounts {
            records,
            stray_bytes: stray,
            ..
        } = counts;
        detail += &format!(", {records} records in 2 s, {lost} lost, {stray} stray bytes");
        if of_others > 0 {
            detail += &format!(", {of_others} of others");
        }
        if counts.alone > 0 {
            detail += &format!(", {} first after a silence", counts.alone);
        }
        for sensor in sensors {
            detail += &format!("\n    {}", sensor.in_words());
        }
    }
    if let Some(problem) = &problem {
        finding.advise(format!("{name}: {problem}."));
    } else {
        // Each of a tracker's sensors tells all the time, where it is one that works.
        let has_none = |sensor: &&Heard| sensor.poses.as_ref().is_some_and(|p| p.samples == 0);
        let silent = sensors.iter().filter(has_none);
        let silent: Vec<_> = silent.map(|s| format!("{name}/{}", s.number)).collect();
        if !silent.is_empty() {
            finding.advise(format!(
                "{name}: no pose came of {} in 2 s; {}.",
                silent.join(", "),
                way.against_silence()
            ));
        }
        if lost > 0 {
            finding.advise(format!("{name}: {}.", way.against_losses()));
        }
    }
    finding.found(Item::new(
        name,
        detail,
        json!({
            "condition": condition,
            "problem": problem,
            "records": counts.records,
            "lost": lost,
            "of_others": of_others,
            "alone": counts.alone,
            "stray_bytes": counts.stray_bytes,
            "sensors": sensors.iter().map(Heard::json).collect::<Vec<_>>(),
        }),
    ));
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_input::{HidError, stream_of, udev_rule};

    #[test]
    fn rate_and_jitter_are_those_of_the_intervals() {
        let times = [0, 10, 20, 32, 40].map(|ms| Nanos(ms * 1_000_000));
        let (rate, jitter) = pace(&times).expect("there are enough");
        assert!((rate - 100.0).abs() < 1e-9);
        // 0, 0, 2 and −2 ms off.
        assert!((jitter.as_secs_f64() - 2e-3 / f64::sqrt(2.0)).abs() < 1e-9);
        assert_eq!(pace(&times[..2]), None);
    }

    #[test]
    fn a_glove_is_told_by_its_hands() {
        let text = "name = 'g'\n[camera]\n[devices.glove]\nkind = 'hid-glove'\nhand = 'left'\n\
                    vendor = 1\nproduct = 2\nbuttons = [{ byte = 0 }]\n\
                    fingers = { index = { byte = 1 } }\n";
        let rig = Rig::parse(text, "g").expect("a rig");
        let (hub, device) = (Hub::for_rig(&rig), &rig.devices["glove"]);
        let mut stream = stream_of(device);
        let mut push = |report: &[u8], ms: u64| {
            let time = Nanos(ms * 1_000_000);
            stream.push(report, time, &mut |sample| hub.push("glove", sample));
        };
        let sensor = hub.sensors().next().expect("one glove");
        let told = |from| Heard::of(&hub, device, &sensor, Nanos(from)).in_words();
        assert_eq!(told(0), "sensor 1: 0 hands");
        for step in 1..=5 {
            push(&[1, 100], 20 * step);
        }
        assert_eq!(
            told(0),
            "sensor 1: 50.0 hands a second, ± 0.00 ms (its fingers are not known yet: open and \
             close the hand a few times); 50.0 states of buttons a second, ± 0.00 ms"
        );
        push(&[1, 200], 120);
        let heard = Heard::of(&hub, device, &sensor, Nanos(0));
        assert!(
            heard
                .in_words()
                .starts_with("sensor 1: 50.0 hands a second, ± 0.00 ms; ")
        );
        let json = heard.json();
        assert_eq!(json["hands"]["samples"], 6);
        assert_eq!(json["buttons"]["samples"], 6);
        assert_eq!(json.get("poses"), None);
    }

    fn state(condition: Condition, counts: StreamCounts) -> DeviceState {
        DeviceState {
            name: "it".into(),
            condition,
            counts,
            trouble: None,
        }
    }

    /// What is found of the device that `lines` describe, which is `after` at the end.
    fn found(lines: &str, after: &DeviceState, sensors: &[Heard]) -> Finding {
        let text = format!(
            "name = 'r'\n[camera]\n[devices.it]\n{lines}\n\
             table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}\n"
        );
        let rig = Rig::parse(&text, "r").expect("a rig");
        let before = state(Condition::Starting, StreamCounts::default());
        let mut finding = Finding::default();
        report(&mut finding, &rig.devices["it"], &before, after, sensors);
        finding
    }

    fn tracked(number: u32, samples: usize) -> Heard {
        let rate_and_jitter = (samples > 2).then_some((100.0, Duration::ZERO));
        Heard {
            number,
            poses: Some(Pace {
                samples,
                rate_and_jitter,
            }),
            hands: None,
            buttons: None,
        }
    }

    const FLOCK: &str = "kind = 'flock-of-birds'\nport = '/dev/ttyS0'\nbirds = 2\nrange = 36\n\
                         hemisphere = 'upper'";
    const VRPN: &str = "kind = 'vrpn'\naddress = 'Tracker0@lab'\nsensors = 2";
    const DTRACK: &str = "kind = 'dtrack'\nport = 5000\nbodies = 2";

    #[test]
    fn a_device_that_is_tried_again_is_told_with_what_was_wrong_with_it() {
        let mut after = state(Condition::Starting, StreamCounts::default());
        let advice = |after: &DeviceState| found(FLOCK, after, &[tracked(1, 0)]).advice;
        assert_eq!(advice(&after).len(), 1);
        assert!(advice(&after)[0].contains("starting for 12 s"));
        after.trouble = Some("it has been silent for 2 s; switch it on".into());
        assert_eq!(
            advice(&after),
            ["it: it has been silent for 2 s; switch it on."]
        );
        let json = found(FLOCK, &after, &[]).json();
        assert_eq!(
            json[0]["problem"],
            "it has been silent for 2 s; switch it on"
        );
    }

    #[test]
    fn a_sensor_without_poses_is_named_with_what_helps_on_its_way_here() {
        let after = state(Condition::Streaming, StreamCounts::default());
        for (lines, helps) in [
            (FLOCK, "plugged in"),
            (VRPN, "`sensors`"),
            (DTRACK, "cameras"),
        ] {
            let finding = found(lines, &after, &[tracked(1, 200), tracked(2, 0)]);
            let [advice] = &finding.advice[..] else {
                panic!("{finding}");
            };
            assert!(advice.contains("no pose came of it/2 in 2 s"), "{advice}");
            assert!(advice.contains(helps), "{advice}");
            let finding = found(lines, &after, &[tracked(1, 200), tracked(2, 200)]);
            assert!(finding.advice.is_empty(), "{finding}");
        }
    }

    #[test]
    fn others_on_a_network_are_no_losses_and_only_a_line_has_a_cable() {
        let foreign = StreamCounts {
            foreign_records: 7,
            ..StreamCounts::default()
        };
        let refused = StreamCounts {
            refused: 3,
            ..foreign
        };
        let sensors = [tracked(1, 200), tracked(2, 200)];
        for lines in [VRPN, DTRACK] {
            let after = state(Condition::Streaming, foreign);
            let finding = found(lines, &after, &sensors);
            assert!(finding.advice.is_empty(), "{finding}");
            assert!(finding.to_string().contains(", 7 of others"), "{finding}");
            assert_eq!(finding.json()[0]["lost"], 0);
            assert_eq!(finding.json()[0]["of_others"], 7);
            let finding = found(lines, &state(Condition::Streaming, refused), &sensors);
            assert_eq!(finding.json()[0]["lost"], 3);
            assert_eq!(finding.advice.len(), 1, "{finding}");
            assert!(!finding.advice[0].contains("shield"), "{finding}");
        }
        let finding = found(FLOCK, &state(Condition::Streaming, refused), &sensors);
        assert_eq!(finding.json()[0]["lost"], 10);
        assert!(finding.advice[0].contains("shield"), "{finding}");
    }

    #[test]
    fn a_sensor_that_begins_to_be_seen_while_it_is_listened_to_has_no_fault() {
        for lines in [FLOCK, VRPN, DTRACK] {
            let begun = StreamCounts {
                records: 200,
                alone: 2,
                samples: 198,
                ..StreamCounts::default()
            };
            let after = state(Condition::Streaming, begun);
            let finding = found(lines, &after, &[tracked(1, 99), tracked(2, 99)]);
            assert!(finding.advice.is_empty(), "{finding}");
            let said = finding.to_string();
            assert!(said.contains("0 lost"), "{said}");
            assert!(said.contains(", 2 first after a silence"), "{said}");
            assert_eq!(finding.json()[0]["alone"], 2);
        }
    }

    #[test]
    fn a_glove_that_is_not_permitted_comes_with_its_udev_rule() {
        let denied = HidError::Denied {
            path: "/dev/hidraw3".into(),
            rule: udev_rule(0x5D70, 0x0010),
        };
        let text =
            "name = 'g'\n[camera]\n[devices.it]\nkind = 'data-glove'\nhand = 'left'\nsensors = 5\n";
        let rig = Rig::parse(text, "g").expect("a rig");
        let counts = StreamCounts::default();
        let after = state(Condition::Waiting(denied.to_string()), counts);
        let before = state(Condition::Starting, counts);
        let mut finding = Finding::default();
        report(&mut finding, &rig.devices["it"], &before, &after, &[]);
        assert!(finding.to_string().contains(&udev_rule(0x5D70, 0x0010)));
        assert!(finding.advice[0].contains("/dev/hidraw3"), "{finding}");
        assert!(
            finding.advice[0].contains("70-sandtable.rules"),
            "{finding}"
        );
    }
}
