//! The devices of a rig: whether each one speaks, how fast, how evenly, and what is lost.

use super::finding::{Finding, Item};
use sandtable_config::{Rig, SensorName};
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
        let sensors: Vec<_> = hub
            .sensors()
            .filter(|sensor| sensor.device == after.name)
            .map(|sensor| Pace::of(&hub, sensor, from))
            .collect();
        report(&mut finding, before, after, &sensors);
    }
    devices.stop();
    Ok(finding)
}

/// How a sensor's poses came in.
struct Pace {
    number: u32,
    poses: usize,
    /// Poses a second, and the standard deviation of the time from one to the next; known from
    /// three poses on.
    rate_and_jitter: Option<(f64, Duration)>,
}

impl Pace {
    fn of(hub: &Hub, sensor: SensorName, from: Nanos) -> Self {
        let times: Vec<_> = hub
            .poses_since(&sensor, from)
            .iter()
            .map(|pose| pose.time)
            .collect();
        Self {
            number: sensor.number,
            poses: times.len(),
            rate_and_jitter: pace(&times),
        }
    }

    fn json(&self) -> Value {
        let (rate, jitter) = self.rate_and_jitter.unzip();
        json!({
            "number": self.number,
            "poses": self.poses,
            "rate_hz": rate,
            "jitter_ms": jitter.map(|jitter| 1e3 * jitter.as_secs_f64()),
        })
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

fn report(finding: &mut Finding, before: &DeviceState, after: &DeviceState, sensors: &[Pace]) {
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
            detail += &match sensor.rate_and_jitter {
                Some((rate, jitter)) => format!(
                    "\n    sensor {}: {rate:.1} poses a second, ± {:.2} ms",
                    sensor.number,
                    1e3 * jitter.as_secs_f64()
                ),
                None => format!("\n    sensor {}: {} poses", sensor.number, sensor.poses),
            };
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
            "sensors": sensors.iter().map(Pace::json).collect::<Vec<_>>(),
        }),
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_and_jitter_are_those_of_the_intervals() {
        let times = [0, 10, 20, 32, 40].map(|ms| Nanos(ms * 1_000_000));
        let (rate, jitter) = pace(&times).expect("there are enough");
        assert!((rate - 100.0).abs() < 1e-9);
        // 0, 0, 2 and −2 ms off.
        assert!((jitter.as_secs_f64() - 2e-3 / f64::sqrt(2.0)).abs() < 1e-9);
        assert_eq!(pace(&times[..2]), None);
    }
}
