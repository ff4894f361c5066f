//! The event loop's calls.

use super::Wake;
use super::frame::RENEWAL;
use super::open::Open;
use super::pacing::{Next, Situation, next};
use super::shell::Shell;
use glam::DVec2;
use std::sync::Arc;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::WindowId;

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
        match wake {
            Wake::Look => {}
            Wake::Message(text) => self.message(text),
            Wake::Quit => self.quitting = true,
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = self.open.as_mut() else {
            return;
        };
        match event {
            WindowEvent::RedrawRequested => {
                self.frame(events);
                return;
            }
            WindowEvent::Destroyed => {
                // Whatever else is on its way has nowhere to go, and drivers do not survive all of it.
                self.open = None;
                self.message("another program has destroyed the window".into());
                events.exit();
                return;
            }
            _ => {}
        }
        // Tab would move the panel's focus; here it hides the panel.
        let is_tab = matches!(&event, WindowEvent::KeyboardInput { event, .. }
            if event.physical_key == PhysicalKey::Code(KeyCode::Tab));
        let panel_has_it = if is_tab {
            false
        } else {
            let response = open.egui.on_window_event(&open.window, &event);
            self.changed |= response.repaint;
            response.consumed
        };
        // What is turned changes something, if it is not the panel.
        self.changed |= matches!(event, WindowEvent::MouseWheel { .. });
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
            } => self.key(&event, panel_has_it),
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
                    MouseButton::Middle => 2,
                    _ => return,
                };
                let down = state == ElementState::Pressed;
                if !down || !panel_has_it {
                    self.mouse.button(index, down);
                    self.changed = true;
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
        if self.quitting {
            events.exit();
            return;
        }
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
