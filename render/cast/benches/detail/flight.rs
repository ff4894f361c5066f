//! How images change from frame to frame of a slow flight.

use super::truth::truth;
use crate::scenes::BenchScene;
use anyhow::Result;
use glam::DVec2;
use sandtable_cast::{CastPool, Image, PreparedScene};
use sandtable_view::View;
use std::sync::Arc;

/// The scene and the view from which the flight begins.
const SCENE: &str = "t4096";
const VIEW: &str = "wan0";

/// The way from frame to frame, in posts.
const WAY: f64 = 0.25;

/// Prints how much images change from frame to frame as the eye moves ahead: in the mean over
/// pixels and channels, in 8-bit codes, and how far from the truth's changes (root mean square).
pub(super) fn print(
    scene: &BenchScene,
    casters: [&Arc<dyn PreparedScene>; 2],
    pool: &CastPool,
    frames: u32,
) -> Result<()> {
    let begin = scene.views.iter().find(|at| at.name == VIEW);
    let Some(begin) = begin.filter(|_| scene.name == SCENE) else {
        return Ok(());
    };
    let mut before: Option<[Vec<[u8; 4]>; 3]> = None;
    let mut changes = [Changes::default(); 3];
    let mut images = [Image::default()];
    for frame in 0..frames {
        let view = flown(&begin.view, f64::from(frame) * WAY, scene);
        let truth = truth(&**casters[0], &view, pool)?;
        let mut seen = |caster: &Arc<dyn PreparedScene>| -> Result<Vec<[u8; 4]>> {
            pool.cast(&**caster, &[view], &mut images)?;
            Ok(images[0].colour().to_vec())
        };
        let now = [seen(casters[0])?, seen(casters[1])?, truth];
        if let Some(before) = &before {
            for ((changes, before_it), it) in changes.iter_mut().zip(before).zip(&now) {
                changes.add([before_it, it], [&before[2], &now[2]]);
            }
        }
        before = Some(now);
    }
    println!(
        "\nFlight: {frames} frames of {SCENE} from {VIEW} on, {WAY} post ahead each; changes from \
         frame to frame in 8-bit codes"
    );
    println!(
        "{:<7} {:>7} {:>9}  {:<12} {:>9}  goal",
        "", "mean", "to truth", "goal", "RMS off"
    );
    let [_, _, truth] = changes;
    for (name, changes, goals) in [
        ("point", changes[0], ["", ""]),
        ("detail", changes[1], ["0.9 to 1.1", "< point's"]),
        ("truth", truth, ["", ""]),
    ] {
        println!(
            "{name:<7} {:>7.3} {:>9.3}  {:<12} {:>9.3}  {}",
            changes.mean(),
            changes.mean() / truth.mean(),
            goals[0],
            changes.rms(),
            goals[1]
        );
    }
    Ok(())
}

/// The view moved ahead, level, by so many posts.
fn flown(view: &View, posts: f64, scene: &BenchScene) -> View {
    let middle = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1])) * 0.5;
    let ahead = view
        .direction(middle.x, middle.y)
        .truncate()
        .normalize_or_zero();
    let way = (posts * scene.scene.ground.grid().spacing * ahead).extend(0.0);
    View {
        eye: view.eye + way,
        window: view.window.map(|corner| corner + way),
        size: view.size,
    }
}

/// Sums over pixels' channels and frames.
#[derive(Clone, Copy, Debug, Default)]
struct Changes {
    /// Of changes.
    sizes: f64,
    /// Of the squares of what changes are off from the truth's.
    squares: f64,
    channels: usize,
}

impl Changes {
    /// Adds the change from an image to the next one, where the truth changes too.
    fn add(&mut self, image: [&[[u8; 4]]; 2], truth: [&[[u8; 4]]; 2]) {
        let [image, truth] = [image, truth].map(|[before, now]| {
            let before = before.iter().flat_map(|pixel| &pixel[..3]);
            let now = now.iter().flat_map(|pixel| &pixel[..3]);
            before
                .zip(now)
                .map(|(&before, &now)| f64::from(now) - f64::from(before))
        });
        for (change, truth) in image.zip(truth) {
            self.sizes += change.abs();
            self.squares += (change - truth).powi(2);
            self.channels += 1;
        }
    }

    fn mean(&self) -> f64 {
        self.sizes / self.channels as f64
    }

    fn rms(&self) -> f64 {
        (self.squares / self.channels as f64).sqrt()
    }
}
