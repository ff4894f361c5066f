//! The shell: the state of the window, and what people do to it.

use super::keys::{self, HeldKeys};
use super::latency::{HeadTimes, Latency};
use super::mouse::Mouse;
use super::open::Open;
use super::pacing::LONGEST_STEP;
use super::panel::Settings;
use super::show::{Activity, Advanced, Drive, Show, Wish};
use super::times::Times;
use super::{Waker, WindowError, WindowOptions};
use crate::scene::caster_choices;
use sandtable_cast::CastPool;
use sandtable_config::Intent;
use sandtable_input::intent::{DeskState, IntentState};
use sandtable_stage::StereoMode;
use std::sync::Arc;
use std::time::Instant;
use winit::event::{ElementState, KeyEvent};
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
    /// Somebody has asked for the end.
    pub(super) quitting: bool,
    pub(super) changed: bool,
    pub(super) activity: Activity,
    /// Whether it was moving when the last frame was driven.
    pub(super) was_moving: bool,
    pub(super) last_frame: Instant,
    pub(super) panel_due: Option<Instant>,
    pub(super) shown: Times,
    pub(super) cast: Times,
    /// The head that the show's views follow.
    pub(super) head: Option<HeadTimes>,
    pub(super) latency: Latency,
    /// When the latency was last told.
    pub(super) latency_reported: Instant,
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
                entry: String::new(),
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
            quitting: false,
            changed: true,
            activity: Activity::Still,
            was_moving: false,
            last_frame: Instant::now(),
            panel_due: None,
            shown: Times::default(),
            cast: Times::default(),
            head: None,
            latency: Latency::default(),
            latency_reported: Instant::now(),
            open: None,
            failures: 0,
            failure: None,
        }
    }

    /// What the window ended with.
    pub(super) fn end(mut self) -> Result<(), WindowError> {
        self.report_last_latency();
        self.failure.map_or(Ok(()), Err)
    }

    pub(super) fn message(&mut self, text: String) {
        tracing::info!("{text}");
        self.messages.push(text);
        let surplus = self.messages.len().saturating_sub(MESSAGES);
        self.messages.drain(..surplus);
        self.changed = true;
    }

    /// Does the window's own part of what people meant.
    fn obey(&mut self, intents: &IntentState) {
        for intent in Intent::ALL {
            if intents.begins(intent) {
                self.changed = true;
                self.begin(intent);
            }
        }
    }

    fn begin(&mut self, intent: Intent) {
        match intent {
            Intent::Quit => self.quitting = true,
            Intent::Menu => self.panel_shown = !self.panel_shown,
            Intent::Screenshot => self.screenshot_due = true,
            Intent::Home => self.show.apply(Wish::Home),
            Intent::SwapEyes => self.settings.swap_eyes = !self.settings.swap_eyes,
            Intent::Mono => self.settings.mode = StereoMode::Mono,
            Intent::SideBySide => self.settings.mode = StereoMode::SideBySide,
            Intent::TopBottom => self.settings.mode = StereoMode::TopBottom,
            Intent::Anaglyph => self.settings.mode = StereoMode::Anaglyph,
            Intent::NextCaster => {
                let present = self.show.readings().caster;
                let names: Vec<_> = caster_choices().map(|(name, _)| name).collect();
                let index = names.iter().position(|&name| name == present);
                let following = index.map_or(0, |index| (index + 1) % names.len());
                self.show.apply(Wish::Caster(names[following]));
            }
            Intent::FullScreen => {
                if let Some(open) = &self.open {
                    let full = open.window.fullscreen().is_none();
                    let screen = full.then_some(Fullscreen::Borderless(None));
                    open.window.set_fullscreen(screen);
                }
            }
            // The show's own.
            _ => {}
        }
    }

    pub(super) fn key(&mut self, event: &KeyEvent, panel_has_it: bool) {
        let PhysicalKey::Code(key) = event.physical_key else {
            return;
        };
        let Some(key) = keys::code(key) else {
            return;
        };
        // What is let go ends something, too.
        self.changed = true;
        if event.state == ElementState::Released {
            self.held.release(key);
            return;
        }
        // Alt-Tab, Ctrl-C and the like are meant for others.
        let others = ModifiersState::CONTROL | ModifiersState::ALT | ModifiersState::SUPER;
        if self.modifiers.intersects(others) || event.repeat {
            return;
        }
        if !panel_has_it || keys::types_nothing(key) {
            self.held.press(key);
        }
    }

    /// Whether a frame is due without anything having changed yet.
    pub(super) fn moving(&self) -> bool {
        self.activity == Activity::Moving || self.mouse.is_held()
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
        let desk = DeskState {
            keys: self.held.take(),
            mouse: self.mouse.take_buttons(),
            gamepad: None,
        };
        let mouse = self.mouse.take(frame, self.settings.mode);
        let Advanced {
            activity,
            intents,
            head,
        } = self.show.advance(&Drive { desk, mouse }, step, now);
        self.head = head;
        self.activity = activity;
        self.was_moving = self.moving();
        self.obey(&intents);
    }
}
