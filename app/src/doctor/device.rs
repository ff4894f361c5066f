//! The devices of a rig: whether each one speaks, how fast, how evenly, and what is lost.

use super::finding::{Finding, Item};
use sandtable_config::{Device, Rig, SensorName};
use sandtable_input::{Clock, Condition, DeviceState, Devices, Hub, StreamCounts};
use sandtable_pose::Nanos;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A Flock's start-up is the longest, and takes up to 7 s.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long each device is listened to.
const LISTENING: Duration = Duration::from_secs(2);

pub(super) fn examine(rig: &Rig) -> Result<Finding, String> {
    let hub = Arc::new(Hub::for_rig(rig));
    let clock = Clock::start();
    let devices = Devices::start(rig, &hub, clock, None).map_err(|error| error.to_string())?;
    let start = Instant::now();
    let is_waited_for = |state: &DeviceState| state.condition == Condition::Starting;
    // One that is not there says so at once, and may yet come.
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
        report(&mut finding, before, after, &sensors);
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

/// Records that were lost or not believed.
fn lost(counts: &StreamCounts) -> u64 {
    counts.cut_records
        + counts.overlong_records
        + counts.foreign_records
        + counts.implausible
        + counts.refused
}

fn report(finding: &mut Finding, before: &DeviceState, after: &DeviceState, sensors: &[Heard]) {
    let records = after.counts.records - before.counts.records;
    let lost = lost(&after.counts) - lost(&before.counts);
    let stray = after.counts.stray_bytes - before.counts.stray_bytes;
    let condition = match &after.condition {
        Condition::Starting => "starting",
        Condition::Streaming => "streaming",
        Condition::Waiting(_) => "waiting",
    };
    let mut detail = condition.to_owned();
    if let Condition::Waiting(reason) = &after.condition {
        finding.advise(format!("{}: {reason}.", after.name));
    } else {
        detail += &format!(", {records} records in 2 s, {lost} lost, {stray} stray bytes");
        for sensor in sensors {
            detail += &format!("\n    {}", sensor.in_words());
        }
        if lost > 0 {
            finding.advise(format!(
                "{}: bytes are lost or altered on its line; check the cable, its length and its \
                 shield, and keep it away from screens and motors.",
                after.name
            ));
        }
    }
    finding.found(Item::new(
        &after.name,
        detail,
        json!({
            "condition": condition,
            "records": records,
            "lost": lost,
            "stray_bytes": stray,
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

    #[test]
    fn a_glove_that_is_not_permitted_comes_with_its_udev_rule() {
        let denied = HidError::Denied {
            path: "/dev/hidraw3".into(),
            rule: udev_rule(0x5D70, 0x0010),
        };
        let state = |condition| DeviceState {
            name: "glove".into(),
            condition,
            counts: StreamCounts::default(),
        };
        let after = state(Condition::Waiting(denied.to_string()));
        let mut finding = Finding::default();
        report(&mut finding, &state(Condition::Starting), &after, &[]);
        assert!(finding.to_string().contains(&udev_rule(0x5D70, 0x0010)));
        assert!(finding.advice[0].contains("/dev/hidraw3"), "{finding}");
        assert!(
            finding.advice[0].contains("70-sandtable.rules"),
            "{finding}"
        );
    }
}
