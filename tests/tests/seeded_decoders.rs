//! Decoders under seeded inputs: random bytes, and what a device sends with some of it altered.
//!
//! `SANDTABLE_INPUTS=10000000 cargo test --release -p sandtable-tests --test seeded_decoders` is the
//! long run; without it there are enough to notice a decoder that has come to panic.

use sandtable_config::Rig;
use sandtable_input::flock::{SimulatedFlock, SimulatorSettings};
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

/// An input: the seed's own bytes, or `real` ones cut out, altered, doubled and lost here and there.
fn input(random: &mut Xorshift, real: &[u8]) -> Vec<u8> {
    let length = random.below(300);
    if random.below(4) == 0 {
        return (0..length).map(|_| random.next() as u8).collect();
    }
    let from = random.below(real.len());
    let mut bytes: Vec<u8> = [random.next() as u8, random.next() as u8].to_vec();
    bytes.extend(real[from..].iter().take(length));
    for _ in 0..random.below(8) {
        let place = random.below(bytes.len());
        match random.below(4) {
            0 => bytes[place] ^= 1 << random.below(8),
            1 => bytes.insert(place, random.next() as u8),
            2 => {
                bytes.remove(place);
            }
            _ => bytes.truncate(place),
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

fn run(name: &str, decoder: Decoder, real: &[u8], inputs: u64) {
    // Each decoder has a seed of its own that does not change when another is added.
    let seed = name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let mut random = Xorshift(seed);
    for number in 0..inputs {
        let bytes = input(&mut random, real);
        let start = Instant::now();
        let result = std::panic::catch_unwind(|| decoder(&bytes));
        assert!(result.is_ok(), "{name}, input {number}: {bytes:02X?}");
        assert!(
            start.elapsed() < PATIENCE,
            "{name}, input {number}: {bytes:02X?}"
        );
    }
    println!("{name}: {inputs} inputs");
}

#[test]
fn no_input_makes_a_decoder_panic_or_hang() {
    let inputs = std::env::var("SANDTABLE_INPUTS");
    let inputs = inputs.map_or(INPUTS, |text| text.parse().expect("a number of inputs"));
    for (name, decoder) in DECODERS {
        let (real, share) = match name {
            "flock" => (flock_bytes(), 1),
            "flock_simulator" => (host_bytes(), 1),
            // A whole text takes a thousand times as long as a record.
            _ => (
                Rig::builtin_text("workbench")
                    .expect("built in")
                    .as_bytes()
                    .to_vec(),
                100,
            ),
        };
        run(name, decoder, &real, inputs.div_ceil(share));
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
