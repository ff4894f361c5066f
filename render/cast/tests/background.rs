//! Casting in the background: nobody waits, and the newest wins.

use glam::{DVec2, DVec3};
use sandtable_cast::{
    BackgroundCaster, Brute, CastError, CastPool, Caster, Finished, Image, PreparedScene, Request,
    Scene, Scheme, Work,
};
use sandtable_terrain::{Ground, TileIndex};
use sandtable_view::{Attitude, Camera, View};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

fn scene() -> Arc<Scene> {
    let ground = Ground::from_fn(30, 30, DVec2::ONE, |col, row| (col % 7 + row % 5) as f32);
    Scene::new(ground.expect("a sound grid"))
}

fn view(yaw: f64) -> View {
    let attitude = Attitude {
        yaw,
        pitch: -0.4,
        roll: 0.0,
    };
    Camera {
        eye: DVec3::new(15.0, -3.0, 14.0),
        attitude,
        horizontal_fov: 1.0,
    }
    .view([40, 30])
}

/// A scene whose casts wait for a word.
struct Gated {
    inner: Arc<dyn PreparedScene>,
    begun: Sender<()>,
    go: Mutex<Receiver<()>>,
}

impl PreparedScene for Gated {
    fn scene(&self) -> &Arc<Scene> {
        self.inner.scene()
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        self.inner.updated(scene, changed)
    }

    fn cast(&self, views: &[View], images: &mut [Image], scheme: Scheme) -> Result<(), CastError> {
        self.begun.send(()).expect("the test listens");
        self.go
            .lock()
            .expect("no panic under it")
            .recv()
            .expect("the test speaks");
        self.inner.cast(views, images, scheme)
    }

    fn work(&self, view: &View) -> Result<Work, CastError> {
        self.inner.work(view)
    }
}

fn wait_for(caster: &BackgroundCaster, frame: u64) -> Arc<Finished> {
    let begin = Instant::now();
    loop {
        if let Some(finished) = caster.newest().filter(|finished| finished.frame == frame) {
            return finished;
        }
        assert!(
            begin.elapsed() < Duration::from_secs(20),
            "frame {frame} never came"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn requests_never_wait_and_only_the_newest_is_cast() {
    let (begun, begins) = channel();
    let (go, gate) = channel();
    let scene = Arc::new(Gated {
        inner: Brute.prepare(scene()).expect("no options"),
        begun,
        go: Mutex::new(gate),
    });
    let pool = Arc::new(CastPool::new(2).expect("two threads"));
    let caster = BackgroundCaster::start(Arc::clone(&pool), || {}).expect("a thread");
    assert!(caster.newest().is_none());
    let request = |frame: u64| {
        caster.request(Request {
            scene: scene.clone(),
            views: vec![view(frame as f64 * 0.1)],
            frame,
        })
    };
    let mut replaced = Vec::new();
    let asked = Instant::now();
    replaced.extend(request(1).map(|replaced| replaced.frame));
    begins.recv().expect("a cast begins");
    let waiting = Instant::now();
    // While the first is being cast, these come and go.
    for frame in 2..=50 {
        replaced.extend(request(frame).map(|replaced| replaced.frame));
        assert!(caster.newest().is_none());
    }
    let waited = waiting.elapsed();
    go.send(()).expect("it waits");
    let first = wait_for(&caster, 1);
    assert_eq!(first.images[0].view, view(0.1));
    begins.recv().expect("the next cast begins");
    go.send(()).expect("it waits");
    let last = wait_for(&caster, 50);
    let mut direct = [Image::default()];
    pool.cast(&*scene.inner, &[view(5.0)], &mut direct)
        .expect("any view will do");
    assert!(last.images == direct);
    assert!(asked <= first.begun && first.begun <= waiting);
    assert!(first.cast_time >= waited);
    assert!(replaced.into_iter().eq(2..50));
    // Nothing in between was cast.
    assert!(begins.try_recv().is_err());
    assert!(!caster.has_ended());
}

#[test]
fn a_caster_that_panics_is_noticed_and_the_last_picture_stays() {
    struct Broken(Arc<dyn PreparedScene>);
    impl PreparedScene for Broken {
        fn scene(&self) -> &Arc<Scene> {
            self.0.scene()
        }
        fn updated(
            &self,
            scene: Arc<Scene>,
            changed: &[TileIndex],
        ) -> Result<Arc<dyn PreparedScene>, CastError> {
            self.0.updated(scene, changed)
        }
        fn cast(&self, _: &[View], _: &mut [Image], _: Scheme) -> Result<(), CastError> {
            panic!("on purpose");
        }
        fn work(&self, view: &View) -> Result<Work, CastError> {
            self.0.work(view)
        }
    }
    let pool = Arc::new(CastPool::new(1).expect("a thread"));
    let caster = BackgroundCaster::start(pool, || {}).expect("a thread");
    let sound = Brute.prepare(scene()).expect("no options");
    let views = vec![view(0.0)];
    caster.request(Request {
        scene: sound.clone(),
        views: views.clone(),
        frame: 1,
    });
    wait_for(&caster, 1);
    caster.request(Request {
        scene: Arc::new(Broken(sound)),
        views,
        frame: 2,
    });
    let begin = Instant::now();
    while !caster.has_ended() {
        assert!(begin.elapsed() < Duration::from_secs(20), "it goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(caster.newest().map(|finished| finished.frame), Some(1));
}

#[test]
fn a_refused_view_is_told_of_and_the_last_picture_stays() {
    /// Casts nothing that is wider than high.
    struct Choosy(Arc<dyn PreparedScene>);
    impl PreparedScene for Choosy {
        fn scene(&self) -> &Arc<Scene> {
            self.0.scene()
        }
        fn updated(
            &self,
            scene: Arc<Scene>,
            changed: &[TileIndex],
        ) -> Result<Arc<dyn PreparedScene>, CastError> {
            self.0.updated(scene, changed)
        }
        fn cast(
            &self,
            views: &[View],
            images: &mut [Image],
            scheme: Scheme,
        ) -> Result<(), CastError> {
            if views.iter().any(|view| view.size[0] > view.size[1]) {
                return Err(CastError::View {
                    caster: "choosy",
                    reason: "it is too wide".into(),
                });
            }
            self.0.cast(views, images, scheme)
        }
        fn work(&self, view: &View) -> Result<Work, CastError> {
            self.0.work(view)
        }
    }
    let pool = Arc::new(CastPool::new(1).expect("a thread"));
    let (told, hear) = channel();
    let caster = BackgroundCaster::start(pool, move || {
        told.send(()).expect("the test listens");
    })
    .expect("a thread");
    let scene: Arc<dyn PreparedScene> =
        Arc::new(Choosy(Brute.prepare(scene()).expect("no options")));
    let request = |size, frame| {
        let views = vec![View { size, ..view(0.0) }];
        let scene = Arc::clone(&scene);
        caster.request(Request {
            scene,
            views,
            frame,
        });
        hear.recv_timeout(Duration::from_secs(20))
            .expect("an answer");
        caster.newest().map(|finished| finished.frame)
    };
    assert_eq!(request([30, 40], 1), Some(1));
    assert_eq!(request([40, 30], 2), Some(1));
    let refusal = caster.refusal().expect("a reason");
    assert_eq!(
        refusal.to_string(),
        "choosy cannot cast this view: it is too wide"
    );
    assert_eq!(request([30, 30], 3), Some(3));
    assert_eq!(caster.refusal(), None);
}
