//! Decoders under seeded inputs: random bytes, and what a device sends with some of it altered.
//!
//! `SANDTABLE_INPUTS=10000000 cargo test --release -p sandtable-tests --test seeded_decoders` is the
//! long run; without it there are enough to notice a decoder that has come to panic.

use glam::{DQuat, DVec3};
use sandtable_config::{Device, Rig};
use sandtable_input::data_glove::{self, SimulatedDataGlove};
use sandtable_input::flock::{SimulatedFlock, SimulatorSettings};
use sandtable_input::pinch::{self, SimulatedPinch};
use sandtable_input::vrpn::{BigEndian, COOKIE, Connection, Report, Stamp, TrackerPose};
use sandtable_input::{Recorder, SimulatedDevice};
use sandtable_pose::Nanos;
use sandtable_tests::decoders::{DECODERS, Decoder};
use std::time::{Duration, Instant};

/// Inputs for each decoder, without the variable.
const INPUTS: u64 = 300_000;

/// No input of a few hundred bytes may take longer, on the slowest machine.
const PATIENCE: Duration = Duration::from_secs(5);

/// A generator that gives the same numbers for the same seed for ever (Marsaglia 2003).
struct Xorshift(u64);

impl Xorshift {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }
}

/// What a started Flock of two sends in some tenths of a second.
fn flock_bytes() -> Vec<u8> {
    let mut flock = SimulatedFlock::new(SimulatorSettings::default());
    let ms = Duration::from_millis;
    flock.receive(&[0x50, 0x32, 2], ms(0));
    flock.receive(&[0x50, 0x23, 1, 0xF1, 0x5D, 0xF2, 0x5D, b'@'], ms(400));
    flock.send(ms(700))
}

/// What a host sends to start one.
fn host_bytes() -> Vec<u8> {
    let mut bytes = b"B".to_vec();
    bytes.extend([
        0x50, 0x32, 2, 0x50, 0x23, 1, 0xF1, 0x5D, 0xF1, 0x4C, 0x0C, 1, 0x4F, 0x24, 0x40,
    ]);
    bytes
}

/// What a PINCH box answers and tells in half a minute, without timestamps and then with them.
fn pinch_bytes() -> Vec<u8> {
    let mut gloves = SimulatedPinch::new(pinch::SimulatorSettings::default());
    let second = Duration::from_secs(1);
    gloves.receive(b"T0CTCLCR", second);
    let mut bytes = gloves.send(15 * second);
    gloves.receive(b"T1", 15 * second);
    bytes.extend(gloves.send(30 * second));
    bytes
}

/// A second of a 5DT glove of 14 sensors at work.
fn data_glove_bytes() -> Vec<u8> {
    let text = "name = 'd'\n[camera]\n[devices.glove]\nkind = 'data-glove'\nhand = 'left'\n\
                sensors = 14\n";
    let rig = Rig::parse(text, "d").expect("a rig");
    let Device::DataGlove(described) = &rig.devices["glove"] else {
        panic!("it is a data glove");
    };
    let settings = data_glove::SimulatorSettings::default();
    let glove = SimulatedDataGlove::new(described, settings);
    // The second in which it closes.
    (75..150).flat_map(|number| glove.report(number)).collect()
}

/// Reports of nine bytes with the id 7.
fn hid_glove_bytes() -> Vec<u8> {
    let report = |n: u8| [7, n, n ^ 0x5A, 0, 0, n, n, 0xFF - n, n % 4];
    (0..=255).flat_map(report).collect()
}

/// What a VRPN server says of a tracker, buttons and channels, without its descriptions. Some of it
/// is no pose and no number.
fn vrpn_messages() -> Real {
    let mut server = Connection::new(["T", "B", "Other"]);
    server.receive(&COOKIE).expect("a cookie");
    server.sent(server.outgoing().len());
    let mut starts = Vec::new();
    for step in 0..40 {
        let bent = f64::from(step) / 40.0;
        let odd = [f64::NAN, f64::INFINITY, 1e300][step as usize % 3];
        let pose = TrackerPose {
            sensor: step % 3,
            position: DVec3::new(0.1 * bent, if step % 10 == 9 { odd } else { 0.2 }, 0.3),
            rotation: DQuat::from_rotation_z(bent) * if step % 10 == 4 { odd } else { 1.0 },
        };
        let last = if step % 5 == 2 { odd } else { -bent };
        let channels = [bent, 0.5, 1.0 - bent, bent, last].map(f64::to_be_bytes);
        let states = [step & 1, step >> 1 & 1, 0].map(i32::to_be_bytes);
        let change = Report::ButtonChange {
            button: step % 5,
            state: step & 1,
        };
        for (sender, report) in [
            (0, Report::Pose(pose)),
            (0, Report::Channels(BigEndian(&channels))),
            (1, Report::ButtonStates(BigEndian(&states))),
            (1, change),
            (2, Report::Pong),
        ] {
            starts.push(server.outgoing().len());
            let stamp = Stamp::default();
            server.report(sender, stamp, &report).expect("room");
        }
    }
    Real {
        starts,
        ..Real::new(server.outgoing().to_vec())
    }
}

/// Frames of a DTrack controller, each with a zero behind it. Some numbers are none.
fn dtrack_frames() -> Real {
    let unit = "[1 0 0 0 1 0 0 0 1]";
    let frame = |n: usize| {
        let odd = |every: usize| match n % every {
            1 => ["nan", "inf", "1e999", "-"][n % 4],
            _ => "0.5",
        };
        let (x, axis) = (odd(5), odd(3));
        format!(
            "fr {n}\r\n6d 2 [0 1.000][{x} -187.2 109.5 0 0 0]{unit} [1 0.9][1 2 {n} 0 0 0]{unit}\r\n\
             6df2 1 1 [0 1.000 6 2][1000 2000 -{n}]{unit}[{} -0.50 {axis}]\r\n\0",
            n % 64
        )
    };
    let mut bytes = Vec::new();
    let mut starts = Vec::new();
    for n in 1..40 {
        starts.push(bytes.len());
        bytes.extend(frame(n).into_bytes());
    }
    Real {
        starts,
        ..Real::new(bytes)
    }
}

/// A recording of a Flock and PINCH gloves, in front of it what says that it is the file itself.
fn recording_bytes() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("real.mcap");
    let rig = Rig::builtin_text("workbench").expect("built in").to_owned()
        + "\n[devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n";
    let rig = Rig::parse(&rig, "r").expect("a rig");
    let recorder = Recorder::create(&path, &rig, None, Nanos(0)).expect("a file");
    for (device, bytes) in [("flock", flock_bytes()), ("pinch", pinch_bytes())] {
        for (read, bytes) in (1..).zip(bytes.chunks(30)) {
            recorder.bytes(device, Nanos(10_000_000 * read), bytes);
        }
    }
    recorder.finish().expect("it is written");
    let mut bytes = vec![0];
    bytes.extend(std::fs::read(&path).expect("it is there"));
    bytes
}

/// Messages of a recording: topic, step, length, and so many bytes.
fn recorded_messages() -> Vec<u8> {
    let mut bytes = Vec::new();
    let devices = [
        flock_bytes(),
        pinch_bytes(),
        data_glove_bytes(),
        hid_glove_bytes(),
    ];
    let devices = devices
        .into_iter()
        .chain([vrpn_messages().bytes, dtrack_frames().bytes]);
    for (topic, device) in (0..).zip(devices) {
        for read in device.chunks(64).take(8) {
            bytes.extend([topic, 2, read.len() as u8]);
            bytes.extend(read);
        }
    }
    for text in [
        &b"{\"event\":\"started\"}"[..],
        b"{\"event\":\"calibration-reset\"}",
    ] {
        bytes.extend([6, 2, text.len() as u8]);
        bytes.extend(text);
    }
    bytes
}

/// What a decoder is fed with, altered here and there.
struct Real {
    bytes: Vec<u8>,
    /// Where inputs begin.
    starts: Vec<usize>,
    /// The most of it in one input.
    longest: usize,
    /// Two bytes of the input's own come first, by which the decoder chooses.
    choice: bool,
}

impl Real {
    fn new(bytes: Vec<u8>) -> Self {
        Self {
            starts: (0..bytes.len()).collect(),
            bytes,
            longest: 300,
            choice: true,
        }
    }

    /// An input: the seed's own bytes, or real ones cut out, altered, doubled and lost here and
    /// there.
    fn input(&self, random: &mut Xorshift) -> Vec<u8> {
        let length = random.below(self.longest);
        if random.below(4) == 0 {
            return (0..length.min(300)).map(|_| random.next() as u8).collect();
        }
        let from = self.starts[random.below(self.starts.len())];
        let mut bytes = Vec::new();
        if self.choice {
            bytes.extend([random.next() as u8, random.next() as u8]);
        }
        bytes.extend(self.bytes[from..].iter().take(length));
        for _ in 0..random.below(8) {
            if bytes.is_empty() {
                break;
            }
            let place = random.below(bytes.len());
            match random.below(4) {
                0 => bytes[place] ^= 1 << random.below(8),
                1 => bytes.insert(place, random.next() as u8),
                2 => {
                    bytes.remove(place);
                }
                _ => bytes.truncate(place),
            }
        }
        bytes
    }
}

fn run(name: &str, decoder: Decoder, real: &Real, inputs: u64) {
    // Each decoder has a seed of its own that does not change when another is added.
    let seed = name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let mut random = Xorshift(seed);
    let begin = Instant::now();
    for number in 0..inputs {
        let bytes = real.input(&mut random);
        let start = Instant::now();
        let result = std::panic::catch_unwind(|| decoder(&bytes));
        assert!(result.is_ok(), "{name}, input {number}: {bytes:02X?}");
        assert!(
            start.elapsed() < PATIENCE,
            "{name}, input {number}: {bytes:02X?}"
        );
    }
    println!("{name}: {inputs} inputs in {:.1?}", begin.elapsed());
}

/// Real reports of one length, which inputs begin with.
fn reports(bytes: Vec<u8>, length: usize) -> Real {
    Real {
        starts: (0..bytes.len()).step_by(length).collect(),
        ..Real::new(bytes)
    }
}

/// A file as it lies there, of which inputs are all but its end, and messages for one.
fn recordings() -> Vec<Real> {
    let file = recording_bytes();
    let messages = recorded_messages();
    vec![
        Real {
            starts: vec![0],
            longest: 2 * file.len(),
            choice: false,
            bytes: file,
        },
        Real {
            longest: messages.len(),
            ..Real::new(messages)
        },
    ]
}

#[test]
fn no_input_makes_a_decoder_panic_or_hang() {
    let inputs = std::env::var("SANDTABLE_INPUTS");
    let inputs = inputs.map_or(INPUTS, |text| text.parse().expect("a number of inputs"));
    for (name, decoder) in DECODERS {
        let (real, share) = match name {
            "flock" => (vec![Real::new(flock_bytes())], 1),
            "flock_simulator" => (vec![Real::new(host_bytes())], 1),
            "pinch" => (vec![Real::new(pinch_bytes())], 1),
            "data_glove" => (vec![reports(data_glove_bytes(), 64)], 1),
            "hid_glove" => (vec![reports(hid_glove_bytes(), 9)], 1),
            "vrpn" => (vec![vrpn_messages()], 1),
            "dtrack" => (vec![dtrack_frames()], 1),
            // A file has to be written for each.
            "recording" => (recordings(), 20),
            // A whole text takes a thousand times as long as a record.
            "rig" => {
                let text = Rig::builtin_text("workbench").expect("built in");
                (vec![Real::new(text.as_bytes().to_vec())], 100)
            }
            _ => panic!("{name} is fed with nothing"),
        };
        let inputs = inputs.div_ceil(share * real.len() as u64);
        for real in &real {
            run(name, decoder, real, inputs);
        }
    }
}

#[test]
fn every_decoder_has_its_fuzz_target() {
    let fuzz = sandtable_tests::repository().join("fuzz");
    let manifest = std::fs::read_to_string(fuzz.join("Cargo.toml")).expect("there are targets");
    for (name, _) in DECODERS {
        assert!(manifest.contains(&format!("name = \"{name}\"")), "{name}");
        let target = std::fs::read_to_string(fuzz.join(format!("fuzz_targets/{name}.rs")));
        let call = format!("sandtable_tests::decoders::{name}(data)");
        assert!(target.expect("its file").contains(&call), "{name}");
    }
}
