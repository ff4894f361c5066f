//! When a pose's bytes were read, beside when it was measured.

use sandtable_config::{Device, Rig, SensorName};
use sandtable_input::{Hub, PoseSample, Sample};
use sandtable_pose::{Nanos, Rigid};

fn sensor(number: u32) -> SensorName {
    SensorName {
        device: "flock".to_owned(),
        number,
    }
}

#[test]
fn a_pose_has_the_arrival_of_its_own_read_while_it_is_known() {
    let hub = Hub::for_rig(&Rig::builtin("workbench").expect("built in"));
    let pose = |ms: u64| {
        Sample::Pose(PoseSample {
            sensor: 1,
            time: Nanos(ms * 1_000_000),
            table_from_sensor: Rigid::IDENTITY,
            frozen: false,
        })
    };
    hub.push_read("flock", pose(10), Nanos(13_500_000));
    hub.push_read("flock", pose(20), Nanos(29_000_000));
    // Whose read nobody tells came when it was measured.
    hub.push("flock", pose(30));
    let arrival = |ms: u64| hub.arrival_of(&sensor(1), Nanos(ms * 1_000_000));
    assert_eq!(arrival(10), Some(Nanos(13_500_000)));
    assert_eq!(arrival(20), Some(Nanos(29_000_000)));
    assert_eq!(arrival(30), Some(Nanos(30_000_000)));
    // No pose was measured then, or by that sensor.
    assert_eq!([arrival(9), arrival(15), arrival(31)], [None; 3]);
    assert_eq!(hub.arrival_of(&sensor(2), Nanos(10_000_000)), None);
    assert_eq!(hub.arrival_of(&sensor(9), Nanos(10_000_000)), None);
    for ms in 31..=600 {
        hub.push("flock", pose(ms));
    }
    assert_eq!(arrival(10), None);
}

#[cfg(unix)]
#[test]
fn what_a_flock_measures_arrives_after_its_bytes_were_on_the_line() {
    use sandtable_input::flock::{Simulator, SimulatorSettings, layout};
    use sandtable_input::{Clock, Devices};
    use std::sync::Arc;
    use std::time::{Duration, Instant};

    let simulator = Simulator::start(SimulatorSettings::default(), None).expect("a terminal");
    let mut rig = Rig::builtin("workbench").expect("built in");
    rig.set_port("flock", simulator.path()).expect("a path");
    let hub = Arc::new(Hub::for_rig(&rig));
    let clock = Clock::start();
    let devices = Devices::start(&rig, &hub, clock, None).expect("a thread");
    let begin = Instant::now();
    let poses = loop {
        let poses = hub.poses_since(&sensor(1), Nanos(0));
        if poses.len() > 50 {
            break poses;
        }
        assert!(
            begin.elapsed() < Duration::from_secs(30),
            "the Flock is silent"
        );
        std::thread::sleep(Duration::from_millis(10));
    };
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    let bits = 10 * layout(flock).record_length() as u64;
    let on_the_line = Duration::from_secs_f64(bits as f64 / f64::from(flock.baud));
    for pose in poses {
        let arrival = hub.arrival_of(&sensor(1), pose.time).expect("it is known");
        // A pose may be dated a little later so that times never go back.
        let line = arrival.since(pose.time) + Duration::from_micros(1);
        assert!(line >= on_the_line, "{line:?} on the line");
        assert!(arrival <= clock.now());
    }
    devices.stop();
    simulator.stop();
}
