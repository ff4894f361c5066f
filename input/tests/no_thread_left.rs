//! Devices that are stopped leave no thread behind, wherever in their work they are.
#![cfg(target_os = "linux")]

use sandtable_config::Rig;
use sandtable_input::flock::{Simulator, SimulatorSettings};
use sandtable_input::{Clock, Devices, Hub};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

fn threads() -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux lists a process's threads");
    tasks.count()
}

/// How many threads there are, once there are as few as `expected` or five seconds have passed: the
/// kernel lists a thread for a moment after it has been joined.
fn settled(expected: usize) -> usize {
    for _ in 0..500 {
        if threads() <= expected {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    threads()
}

#[test]
fn none_is_left_after_a_stop_at_any_time() {
    let simulator = Simulator::start(SimulatorSettings::default(), None).expect("a terminal");
    let before = threads();
    for (port, lasting) in [
        (Path::new("/dev/there-is-no-such-port"), 0),
        (Path::new("/dev/there-is-no-such-port"), 700),
        (simulator.path(), 0),
        (simulator.path(), 300),
        // Past the silences, in the middle of the stream.
        (simulator.path(), 4500),
    ] {
        let mut rig = Rig::builtin("workbench").expect("built in");
        rig.set_port("flock", port).expect("a path");
        let hub = Arc::new(Hub::for_rig(&rig));
        let devices = Devices::start(&rig, &hub, Clock::start(), None).expect("threads");
        std::thread::sleep(Duration::from_millis(lasting));
        assert!(threads() > before);
        devices.stop();
        assert_eq!(
            settled(before),
            before,
            "after {lasting} ms on {}",
            port.display()
        );
    }
    simulator.stop();
}
