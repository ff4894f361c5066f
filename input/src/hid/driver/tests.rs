//! The driver with a scripted bus: gloves that come, go, fall silent and send other things.

use super::super::bus::HidReports;
use super::super::choice::Found;
use super::*;
use crate::data_glove::{VALUES, encode_report, products};
use crate::devices::Outlet;
use crate::{
    Clock, Condition, DeviceState, HandState, Hub, Recorder, Replay, Sample, StreamCounts,
};
use crossbeam_channel::Sender;
use sandtable_config::{ByteOrder, Device, HidAddress, Rig, SensorName, Side};
use sandtable_pose::Nanos;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

const RIG: &str = "name = 'd'\n[camera]\n[devices.glove]\nkind = 'data-glove'\n\
                   hand = 'right'\nsensors = 5\n";

/// What a plugged-in glove sends; then it is silent, or gone where that is the last.
type Plugged = VecDeque<Option<Vec<u8>>>;

/// Each time that it is looked for, what is there: a glove, or nothing.
struct ScriptedBus(VecDeque<Option<Plugged>>);

struct ScriptedReports(Plugged);

impl HidBus for ScriptedBus {
    fn list(&mut self) -> Result<Vec<Found>, HidError> {
        let glove = Found {
            path: "/dev/hidraw9".into(),
            vendor: 0x5D70,
            product: 0x0010,
            serial_number: None,
        };
        Ok(match self.0.front() {
            Some(Some(_)) => vec![glove],
            _ => {
                self.0.pop_front();
                Vec::new()
            }
        })
    }

    fn open(&mut self, _: &Found) -> Result<Box<dyn HidReports>, HidError> {
        let plugged = self.0.pop_front().flatten();
        Ok(Box::new(ScriptedReports(plugged.unwrap_or_default())))
    }
}

impl HidReports for ScriptedReports {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, HidError> {
        std::thread::sleep(Duration::from_millis(5));
        match self.0.pop_front() {
            None => Ok(0),
            Some(None) => Err(HidError::Gone {
                path: "/dev/hidraw9".into(),
                problem: "unplugged".into(),
            }),
            Some(Some(report)) => {
                buffer[..report.len()].copy_from_slice(&report);
                Ok(report.len())
            }
        }
    }
}

/// Opens and closes the hand, as often as need be.
fn reports(count: usize) -> Plugged {
    let raw = |n: usize| [1000, 2000, 1500][n % 3];
    let report = |n| encode_report(&[raw(n); VALUES], ByteOrder::BigEndian).to_vec();
    (0..count).map(|n| Some(report(n))).collect()
}

struct Session {
    hub: Arc<Hub>,
    clock: Clock,
    state: Arc<Mutex<DeviceState>>,
    reset_asked: Arc<AtomicBool>,
    stop: Option<Sender<Infallible>>,
    thread: Option<JoinHandle<()>>,
}

impl Session {
    fn start(
        script: impl IntoIterator<Item = Option<Plugged>>,
        silent_after: Option<Duration>,
        recorder: Option<&Recorder>,
    ) -> Self {
        let rig = Rig::parse(RIG, "d").unwrap();
        let hub = Arc::new(Hub::for_rig(&rig));
        let clock = Clock::start();
        let state = Arc::new(Mutex::new(DeviceState {
            name: "glove".into(),
            condition: Condition::Starting,
            counts: StreamCounts::default(),
            trouble: None,
        }));
        let reset_asked = Arc::new(AtomicBool::new(false));
        let outlet = Outlet {
            device: "glove".into(),
            hub: Arc::clone(&hub),
            clock,
            recorder: recorder.cloned(),
            state: Arc::clone(&state),
            reset_asked: Arc::clone(&reset_asked),
        };
        let (stop, stopped) = crossbeam_channel::bounded(0);
        let thread = DeviceThread::new(outlet, stopped);
        let bus = ScriptedBus(script.into_iter().collect());
        let wanted = Wanted {
            what: "right glove".into(),
            vendor: 0x5D70,
            products: products(Side::Right, 5).to_vec(),
            address: HidAddress::default(),
        };
        let mut stream = crate::stream_of(&rig.devices["glove"]);
        let thread = std::thread::spawn(move || {
            run(bus, wanted, silent_after, stream.as_mut(), thread);
        });
        Self {
            hub,
            clock,
            state,
            reset_asked,
            stop: Some(stop),
            thread: Some(thread),
        }
    }

    fn state(&self) -> DeviceState {
        self.state.lock().unwrap().clone()
    }

    /// Waits until the device's problem holds these words.
    fn wait_for_problem(&self, words: &str) -> String {
        self.wait_for(words, || match self.state().condition {
            Condition::Waiting(text) if text.contains(words) => Some(text),
            _ => None,
        })
    }

    fn wait_for<T>(&self, what: &str, mut found: impl FnMut() -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(found) = found() {
                return found;
            }
            let state = self.state();
            assert!(
                start.elapsed() < Duration::from_secs(20),
                "{what}: {state:?}"
            );
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn hand(&self) -> Option<HandState> {
        hand_at(&self.hub, self.clock.now())
    }

    fn end(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

fn hand_at(hub: &Hub, time: Nanos) -> Option<HandState> {
    let sensor = SensorName {
        device: "glove".into(),
        number: 1,
    };
    hub.hand_at(&sensor, time)
}

#[test]
fn a_glove_that_goes_away_lets_go_and_comes_back_and_all_of_it_replays() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("glove.mcap");
    let rig = Rig::parse(RIG, "d").unwrap();
    let recorder = Recorder::create(&file, &rig, None, Nanos(0)).unwrap();
    let mut unplugged = reports(30);
    unplugged.push_back(None);
    let script = [Some(unplugged), None, None, Some(reports(40))];
    let mut session = Session::start(script, None, Some(&recorder));
    session.wait_for_problem("/dev/hidraw9 is gone");
    assert_eq!(session.hand(), None);
    session.wait_for_problem("no right glove");
    // Obeyed once the glove is back.
    session.reset_asked.store(true, Ordering::Relaxed);
    session.wait_for("all reports", || {
        (session.state().counts.samples == 70).then_some(())
    });
    assert_eq!(session.state().condition, Condition::Streaming);
    session.end();
    // Silent since, but nobody says so: it is held.
    assert!(session.hand().is_some());
    recorder.finish().unwrap();

    let mut replay = Replay::open(&file).unwrap();
    let replayed = Hub::for_rig(replay.rig());
    replay.advance_to(Nanos(u64::MAX), &replayed);
    let (mut lost, mut bent) = (0, 0);
    for tenth_ms in 0..session.clock.now().0 / 100_000 {
        let time = Nanos(tenth_ms * 100_000);
        let live = hand_at(&session.hub, time);
        assert_eq!(hand_at(&replayed, time), live, "at {time:?}");
        match live {
            None => lost += u32::from(bent > 0),
            Some(_) => bent += 1,
        }
    }
    assert!(lost > 0 && bent > 0, "{lost} {bent}");
    // The first report, and the first one after the reset, have a range of nothing.
    let samples = replay.samples("glove");
    let unknown = |sample: &Sample| match sample {
        Sample::Hand(sample) => sample.hand == HandState::default(),
        _ => false,
    };
    let unknown: Vec<bool> = samples.iter().map(unknown).collect();
    let began_anew = unknown.windows(2).filter(|pair| !pair[0] && pair[1]);
    assert_eq!((unknown[0], began_anew.count()), (true, 1));
}

#[test]
fn a_glove_that_falls_silent_lets_go() {
    let silence = Some(Duration::from_millis(200));
    let mut session = Session::start([Some(reports(5))], silence, None);
    let problem = session.wait_for_problem("silent for 0.2 s");
    assert!(problem.contains("`silent_after`"), "{problem}");
    assert_eq!(session.hand(), None);
    assert_eq!(session.state().counts.samples, 5);
    session.end();
}

#[test]
fn reports_that_are_none_are_told_as_such() {
    let others = vec![Some(vec![1; 8]); 1000].into();
    let mut session = Session::start([Some(others)], Some(Duration::from_secs(9)), None);
    let problem = session.wait_for_problem("reports of 8 bytes");
    assert!(problem.contains("right glove"), "{problem}");
    session.end();
}

#[test]
fn the_rigs_gloves_run_on_the_systems_own_bus() {
    // No machine of ours has the glove of this id: it is waited for, by name.
    let text = format!("{RIG}product = 0xFFFE\n");
    let rig = Rig::parse(&text, "d").unwrap();
    assert!(matches!(rig.devices["glove"], Device::DataGlove(_)));
    let hub = Arc::new(Hub::for_rig(&rig));
    let devices = crate::Devices::start(&rig, &hub, Clock::start(), None).unwrap();
    let start = Instant::now();
    let problem = loop {
        if let Condition::Waiting(text) = devices.states().remove(0).condition {
            break text;
        }
        assert!(start.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(2));
    };
    assert!(
        problem.contains("right 5DT glove of 5 sensors (5d70:fffe)"),
        "{problem}"
    );
    assert!(devices.reset_calibration("glove") && !devices.reset_calibration("other"));
}
