//! The shell: the state of the window, and what people do to it.

use super::keys::{Command, HeldKeys};
use super::mouse::Mouse;
use super::open::Open;
use super::pacing::LONGEST_STEP;
use super::panel::Settings;
use super::show::{Activity, Drive, Show, Wish};
use super::times::Times;
use super::{Waker, WindowError, WindowOptions};
use sandtable_cast::{CASTERS, CastPool};
use sandtable_input::FlightAxes;
use std::sync::Arc;
use std::time::Instant;
use winit::event::{ElementState, KeyEvent};
use winit::event_loop::ActiveEventLoop;
use winit::keyboard::{ModifiersState, PhysicalKey};
use winit::window::Fullscreen;

/// Messages kept.
const MESSAGES: usize = 8;

/// Everything about the window but the window itself.
pub(super) struct Shell<'a> {
    pub(super) options: WindowOptions,
    pub(super) pool: Arc<CastPool>,
    pub(super) show: &'a mut dyn Show,
    pub(super) waker: Waker,
    pub(super) settings: Settings,
    pub(super) panel_shown: bool,
    pub(super) held: HeldKeys,
    pub(super) modifiers: ModifiersState,
    pub(super) mouse: Mouse,
    pub(super) messages: Vec<String>,
    pub(super) screenshot_due: bool,
    pub(super) changed: bool,
    pub(super) activity: Activity,
    /// Whether it was moving when the last frame was driven.
    pub(super) was_moving: bool,
    pub(super) last_frame: Instant,
    pub(super) panel_due: Option<Instant>,
    pub(super) shown: Times,
    pub(super) cast: Times,
    pub(super) open: Option<Open>,
    /// Failures to renew a lost GPU, one after another.
    pub(super) failures: u32,
    pub(super) failure: Option<WindowError>,
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

    pub(super) fn message(&mut self, text: String) {
        tracing::info!("{text}");
        self.messages.push(text);
        let surplus = self.messages.len().saturating_sub(MESSAGES);
        self.messages.drain(..surplus);
        self.changed = true;
    }

    pub(super) fn command(&mut self, command: Command, events: &ActiveEventLoop) {
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
                let index = CASTERS.iter().position(|kind| kind.name == present);
                let following = index.map_or(0, |index| (index + 1) % CASTERS.len());
                self.show.apply(Wish::Caster(CASTERS[following].name));
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

    pub(super) fn key(&mut self, event: &KeyEvent, panel_has_it: bool, events: &ActiveEventLoop) {
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
            Some(_) if event.repeat => {}
            Some(command) if !panel_has_it || command.above_panel() => {
                self.command(command, events);
            }
            None if !panel_has_it => self.held.press(key),
            _ => {}
        }
    }

    /// Whether a frame is due without anything having changed yet.
    pub(super) fn moving(&self) -> bool {
        self.activity == Activity::Moving
            || self.held.axes() != FlightAxes::default()
            || self.mouse.is_held()
    }

    /// Advances the show by the time since it last was.
    pub(super) fn advance(&mut self, now: Instant) {
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
}
