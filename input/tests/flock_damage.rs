//! What damaged bytes of a Flock can do: at every place of every format, alone and in a group.
//!
//! `cargo test -p sandtable-input --test flock_damage -- --nocapture` prints the shares that
//! docs/flock.md states.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use glam::{DQuat, DVec3, EulerRot};
use sandtable_config::{Confirm, Device, Flock, RecordFormat, Rig};
use sandtable_input::flock::{FlockStream, Record, Scale, layout};
use sandtable_input::{PoseSample, Stream};
use sandtable_pose::{Nanos, Rigid};

/// Cycles of the measuring rate that a stream has, and the one that is damaged.
const CYCLES: u32 = 12;
const DAMAGED: u32 = 6;

/// The workbench's Flock, in another format.
fn flock(format: RecordFormat, birds: u32, confirm: Confirm) -> Flock {
    let rig = Rig::builtin("workbench").unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    Flock {
        format,
        birds,
        group: birds > 1,
        confirm,
        ..flock.clone()
    }
}

/// Where a bird is: on its way at a hand's pace, and turning.
fn path(bird: u32, cycle: u32) -> Rigid {
    let t = f64::from(cycle) * 0.00968;
    let turn = DQuat::from_euler(
        EulerRot::ZYX,
        0.4 * t + f64::from(bird),
        0.3 + 0.2 * t,
        -0.8,
    );
    let place = DVec3::new(0.3 * (t + 0.4).sin(), 0.1 * f64::from(bird), -0.5 + 0.1 * t);
    Rigid::new(turn, place)
}

/// The bytes of each cycle.
fn sent(flock: &Flock) -> Vec<Vec<u8>> {
    let (layout, scale) = (layout(flock), Scale::of(flock));
    let cycle = |cycle| {
        let mut bytes = Vec::new();
        for bird in 1..=flock.birds {
            let record = Record {
                bird,
                words: scale.words(&path(bird, cycle)),
                buttons: None,
            };
            layout.encode(&record, &mut bytes);
        }
        bytes
    };
    (0..CYCLES).map(cycle).collect()
}

/// The poses that come of the cycles with one of them replaced.
fn poses(flock: &Flock, cycles: &[Vec<u8>], damaged: &[u8]) -> Vec<PoseSample> {
    let mut stream = FlockStream::new(flock);
    let mut poses = Vec::new();
    for (number, cycle) in (0..).zip(cycles) {
        let bytes = if number == DAMAGED { damaged } else { cycle };
        let arrival = Nanos(u64::from(number) * 9_680_000 + 5_000_000);
        stream.push(bytes, arrival, &mut |sample| poses.extend(sample.pose()));
    }
    poses
}

/// How far a pose is from the nearest of those sent, as far as the format tells: in metres, and
/// in radians there.
fn off(flock: &Flock, sample: &PoseSample) -> [f64; 2] {
    let scale = Scale::of(flock);
    (0..CYCLES)
        .map(|cycle| {
            // Through the words, so that what the line cuts off, and what it does not carry, is
            // no error.
            let words = scale.words(&path(sample.sensor, cycle));
            let sent = flock.table_from_tracker * scale.pose(&words).unwrap();
            let found = sample.table_from_sensor;
            [
                (sent.translation - found.translation).length(),
                sent.rotation.angle_between(found.rotation),
            ]
        })
        .min_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1])))
        .unwrap()
}

fn is_wrong(flock: &Flock, sample: &PoseSample) -> bool {
    let [metres, radians] = off(flock, sample);
    metres > 1e-6 || radians > 1e-6
}

/// Every format, alone and in groups.
fn flocks(confirm: Confirm) -> impl Iterator<Item = Flock> {
    let formats = RecordFormat::ALL.into_iter();
    formats.flat_map(move |format| [1, 2, 4].map(|birds| flock(format, birds, confirm)))
}

#[test]
fn a_lost_byte_or_a_turned_phase_bit_costs_two_records_and_makes_no_wrong_pose() {
    for confirm in [Confirm::Immediate, Confirm::NextMark] {
        for flock in flocks(confirm) {
            let cycles = sent(&flock);
            let whole = poses(&flock, &cycles, &cycles[DAMAGED as usize]).len();
            for place in 0..cycles[0].len() {
                let mut lost = cycles[DAMAGED as usize].clone();
                lost.remove(place);
                let mut turned = cycles[DAMAGED as usize].clone();
                turned[place] ^= 0x80;
                for damaged in [lost, turned] {
                    let poses = poses(&flock, &cycles, &damaged);
                    assert!(
                        poses.len() + 2 >= whole,
                        "{:?}, {} birds, byte {place}: {} of {whole}",
                        flock.format,
                        flock.birds,
                        poses.len()
                    );
                    for pose in poses {
                        assert!(!is_wrong(&flock, &pose), "{:?}, byte {place}", flock.format);
                    }
                }
            }
        }
    }
}

#[test]
fn no_doubled_byte_makes_a_wrong_pose_of_a_confirmed_record() {
    for flock in flocks(Confirm::NextMark) {
        let cycles = sent(&flock);
        for place in 0..cycles[0].len() {
            let mut doubled = cycles[DAMAGED as usize].clone();
            doubled.insert(place, doubled[place]);
            for pose in poses(&flock, &cycles, &doubled) {
                assert!(!is_wrong(&flock, &pose), "{:?}, byte {place}", flock.format);
            }
        }
    }
}

#[test]
fn garbage_before_the_first_record_makes_no_pose() {
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 24) as u8
    };
    for flock in flocks(Confirm::NextMark) {
        let cycles = sent(&flock);
        for _ in 0..200 {
            let mut stream = FlockStream::new(&flock);
            let length = random() % 60;
            let garbage: Vec<u8> = (0..length).map(|_| random() & 0x7F).collect();
            let mut found = Vec::new();
            for (number, bytes) in (0..).zip([&garbage].into_iter().chain(&cycles)) {
                let arrival = Nanos(number * 9_680_000 + 5_000_000);
                stream.push(bytes, arrival, &mut |sample| {
                    found.extend(sample.pose().copied())
                });
            }
            assert!(found.len() >= 9 * flock.birds as usize);
            assert!(found.iter().all(|pose| !is_wrong(&flock, pose)));
        }
    }
}

/// What became of damages: how many there were, and how many let a wrong pose out.
#[derive(Default)]
struct Share {
    damages: u32,
    passed: u32,
    worst: [f64; 2],
}

impl Share {
    fn add(&mut self, flock: &Flock, cycles: &[Vec<u8>], damaged: &[u8]) {
        self.damages += 1;
        let mut passed = false;
        for pose in poses(flock, cycles, damaged) {
            let [metres, radians] = off(flock, &pose);
            passed |= metres > 1e-3 || radians > 2e-3;
            self.worst = [self.worst[0].max(metres), self.worst[1].max(radians)];
        }
        self.passed += u32::from(passed);
    }

    fn percent(&self) -> f64 {
        100.0 * f64::from(self.passed) / f64::from(self.damages)
    }
}

#[test]
fn what_cannot_be_seen_is_held_to_what_a_hand_could_do() {
    println!("| format | birds | doubled bytes | altered bits | worst mm | worst degrees |");
    println!("| --- | ---: | ---: | ---: | ---: | ---: |");
    for format in RecordFormat::ALL {
        for birds in [1, 2] {
            let flock = flock(format, birds, Confirm::Immediate);
            let cycles = sent(&flock);
            let (mut doubled, mut altered) = (Share::default(), Share::default());
            for place in 0..cycles[0].len() {
                let mut damaged = cycles[DAMAGED as usize].clone();
                damaged.insert(place, damaged[place]);
                doubled.add(&flock, &cycles, &damaged);
                for bit in 0..7 {
                    let mut damaged = cycles[DAMAGED as usize].clone();
                    damaged[place] ^= 1 << bit;
                    altered.add(&flock, &cycles, &damaged);
                }
            }
            let worst = [0, 1].map(|k| doubled.worst[k].max(altered.worst[k]));
            println!(
                "| {format:?} | {birds} | {:.0} % | {:.0} % | {:.0} | {:.1} |",
                doubled.percent(),
                altered.percent(),
                1e3 * worst[0],
                worst[1].to_degrees(),
            );
            // 5 m/s and 1000 degrees a second over a cycle, and what the bird itself went.
            assert!(worst[0] < 0.06 && worst[1] < 11f64.to_radians());
            assert!(doubled.percent() <= 30.0 && altered.percent() <= 60.0);
        }
    }
}
