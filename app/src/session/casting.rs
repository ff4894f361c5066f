//! By which caster a session casts, and the change to another.
//!
//! A caster may have a volume or a pyramid to build first. That happens beside the session, which
//! goes on with the present caster until the next one is ready.

use crate::scene::ChosenCaster;
use anyhow::{Result, bail};
use sandtable_cast::{CastError, CastPool, PreparedScene, Scene};
use std::sync::Arc;
use std::thread::JoinHandle;

type Prepared = Result<Arc<dyn PreparedScene>, CastError>;

/// The caster in use, and the next one while it is being prepared.
pub(super) struct Casting {
    name: String,
    prepared: Arc<dyn PreparedScene>,
    next: Option<(String, JoinHandle<Prepared>)>,
}

impl Casting {
    /// Prepares `scene` and waits for it.
    pub(super) fn new(caster: &ChosenCaster, scene: &Arc<Scene>, pool: &CastPool) -> Result<Self> {
        Ok(Self {
            name: caster.name.clone(),
            prepared: pool.run(|| caster.caster.prepare(Arc::clone(scene)))?,
            next: None,
        })
    }

    /// What the caster in use is called.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The scene, prepared by the caster in use.
    pub(super) fn prepared(&self) -> &Arc<dyn PreparedScene> {
        &self.prepared
    }

    /// Whether another caster is being prepared.
    pub(super) fn is_changing(&self) -> bool {
        self.next.is_some()
    }

    /// Begins to prepare another caster. One still being prepared is dropped when it is ready.
    pub(super) fn change(&mut self, caster: ChosenCaster, pool: &Arc<CastPool>) -> Result<()> {
        let ChosenCaster { name, caster } = caster;
        let (scene, pool) = (Arc::clone(self.prepared.scene()), Arc::clone(pool));
        let thread = std::thread::Builder::new()
            .name("preparing".into())
            .spawn(move || pool.run(|| caster.prepare(scene)))?;
        self.next = Some((name, thread));
        Ok(())
    }

    /// Takes the next caster into use if it is ready.
    pub(super) fn settle(&mut self) -> Result<()> {
        let ready = |(_, thread): &mut (String, JoinHandle<Prepared>)| thread.is_finished();
        let Some((name, thread)) = self.next.take_if(ready) else {
            return Ok(());
        };
        match thread.join() {
            Ok(prepared) => {
                self.prepared = prepared?;
                self.name = name;
                Ok(())
            }
            Err(_) => bail!("the caster {name} broke down while it was prepared"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::caster;
    use glam::DVec2;
    use sandtable_terrain::Ground;
    use std::time::{Duration, Instant};

    #[test]
    fn the_present_caster_stays_until_the_next_is_ready() {
        let ground = Ground::from_fn(9, 9, DVec2::ONE, |col, row| (col + row) as f32).unwrap();
        let pool = Arc::new(CastPool::new(1).unwrap());
        let first = caster("brute").unwrap();
        let mut casting = Casting::new(&first, &Scene::new(ground), &pool).unwrap();
        let before = Arc::clone(casting.prepared());
        // The pool's only thread is kept busy, so that nothing can be prepared.
        let (go, gate) = std::sync::mpsc::channel::<()>();
        let busy = Arc::clone(&pool);
        let keeper = std::thread::spawn(move || busy.run(move || gate.recv()));
        casting.change(caster("coherent").unwrap(), &pool).unwrap();
        casting.settle().unwrap();
        let early = (casting.name().to_owned(), casting.is_changing());
        go.send(()).unwrap();
        keeper.join().unwrap().unwrap();
        // The keeper may have come second; then the change was ready at once.
        if early.0 == "brute" {
            assert!(early.1);
        }
        let begin = Instant::now();
        while casting.is_changing() && begin.elapsed() < Duration::from_secs(20) {
            casting.settle().unwrap();
        }
        assert_eq!(casting.name(), "coherent");
        assert!(!Arc::ptr_eq(&before, casting.prepared()));
    }
}
