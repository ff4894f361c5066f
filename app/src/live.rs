//! A session in a window: live, with its devices, or replayed.

use crate::guide::{Guide, GuideSetup};
use crate::rig;
use crate::session::{Session, summit};
use crate::tape::{self, Tape};
use crate::window::{
    Activity, Advanced, Device, Drive, GuideReadings, GuideStep, GuideWish, HeadTimes, Readings,
    Show, Wish,
};
use glam::DVec3;
use sandtable_audio::{Control, Output, Playback};
use sandtable_cast::PreparedScene;
use sandtable_config::Intent;
use sandtable_input::intent::{DeskState, IntentState};
use sandtable_input::{Clock, Condition, Devices, Estimate, Gamepads, Replay};
use sandtable_pose::{Nanos, Validity};
use sandtable_view::View;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Where a session's times come from.
pub(crate) enum Timeline {
    /// The clock, and devices that run by it.
    Live {
        /// Since the session's start.
        clock: Clock,
        /// The rig's devices, but while one of them is calibrated.
        devices: Option<Devices>,
        /// Where they are recorded, if they are.
        tape: Option<Box<Tape>>,
    },
    /// A recording.
    Replayed {
        /// What was recorded.
        replay: Box<Replay>,
        /// When it began to be shown.
        begun: Instant,
        /// Recorded seconds a second.
        speed: f64,
        /// Whether it begins anew at its end.
        repeats: bool,
    },
}

/// A session that people see, steer and hear.
pub(crate) struct Live {
    session: Session,
    timeline: Timeline,
    gamepads: Option<Gamepads>,
    /// What people meant last.
    intents: IntentState,
    sound: Option<(Control, Output)>,
    summit: DVec3,
    setup: GuideSetup,
    guide: Option<Guide>,
}

impl Live {
    /// Brings `session` to life.
    pub(crate) fn new(
        session: Session,
        timeline: Timeline,
        gamepads: Option<Gamepads>,
        mute: bool,
        setup: GuideSetup,
    ) -> Self {
        let sound = (!mute).then(|| Output::start(session.sound_settings()));
        let summit = summit(session.ground());
        Self {
            session,
            timeline,
            gamepads,
            intents: IntentState::default(),
            sound,
            summit,
            setup,
            guide: None,
        }
    }

    /// Ends devices and recording.
    pub(crate) fn end(self) -> Option<Box<Tape>> {
        match self.timeline {
            Timeline::Live { devices, tape, .. } => {
                drop(devices);
                tape
            }
            Timeline::Replayed { .. } => None,
        }
    }

    /// Begins a step of the calibration.
    pub(crate) fn begin_guide(&mut self, step: GuideStep) {
        let Timeline::Live { devices, tape, .. } = &mut self.timeline else {
            return self.session.say("a replay is not calibrated");
        };
        if tape.is_some() {
            let why =
                "a recording has one rig from its begin to its end: calibrate without --record";
            return self.session.say(why);
        }
        match Guide::begin(step, &self.setup, self.session.rig(), devices) {
            Ok(guide) => self.guide = Some(guide),
            Err(error) => self.session.say(format!("{error:#}")),
        }
    }

    /// Takes in what the calibration says; at its end, the rig as it is then.
    fn follow_guide(&mut self) {
        let Some(written) = self.guide.as_mut().and_then(Guide::listen) else {
            return;
        };
        if !written.is_empty() {
            self.setup.rig = written;
        }
        match rig::open(&self.setup.rig, &self.setup.device) {
            Ok(rig) => self.session.adopt(rig),
            Err(error) => self.session.say(format!("{error:#}")),
        }
        let Timeline::Live { clock, devices, .. } = &mut self.timeline else {
            return;
        };
        match Devices::start(self.session.rig(), self.session.hub(), *clock, None) {
            Ok(started) => *devices = Some(started),
            Err(error) => self.session.say(error.to_string()),
        }
    }

    fn guide_readings(&self) -> Option<GuideReadings> {
        let guide = self.guide.as_ref()?;
        let question = guide.question();
        let mark = question.and_then(|(_, mark)| self.session.on_glass(mark?));
        Some(GuideReadings {
            title: guide.step().name(),
            lines: guide.lines().to_vec(),
            question: question.map(|(prompt, _)| prompt.to_owned()),
            mark: mark.map(|(at, _)| at),
            // A ruler's error is no height.
            mark_is_raised: mark.is_some_and(|(_, above)| above > 2e-3),
            ended: guide.has_ended(),
        })
    }

    /// Shows what a replay has come to; at its end it begins anew or stays.
    fn recall(&mut self, desk: &DeskState, now: Instant) {
        let Timeline::Replayed {
            replay,
            begun,
            speed,
            repeats,
        } = &mut self.timeline
        else {
            return;
        };
        let shown = now.saturating_duration_since(*begun);
        let mut time = replay.start() + shown.mul_f64(*speed);
        if time > replay.end() && *repeats {
            *begun = now;
            time = replay.start();
            replay.rewind();
            self.session.hub().clear();
        }
        match tape::recall(replay, &mut self.session, time, desk) {
            Ok(intents) => self.intents = intents,
            Err(error) => self.session.say(format!("{error:#}")),
        }
    }
}

impl Show for Live {
    fn advance(&mut self, drive: &Drive, step: Duration, now: Instant) -> Advanced {
        let mut desk = drive.desk.clone();
        desk.gamepad = self.gamepads.as_mut().and_then(Gamepads::poll);
        // A gamepad has no event that would wake the window: while one is there, it is asked.
        let mut moving = desk.gamepad.is_some() || self.session.settle_caster();
        let mut head = None;
        match &mut self.timeline {
            Timeline::Live { clock, tape, .. } => {
                let time = clock.now();
                self.intents = self.session.take_in(time, &desk);
                head = head_times(&self.session, *clock, time, self.intents.look);
                match &mut self.guide {
                    None => moving |= self.session.drive(&self.intents, &drive.mouse, step),
                    // Whoever acts says "now", and moves nothing.
                    Some(guide) => {
                        if self.intents.begins(Intent::Act) {
                            guide.answer(String::new());
                        }
                        moving = true;
                    }
                }
                moving |= !self.session.rig().devices.is_empty();
                if let Some(tape) = tape
                    && let Err(error) = tape.follow(&self.session, time)
                {
                    self.session.say(format!("{error:#}"));
                }
            }
            Timeline::Replayed { .. } => {
                // What was recorded comes last: it is what is shown.
                self.session.drive(&self.intents, &drive.mouse, step);
                self.recall(&desk, now);
                moving = true;
            }
        }
        moving |= self.intents.is_active();
        self.follow_guide();
        if let Some((control, _)) = &mut self.sound {
            control.set(self.session.soundscape(self.summit));
        }
        Advanced {
            activity: match moving {
                true => Activity::Moving,
                false => Activity::Still,
            },
            intents: self.intents,
            head,
        }
    }

    fn views(&self, frame: [u32; 2], stereo: bool) -> Vec<View> {
        self.session.views(frame, stereo)
    }

    fn scene(&self) -> Arc<dyn PreparedScene> {
        Arc::clone(self.session.prepared())
    }

    fn readings(&self) -> Readings {
        let mut readings = self.session.readings();
        readings.guide = self.guide_readings();
        if let Timeline::Live { devices, tape, .. } = &self.timeline {
            readings.can_calibrate = readings.table.is_some() && devices.is_some();
            for state in devices.iter().flat_map(Devices::states) {
                let (words, works) = match state.condition {
                    Condition::Starting => {
                        let starting = || "starting".to_owned();
                        (state.trouble.unwrap_or_else(starting), false)
                    }
                    Condition::Streaming => ("streaming".to_owned(), true),
                    Condition::Waiting(why) => (why, false),
                };
                readings.devices.push(Device {
                    name: state.name,
                    state: words,
                    works,
                });
            }
            if let Some(tape) = tape {
                let problem = tape.recorder().problem();
                // In the messages, too, as nobody may see the devices' column then.
                if let Some(problem) = &problem {
                    readings.messages.push(format!("recording: {problem}"));
                }
                readings.devices.push(Device {
                    name: "recording".into(),
                    works: problem.is_none(),
                    state: problem.unwrap_or_else(|| "running".into()),
                });
            }
        }
        if let Some((_, output)) = &self.sound {
            let (state, works) = match output.playback() {
                Playback::Opening => ("opening".to_owned(), true),
                Playback::Playing { device, .. } => (device, true),
                Playback::Silent { note } => (note, false),
            };
            readings.devices.push(Device {
                name: "sound".into(),
                state,
                works,
            });
        }
        readings
    }

    fn bindings(&self) -> Vec<(String, String)> {
        let intents = self.session.rig().intents.iter();
        let words = intents.map(|(intent, sources)| {
            let sources: Vec<String> = sources.iter().map(ToString::to_string).collect();
            (intent.meaning().to_owned(), sources.join(", "))
        });
        words.collect()
    }

    fn apply(&mut self, wish: Wish) {
        match (wish, &mut self.guide) {
            (Wish::Guide(GuideWish::Begin(step)), None) => self.begin_guide(step),
            (Wish::Guide(GuideWish::Answer(line)), Some(guide)) => guide.answer(line),
            (Wish::Guide(GuideWish::Stop), Some(guide)) => guide.end(),
            (Wish::Guide(GuideWish::Close), guide) => {
                guide.take_if(|guide| guide.has_ended());
            }
            (Wish::Guide(_), _) => {}
            (wish, _) => self.session.apply(wish),
        }
    }
}

/// When the head that a table's views follow at `time` was measured, read and taken in; `None`
/// where no tracker tells it, or it is lost.
fn head_times(
    session: &Session,
    clock: Clock,
    time: Nanos,
    look: Option<Estimate>,
) -> Option<HeadTimes> {
    // A camera's views follow no head.
    session.placement()?;
    let sensor = session.rig().head.as_ref()?.sensor.as_ref()?;
    let look = look.filter(|look| look.pose.validity != Validity::Lost)?;
    let measured = look.pose.time;
    let read = session.hub().arrival_of(sensor, measured)?;
    Some(HeadTimes {
        measured: clock.instant(measured),
        read: clock.instant(read),
        taken_in: clock.instant(time),
        predicted: look.predicted,
    })
}

/// The time of frame `frame` of a replay on the virtual clock, at `rate` frames a second and
/// `speed` recorded seconds a second.
pub(crate) fn frame_time(start: Nanos, frame: u32, rate: u32, speed: f64) -> Nanos {
    let shown = Duration::from_nanos(u64::from(frame) * 1_000_000_000 / u64::from(rate));
    start + shown.mul_f64(speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_a_replay_are_where_its_speed_puts_them() {
        let start = Nanos(500);
        assert_eq!(frame_time(start, 0, 60, 3.0), start);
        assert_eq!(frame_time(start, 7, 60, 1.0), Nanos(500 + 116_666_666));
        assert_eq!(frame_time(start, 60, 60, 0.5), Nanos(500 + 500_000_000));
        assert_eq!(
            frame_time(start, 3600, 60, 100.0),
            Nanos(500 + 6_000_000_000_000)
        );
    }
}
