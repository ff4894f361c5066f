//! A session's recording: its devices' bytes, and how the world lay and the camera flew meanwhile.

use crate::cli::TerrainArgs;
use crate::likeness::Likeness;
use crate::navigation::FlyCamera;
use crate::scene::{self, OpenScene};
use crate::session::{Session, Viewpoint};
use anyhow::{Context, Result, anyhow};
use glam::DVec3;
use sandtable_input::intent::{DeskState, IntentState};
use sandtable_input::{Recorder, Replay};
use sandtable_pose::{Nanos, Rigid};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Placement};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::Write;
use std::path::Path;

/// The topic of the terrain's name.
const TERRAIN_TOPIC: &str = "/session/terrain";
/// The topic of a flying camera.
const CAMERA_TOPIC: &str = "/session/camera";
/// The topics of a head and a hand that the mouse moves.
const BODY_TOPICS: [&str; 2] = ["/session/head", "/session/hand"];

/// The terrain that was flown over.
#[derive(Debug, Serialize, Deserialize)]
struct RecordedTerrain {
    source: String,
    photo: Option<String>,
    /// What the ground is known again by; recordings from before there was this have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ground: Option<Likeness>,
}

/// Where a camera was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct RecordedCamera {
    eye: DVec3,
    attitude: Attitude,
}

impl From<&FlyCamera> for RecordedCamera {
    fn from(camera: &FlyCamera) -> Self {
        Self {
            eye: camera.eye,
            attitude: camera.attitude,
        }
    }
}

/// A recording of a session, while it runs.
pub(crate) struct Tape {
    recorder: Recorder,
    placement: Option<Placement>,
    camera: Option<RecordedCamera>,
    bodies: [Option<Rigid>; 2],
}

impl Tape {
    /// Begins a recording of `session` in a new file.
    pub(crate) fn create(
        path: &Path,
        session: &Session,
        terrain: &TerrainArgs,
        start: Nanos,
    ) -> Result<Self> {
        let placement = session.placement();
        let value = placement.map(serde_json::to_value).transpose()?;
        let recorder = Recorder::create(path, session.rig(), value.as_ref(), start)?;
        let recorded = RecordedTerrain {
            // A recording holds text: a name that is none is recorded as it is shown, like a photo's.
            source: terrain.source().display().to_string(),
            photo: terrain
                .photo
                .as_ref()
                .map(|path| path.display().to_string()),
            ground: Some(Likeness::of(session.ground())),
        };
        recorder.json(TERRAIN_TOPIC, start, serde_json::to_value(recorded)?);
        let mut tape = Self {
            recorder,
            placement,
            camera: None,
            bodies: [None; 2],
        };
        tape.follow(session, start)?;
        Ok(tape)
    }

    /// What devices record to.
    pub(crate) fn recorder(&self) -> &Recorder {
        &self.recorder
    }

    /// Records where the session has moved to by `time`, if it has.
    pub(crate) fn follow(&mut self, session: &Session, time: Nanos) -> Result<()> {
        let placement = session.placement();
        if placement != self.placement {
            self.placement = placement;
            if let Some(placement) = placement {
                self.recorder
                    .placement(time, serde_json::to_value(placement)?);
            }
        }
        if let Viewpoint::Camera { camera, .. } = session.viewpoint() {
            let camera = RecordedCamera::from(camera);
            if self.camera != Some(camera) {
                self.camera = Some(camera);
                self.recorder
                    .json(CAMERA_TOPIC, time, serde_json::to_value(camera)?);
            }
        }
        for ((topic, recorded), body) in BODY_TOPICS
            .into_iter()
            .zip(&mut self.bodies)
            .zip(session.bodies())
        {
            let moved = Some(body.table_from_body());
            if !body.is_tracked() && *recorded != moved {
                *recorded = moved;
                self.recorder
                    .json(topic, time, serde_json::to_value(moved)?);
            }
        }
        Ok(())
    }
}

/// Ends a recording and says what it holds.
pub(crate) fn finish(tape: &Tape, path: &Path) -> Result<()> {
    let summary = tape.recorder.finish()?;
    if let Some(summary) = summary {
        // A terminal that is gone reads nothing any more; the recording is whole all the same.
        let _ = writeln!(
            std::io::stderr(),
            "{}: {} messages, {} bytes, {} dropped",
            path.display(),
            summary.messages,
            summary.bytes,
            summary.dropped
        );
    }
    Ok(())
}

/// The terrain that was recorded over, unless the command line names another.
pub(crate) fn terrain(replay: &Replay, given: &TerrainArgs) -> Result<TerrainArgs> {
    if given.terrain.is_some() {
        return Ok(given.clone());
    }
    let Some(recorded) = recorded_terrain(replay)? else {
        return Ok(given.clone());
    };
    Ok(TerrainArgs {
        terrain: Some(recorded.source.into()),
        photo: given
            .photo
            .clone()
            .or_else(|| recorded.photo.map(Into::into)),
    })
}

fn recorded_terrain(replay: &Replay) -> Result<Option<RecordedTerrain>> {
    let Some((_, value)) = replay.values(TERRAIN_TOPIC).first() else {
        return Ok(None);
    };
    let recorded = RecordedTerrain::deserialize(value).context(
        "the recording's /session/terrain cannot be understood; name the terrain yourself",
    )?;
    Ok(Some(recorded))
}

/// Opens `terrain`, over which the recording in `path` is to be replayed.
///
/// # Errors
/// Where it cannot be opened; one that the recording names says so, as its path may be that of
/// another folder.
pub(crate) fn open_terrain(
    path: &Path,
    given: &TerrainArgs,
    terrain: &TerrainArgs,
) -> Result<OpenScene> {
    let opened = scene::open(terrain);
    if given.terrain.is_some() {
        return opened;
    }
    opened.map_err(|error| {
        let (path, source) = (path.display(), terrain.source().display());
        anyhow!(
            "{error:#}; {path} was recorded over {source}: if that lies elsewhere now, name it, as \
             in: sandtable fly TERRAIN --replay {path}"
        )
    })
}

/// How the ground that the recording in `path` is replayed over, `terrain`, differs from the one
/// that it was recorded over, in a line; `None` where it does not, or where nobody knows.
pub(crate) fn other_ground(
    path: &Path,
    replay: &Replay,
    terrain: &TerrainArgs,
    ground: &Ground,
) -> Option<String> {
    let recorded = recorded_terrain(replay).ok()??;
    let [was, is] = recorded.ground?.difference(&Likeness::of(ground))?;
    let now = terrain.source().display().to_string();
    let (path, before) = (path.display(), recorded.source);
    Some(if before == now {
        format!(
            "{now} has changed since {path} was recorded over it ({was}; now {is}): what was \
             looked at then may lie elsewhere"
        )
    } else {
        format!(
            "{path} was recorded over {before} ({was}) and is replayed over {now} ({is}): what was \
             looked at then may lie elsewhere"
        )
    })
}

/// Puts `session` where it was at `time`: its placement or camera, head and hand. Gives what people
/// mean, then by their devices and now by what is pressed at the desk.
pub(crate) fn recall(
    replay: &mut Replay,
    session: &mut Session,
    time: Nanos,
    desk: &DeskState,
) -> Result<IntentState> {
    replay.advance_to(time, session.hub());
    if let Some(value) = newest(
        replay.values(sandtable_input::recording::PLACEMENT_TOPIC),
        time,
    ) {
        let placement = Placement::deserialize(value)
            .context("a placement in the recording cannot be understood")?;
        session.set_placement(placement);
    }
    if let Some(value) = newest(replay.values(CAMERA_TOPIC), time) {
        let recorded = RecordedCamera::deserialize(value)
            .context("a camera in the recording cannot be understood")?;
        if let Viewpoint::Camera { camera, .. } = session.viewpoint_mut() {
            camera.eye = recorded.eye;
            camera.attitude = recorded.attitude;
        }
    }
    let intents = session.take_in(time, desk);
    for (topic, body) in BODY_TOPICS.into_iter().zip(session.bodies_mut()) {
        if let Some(value) = newest(replay.values(topic), time) {
            let table_from_body = Rigid::deserialize(value)
                .with_context(|| format!("{topic} in the recording cannot be understood"))?;
            body.rest_at(table_from_body);
        }
    }
    Ok(intents)
}

/// The newest value at or before `time`.
fn newest(values: &[(Nanos, Value)], time: Nanos) -> Option<&Value> {
    let later = values.partition_point(|(at, _)| *at <= time);
    values.get(later.checked_sub(1)?).map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terrain_that_was_recorded_without_a_likeness_is_still_understood() {
        let old = r#"{"source":"g.asc","photo":null}"#;
        let recorded: RecordedTerrain = serde_json::from_str(old).expect("it is understood");
        assert_eq!((recorded.source.as_str(), recorded.ground), ("g.asc", None));
    }
}
