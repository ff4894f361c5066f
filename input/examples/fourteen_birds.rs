//! A bench: fourteen birds at 103 records a second each over a pseudo-terminal, through the real
//! driver into the hub. It counts what is lost, and measures how long a record takes from the line
//! into the hub and how much of a processor the driver needs.
//!
//! ```text
//! cargo run --release -p sandtable-input --example fourteen_birds -- [SECONDS]
//! ```
//!
//! Without SECONDS, ten minutes. Exits with 1 where a record was lost, the 99th percentile is 2 ms
//! or more, or the driver takes 5 % or more of a core.

#[cfg(target_os = "linux")]
fn main() -> std::process::ExitCode {
    linux::main()
}

#[cfg(not(target_os = "linux"))]
fn main() {
    eprintln!("threads are measured through Linux's /proc; there is none here");
}

#[cfg(target_os = "linux")]
mod linux {
    use glam::{DQuat, DVec3};
    use sandtable_config::{Device, Rig, SensorName};
    use sandtable_input::flock::{Record, Scale, layout, startup};
    use sandtable_input::{Clock, Devices, Hub};
    use sandtable_pose::{Nanos, Rigid};
    use serialport::{SerialPort, TTYPort};
    use std::io::{Read, Write};
    use std::path::Path;
    use std::process::ExitCode;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
    use std::time::{Duration, Instant};

    const BIRDS: u32 = 14;
    const RATE: f64 = 103.0;

    /// A line that carries a record in no time: the bench is of this program, not of 115200 baud.
    const BAUD: u32 = 1 << 30;

    pub(super) fn main() -> ExitCode {
        let seconds = std::env::args().nth(1);
        let seconds = seconds.map_or(600.0, |text| text.parse().expect("SECONDS is a number"));
        let (mut host, device) = TTYPort::pair().expect("a pseudo-terminal");
        let port = device.name().expect("it has a path");
        let rig = rig(Path::new(&port));
        let hub = Arc::new(Hub::for_rig(&rig));
        let clock = Clock::start();
        let devices = Devices::start(&rig, &hub, clock, None).expect("threads");
        answer_startup(&mut host, &rig);

        // When each cycle was written, by its number; the first position word carries the number.
        let cycles = (seconds * RATE) as u64;
        let written: Arc<Vec<AtomicU64>> =
            Arc::new((0..cycles).map(|_| AtomicU64::new(0)).collect());
        let done = Arc::new(AtomicBool::new(false));
        let writer = {
            let (written, done, rig) = (Arc::clone(&written), Arc::clone(&done), rig.clone());
            std::thread::Builder::new()
                .name("line".into())
                .spawn(move || {
                    write(&mut host, &rig, clock, &written);
                    done.store(true, Ordering::Release);
                    // Open until the driver has read all.
                    std::thread::sleep(Duration::from_millis(500));
                })
                .expect("a thread")
        };
        let processor = driver_time();
        let start = Instant::now();
        let mut latencies = Vec::with_capacity((cycles * u64::from(BIRDS)) as usize);
        let mut seen = vec![Nanos(0); BIRDS as usize];
        let mut last_round = false;
        while !last_round {
            last_round = done.load(Ordering::Acquire);
            if last_round {
                std::thread::sleep(Duration::from_millis(300));
            }
            for (number, seen) in (1..=BIRDS).zip(&mut seen) {
                drain(
                    &hub,
                    number,
                    clock.now(),
                    seen,
                    &rig,
                    &written,
                    &mut latencies,
                );
            }
            std::thread::sleep(Duration::from_millis(200));
        }
        let lasted = start.elapsed();
        let used = driver_time() - processor;
        let counts = devices.states().remove(0).counts;
        devices.stop();
        writer.join().expect("the line ended well");
        drop(device);
        report(latencies, cycles, &counts, used, lasted)
    }

    fn report(
        mut latencies: Vec<f64>,
        cycles: u64,
        counts: &sandtable_input::StreamCounts,
        used: Duration,
        lasted: Duration,
    ) -> ExitCode {
        latencies.sort_by(f64::total_cmp);
        let at = |share: f64| latencies[((latencies.len() - 1) as f64 * share) as usize];
        // The gate lets a bird's first record wait for its second.
        let expected = (cycles - 1) * u64::from(BIRDS);
        let lost = expected.saturating_sub(counts.samples);
        let share = 100.0 * used.as_secs_f64() / lasted.as_secs_f64();
        println!(
            "{BIRDS} birds, {cycles} cycles in {:.0} s",
            lasted.as_secs_f64()
        );
        println!(
            "records {}, samples {}, lost {lost}",
            counts.records, counts.samples
        );
        println!(
            "line to hub: median {:.3} ms, p99 {:.3} ms, p99.9 {:.3} ms, longest {:.3} ms",
            at(0.5),
            at(0.99),
            at(0.999),
            at(1.0)
        );
        println!("driver: {share:.2} % of a core");
        let good = lost == 0 && at(0.99) < 2.0 && share < 5.0;
        if good {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        }
    }

    /// A workbench with fourteen birds and nothing that wears them.
    fn rig(port: &Path) -> Rig {
        let text = Rig::builtin_text("workbench").expect("built in");
        let text = text.replace("birds = 2", "birds = 14");
        let mut rig = Rig::parse(&text, "the bench's rig").expect("sound");
        rig.set_port("flock", port).expect("a path");
        if let Some(Device::Flock(flock)) = rig.devices.get_mut("flock") {
            flock.baud = BAUD;
            flock.reset_with_rts = false;
        }
        rig
    }

    /// Reads the driver's commands until it asks for the status, and answers.
    fn answer_startup(host: &mut TTYPort, rig: &Rig) {
        let Device::Flock(flock) = &rig.devices["flock"] else {
            panic!("the workbench has a Flock");
        };
        assert!(startup(flock).iter().any(|step| step.what == "stream"));
        host.set_timeout(Duration::from_secs(10))
            .expect("a timeout");
        let mut heard = Vec::new();
        let mut byte = [0];
        while !heard.ends_with(&[b'O', 36]) {
            host.read_exact(&mut byte)
                .expect("the driver starts its Flock");
            heard.push(byte[0]);
        }
        host.write_all(&[0xE0; 14]).expect("room");
        while byte[0] != b'@' {
            host.read_exact(&mut byte)
                .expect("the driver starts a stream");
        }
    }

    /// Writes cycle after cycle at their times.
    fn write(host: &mut TTYPort, rig: &Rig, clock: Clock, written: &[AtomicU64]) {
        let Device::Flock(flock) = &rig.devices["flock"] else {
            panic!("the workbench has a Flock");
        };
        let (layout, scale) = (layout(flock), Scale::of(flock));
        let start = Instant::now();
        let mut bytes = Vec::new();
        for (number, time) in written.iter().enumerate() {
            bytes.clear();
            for bird in 1..=BIRDS {
                let words = scale.words(&Rigid::new(DQuat::IDENTITY, place(number)));
                let record = Record {
                    bird,
                    words,
                    buttons: None,
                };
                layout.encode(&record, &mut bytes);
            }
            let due = Duration::from_secs_f64(number as f64 / RATE);
            std::thread::sleep(due.saturating_sub(start.elapsed()));
            time.store(clock.now().0, Ordering::Release);
            host.write_all(&bytes).expect("the driver reads");
        }
    }

    /// Where all birds are in a cycle: a slow sway whose phase tells the cycle within a minute.
    fn place(cycle: usize) -> DVec3 {
        let step = (cycle % 4096) as f64;
        // Up and down again, so that no step is a jump.
        let up = if step < 2048.0 { step } else { 4096.0 - step };
        DVec3::new(
            up * STEP,
            if step < 2048.0 { 0.1 } else { 0.1 + STEP },
            -0.3,
        )
    }

    /// A metre a second would be 44 of these a cycle.
    const STEP: f64 = 72.0 * 0.0254 * 4.0 / 32768.0;

    /// Takes in all poses of a bird since `seen`, and how long each was on its way.
    fn drain(
        hub: &Hub,
        number: u32,
        now: Nanos,
        seen: &mut Nanos,
        rig: &Rig,
        written: &[AtomicU64],
        latencies: &mut Vec<f64>,
    ) {
        let Device::Flock(flock) = &rig.devices["flock"] else {
            panic!("the workbench has a Flock");
        };
        let sensor = SensorName {
            device: "flock".into(),
            number,
        };
        let newest = hub.pose_at(&sensor, now).map(|pose| pose.time);
        let mut time = now;
        while let Some(pose) = hub.pose_at(&sensor, time).filter(|pose| pose.time > *seen) {
            time = pose.time - Duration::from_nanos(1);
            let place = flock
                .table_from_tracker
                .inverse()
                .point(pose.frame_from_body.translation);
            let up = (place.x / STEP).round() as usize;
            let phase = if place.y < 0.1 + 0.5 * STEP {
                up
            } else {
                4096 - up
            };
            // The cycle of this phase that was written last before the pose came.
            let around = (pose.time.0 as f64 * 1e-9 * RATE) as usize;
            let turns = (around + 4096).saturating_sub(phase) / 4096;
            let sent = (0..=turns)
                .rev()
                .filter_map(|turn| written.get(turn * 4096 + phase))
                .map(|sent| sent.load(Ordering::Acquire))
                .find(|&sent| sent != 0 && sent <= pose.time.0);
            if let Some(sent) = sent {
                latencies.push((pose.time.0 - sent) as f64 * 1e-6);
            }
        }
        if let Some(newest) = newest {
            *seen = newest;
        }
    }

    /// The processor time that the driver's thread has used.
    fn driver_time() -> Duration {
        let tasks = std::fs::read_dir("/proc/self/task").expect("Linux lists threads");
        tasks
            .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok())
            .find_map(|stat| {
                let (name, rest) = stat.split_once(") ")?;
                let fields: Vec<_> = rest.split(' ').collect();
                let ticks: u64 = fields
                    .get(11..13)?
                    .iter()
                    .filter_map(|f| f.parse::<u64>().ok())
                    .sum();
                // A hundred ticks a second, as everywhere.
                name.ends_with("(device flock")
                    .then(|| Duration::from_millis(10 * ticks))
            })
            .unwrap_or_default()
    }
}
