//! A window over made-up hills, to try the stage. To be replaced.
#![allow(
    dead_code,
    unused_imports,
    reason = "the session that uses all of it is yet to come"
)]

mod navigation;
mod window;

use glam::{DVec2, DVec3};
use navigation::{FlyCamera, Pace};
use sandtable_cast::{CASTERS, CastPool, PreparedScene, Scene, caster_by_name};
use sandtable_stage::Composing;
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Stereo, View};
use std::sync::Arc;
use std::time::{Duration, Instant};
use window::{Activity, Display, Drive, Readings, Show, WindowOptions, Wish};

struct Hills {
    camera: FlyCamera,
    start: FlyCamera,
    scene: Arc<Scene>,
    prepared: Arc<dyn PreparedScene>,
    caster: &'static str,
}

impl Hills {
    fn above_ground(&self) -> Option<f64> {
        let eye = self.camera.eye;
        let ground = self.scene.ground.height_at(eye.x, eye.y)?;
        Some(eye.z - ground)
    }

    fn look(&self) -> Camera {
        Camera {
            eye: self.camera.eye,
            attitude: self.camera.attitude,
            horizontal_fov: 60_f64.to_radians(),
        }
    }
}

impl Show for Hills {
    fn advance(&mut self, drive: &Drive, step: Duration, _now: Instant) -> Activity {
        let speed = self.camera.pace.speed(self.above_ground()) * drive.boost;
        self.camera.advance(&drive.axes, speed, step.as_secs_f64());
        let drag = drive.mouse.drag;
        self.camera.turn(drag.x, -drag.y);
        self.camera.pace = self.camera.pace.faster(drive.mouse.wheel);
        Activity::Still
    }

    fn views(&self, frame: [u32; 2], stereo: bool) -> Vec<View> {
        if stereo {
            let stereo = Stereo {
                separation: 60.0,
                screen_distance: 2000.0,
            };
            self.look().stereo_views(stereo, frame).into_array().into()
        } else {
            vec![self.look().view(frame)]
        }
    }

    fn scene(&self) -> Arc<dyn PreparedScene> {
        Arc::clone(&self.prepared)
    }

    fn readings(&self) -> Readings {
        Readings {
            terrain: "hills".into(),
            position: self.camera.eye,
            above_ground: self.above_ground(),
            attitude: self.camera.attitude,
            speed: self.camera.pace.speed(self.above_ground()),
            caster: self.caster,
            ..Default::default()
        }
    }

    fn apply(&mut self, wish: Wish) {
        match wish {
            Wish::Home => self.camera = self.start,
            Wish::Position(eye) => self.camera.eye = eye,
            Wish::Attitude(attitude) => self.camera.set_attitude(attitude),
            Wish::Speed(speed) => self.camera.pace = Pace::Constant(speed),
            Wish::Table(_) => {}
            Wish::Caster(name) => {
                if let Some(caster) = caster_by_name(name) {
                    self.caster = name;
                    self.prepared = caster.prepare(Arc::clone(&self.scene));
                }
            }
        }
    }
}

fn main() -> anyhow::Result<()> {
    tracing_subscriber::fmt().init();
    let display = Display::connect()?;
    let ground = Ground::from_fn(513, 513, DVec2::splat(30.0), |col, row| {
        let (x, y) = (f64::from(col) * 0.03, f64::from(row) * 0.03);
        (900.0 + 300.0 * (x.sin() * y.cos()) + 120.0 * (2.7 * x + y).sin()) as f32
    })?;
    let scene = Scene::new(ground);
    let camera = FlyCamera {
        eye: DVec3::new(7500.0, -500.0, 2200.0),
        attitude: Attitude {
            pitch: -0.25,
            ..Default::default()
        },
        pace: Pace::Constant(400.0),
    };
    let mut show = Hills {
        camera,
        start: camera,
        prepared: CASTERS[0].prepare(Arc::clone(&scene)),
        scene,
        caster: CASTERS[0].name(),
    };
    let options = WindowOptions {
        title: "sandtable".into(),
        size: [1100, 700],
        full_screen: false,
        composing: Composing::default(),
        panel: true,
        screenshots: std::env::current_dir()?,
    };
    display.run(options, Arc::new(CastPool::new(0)?), &mut show)?;
    Ok(())
}
