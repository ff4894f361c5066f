//! A frame: advance the show, have it cast, draw what there is.

use super::Wake;
use super::guide;
use super::open::Open;
use super::panel::{self, Settings, Vitals};
use super::shell::Shell;
use super::show::Wish;
use sandtable_cast::Request;
use sandtable_stage::{Composing, GpuError, Panel, Presented, save_screenshot_in_background};
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::event_loop::ActiveEventLoop;

/// How long the shell waits before it looks for a lost GPU again, and how often it does.
pub(super) const RENEWAL: (Duration, u32) = (Duration::from_secs(1), 10);

impl Shell<'_> {
    /// Advances the show, has it cast, and draws what there is.
    pub(super) fn frame(&mut self, events: &ActiveEventLoop) {
        let begin = Instant::now();
        // What people mean may ask for another frame after this one.
        self.changed = false;
        self.advance(begin);
        let Some(mut open) = self.open.take() else {
            return;
        };
        let mut wishes = Vec::new();
        if open.is_visible() {
            self.request_cast(&mut open);
            self.take_finished(&mut open, begin);
            self.draw_panel(&mut open, begin, &mut wishes);
            self.present(&mut open, begin, events);
            self.report_latency(begin);
        }
        if !wishes.is_empty() {
            self.changed = true;
        }
        for wish in wishes {
            self.show.apply(wish);
        }
        self.open = Some(open);
    }

    /// What each eye is cast at.
    fn eye_size(&self, frame: [u32; 2]) -> [u32; 2] {
        let full = self.settings.mode.eye_size(frame);
        full.map(|side| side.div_ceil(self.settings.reduction))
    }

    /// Has the newest views cast, where they differ from the last ones.
    fn request_cast(&mut self, open: &mut Open) {
        let frame = open.presenter.size();
        let size = self.eye_size(frame);
        let mut views = self.show.views(frame, self.settings.mode.is_stereo());
        for view in &mut views {
            view.size = size;
        }
        let scene = self.show.scene();
        let same = open
            .requested
            .as_ref()
            .is_some_and(|(old_views, old_scene)| {
                *old_views == views && Arc::ptr_eq(old_scene, &scene)
            });
        if !same {
            open.newest_request += 1;
            open.requested = Some((views.clone(), Arc::clone(&scene)));
            let frame = open.newest_request;
            let replaced = open.caster.request(Request {
                scene,
                views,
                frame,
            });
            let replaced = replaced.map(|request| request.frame);
            self.latency.requested(frame, self.head, replaced);
        }
    }

    /// Puts the newest finished images onto the GPU, if they are not there yet.
    fn take_finished(&mut self, open: &mut Open, now: Instant) {
        let Some(finished) = open.caster.newest() else {
            return;
        };
        if open.uploaded == Some(finished.frame) {
            return;
        }
        open.uploaded = Some(finished.frame);
        self.cast.add(now, finished.cast_time);
        match open.presenter.set_images(&finished.images) {
            Ok(()) => self
                .latency
                .cast(finished.frame, finished.begun, finished.cast_time),
            Err(error) => self.message(error.to_string()),
        }
    }

    fn draw_panel(&mut self, open: &mut Open, now: Instant, wishes: &mut Vec<Wish>) {
        let readings = self.show.readings();
        let bindings = match self.settings.keys {
            true => self.show.bindings(),
            false => Vec::new(),
        };
        let mut messages = self.messages.clone();
        if open.caster.has_ended() {
            messages.push("the caster has broken down: start the program anew".into());
        } else if let Some(refusal) = open.caster.refusal() {
            messages.push(refusal.to_string());
        }
        let vitals = Vitals {
            cast_ms: self.cast.last_ms(),
            casts_per_second: self.cast.rate(now),
            display_ms: self.shown.last_ms(),
            frames_per_second: self.shown.rate(now),
            latency: self.latency.lately(panel::LATELY),
            threads: self.pool.threads(),
            eye_size: self.eye_size(open.presenter.size()),
            gpu: open
                .presenter
                .gpu()
                .map_or_else(String::new, |gpu| gpu.description()),
            messages,
        };
        let before = self.settings.clone();
        let input = open.take_panel_input();
        let context = open.egui.egui_ctx().clone();
        let output = context.run_ui(input, |ui| {
            if let Some(guide) = &readings.guide {
                // The panel would hide marks on the glass.
                let Settings { mode, entry, .. } = &mut self.settings;
                *wishes = guide::lay_out(ui.ctx(), guide, *mode, entry);
            } else if self.panel_shown {
                *wishes = panel::lay_out(ui, &mut self.settings, &readings, &vitals, &bindings);
            }
        });
        self.changed |= self.settings != before;
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        self.panel_due = root.and_then(|root| now.checked_add(root.repaint_delay));
        open.egui
            .handle_platform_output(&open.window, output.platform_output);
        open.presenter.set_panel(Panel {
            primitives: context.tessellate(output.shapes, output.pixels_per_point),
            textures: output.textures_delta,
            pixels_per_point: output.pixels_per_point,
        });
    }

    fn present(&mut self, open: &mut Open, begin: Instant, events: &ActiveEventLoop) {
        let composing = Composing {
            mode: self.settings.mode,
            swap_eyes: self.settings.swap_eyes,
        };
        let window = Arc::clone(&open.window);
        match open
            .presenter
            .present(composing, || window.pre_present_notify())
        {
            Ok(Presented::Drawn) => {
                self.failures = 0;
                let waited = open.presenter.waited();
                let now = Instant::now();
                self.shown
                    .add(now, now.duration_since(begin).saturating_sub(waited));
                if let Some(frame) = open.uploaded {
                    self.latency.presented(frame, now);
                }
                if std::mem::take(&mut self.screenshot_due) {
                    self.take_screenshot(open, composing);
                }
            }
            Ok(Presented::Later) => self.changed = true,
            Ok(Presented::Hidden) => open.occluded = true,
            Ok(Presented::Renewed) => {
                open.start_panel_anew();
                self.message("the graphics device was lost and has been replaced".into());
            }
            Err(error) => self.renewal_failed(error, events),
        }
        let error = open.presenter.gpu().and_then(|gpu| gpu.take_error());
        if let Some(error) = error {
            self.message(error);
        }
    }

    fn renewal_failed(&mut self, error: GpuError, events: &ActiveEventLoop) {
        self.failures += 1;
        self.message(format!("the graphics device was lost: {error}"));
        if self.failures >= RENEWAL.1 {
            self.failure = Some(error.into());
            events.exit();
        }
    }

    fn take_screenshot(&mut self, open: &mut Open, composing: Composing) {
        match open.presenter.capture(composing) {
            Ok(image) => {
                let proxy = self.waker.0.clone();
                let folder = self.options.screenshots.clone();
                save_screenshot_in_background(image, folder, move |saved| {
                    let text = match saved {
                        Ok(path) => format!("wrote {}", path.display()),
                        Err(error) => error.to_string(),
                    };
                    // Fails only when the window has been closed, and then nobody reads it.
                    let _ = proxy.send_event(Wake::Message(text));
                });
            }
            Err(error) => self.message(error.to_string()),
        }
    }
}
