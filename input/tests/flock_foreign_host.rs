//! A foreign host: starts the simulated Flock on a pseudo-terminal as VRPN 07.38 starts a real one,
//! byte for byte, with nothing of this crate on its side of the line.
#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use sandtable_input::flock::{Motion, Simulator, SimulatorSettings};
use serialport::SerialPort;
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// A host with its end of the line.
struct Host(Box<dyn SerialPort>);

impl Host {
    fn open(path: &Path) -> Self {
        let port = serialport::new(path.to_str().unwrap(), 115_200);
        Self(port.timeout(Duration::from_millis(20)).open().unwrap())
    }

    fn send(&mut self, bytes: &[u8]) {
        self.0.write_all(bytes).unwrap();
    }

    /// What comes until there are `count` bytes, or within half a second, as VRPN waits.
    fn receive(&mut self, count: usize) -> Vec<u8> {
        let (begun, mut got) = (Instant::now(), Vec::new());
        while got.len() < count && begun.elapsed() < Duration::from_millis(500) {
            let mut byte = [0];
            match self.0.read(&mut byte) {
                Ok(read) => got.extend(&byte[..read]),
                Err(error) if error.kind() == ErrorKind::TimedOut => {}
                Err(error) => panic!("{error}"),
            }
        }
        got
    }

    /// Throws away what has come, as VRPN flushes its input.
    fn discard(&mut self) {
        while !self.receive(64).is_empty() {}
    }
}

#[test]
fn it_starts_as_vrpn_starts_it_with_one_to_four_birds() {
    let hosts = (1..=4u8).map(|birds| std::thread::spawn(move || start(birds)));
    for host in hosts.collect::<Vec<_>>() {
        host.join().unwrap();
    }
}

fn start(birds: u8) {
    let simulator = Simulator::start(
        SimulatorSettings {
            birds: birds.into(),
            motions: vec![Motion::hold([12.0, 3.0, -5.0], [30.0, 20.0, 10.0])],
            ..SimulatorSettings::default()
        },
        None,
    )
    .unwrap();
    let mut host = Host::open(simulator.path());
    host.send(&[0x42]);
    host.discard();
    // Auto-configuration, with the least silence that newer manuals ask for.
    std::thread::sleep(Duration::from_millis(600));
    host.send(&[0x50, 0x32, birds]);
    std::thread::sleep(Duration::from_millis(600));
    // Group mode, then format and hemisphere of each bird, in one write.
    let mut settings = vec![0x50, 0x23, 0x01];
    settings.extend((1..=birds).flat_map(|bird| [0xF0 + bird, 0x5D]));
    settings.extend((1..=birds).flat_map(|bird| [0xF0 + bird, 0x4C, 0x00, 0x00]));
    host.send(&settings);
    host.discard();
    // Exactly 14 bytes of status: the first bird is the master, each one runs and is accessible.
    host.send(&[0x4F, 0x24]);
    let status = host.receive(15);
    let mut expected = [0; 14];
    expected[..usize::from(birds)].fill(0xE0);
    expected[0] = 0xE1;
    assert_eq!(status, expected, "{birds} birds");
    host.send(&[0x4F, 0x02, 0x4F, 0x06]);
    let speeds = host.receive(4);
    assert_eq!((speeds.len(), &speeds[..2]), (4, &[0x28, 0x00][..]));
    // The stream: 15 bytes a bird, the first with its phase bit, the last its address.
    host.send(&[0x40]);
    let length = 15 * usize::from(birds);
    let stream = host.receive(4 * length);
    assert_eq!(stream.len(), 4 * length, "{birds} birds");
    for (number, record) in stream.chunks_exact(15).enumerate() {
        let bird = number % usize::from(birds) + 1;
        assert_eq!(usize::from(record[14]), bird);
        let phases: Vec<bool> = record.iter().map(|byte| byte & 0x80 != 0).collect();
        assert!(phases[0] && !phases[1..].contains(&true), "{record:02X?}");
    }
    // The worked record: 12, 3, -5 inches; 30, 20, 10 degrees.
    let worked = [
        0xAA, 0x15, 0x2A, 0x05, 0x0E, 0x77, 0x73, 0x3C, 0x47, 0x7D, 0x71, 0x73, 0x57, 0x70, 1,
    ];
    assert!(
        stream
            .chunks_exact(length)
            .any(|cycle| cycle[..15] == worked),
        "{stream:02X?}"
    );
    host.send(&[0x42, 0x47]);
    host.discard();
    assert!(host.receive(1).is_empty());
    simulator.stop();
}
