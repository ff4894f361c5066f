//! The Flock of Birds: its records, and the simulated one's commands.

use sandtable_config::{Confirm, Device, Flock, RecordFormat, Rig};
use sandtable_input::flock::{FlockStream, SimulatedFlock, SimulatorSettings, layout};
use sandtable_input::{Sample, Stream};
use sandtable_pose::Nanos;
use std::sync::LazyLock;
use std::time::Duration;

/// Flocks of every format, alone and in a group, plain and with all that a record can bring.
static FLOCKS: LazyLock<Vec<Flock>> = LazyLock::new(|| {
    let rig = Rig::builtin("workbench").expect("built in");
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    let of = |format, birds, more: bool| Flock {
        format,
        birds,
        group: birds > 1,
        buttons: more,
        confirm: if more {
            Confirm::NextMark
        } else {
            Confirm::Immediate
        },
        ..flock.clone()
    };
    let formats = RecordFormat::ALL.into_iter();
    formats
        .flat_map(|format| [1, 4].map(|birds| [false, true].map(|more| of(format, birds, more))))
        .flatten()
        .collect()
});

/// The Flock's stream: the first byte chooses what records look like, the second how the bytes are
/// cut into reads.
///
/// # Panics
/// Where a pose comes out that is none, from fewer bytes than a record has, or before its time.
pub fn flock(data: &[u8]) {
    let [kind, cut, bytes @ ..] = data else {
        return;
    };
    let flock = &FLOCKS[usize::from(*kind) % FLOCKS.len()];
    let length = layout(flock).record_length();
    let mut stream = FlockStream::new(flock);
    let mut newest = [Nanos(0); 4];
    let mut poses = 0;
    for (read, bytes) in (1..).zip(bytes.chunks(1 + usize::from(*cut))) {
        let arrival = Nanos(read * 20_000_000);
        stream.push(bytes, arrival, &mut |sample| {
            let time = sample.time();
            assert!(time <= arrival, "{sample:?} comes from the future");
            if let Sample::Pose(pose) = sample {
                let rigid = pose.table_from_sensor;
                assert!(rigid.translation.is_finite() && rigid.rotation.is_normalized());
                let newest = &mut newest[pose.sensor as usize - 1];
                assert!(time > *newest, "{sample:?} goes back in time");
                *newest = time;
                poses += 1;
            }
        });
    }
    assert!(
        poses * length <= bytes.len(),
        "{poses} poses of {} bytes",
        bytes.len()
    );
    let counts = stream.counts();
    let whole = (counts.records + counts.foreign_records) as usize * length;
    assert!(whole + counts.stray_bytes as usize <= bytes.len());
}

/// The simulated Flock, which reads what any host sends.
///
/// # Panics
/// Where it sends more than its line can carry.
pub fn flock_simulator(data: &[u8]) {
    let mut flock = SimulatedFlock::new(SimulatorSettings::default());
    let mut sent = 0;
    let mut now = Duration::ZERO;
    for bytes in data.chunks(3) {
        now += Duration::from_millis(7);
        flock.receive(bytes, now);
        sent += flock.send(now).len();
    }
    // 115200 baud are 11.52 bytes a millisecond.
    assert!(
        sent as f64 <= 11.52 * now.as_secs_f64() * 1e3 + 1.0,
        "{sent} bytes by {now:?}"
    );
}
