//! Flights along recorded tracks (GPX).

mod file;

use crate::cli::RenderArgs;
use crate::exit::usage;
use crate::film::Film;
use crate::notice::notice;
use crate::scene;
use crate::scene::ChosenCaster;
use crate::session::{Session, Viewpoint};
use anyhow::{Context, Result, bail};
use glam::{DVec2, DVec3};
use sandtable_cast::CastPool;
use sandtable_config::Rig;
use sandtable_input::Hub;
use sandtable_terrain::{Georeference, Ground};
use sandtable_view::{Attitude, ViewFile};
use std::path::Path;
use std::sync::Arc;

/// Frames a second of a filmed track.
const RATE: u32 = 30;

/// The longest film, in frames: an hour.
const LONGEST: f64 = 3600.0 * RATE as f64;

/// No track is so many metres above or below the sea, nor flown so high above the ground. Rays from an
/// eye at no finite place would each be led over all of the ground.
const HIGHEST: f64 = 1e5;

/// Seconds of flight over which the camera's heading looks ahead.
const AHEAD: f64 = 2.0;

/// Films the flight along the track at `path`.
pub(crate) fn render(
    args: &RenderArgs,
    path: &Path,
    view: Option<&ViewFile>,
    caster: &ChosenCaster,
) -> Result<()> {
    let open = scene::open(&args.terrain)?;
    let (speed, height) = (args.flight[0], args.flight[1]);
    if !(speed > 0.0 && speed.is_finite() && height.abs() <= HIGHEST) {
        return Err(usage(format_args!(
            "--flight needs a speed above 0 and a height of at most {HIGHEST} m"
        )));
    }
    let track = Track::read(path, &open.georeference, &open.scene.ground, speed, height)?;
    for note in &track.notes {
        tracing::info!("{note}");
    }
    let frames = (track.seconds() * f64::from(RATE)).ceil().max(1.0);
    if frames > LONGEST {
        let remedy = if track.is_timed {
            "cut the track into parts, or take its times out, so that it is flown at the speed of \
             --flight SPEED HEIGHT"
        } else {
            "give a higher speed: --flight SPEED HEIGHT"
        };
        bail!(
            "the flight along {} takes {:.0} s, but a film may last an hour; {remedy}",
            path.display(),
            track.seconds()
        );
    }
    let pool = CastPool::new(args.threads).context("cannot start the casting threads")?;
    let pool = Arc::new(pool.with_scheme(args.scheme));
    let rig = Rig::builtin("desktop")?;
    let hub = Arc::new(Hub::for_rig(&rig));
    let mut session = Session::new(rig, &open, caster, Arc::clone(&pool), hub)?;
    let eye_size = view.map_or([960, 540], ViewFile::size);
    if let (
        Some(view),
        Viewpoint::Camera {
            horizontal_fov,
            stereo,
            ..
        },
    ) = (view, session.viewpoint_mut())
    {
        if let Some(fov) = view.horizontal_fov() {
            *horizontal_fov = fov;
        }
        if let Some(eyes) = view.camera_stereo() {
            *stereo = eyes;
        }
    }
    let film = Film {
        output: args.output.clone(),
        audio: args.audio.clone(),
        eye_size,
        stereo: args.stereo.mode(),
        swap_eyes: false,
        rate: RATE,
        frames: frames as u32,
    };
    film.shoot(&mut session, &pool, |session, frame| {
        let seconds = f64::from(frame) / f64::from(RATE);
        let (eye, attitude, airspeed) = track.pose(seconds);
        if let Viewpoint::Camera { camera, .. } = session.viewpoint_mut() {
            camera.eye = eye;
            camera.attitude = attitude;
        }
        session.set_airspeed(airspeed);
    })?;
    notice(format_args!(
        "{}: {} frames, {:.1} s",
        args.output.display(),
        film.frames,
        track.seconds()
    ));
    Ok(())
}

/// A track in the world, with the seconds at which its points are passed.
#[derive(Debug)]
struct Track {
    points: Vec<(f64, DVec3)>,
    /// Whether the seconds are the file's own.
    is_timed: bool,
    /// What of the file is not flown as it says.
    notes: Vec<String>,
}

impl Track {
    /// Reads the first track or route of a GPX file.
    ///
    /// Points without elevation are `height` metres above the ground; points below the ground are
    /// raised to 2 m above it. Where a point has no time, or an earlier one than the point before, the
    /// track is flown at `speed` metres a second; of points at the same time the first counts.
    fn read(
        path: &Path,
        georeference: &Georeference,
        ground: &Ground,
        speed: f64,
        height: f64,
    ) -> Result<Self> {
        let gpx = file::read(path)?;
        let count = gpx.tracks.len() + gpx.routes.len();
        let mut notes = Vec::new();
        if count > 1 {
            notes.push(format!(
                "{} holds {count} tracks and routes; the first of two points or more is flown",
                path.display()
            ));
        }
        let waypoints: Vec<gpx::Waypoint> = gpx
            .tracks
            .into_iter()
            .map(|track| {
                track
                    .segments
                    .into_iter()
                    .flat_map(|segment| segment.points)
                    .collect()
            })
            .chain(gpx.routes.into_iter().map(|route| route.points))
            .find(|points: &Vec<_>| points.len() >= 2)
            .with_context(|| {
                format!(
                    "{} has no track or route of two points or more",
                    path.display()
                )
            })?;
        let mut places = Vec::with_capacity(waypoints.len());
        for (number, point) in (1..).zip(&waypoints) {
            if let Some(elevation) = point.elevation
                && !(-HIGHEST..=HIGHEST).contains(&elevation)
            {
                let place = point.point();
                bail!(
                    "{}: point {number} of the track, at {} N, {} E, has the elevation {elevation:e} m; \
                     correct it (metres, from -{HIGHEST} to {HIGHEST}) or leave it out",
                    path.display(),
                    place.y(),
                    place.x()
                );
            }
            let degrees = DVec2::new(point.point().x(), point.point().y());
            let at = georeference.world_from_wgs84(degrees).with_context(|| {
                format!("cannot place the track {} on the terrain", path.display())
            })?;
            let surface = ground.height_at(at.x, at.y);
            let floor = surface.unwrap_or(f64::from(ground.range()[0]));
            let z = point.elevation.unwrap_or(floor + height).max(floor + 2.0);
            places.push((at.extend(z), surface.is_some()));
        }
        if !places.iter().any(|(_, over_terrain)| *over_terrain) {
            bail!("no point of {} lies over the terrain", path.display());
        }
        let times: Option<Vec<f64>> = waypoints
            .iter()
            .map(|point| {
                let time = time::OffsetDateTime::from(point.time?);
                Some(time.unix_timestamp_nanos() as f64 * 1e-9)
            })
            .collect();
        let has_times = waypoints.iter().any(|point| point.time.is_some());
        let times = times.filter(|times| {
            times.windows(2).all(|pair| pair[1] >= pair[0]) && times.last() > times.first()
        });
        if has_times && times.is_none() {
            notes.push(format!(
                "the times in {} are left out, as some points have none or an earlier one than the point \
                 before; it is flown at {speed} m/s",
                path.display()
            ));
        }
        let mut points: Vec<(f64, DVec3)> = Vec::with_capacity(places.len());
        for (index, (place, _)) in places.into_iter().enumerate() {
            let seconds = match (&times, points.last()) {
                (Some(times), _) => times[index] - times[0],
                (None, None) => 0.0,
                (None, Some((before, last))) => before + place.distance(*last) / speed,
            };
            if points.last().is_none_or(|(before, _)| seconds > *before) {
                points.push((seconds, place));
            }
        }
        Ok(Self {
            points,
            is_timed: times.is_some(),
            notes,
        })
    }

    fn seconds(&self) -> f64 {
        self.points.last().map_or(0.0, |(seconds, _)| *seconds)
    }

    fn place(&self, seconds: f64) -> DVec3 {
        let after = self.points.partition_point(|(at, _)| *at <= seconds);
        match (
            self.points.get(after.wrapping_sub(1)),
            self.points.get(after),
        ) {
            (Some((t0, from)), Some((t1, to))) => from.lerp(*to, (seconds - t0) / (t1 - t0)),
            (Some((_, last)), None) => *last,
            (None, first) => first.map_or(DVec3::ZERO, |(_, place)| *place),
        }
    }

    /// Eye, attitude and speed at a time: looking along the way of the seconds around it, and a
    /// little down.
    fn pose(&self, seconds: f64) -> (DVec3, Attitude, f64) {
        let eye = self.place(seconds);
        let end = self.seconds();
        let (from, to) = ((seconds - 0.5 * AHEAD).max(0.0), (seconds + AHEAD).min(end));
        let from = from.min((end - AHEAD).max(0.0));
        let way = self.place(to) - self.place(from);
        let along = way.truncate().length();
        let attitude = Attitude {
            yaw: way.x.atan2(way.y),
            pitch: 0.5 * way.z.atan2(along.max(1e-9)) - 10f64.to_radians(),
            roll: 0.0,
        };
        (
            eye,
            attitude,
            if to > from {
                way.length() / (to - from)
            } else {
                0.0
            },
        )
    }
}
