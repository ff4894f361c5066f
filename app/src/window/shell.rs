//! The shell: window events in, frames out.

use super::keys::{Command, HeldKeys};
use super::mouse::Mouse;
use super::pacing::{LONGEST_STEP, Next, Situation, next};
use super::panel::{self, Settings, Vitals};
use super::show::{Activity, Drive, Show, Wish};
use super::times::Times;
use super::{Wake, Waker, WindowError, WindowOptions};
use glam::DVec2;
use sandtable_cast::{BackgroundCaster, CASTERS, CastPool, PreparedScene, Request};
use sandtable_input::FlightAxes;
use sandtable_stage::{
    Composing, GpuError, Panel, Presented, Presenter, save_screenshot_in_background,
};
use sandtable_view::View;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{ModifiersState, PhysicalKey};
use winit::window::{Fullscreen, Window, WindowId};

/// How long the shell waits before it looks for a lost GPU again, and how often it does.
const RENEWAL: (Duration, u32) = (Duration::from_secs(1), 10);

/// Messages kept.
const MESSAGES: usize = 8;

/// Everything about the window but the window itself.
pub(super) struct Shell<'a> {
    options: WindowOptions,
    pool: Arc<CastPool>,
    show: &'a mut dyn Show,
    waker: Waker,
    settings: Settings,
    panel_shown: bool,
    held: HeldKeys,
    modifiers: ModifiersState,
    mouse: Mouse,
    messages: Vec<String>,
    screenshot_due: bool,
    changed: bool,
    activity: Activity,
    /// Whether it was moving when the last frame was driven.
    was_moving: bool,
    last_frame: Instant,
    panel_due: Option<Instant>,
    shown: Times,
    cast: Times,
    open: Option<Open>,
    /// Failures to renew a lost GPU, one after another.
    failures: u32,
    failure: Option<WindowError>,
}

/// The open window and what belongs to it. The caster's thread ends before the GPU goes, and the
/// GPU before the window.
struct Open {
    caster: BackgroundCaster,
    presenter: Presenter,
    egui: egui_winit::State,
    window: Arc<Window>,
    /// The shortest time from frame to frame.
    interval: Duration,
    requested: Option<(Vec<View>, Arc<dyn PreparedScene>)>,
    /// The number of the newest request and of the images on the GPU.
    newest_request: u64,
    uploaded: Option<u64>,
    occluded: bool,
    minimised: bool,
}

impl<'a> Shell<'a> {
    pub(super) fn new(
        options: WindowOptions,
        pool: Arc<CastPool>,
        show: &'a mut dyn Show,
        waker: Waker,
    ) -> Self {
        Self {
            settings: Settings {
                mode: options.composing.mode,
                swap_eyes: options.composing.swap_eyes,
                reduction: 1,
                keys: false,
            },
            panel_shown: options.panel,
            options,
            pool,
            show,
            waker,
            held: HeldKeys::default(),
            modifiers: ModifiersState::empty(),
            mouse: Mouse::default(),
            messages: Vec::new(),
            screenshot_due: false,
            changed: true,
            activity: Activity::Still,
            was_moving: false,
            last_frame: Instant::now(),
            panel_due: None,
            shown: Times::default(),
            cast: Times::default(),
            open: None,
            failures: 0,
            failure: None,
        }
    }

    /// What the window ended with.
    pub(super) fn end(self) -> Result<(), WindowError> {
        self.failure.map_or(Ok(()), Err)
    }

    fn message(&mut self, text: String) {
        tracing::info!("{text}");
        self.messages.push(text);
        let surplus = self.messages.len().saturating_sub(MESSAGES);
        self.messages.drain(..surplus);
        self.changed = true;
    }

    fn command(&mut self, command: Command, events: &ActiveEventLoop) {
        self.changed = true;
        match command {
            Command::Quit => events.exit(),
            Command::TogglePanel => self.panel_shown = !self.panel_shown,
            Command::Screenshot => self.screenshot_due = true,
            Command::Home => self.show.apply(Wish::Home),
            Command::SwapEyes => self.settings.swap_eyes = !self.settings.swap_eyes,
            Command::Stereo(mode) => self.settings.mode = mode,
            Command::NextCaster => {
                let present = self.show.readings().caster;
                let index = CASTERS.iter().position(|caster| caster.name() == present);
                let following = index.map_or(0, |index| (index + 1) % CASTERS.len());
                self.show.apply(Wish::Caster(CASTERS[following].name()));
            }
            Command::FullScreen => {
                if let Some(open) = &self.open {
                    let full = open.window.fullscreen().is_none();
                    let screen = full.then_some(Fullscreen::Borderless(None));
                    open.window.set_fullscreen(screen);
                }
            }
        }
    }

    fn key(&mut self, event: &KeyEvent, panel_has_it: bool, events: &ActiveEventLoop) {
        let PhysicalKey::Code(key) = event.physical_key else {
            return;
        };
        if event.state == ElementState::Released {
            self.held.release(key);
            return;
        }
        // Alt-Tab, Ctrl-C and the like are meant for others.
        let others = ModifiersState::CONTROL | ModifiersState::ALT | ModifiersState::SUPER;
        if self.modifiers.intersects(others) {
            return;
        }
        match Command::of(key) {
            Some(command) if !panel_has_it || command.above_panel() => {
                if !event.repeat {
                    self.command(command, events);
                }
            }
            None if !panel_has_it => self.held.press(key),
            _ => {}
        }
    }

    /// Whether a frame is due without anything having changed yet.
    fn moving(&self) -> bool {
        self.activity == Activity::Moving
            || self.held.axes() != FlightAxes::default()
            || self.mouse.is_held()
    }

    /// Advances the show by the time since it last was.
    fn advance(&mut self, now: Instant) {
        let (frame, interval) = self.open.as_ref().map_or_else(
            || ([1, 1], LONGEST_STEP),
            |open| (open.presenter.size(), open.interval),
        );
        // What people ask for after a rest begins now, not when the rest began.
        let longest = if self.was_moving {
            LONGEST_STEP
        } else {
            interval
        };
        let step = now.duration_since(self.last_frame).min(longest);
        self.last_frame = now;
        let drive = Drive {
            axes: self.held.axes(),
            boost: self.held.boost(),
            mouse: self.mouse.take(frame),
        };
        self.held.used();
        self.activity = self.show.advance(&drive, step, now);
        self.was_moving = self.moving();
    }

    /// Advances the show, has it cast, and draws what there is.
    fn frame(&mut self, events: &ActiveEventLoop) {
        let begin = Instant::now();
        self.advance(begin);
        self.changed = false;
        let Some(mut open) = self.open.take() else {
            return;
        };
        let mut wishes = Vec::new();
        if open.is_visible() {
            self.request_cast(&mut open);
            self.take_finished(&mut open, begin);
            self.draw_panel(&mut open, begin, &mut wishes);
            self.present(&mut open, begin, events);
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
            open.caster.request(Request {
                scene,
                views,
                frame: open.newest_request,
            });
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
        if let Err(error) = open.presenter.set_images(&finished.images) {
            self.message(error.to_string());
        }
    }

    fn draw_panel(&mut self, open: &mut Open, now: Instant, wishes: &mut Vec<Wish>) {
        let readings = self.show.readings();
        let vitals = Vitals {
            cast_ms: self.cast.last_ms(),
            casts_per_second: self.cast.rate(now),
            display_ms: self.shown.last_ms(),
            frames_per_second: self.shown.rate(now),
            threads: self.pool.threads(),
            eye_size: self.eye_size(open.presenter.size()),
            gpu: open
                .presenter
                .gpu()
                .map_or_else(String::new, |gpu| gpu.description()),
            messages: self.messages.clone(),
        };
        let before = self.settings.clone();
        let input = open.egui.take_egui_input(&open.window);
        let context = open.egui.egui_ctx().clone();
        let output = context.run_ui(input, |ui| {
            if self.panel_shown {
                *wishes = panel::lay_out(ui, &mut self.settings, &readings, &vitals);
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

impl Open {
    fn new(
        events: &ActiveEventLoop,
        options: &WindowOptions,
        pool: Arc<CastPool>,
        waker: Waker,
    ) -> Result<Self, WindowError> {
        let [width, height] = options.size;
        let attributes = Window::default_attributes()
            .with_title(&options.title)
            .with_inner_size(LogicalSize::new(width, height))
            .with_fullscreen(options.full_screen.then_some(Fullscreen::Borderless(None)));
        let window = Arc::new(
            events
                .create_window(attributes)
                .map_err(WindowError::NoWindow)?,
        );
        let (display, surface_window) = (events.owned_display_handle(), Arc::clone(&window));
        let source = Box::new(move || {
            let descriptor = wgpu::InstanceDescriptor::new_with_display_handle_from_env(Box::new(
                display.clone(),
            ));
            let instance = wgpu::Instance::new(descriptor);
            let surface = instance.create_surface(Arc::clone(&surface_window))?;
            Ok((instance, surface))
        });
        let presenter = Presenter::new(source, window.inner_size().into())?;
        let caster =
            BackgroundCaster::start(pool, move || waker.wake()).map_err(WindowError::NoThread)?;
        let refresh = window
            .current_monitor()
            .and_then(|monitor| monitor.refresh_rate_millihertz())
            .filter(|rate| *rate > 0)
            .unwrap_or(60_000);
        Ok(Self {
            caster,
            egui: panel_state(&window, &presenter),
            presenter,
            window,
            // A little early: where presenting waits for the glass, that sets the pace.
            interval: Duration::from_secs_f64(0.9 * 1000.0 / f64::from(refresh)),
            requested: None,
            newest_request: 0,
            uploaded: None,
            occluded: false,
            minimised: false,
        })
    }

    fn is_visible(&self) -> bool {
        !self.occluded && !self.minimised && !self.presenter.size().contains(&0)
    }

    /// All textures of the panel were lost: a new one uploads them again, as do the eyes' images.
    fn start_panel_anew(&mut self) {
        self.egui = panel_state(&self.window, &self.presenter);
        self.uploaded = None;
    }
}

fn panel_state(window: &Window, presenter: &Presenter) -> egui_winit::State {
    let context = egui::Context::default();
    context.set_theme(egui::Theme::Dark);
    egui_winit::State::new(
        context,
        egui::ViewportId::ROOT,
        window,
        Some(window.scale_factor() as f32),
        None,
        presenter.gpu().map(|gpu| gpu.longest_side() as usize),
    )
}

impl ApplicationHandler<Wake> for Shell<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match Open::new(
            events,
            &self.options,
            Arc::clone(&self.pool),
            self.waker.clone(),
        ) {
            Ok(open) => {
                self.last_frame = Instant::now();
                self.open = Some(open);
                self.frame(events);
            }
            Err(error) => {
                self.failure = Some(error);
                events.exit();
            }
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, wake: Wake) {
        self.changed = true;
        if let Wake::Message(text) = wake {
            self.message(text);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = self.open.as_mut() else {
            return;
        };
        if matches!(event, WindowEvent::RedrawRequested) {
            self.frame(events);
            return;
        }
        // Tab would move the panel's focus; here it hides the panel.
        let is_tab = matches!(&event, WindowEvent::KeyboardInput { event, .. }
            if event.physical_key == PhysicalKey::Code(winit::keyboard::KeyCode::Tab));
        let panel_has_it = if is_tab {
            false
        } else {
            let response = open.egui.on_window_event(&open.window, &event);
            self.changed |= response.repaint;
            response.consumed
        };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                open.presenter.resize(size.into());
                open.minimised = size.width == 0 || size.height == 0;
                open.occluded = false;
                self.changed = true;
            }
            WindowEvent::Occluded(occluded) => {
                open.occluded = occluded;
                self.changed = true;
            }
            WindowEvent::Focused(focused) => {
                if focused {
                    // Some window systems report nothing else when a window is restored.
                    open.occluded = false;
                } else {
                    self.held.clear();
                    self.mouse.clear();
                }
                self.changed = true;
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput {
                event,
                is_synthetic: false,
                ..
            } => self.key(&event, panel_has_it, events),
            WindowEvent::CursorMoved { position, .. } => {
                let over_panel = open.egui.egui_ctx().is_pointer_over_egui();
                self.mouse
                    .moved(DVec2::new(position.x, position.y), over_panel);
                // A show may follow the pointer without any button held.
                self.changed = true;
            }
            WindowEvent::CursorLeft { .. } => self.mouse.left(),
            WindowEvent::MouseInput { state, button, .. } => {
                let index = match button {
                    MouseButton::Left => 0,
                    MouseButton::Right => 1,
                    _ => return,
                };
                let down = state == ElementState::Pressed;
                if !down || !panel_has_it {
                    self.mouse.button(index, down);
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !panel_has_it => {
                self.mouse.turned(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    // Twenty pixels a notch, as touchpads report them.
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / 20.0,
                });
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(open) = self.open.as_ref() else {
            return;
        };
        let situation = Situation {
            changed: self.changed || self.screenshot_due || self.failures > 0,
            moving: self.moving(),
            visible: open.is_visible(),
            last: self.last_frame,
            interval: if self.failures > 0 {
                RENEWAL.0
            } else {
                open.interval
            },
            panel_due: self.panel_due,
        };
        let now = Instant::now();
        events.set_control_flow(match next(&situation, now) {
            Next::Draw => {
                open.window.request_redraw();
                ControlFlow::Wait
            }
            Next::Advance => {
                self.advance(now);
                ControlFlow::WaitUntil(now)
            }
            Next::SleepUntil(due) => ControlFlow::WaitUntil(due),
            Next::Sleep => ControlFlow::Wait,
        });
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        if let Some(open) = self.open.take() {
            // The last cast may take a moment to end; nobody needs to watch that.
            open.window.set_visible(false);
        }
    }
}
