//! The mouse, from window events to what a show is driven by.

use glam::DVec2;
use sandtable_stage::StereoMode;

/// What the mouse does over the picture. Lengths are in picture heights, y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MouseDrive {
    /// Where the pointer is: from (0, 0) at the picture's upper left to (1, 1) at its lower right
    /// corner; `None` where it is not over the picture.
    pub(crate) pointer: Option<DVec2>,
    /// Where it was when a button went down since the last call, if one did.
    pub(crate) pressed_at: Option<DVec2>,
    /// How far it moved over the picture since the last call.
    pub(crate) moved: DVec2,
    /// Notches that the wheel was turned away from the hand since the last call.
    pub(crate) wheel: f64,
    /// The proportions of the picture: of the window, whose eyes' pictures have the same.
    pub(crate) picture: [u32; 2],
}

impl MouseDrive {
    /// The picture's width by its height.
    pub(crate) fn aspect(&self) -> f64 {
        let [width, height] = self.picture.map(|side| f64::from(side.max(1)));
        width / height
    }
}

/// Gathers mouse events between two calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Mouse {
    /// In pixels of the window.
    pointer: Option<DVec2>,
    /// In pixels of the window.
    moved: DVec2,
    /// The left, the right and the middle one.
    buttons: [bool; 3],
    /// Those that went down since the last call, so that a short click counts for one.
    clicked: [bool; 3],
    /// Where the pointer was when the first of them did, in pixels of the window.
    pressed_at: Option<DVec2>,
    wheel: f64,
}

impl Mouse {
    /// The pointer is at `to` (pixels), over the panel or not.
    pub(super) fn moved(&mut self, to: DVec2, over_panel: bool) {
        // A drag that began on the picture goes on over the panel.
        if over_panel && !self.is_held() {
            self.pointer = None;
            return;
        }
        if let Some(from) = self.pointer {
            self.moved += to - from;
        }
        self.pointer = Some(to);
    }

    /// The pointer left the window.
    pub(super) fn left(&mut self) {
        self.pointer = None;
    }

    /// The left (0), the right (1) or the middle button (2) went down on the picture, or up
    /// anywhere.
    pub(super) fn button(&mut self, index: usize, down: bool) {
        self.buttons[index] = down;
        self.clicked[index] |= down;
        if down {
            self.pressed_at = self.pressed_at.or(self.pointer);
        }
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

    /// The buttons that are down, or were since the last call.
    pub(super) fn take_buttons(&mut self) -> [bool; 3] {
        let clicked = std::mem::take(&mut self.clicked);
        std::array::from_fn(|index| self.buttons[index] || clicked[index])
    }

    /// What was gathered for a window of `frame` pixels that eyes share as `mode` says; movements
    /// and wheel begin anew.
    pub(super) fn take(&mut self, frame: [u32; 2], mode: StereoMode) -> MouseDrive {
        let [width, height] = frame.map(|side| f64::from(side.max(1)));
        // Where two eyes share the window, each has a squeezed picture of its own in it.
        let eyes = match mode {
            StereoMode::SideBySide => DVec2::new(2.0, 1.0),
            StereoMode::TopBottom => DVec2::new(1.0, 2.0),
            StereoMode::Mono | StereoMode::Anaglyph => DVec2::ONE,
        };
        let in_picture = |at: DVec2| {
            let shared = at / DVec2::new(width, height) * eyes;
            shared - shared.floor().min(eyes - 1.0).max(DVec2::ZERO)
        };
        MouseDrive {
            pointer: self.pointer.map(in_picture),
            pressed_at: self.pressed_at.take().map(in_picture),
            moved: std::mem::take(&mut self.moved) * eyes / height,
            wheel: std::mem::take(&mut self.wheel),
            picture: frame,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn movements_and_turns_are_gathered_until_they_are_taken() {
        let mut mouse = Mouse::default();
        mouse.moved(DVec2::new(100.0, 100.0), false);
        mouse.moved(DVec2::new(300.0, 150.0), false);
        mouse.moved(DVec2::new(240.0, 200.0), false);
        mouse.turned(1.0);
        mouse.turned(-3.0);
        let drive = mouse.take([1000, 500], StereoMode::Anaglyph);
        assert_eq!(drive.pointer, Some(DVec2::new(0.24, 0.4)));
        assert_eq!(drive.moved, DVec2::new(0.28, 0.2));
        assert_eq!((drive.wheel, drive.aspect()), (-2.0, 2.0));
        let next = mouse.take([1000, 500], StereoMode::Mono);
        assert_eq!((next.moved, next.wheel), (DVec2::ZERO, 0.0));
    }

    #[test]
    fn each_eyes_picture_is_pointed_at_for_itself() {
        let mut mouse = Mouse::default();
        let mut at = |x: f64, y: f64, mode| {
            mouse.moved(DVec2::new(x, y), false);
            mouse.take([1000, 500], mode).pointer.unwrap()
        };
        for x in [100.0, 600.0] {
            let pointer = at(x, 125.0, StereoMode::SideBySide);
            assert!((pointer - DVec2::new(0.2, 0.25)).length() < 1e-12);
        }
        for y in [125.0, 375.0] {
            let pointer = at(100.0, y, StereoMode::TopBottom);
            assert!((pointer - DVec2::new(0.1, 0.5)).length() < 1e-12);
        }
        // The last pixel's edge is the picture's, and a drag may leave the window.
        assert_eq!(at(1000.0, 500.0, StereoMode::SideBySide), DVec2::ONE);
        assert_eq!(
            at(-100.0, 0.0, StereoMode::SideBySide),
            DVec2::new(-0.2, 0.0)
        );
        let moved = |mode| {
            let mut mouse = Mouse::default();
            mouse.moved(DVec2::ZERO, false);
            mouse.moved(DVec2::splat(50.0), false);
            mouse.take([1000, 500], mode).moved
        };
        assert_eq!(moved(StereoMode::SideBySide), DVec2::new(0.2, 0.1));
        assert_eq!(moved(StereoMode::TopBottom), DVec2::new(0.1, 0.2));
    }

    #[test]
    fn over_the_panel_there_is_no_pointer_but_a_drag_goes_on() {
        let mut mouse = Mouse::default();
        let take = |mouse: &mut Mouse| mouse.take([100, 100], StereoMode::Mono);
        mouse.moved(DVec2::new(10.0, 10.0), true);
        assert_eq!(take(&mut mouse).pointer, None);
        mouse.moved(DVec2::new(10.0, 10.0), false);
        mouse.button(0, true);
        mouse.moved(DVec2::new(20.0, 10.0), true);
        let drive = take(&mut mouse);
        assert_eq!((drive.pointer.is_some(), drive.moved.x), (true, 0.1));
        mouse.button(0, false);
        mouse.moved(DVec2::new(50.0, 10.0), true);
        assert_eq!(take(&mut mouse).moved, DVec2::ZERO);
        mouse.left();
        assert_eq!(mouse.take([0, 0], StereoMode::Mono).pointer, None);
    }

    #[test]
    fn a_click_between_two_frames_counts_for_one_of_them() {
        let mut mouse = Mouse::default();
        mouse.button(1, true);
        mouse.button(1, false);
        assert_eq!(mouse.take_buttons(), [false, true, false]);
        assert_eq!(mouse.take_buttons(), [false; 3]);
    }

    #[test]
    fn what_is_dragged_before_the_next_frame_began_where_the_button_went_down() {
        let mut mouse = Mouse::default();
        mouse.moved(DVec2::new(10.0, 20.0), false);
        mouse.moved(DVec2::new(30.0, 20.0), false);
        mouse.button(0, true);
        mouse.moved(DVec2::new(70.0, 20.0), false);
        mouse.button(1, true);
        let drive = mouse.take([100, 100], StereoMode::Mono);
        assert_eq!(drive.pressed_at, Some(DVec2::new(0.3, 0.2)));
        assert_eq!(drive.pointer, Some(DVec2::new(0.7, 0.2)));
        assert_eq!(mouse.take([100, 100], StereoMode::Mono).pressed_at, None);
    }
}
