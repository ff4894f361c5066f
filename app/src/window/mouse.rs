//! The mouse, from window events to what a show is driven by.

use glam::DVec2;

/// What the mouse does over the picture. Lengths are in window heights, y down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MouseDrive {
    /// Where the pointer is: from (0, 0) at the window's upper left to (1, 1) at its lower right
    /// corner; `None` where it is not over the picture.
    pub(crate) pointer: Option<DVec2>,
    /// How far it was dragged with the main button since the last call, in window heights.
    pub(crate) drag: DVec2,
    /// The same with the other button.
    pub(crate) other_drag: DVec2,
    /// Whether the main and the other button are down.
    pub(crate) buttons: [bool; 2],
    /// Notches that the wheel was turned away from the hand since the last call.
    pub(crate) wheel: f64,
}

/// Gathers mouse events between two calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Mouse {
    /// In pixels.
    pointer: Option<DVec2>,
    /// In pixels.
    drags: [DVec2; 2],
    buttons: [bool; 2],
    wheel: f64,
}

impl Mouse {
    /// The pointer is at `to` (pixels), over the panel or not.
    pub(super) fn moved(&mut self, to: DVec2, over_panel: bool) {
        if let Some(from) = self.pointer {
            for (drag, down) in self.drags.iter_mut().zip(self.buttons) {
                if down {
                    *drag += to - from;
                }
            }
        }
        // A drag that began on the picture goes on over the panel.
        let on_picture = !over_panel || self.buttons.contains(&true);
        self.pointer = on_picture.then_some(to);
    }

    /// The pointer left the window.
    pub(super) fn left(&mut self) {
        self.pointer = None;
    }

    /// The main button (0) or the other one (1) went down on the picture, or up anywhere.
    pub(super) fn button(&mut self, index: usize, down: bool) {
        self.buttons[index] = down;
    }

    /// The wheel was turned over the picture.
    pub(super) fn turned(&mut self, notches: f64) {
        self.wheel += notches;
    }

    /// Whether a button is held.
    pub(super) fn is_held(&self) -> bool {
        self.buttons.contains(&true)
    }

    /// Releases all buttons, as when the window loses the pointer.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// What was gathered for a window of `frame` pixels; drags and wheel begin anew.
    pub(super) fn take(&mut self, frame: [u32; 2]) -> MouseDrive {
        let [width, height] = frame.map(|side| f64::from(side.max(1)));
        let [drag, other_drag] = std::mem::take(&mut self.drags).map(|drag| drag / height);
        MouseDrive {
            pointer: self.pointer.map(|at| at / DVec2::new(width, height)),
            drag,
            other_drag,
            buttons: self.buttons,
            wheel: std::mem::take(&mut self.wheel),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drags_count_only_while_their_button_is_down() {
        let mut mouse = Mouse::default();
        mouse.moved(DVec2::new(100.0, 100.0), false);
        mouse.moved(DVec2::new(200.0, 100.0), false);
        mouse.button(0, true);
        mouse.moved(DVec2::new(300.0, 150.0), false);
        mouse.moved(DVec2::new(240.0, 200.0), true);
        mouse.button(0, false);
        mouse.button(1, true);
        mouse.moved(DVec2::new(250.0, 200.0), false);
        mouse.turned(1.0);
        mouse.turned(-3.0);
        let drive = mouse.take([1000, 500]);
        assert_eq!(drive.pointer, Some(DVec2::new(0.25, 0.4)));
        assert_eq!(drive.drag, DVec2::new(0.08, 0.2));
        assert_eq!(drive.other_drag, DVec2::new(0.02, 0.0));
        assert_eq!((drive.buttons, drive.wheel), ([false, true], -2.0));
        let next = mouse.take([1000, 500]);
        assert_eq!((next.drag, next.wheel), (DVec2::ZERO, 0.0));
    }

    #[test]
    fn over_the_panel_there_is_no_pointer() {
        let mut mouse = Mouse::default();
        mouse.moved(DVec2::new(10.0, 10.0), true);
        assert_eq!(mouse.take([100, 100]).pointer, None);
        mouse.moved(DVec2::new(10.0, 10.0), false);
        mouse.left();
        assert_eq!(mouse.take([0, 0]).pointer, None);
    }
}
