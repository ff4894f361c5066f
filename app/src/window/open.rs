//! The open window, its GPU and its casting thread.

use super::{Waker, WindowError, WindowOptions};
use sandtable_cast::{BackgroundCaster, CastPool, PreparedScene};
use sandtable_stage::Presenter;
use sandtable_view::View;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::dpi::LogicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::{Fullscreen, Window};

/// The open window and what belongs to it. The caster's thread ends before the GPU goes, and the
/// GPU before the window.
pub(super) struct Open {
    pub(super) caster: BackgroundCaster,
    pub(super) presenter: Presenter,
    pub(super) egui: egui_winit::State,
    pub(super) window: Arc<Window>,
    /// The shortest time from frame to frame.
    pub(super) interval: Duration,
    pub(super) requested: Option<(Vec<View>, Arc<dyn PreparedScene>)>,
    /// The number of the newest request and of the images on the GPU.
    pub(super) newest_request: u64,
    pub(super) uploaded: Option<u64>,
    pub(super) occluded: bool,
    pub(super) minimised: bool,
    /// When it was opened.
    since: Instant,
}

impl Open {
    pub(super) fn new(
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
            since: Instant::now(),
        })
    }

    pub(super) fn is_visible(&self) -> bool {
        !self.occluded && !self.minimised && !self.presenter.size().contains(&0)
    }

    /// What happened on the panel since it was last drawn.
    ///
    /// The window is not asked how large it is, as [`egui_winit::State::take_egui_input`] does: where another
    /// program has destroyed it and the event that tells so is still on its way, winit panics at that.
    pub(super) fn take_panel_input(&mut self) -> egui::RawInput {
        let [width, height] = self.presenter.size().map(|side| side as f32);
        let size = egui::vec2(width, height)
            / egui_winit::pixels_per_point(self.egui.egui_ctx(), &self.window);
        let input = self.egui.egui_input_mut();
        input.time = Some(self.since.elapsed().as_secs_f64());
        input.screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size));
        input.take()
    }

    /// All textures of the panel were lost: a new one uploads them again, as do the eyes' images.
    pub(super) fn start_panel_anew(&mut self) {
        self.egui = panel_state(&self.window, &self.presenter);
        self.uploaded = None;
    }
}

fn panel_state(window: &Window, presenter: &Presenter) -> egui_winit::State {
    let context = egui::Context::default();
    context.set_theme(egui::Theme::Dark);
    // egui's own grey is too dim in a room lit for stereo glasses.
    context.all_styles_mut(|style| {
        style.visuals.override_text_color = Some(egui::Color32::from_gray(215));
    });
    egui_winit::State::new(
        context,
        egui::ViewportId::ROOT,
        window,
        Some(window.scale_factor() as f32),
        None,
        presenter.gpu().map(|gpu| gpu.longest_side() as usize),
    )
}
